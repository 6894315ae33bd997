#include "benchmarks/reference/bullet/days.h"

#include "tests/support/test_data.h"

#include <gtest/gtest.h>

namespace bullet_ccd::tests
{
using namespace reference;

/// What is not for long tests alone: of the days that take less than a second of processor time,
/// one of so many.
constexpr int kShortDay = 90;
constexpr int kShown = 6;

TEST(Days, OfOursFareNoWorseThanInStockBullet)
{
    int bad = 0;
    int number = 0;
    for (const Day& day : days())
    {
        if (!longTests() && (day.steps > kShortDay || number++ % kShown != 0))
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
