#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
TEST(JointPath, OfACubicHasItsValuesRatesAndExtremes)
{
    // t^3 - t^2: falls to -4/27 at 2/3; its rate is lowest at 1/3 with -1/3, its bend 6 t - 2.
    const JointPath path{{0.0, 0.0, -1.0, 1.0}};
    EXPECT_NEAR(path.at(2.0 / 3.0), -4.0 / 27.0, 1e-15);
    EXPECT_NEAR(path.rateAt(1.0 / 3.0), -1.0 / 3.0, 1e-15);
    const JointPathBounds bounds = path.bounds();
    EXPECT_NEAR(bounds.bend, 4.0, 1e-9);
    EXPECT_LE(bounds.lowestRate, -1.0 / 3.0);
    EXPECT_GE(bounds.lowestRate, -0.5);
    EXPECT_NEAR(bounds.highestRate, 1.0, 1e-9);
    EXPECT_GE(bounds.reach, 4.0 / 27.0);
    EXPECT_LE(bounds.reach, 0.25);
}

TEST(JointPath, ItsPartsAreThePathAndItsBoundsHold)
{
    Random random(7);
    double tightest = 0.0;
    for (int i = 0; i < 2000; ++i)
    {
        JointPath path;
        const int degree = random.integer(0, 5);
        for (std::size_t k = 0; k <= static_cast<std::size_t>(degree); ++k)
        {
            path.c[k] = random.uniform(-2.0, 2.0);
        }
        EXPECT_EQ(path.isLinear(), degree < 2);
        const double begin = random.uniform(0.0, 0.6);
        const double end = random.uniform(0.4, 1.0);
        const JointPath part = path.partOf(begin, end);
        const JointPathBounds bounds = path.bounds();
        for (int k = 0; k <= 100; ++k)
        {
            const double s = 0.01 * k;
            const double t = begin + s * (end - begin);
            EXPECT_NEAR(part.at(s), path.at(t), 1e-14);
            EXPECT_NEAR(part.rateAt(s), (end - begin) * path.rateAt(t), 1e-13);
            const double bend =
                2.0 * path.c[2] +
                s * (6.0 * path.c[3] + s * (12.0 * path.c[4] + s * 20.0 * path.c[5]));
            EXPECT_LE(std::abs(path.at(s)), bounds.reach);
            EXPECT_LE(path.rateAt(s), bounds.highestRate);
            EXPECT_GE(path.rateAt(s), bounds.lowestRate);
            EXPECT_LE(std::abs(bend), bounds.bend);
            tightest = std::max(tightest, bounds.bend > 1.0 ? std::abs(bend) / bounds.bend : 0.0);
        }
    }
    EXPECT_GT(tightest, 0.999);
}
}  // namespace
}  // namespace bullet_ccd::tests
