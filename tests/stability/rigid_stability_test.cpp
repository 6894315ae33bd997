/// Every rigid case: not late, tight, no false contact, honest witnesses; as it is, with the bodies
/// swapped, and seen from elsewhere.
#include "tests/stability/cases.h"
#include "tests/support/random_scenes.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <ostream>

namespace bullet_ccd::tests
{
void PrintTo(const RigidCase& tested, std::ostream* out);
void PrintTo(const RigidCase& tested, std::ostream* out)
{
    *out << tested.id;
}

namespace
{
class RigidStability : public testing::TestWithParam<RigidCase>
{
};

void expectAnswer(const RigidScene& scene, const CaseAnswer& answer, double tolerance)
{
    const double rounding = roundingOf(scene);
    const ToiResult result = queryToi(scene, tolerance);
    expectHonest(scene, result, tolerance, "");
    if (answer.time)
    {
        ASSERT_EQ(result.status, ToiStatus::Hit) << "contact missed";
        const double ulps = 4.0 * std::numeric_limits<double>::epsilon();
        EXPECT_LE(result.time, *answer.time + ulps + leadTime(answer, rounding)) << "late";
        // The distance is not exactly linear over the tolerance: 10 % more.
        EXPECT_GE(result.time, *answer.time - ulps - 1.1 * leadTime(answer, tolerance + rounding))
            << "early";
    }
    else if (answer.clearance > tolerance + rounding)
    {
        EXPECT_EQ(result.status, ToiStatus::Separated) << "false contact";
    }
}

TEST_P(RigidStability, MeetsItsClosedForm)
{
    for (const double tolerance : GetParam().answer.tolerances)
    {
        SCOPED_TRACE(tolerance);
        expectAnswer(GetParam().scene, GetParam().answer, tolerance * GetParam().answer.length);
    }
}

TEST_P(RigidStability, MeetsItWithTheBodiesSwapped)
{
    for (const double tolerance : GetParam().answer.tolerances)
    {
        SCOPED_TRACE(tolerance);
        expectAnswer(
            swapped(GetParam().scene), GetParam().answer, tolerance * GetParam().answer.length);
    }
}

TEST_P(RigidStability, MeetsItSeenFromElsewhere)
{
    Random random(12);
    for (int i = 0; i < 3; ++i)
    {
        const RigidScene scene =
            moved(GetParam().scene, random.pose(10.0 * GetParam().answer.length));
        for (const double tolerance : GetParam().answer.tolerances)
        {
            SCOPED_TRACE(tolerance);
            expectAnswer(scene, GetParam().answer, tolerance * GetParam().answer.length);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Catalogue,
                         RigidStability,
                         testing::ValuesIn(rigidCases()),
                         [](const auto& tested) { return tested.param.id; });
}  // namespace
}  // namespace bullet_ccd::tests
