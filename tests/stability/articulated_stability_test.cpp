/// Every articulated case: not late, tight, all ties reported.
#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "tests/stability/stability_suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
class ArticulatedStability : public StabilitySuite<ArticulatedCase>
{
};

ArticulatedToiResult query(const ArticulatedCase& tested,
                           double tolerance,
                           ToiStrategy strategy = ToiStrategy::BestFirst)
{
    return query(sceneOf(tested),
                 ArticulatedToiOptions{.toi = {.tolerance = tolerance, .strategy = strategy}});
}

/// Distance of the named pair, by brute force.
double distanceOf(const ArticulatedCase& tested, const LinkContact& contact, double t)
{
    const auto linkBody = [&](std::int32_t link)
    {
        return oracleLink(
            tested.linkMeshes[static_cast<std::size_t>(link)], tested.tree, tested.motion, link);
    };
    const OracleBody a = linkBody(contact.link);
    if (contact.otherLink != kNone)
    {
        return oracleDistanceAt(a, linkBody(contact.otherLink), t);
    }
    const TriangleMesh& mesh = tested.obstacles[static_cast<std::size_t>(contact.obstacle)];
    return oracleDistanceAt(a, oracleBody(mesh, {}), t);
}

void expectContacts(const ArticulatedCase& tested,
                    const ArticulatedToiResult& result,
                    double tolerance)
{
    const double rounding = roundingOf(tested);
    ASSERT_FALSE(result.contacts.empty());
    for (const LinkContact& contact : result.contacts)
    {
        EXPECT_LE(contact.gap, tolerance + rounding);
        const double distance = distanceOf(tested, contact, result.time);
        EXPECT_GT(distance, 0.0);
        EXPECT_LE(distance, contact.gap + rounding);
        EXPECT_NEAR((contact.pointLink - contact.pointOther).norm(), contact.gap, 2.0 * rounding);
        EXPECT_NEAR(contact.normal.norm(), 1.0, 1e-12);
    }
}

void expectAnswer(const ArticulatedCase& tested,
                  double tolerance,
                  ToiStrategy strategy = ToiStrategy::BestFirst)
{
    const CaseAnswer& answer = tested.answer;
    const double rounding = roundingOf(tested);
    const ArticulatedToiResult result = query(tested, tolerance, strategy);
    if (!answer.time)
    {
        EXPECT_TRUE(result.status == ToiStatus::Separated ||
                    (result.status == ToiStatus::Hit && answer.clearance <= tolerance + rounding));
        return;
    }
    ASSERT_EQ(result.status, ToiStatus::Hit);
    expectTime(result.time, answer, tolerance, rounding);
    expectContacts(tested, result, tolerance);
    for (const std::int32_t link : tested.links)
    {
        EXPECT_TRUE(std::any_of(result.contacts.begin(),
                                result.contacts.end(),
                                [&](const LinkContact& contact) { return contact.link == link; }))
            << "contact of link " << link << " not reported";
    }
}

TEST_P(ArticulatedStability, MeetsItsClosedForm)
{
    for (const double tolerance : tested().answer.tolerances)
    {
        SCOPED_TRACE(tolerance);
        expectAnswer(tested(), tolerance * tested().answer.length, strategy());
    }
}

TEST_P(ArticulatedStability, KeepsItsAnswerUnderEveryRelation)
{
    const auto ask = [this](const ArticulatedCase& asked, double tolerance)
    {
        const ArticulatedToiResult result = query(asked, tolerance, strategy());
        if (isContact(result.status))
        {
            expectContacts(asked, result, tolerance);
        }
        return result;
    };
    expectRelations(tested(), ask);
}

INSTANTIATE_TEST_SUITE_P(Catalogue,
                         ArticulatedStability,
                         ArticulatedStability::everyWay(articulatedCases()),
                         ArticulatedStability::nameOfWay);

TEST(ArticulatedClosedForm, ManyTurnsOutOfReachAreFree)
{
    ArticulatedCase tested = articulatedCase("N24");
    tested.obstacles[0] = shifted(tested.obstacles[0], {3.0, 0, 0});
    tested.answer.time.reset();
    tested.answer.clearance = 1.0;
    expectAnswer(tested, 1e-6);
}

TEST(ArticulatedClosedForm, ASphericalJointIsAPendulumAboutItsAxis)
{
    // G01 with the joint's rest rotation and axis turned together.
    Random random(14);
    for (int i = 0; i < 20; ++i)
    {
        ArticulatedCase tested = articulatedCase("G01");
        const Eigen::Matrix3d R = random.rotation();
        tested.tree.links[1].joint.type = JointType::Spherical;
        tested.tree.links[1].X_PL0.linear() = R;
        tested.motion.balls = {
            {},
            {.start = R.transpose(),
             .rate = R.transpose() * Eigen::Vector3d(0, 0, 0.5 * std::acos(-1.0))}};
        tested.motion.rates = {0, 0};
        expectAnswer(tested, 1e-6);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
