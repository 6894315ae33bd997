/// Every rigid case with every strategy: not late, tight, no false contact, honest witnesses; as it
/// is, and under every relation.
#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/stability/stability_suite.h"
#include "tests/support/expect_honest.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Parameter = std::tuple<RigidCase, ToiStrategy>;

/// Every case with every strategy.
std::vector<Parameter> parameters()
{
    std::vector<Parameter> result;
    for (const RigidCase& tested : rigidCases())
    {
        for (const ToiStrategy strategy :
             {ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A})
        {
            result.emplace_back(tested, strategy);
        }
    }
    return result;
}

class RigidStability : public StabilitySuite<RigidCase>
{
protected:
    [[nodiscard]] ToiOptions options(double tolerance) const
    {
        return {.tolerance = tolerance, .strategy = strategy()};
    }

    /// What every answer promises, at the given tolerance, and the closed form.
    void expectAnswer(const RigidScene& scene, const CaseAnswer& answer, double tolerance) const
    {
        const double rounding = roundingOf(scene);
        const ToiResult result = queryToi(scene, options(tolerance));
        expectHonest(scene, result, tolerance, "");
        if (answer.time)
        {
            ASSERT_TRUE(isContact(result.status)) << "contact missed";
            expectTime(result.time, answer, tolerance, rounding);
        }
        else if (answer.clearance > tolerance + rounding)
        {
            EXPECT_EQ(result.status, ToiStatus::Separated) << "false contact";
            EXPECT_LE(result.gap, (1.0 + 1e-12) * answer.clearance + rounding)
                << "no lower bound of the distance";
        }
    }
};

TEST_P(RigidStability, MeetsItsClosedForm)
{
    const CaseAnswer& answer = tested().answer;
    for (const double tolerance : answer.tolerances)
    {
        SCOPED_TRACE(tolerance);
        expectAnswer(tested().scene, answer, tolerance * answer.length);
        if (answer.status)
        {
            EXPECT_EQ(queryToi(tested().scene, options(tolerance * answer.length)).status,
                      *answer.status);
        }
    }
}

/// A thousandth of the tolerance of most cases, wherever the gap that is left is above rounding.
TEST_P(RigidStability, MeetsItAtABillionth)
{
    const CaseAnswer& answer = tested().answer;
    const double tolerance = 1e-9 * answer.length;
    if (tolerance < answer.finest() && 1e-3 * tolerance > roundingOf(tested()) &&
        !answer.startsTouching && !answer.hangsOnRounding)
    {
        expectAnswer(tested().scene, answer, tolerance);
    }
}

TEST_P(RigidStability, KeepsItsAnswerUnderEveryRelation)
{
    const auto ask = [this](const RigidCase& asked, double tolerance)
    {
        const ToiResult result = queryToi(asked.scene, options(tolerance));
        expectHonest(asked.scene, result, tolerance, "");
        return result;
    };
    expectRelations(tested(), ask);
}

TEST_P(RigidStability, DoesNotDependOnTheOrderOfTriangles)
{
    const ToiOptions how = options(tested().answer.finest());
    const ToiResult first = queryToi(tested().scene, how);
    for (const Variant<RigidCase>& variant : variantsOf(tested(), Relation::Permuted))
    {
        const ToiResult second = queryToi(variant.legs[0].tested.scene, how);
        EXPECT_EQ(first.status, second.status) << variant.name;
        // The same trees but for triangles that single precision cannot tell apart.
        EXPECT_NEAR(first.time, second.time, 1e-12) << variant.name;
    }
}

/// From the reported contact back to the start: nothing is in the way, as bodies within the
/// tolerance that part are not in contact. Half the tolerance is left as room, as ToiOptions::aim
/// advises: the default leaves a 4096th, in some cases less than the rounding of the new start.
TEST_P(RigidStability, CanGoBackFromItsContact)
{
    if (!tested().answer.time || tested().answer.startsTouching || tested().answer.time == 0.0)
    {
        return;
    }
    ToiOptions how = options(tested().answer.finest());
    how.aim = 0.5;
    const ToiResult contact = queryToi(tested().scene, how);
    const RigidScene back = partOf(tested(), contact.time, 0.0).scene;
    const ToiResult result = queryToi(back, how);
    EXPECT_FALSE(isContact(result.status)) << static_cast<int>(result.status);
    expectHonest(back, result, how.tolerance, "");
}

INSTANTIATE_TEST_SUITE_P(Catalogue,
                         RigidStability,
                         testing::ValuesIn(parameters()),
                         RigidStability::nameOfWay);

/// A million queries in a row, each from where the one before ended; the contact comes in the last.
TEST(RigidExtremes, ALongFlightMeetsTheGroundInItsLastQuery)
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
TEST(RigidExtremes, LengthsThatCannotBeSquaredAreRefusedOrAnsweredRightly)
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
