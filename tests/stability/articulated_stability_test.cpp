/// Every articulated case: not late, tight, all ties reported; and the grasping sequences that stop
/// a link at its contact and go on with the next.
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
    expectRelations(tested(), ask, [](Relation) { return true; });
}

INSTANTIATE_TEST_SUITE_P(Catalogue,
                         ArticulatedStability,
                         ArticulatedStability::everyWay(articulatedCases()),
                         ArticulatedStability::nameOfWay);

ArticulatedCase caseById(const std::string& id)
{
    for (ArticulatedCase& tested : articulatedCases())
    {
        if (tested.id == id)
        {
            return tested;
        }
    }
    throw std::invalid_argument(id);
}

TEST(ArticulatedClosedForm, ManyTurnsOutOfReachAreFree)
{
    ArticulatedCase tested = caseById("N24");
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
        ArticulatedCase tested = caseById("G01");
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

TEST(GraspSequence, TheFingerWrapsTheCylinderLinkByLink)
{
    // I09: as G12a up to the first contact, then the distal link as in G13.
    constexpr double kTolerance = 1e-7;
    ArticulatedCase finger = caseById("G13");
    const double secondTime = *finger.answer.time;
    finger.motion.positions = {0, 1.2, 0};
    finger.motion.rates = {0, -1, 0};
    const ArticulatedToiResult first = query(finger, kTolerance);
    ASSERT_EQ(first.status, ToiStatus::Hit);
    const CaseAnswer expected = caseById("G12a").answer;
    EXPECT_NEAR(first.time, *expected.time, 1.1 * leadTime(expected, kTolerance));
    EXPECT_EQ(first.contacts[0].link, 1);

    finger.motion.positions[1] = 1.2 - first.time;
    finger.motion.rates = {0, 0, -3};
    const ArticulatedToiResult second = query(finger, kTolerance);
    ASSERT_EQ(second.status, ToiStatus::Hit);
    // The first phalanx stopped up to the tolerance short of its contact; the second then has to
    // turn up to that much farther, seen from the nearer contact.
    EXPECT_NEAR(second.time, secondTime, 1e-4);
    ASSERT_EQ(second.contacts.size(), 1U);
    EXPECT_EQ(second.contacts[0].link, 2);
    for (const LinkContact& contact : {first.contacts[0], second.contacts[0]})
    {
        const Eigen::Vector3d toAxis(0.10 - contact.pointOther.x(), -contact.pointOther.y(), 0.0);
        EXPECT_GT(contact.normal.dot(toAxis.normalized()), 0.999);
    }
}

TEST(GraspSequence, TheSecondJawGoesOnAfterTheFirstStops)
{
    constexpr double kTolerance = 1e-7;
    ArticulatedCase jaws = caseById("I03a");
    const ArticulatedToiResult first = query(jaws, kTolerance);
    ASSERT_EQ(first.status, ToiStatus::Hit);
    ASSERT_EQ(first.contacts.size(), 1U);
    EXPECT_EQ(first.contacts[0].link, 2);
    EXPECT_NEAR(first.time, 0.25, kTolerance / 0.04 * 1.01);
    jaws.motion.positions[1] += first.time * jaws.motion.rates[1];
    jaws.motion.positions[2] += first.time * jaws.motion.rates[2];
    jaws.motion.rates[2] = 0.0;
    const ArticulatedToiResult second = query(jaws, kTolerance);
    ASSERT_EQ(second.status, ToiStatus::Hit);
    EXPECT_EQ(second.contacts[0].link, 1);
    EXPECT_NEAR(first.time + second.time, 0.5, 2.0 * kTolerance / 0.04 * 1.01);
}

TEST(GraspSequence, AThousandSubQueriesLeaveOneTolerance)
{
    // E13: the motion of G12a cut into 1000 queries, each from the end of the one before.
    constexpr int kSteps = 1000;
    constexpr double kTolerance = 1e-5;
    ArticulatedCase finger = caseById("G12a");
    const CaseAnswer answer = finger.answer;
    finger.motion.rates = {0, -1.0 / kSteps};
    double angle = 1.2;
    for (int i = 0; i < kSteps; ++i)
    {
        finger.motion.positions[1] = angle;
        const ArticulatedToiResult result = query(finger, kTolerance);
        angle -= result.time / kSteps;
        if (result.status == ToiStatus::Hit)
        {
            const double time = 1.2 - angle;
            EXPECT_LE(time, *answer.time + 1e-12);
            EXPECT_GE(time, *answer.time - 1.1 * leadTime(answer, kTolerance));
            return;
        }
        ASSERT_EQ(result.status, ToiStatus::Separated);
    }
    FAIL() << "contact missed";
}

TEST(GraspSequence, OpeningFromAContactIsFree)
{
    ArticulatedCase finger = caseById("G12a");
    const ArticulatedToiResult contact = query(finger, 1e-7);
    ASSERT_EQ(contact.status, ToiStatus::Hit);
    finger.motion.positions[1] += contact.time * finger.motion.rates[1];
    finger.motion.rates[1] = 1.0;
    EXPECT_EQ(query(finger, 1e-7).status, ToiStatus::Separated);
}

TEST(GraspSequence, TheOrderOfFingersThatCannotMeetDoesNotMatter)
{
    // I11: each of four pendulums closes to its wall, in all 24 orders.
    const ArticulatedCase hand = caseById("G05");
    std::vector<std::size_t> order{1, 2, 3, 4};
    std::vector<double> first;
    int orders = 0;
    do
    {
        ArticulatedCase closing = hand;
        std::vector<double> stopped(5, 0.0);
        for (const std::size_t finger : order)
        {
            closing.motion.rates.assign(5, 0.0);
            closing.motion.rates[finger] = hand.motion.rates[finger];
            const ArticulatedToiResult result = query(closing, 1e-6);
            ASSERT_EQ(result.status, ToiStatus::Hit);
            ASSERT_EQ(result.contacts.size(), 1U);
            EXPECT_EQ(result.contacts[0].link, static_cast<std::int32_t>(finger));
            closing.motion.positions[finger] += result.time * closing.motion.rates[finger];
            stopped[finger] = closing.motion.positions[finger];
        }
        if (first.empty())
        {
            first = stopped;
        }
        EXPECT_EQ(stopped, first);
        ++orders;
    } while (std::next_permutation(order.begin(), order.end()));
    EXPECT_EQ(orders, 24);
}

TEST(GraspSequence, AnObjectOutOfReachCostsNoTriangleTests)
{
    ArticulatedCase finger = caseById("G12a");
    finger.obstacles[0] = shifted(finger.obstacles[0], {0.3, 0.2, 0});
    const ArticulatedToiResult result = query(finger, 1e-7);
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_EQ(result.counters.trianglePairs, 0);
}

TEST(GraspSequence, ReversingAfterAContactIsFree)
{
    // E12 on a jaw: from the reported contact back to the start.
    ArticulatedCase jaws = caseById("I02");
    const ArticulatedToiResult contact = query(jaws, 1e-6);
    ASSERT_EQ(contact.status, ToiStatus::Hit);
    for (std::size_t i = 1; i < 3; ++i)
    {
        jaws.motion.positions[i] += contact.time * jaws.motion.rates[i];
        jaws.motion.rates[i] *= -contact.time;
    }
    EXPECT_EQ(query(jaws, 1e-6).status, ToiStatus::Separated);
}
}  // namespace
}  // namespace bullet_ccd::tests
