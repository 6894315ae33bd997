/// Every rigid case with every strategy: not late, tight, no false contact, honest witnesses; as it
/// is, with the bodies swapped, seen from elsewhere, in other units, with its triangles shuffled.
#include "tests/stability/cases.h"
#include "tests/support/random_scenes.h"
#include "tests/support/shapes.h"
#include "tests/support/soak_queries.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <ostream>
#include <tuple>

namespace bullet_ccd::tests
{
void PrintTo(const RigidCase& tested, std::ostream* out);
void PrintTo(const RigidCase& tested, std::ostream* out)
{
    *out << tested.id;
}

namespace
{
using Parameter = std::tuple<RigidCase, ToiStrategy>;

class RigidStability : public testing::TestWithParam<Parameter>
{
protected:
    [[nodiscard]] const RigidCase& tested() const { return std::get<0>(GetParam()); }
    [[nodiscard]] ToiOptions options(double tolerance) const
    {
        return {.tolerance = tolerance, .strategy = std::get<1>(GetParam())};
    }

    /// The answer in units of which `unit` make up one of the catalogue's.
    void expectAnswer(const RigidScene& scene, double unit = 1.0) const
    {
        for (const double tolerance : tested().answer.tolerances)
        {
            SCOPED_TRACE(tolerance);
            expectAnswerAt(scene, tolerance * tested().answer.length, unit);
        }
    }

private:
    void expectAnswerAt(const RigidScene& scene, double tolerance, double unit) const
    {
        const CaseAnswer& answer = tested().answer;
        const double rounding = roundingOf(scene) / unit;
        const ToiResult result = queryToi(scene, options(tolerance * unit));
        expectHonest(scene, result, tolerance * unit, "");
        if (answer.time)
        {
            ASSERT_EQ(result.status, ToiStatus::Hit) << "contact missed";
            const double ulps = 4.0 * std::numeric_limits<double>::epsilon();
            EXPECT_LE(result.time, *answer.time + ulps + leadTime(answer, rounding)) << "late";
            // The distance is not exactly linear over the tolerance: 10 % more.
            EXPECT_GE(result.time,
                      *answer.time - ulps - 1.1 * leadTime(answer, tolerance + rounding))
                << "early";
        }
        else if (answer.clearance > tolerance + rounding)
        {
            EXPECT_EQ(result.status, ToiStatus::Separated) << "false contact";
            EXPECT_LE(result.gap, (1.0 + 1e-12) * answer.clearance * unit + rounding * unit)
                << "no lower bound of the distance";
        }
    }
};

TEST_P(RigidStability, MeetsItsClosedForm)
{
    expectAnswer(tested().scene);
}

TEST_P(RigidStability, MeetsItWithTheBodiesSwapped)
{
    expectAnswer(swapped(tested().scene));
}

TEST_P(RigidStability, MeetsItSeenFromElsewhere)
{
    Random random(12);
    for (int i = 0; i < 3; ++i)
    {
        expectAnswer(moved(tested().scene, random.pose(10.0 * tested().answer.length)));
    }
}

TEST_P(RigidStability, MeetsItInOtherUnits)
{
    for (const double unit : {1e-3, 1e3})
    {
        SCOPED_TRACE(unit);
        expectAnswer(scaled(tested().scene, unit), unit);
    }
}

TEST_P(RigidStability, DoesNotDependOnTheOrderOfTriangles)
{
    Random random(13);
    RigidScene scene = tested().scene;
    const ToiOptions how = options(tested().answer.tolerances.back() * tested().answer.length);
    const ToiResult first = queryToi(scene, how);
    for (int i = 0; i < 2; ++i)
    {
        scene.meshA = permuted(scene.meshA, random);
        scene.meshB = permuted(scene.meshB, random);
        const ToiResult second = queryToi(scene, how);
        EXPECT_EQ(first.status, second.status);
        // The same tree but for triangles that single precision cannot tell apart.
        EXPECT_NEAR(first.time, second.time, 1e-12);
    }
}

INSTANTIATE_TEST_SUITE_P(Catalogue,
                         RigidStability,
                         testing::Combine(testing::ValuesIn(rigidCases()),
                                          testing::Values(ToiStrategy::BestFirst,
                                                          ToiStrategy::Interval,
                                                          ToiStrategy::C2A)),
                         [](const auto& tested)
                         {
                             std::string strategy = nameOf(std::get<1>(tested.param));
                             std::erase(strategy, '-');
                             return std::get<0>(tested.param).id + "_" + strategy;
                         });

/// A million queries in a row, each from where the one before ended; the contact comes in the last.
TEST(RigidStability, ALongFlightMeetsTheGroundInItsLastQuery)
{
    constexpr int kQueries = 1'000'000;
    RigidMotion fall{.X_W0 = poseOf({0, 0, 1.0 + 8.0 * (kQueries - 0.5)}), .v_W = {0, 0, -8}};
    const SsvTree body = buildSsvTree(cube(1.0));
    const SsvTree ground = buildSsvTree(floorAt(0.0, 10.0));
    ToiWorkspace work;
    ToiResult result;
    int queries = 0;
    while (result.status == ToiStatus::Separated && queries < kQueries + 1)
    {
        result =
            rigidToi({.tree = &body, .motion = fall}, {.tree = &ground}, {.tolerance = 1e-6}, work);
        fall.X_W0 = fall.at(result.time).X_W;
        ++queries;
    }
    EXPECT_EQ(queries, kQueries);
    ASSERT_EQ(result.status, ToiStatus::Hit);
    EXPECT_LE(result.time, 0.5);
    EXPECT_GE(result.time, 0.5 - 1e-6 / 8.0 - 1e-14);
}

/// Lengths whose squares over- or underflow are refused or answered rightly.
TEST(RigidStability, LengthsThatCannotBeSquaredAreRefusedOrAnsweredRightly)
{
    for (const double unit : {1e-150, 1e-30, 1e30, 1e150})
    {
        const RigidScene scene{
            .meshA = cube(unit),
            .meshB = floorAt(0.0, 10.0 * unit),
            .motionA = {.X_W0 = poseOf({0, 0, 5.0 * unit}), .v_W = {0, 0, -8.0 * unit}}};
        try
        {
            const ToiResult result = queryToi(scene, 1e-6 * unit);
            EXPECT_EQ(result.status, ToiStatus::Hit) << unit;
            EXPECT_LE(result.time, 0.5) << unit;
            EXPECT_GE(result.time, 0.5 - 1e-6) << unit;
        }
        catch (const std::invalid_argument& error)
        {
            EXPECT_NE(std::string(error.what()), "") << unit;
        }
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
