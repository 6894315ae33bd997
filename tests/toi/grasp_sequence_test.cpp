/// Sequences of articulated queries as grasping asks them: a link stops at its contact, and the
/// others go on. The scenes are cases of the catalogue.
#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
ArticulatedToiResult ask(const ArticulatedCase& tested, double tolerance)
{
    return query(sceneOf(tested), ArticulatedToiOptions{.toi = {.tolerance = tolerance}});
}

TEST(GraspSequence, TheFingerWrapsTheCylinderLinkByLink)
{
    // I09: as G12a up to the first contact, then the distal link as in G13.
    constexpr double kTolerance = 1e-7;
    ArticulatedCase finger = articulatedCase("G13");
    const double secondTime = *finger.answer.time;
    finger.motion.positions = {0, 1.2, 0};
    finger.motion.rates = {0, -1, 0};
    const ArticulatedToiResult first = ask(finger, kTolerance);
    ASSERT_EQ(first.status, ToiStatus::Hit);
    const CaseAnswer expected = articulatedCase("G12a").answer;
    EXPECT_NEAR(first.time, *expected.time, 1.1 * leadTime(expected, kTolerance));
    EXPECT_EQ(first.contacts[0].link, 1);

    finger.motion.positions[1] = 1.2 - first.time;
    finger.motion.rates = {0, 0, -3};
    const ArticulatedToiResult second = ask(finger, kTolerance);
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
    ArticulatedCase jaws = articulatedCase("I03a");
    const ArticulatedToiResult first = ask(jaws, kTolerance);
    ASSERT_EQ(first.status, ToiStatus::Hit);
    ASSERT_EQ(first.contacts.size(), 1U);
    EXPECT_EQ(first.contacts[0].link, 2);
    EXPECT_NEAR(first.time, 0.25, kTolerance / 0.04 * 1.01);
    jaws.motion.positions[1] += first.time * jaws.motion.rates[1];
    jaws.motion.positions[2] += first.time * jaws.motion.rates[2];
    jaws.motion.rates[2] = 0.0;
    const ArticulatedToiResult second = ask(jaws, kTolerance);
    ASSERT_EQ(second.status, ToiStatus::Hit);
    EXPECT_EQ(second.contacts[0].link, 1);
    EXPECT_NEAR(first.time + second.time, 0.5, 2.0 * kTolerance / 0.04 * 1.01);
}

TEST(GraspSequence, AThousandSubQueriesLeaveOneTolerance)
{
    // E13: the motion of G12a cut into 1000 queries, each from the end of the one before.
    constexpr int kSteps = 1000;
    constexpr double kTolerance = 1e-5;
    ArticulatedCase finger = articulatedCase("G12a");
    const CaseAnswer answer = finger.answer;
    finger.motion.rates = {0, -1.0 / kSteps};
    double angle = 1.2;
    for (int i = 0; i < kSteps; ++i)
    {
        finger.motion.positions[1] = angle;
        const ArticulatedToiResult result = ask(finger, kTolerance);
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
    ArticulatedCase finger = articulatedCase("G12a");
    const ArticulatedToiResult contact = ask(finger, 1e-7);
    ASSERT_EQ(contact.status, ToiStatus::Hit);
    finger.motion.positions[1] += contact.time * finger.motion.rates[1];
    finger.motion.rates[1] = 1.0;
    EXPECT_EQ(ask(finger, 1e-7).status, ToiStatus::Separated);
}

TEST(GraspSequence, TheOrderOfFingersThatCannotMeetDoesNotMatter)
{
    // I11: each of four pendulums closes to its wall, in all 24 orders.
    const ArticulatedCase hand = articulatedCase("G05");
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
            const ArticulatedToiResult result = ask(closing, 1e-6);
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
    ArticulatedCase finger = articulatedCase("G12a");
    finger.obstacles[0] = shifted(finger.obstacles[0], {0.3, 0.2, 0});
    const ArticulatedToiResult result = ask(finger, 1e-7);
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_EQ(result.counters.trianglePairs, 0);
}

TEST(GraspSequence, ReversingAfterAContactIsFree)
{
    // E12 on a jaw: from the reported contact back to the start.
    ArticulatedCase jaws = articulatedCase("I02");
    const ArticulatedToiResult contact = ask(jaws, 1e-6);
    ASSERT_EQ(contact.status, ToiStatus::Hit);
    for (std::size_t i = 1; i < 3; ++i)
    {
        jaws.motion.positions[i] += contact.time * jaws.motion.rates[i];
        jaws.motion.rates[i] *= -contact.time;
    }
    EXPECT_EQ(ask(jaws, 1e-6).status, ToiStatus::Separated);
}
}  // namespace
}  // namespace bullet_ccd::tests
