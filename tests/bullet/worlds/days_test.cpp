#include "benchmarks/reference/bullet/days.h"

#include "tests/support/test_data.h"

#include <gtest/gtest.h>

namespace bullet_ccd::tests
{
using namespace reference;

/// Days that take a second of processor time are for long tests.
constexpr int kShortDay = 90;

TEST(Days, OfOursFareNoWorseThanInStockBullet)
{
    int bad = 0;
    for (const Day& day : days())
    {
        if (day.steps > kShortDay && !longTests())
        {
            continue;
        }
        const int stock = play(day, Kind::Stock);
        bad += stock;
        for (const Kind kind : kOurKinds)
        {
            const int ours = play(day, kind);
            EXPECT_TRUE(day.isGood(ours, stock))
                << day.name << ", " << nameOf(kind) << ": " << ours << " " << day.wrong << ", "
                << stock << " in stock Bullet";
        }
    }
    // Days on which nothing goes wrong in stock Bullet would show nothing.
    EXPECT_GT(bad, 20);
}
}  // namespace bullet_ccd::tests
