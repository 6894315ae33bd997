// Where candidates of a mixed plan come from, and what grasps can carry.
#include "grasp/planner/source_schedule.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/closing/closing.h"
#include "grasp/planner/grasp_planner.h"
#include "grasp/planner/weight_margin.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
using tests::makeGripper;

/// Runs a schedule on outcomes that a function of the turn decides; returns how often each source
/// was taken in the candidates from `first` on.
template <typename Outcome>
std::map<ApproachSource, int> runSchedule(SourceSchedule& schedule,
                                          std::int64_t candidates,
                                          std::int64_t first,
                                          const Outcome& holds)
{
    std::vector<char> held(static_cast<std::size_t>(candidates), 0);
    std::map<ApproachSource, int> taken;
    std::int64_t number = 0;
    while (number < candidates)
    {
        schedule.extend(held);
        for (; number < schedule.end(); ++number)
        {
            const ApproachTurn& turn = schedule.turn(number);
            held[static_cast<std::size_t>(number)] = holds(turn) ? 1 : 0;
            taken[turn.source] += number >= first ? 1 : 0;
        }
    }
    return taken;
}

TEST(SourceSchedule, SpendsCandidatesWhereTheySucceedAboveAFloor)
{
    constexpr std::int64_t kCandidates = 384;
    constexpr std::int64_t kLast = 192;  // the last half
    SourceSchedule schedule({0, 2}, kCandidates);
    // Surface holds three of four from preshape 2, nothing else holds.
    const auto taken = runSchedule(schedule,
                                   kCandidates,
                                   kLast,
                                   [](const ApproachTurn& turn) {
                                       return turn.source == ApproachSource::Surface &&
                                              turn.preshape == 2 && turn.turn % 4 != 0;
                                   });
    EXPECT_GT(taken.at(ApproachSource::Surface), 0.6 * kLast);
    EXPECT_GE(taken.at(ApproachSource::Sphere), kLast / 40 - 2);
    EXPECT_GE(taken.at(ApproachSource::Boxes), kLast / 40 - 2);
    EXPECT_NEAR(taken.at(ApproachSource::Pinch), kLast / 4, 2);
}

/// What sources are usually worth counts less, the more is known.
TEST(SourceSchedule, TreatsEqualsAlikeInTheEnd)
{
    for (const bool holds : {false, true})
    {
        SourceSchedule schedule({0}, 1536);
        const auto taken =
            runSchedule(schedule, 1536, 0, [&](const ApproachTurn&) { return holds; });
        for (const ApproachSource source : kMixedSources)
        {
            EXPECT_GT(taken.at(source), 0.2 * 1536);
        }
    }
}

TEST(SourceSchedule, BlocksGrowAndTurnsCount)
{
    SourceSchedule schedule({1, 0}, 50);
    const std::vector<char> held(50, 1);
    std::vector<std::int64_t> ends;
    while (schedule.end() < 50)
    {
        schedule.extend(held);
        ends.push_back(schedule.end());
    }
    EXPECT_EQ(ends, (std::vector<std::int64_t>{8, 16, 24, 36, 50}));
    std::map<std::pair<ApproachSource, std::size_t>, std::int64_t> next;
    for (std::int64_t number = 0; number < 50; ++number)
    {
        const ApproachTurn& turn = schedule.turn(number);
        EXPECT_EQ(turn.turn, (next[{turn.source, turn.preshape}]++));
    }
    EXPECT_EQ(next.size(), 8U);
}

/// Small blocks do not starve what is rarely due: of 80 candidates every source gets one, and where
/// Sphere holds, it gets most of what is not kept for Pinch.
TEST(SourceSchedule, GivesMostToSphereButAsksTheOthersSoon)
{
    SourceSchedule schedule({0, 1, 2}, 80);
    const auto taken =
        runSchedule(schedule,
                    80,
                    0,
                    [](const ApproachTurn& turn) { return turn.source == ApproachSource::Sphere; });
    EXPECT_GE(taken.at(ApproachSource::Sphere), 48);
    EXPECT_NEAR(taken.at(ApproachSource::Pinch), 20, 1);
    EXPECT_GE(taken.at(ApproachSource::Surface), 1);
    EXPECT_GE(taken.at(ApproachSource::Boxes), 1);
}

/// Pinches keep their quarter whether they succeed or not, and go to the preshape where they do.
TEST(SourceSchedule, KeepsAQuarterForPinches)
{
    for (const bool holds : {false, true})
    {
        SourceSchedule schedule({0, 1}, 400);
        const auto taken = runSchedule(
            schedule,
            400,
            0,
            [&](const ApproachTurn& turn)
            { return (turn.source == ApproachSource::Pinch) == holds && turn.preshape == 1; });
        EXPECT_NEAR(taken.at(ApproachSource::Pinch), 100, 1);
        std::int64_t second = 0;  // of the pinches, those of preshape 1
        for (std::int64_t number = 0; number < schedule.end(); ++number)
        {
            const ApproachTurn& turn = schedule.turn(number);
            second += turn.source == ApproachSource::Pinch && turn.preshape == 1 ? 1 : 0;
        }
        EXPECT_TRUE(!holds || second > 80) << second;
    }
}

/// Where Sphere holds nothing, the others are asked at once.
TEST(SourceSchedule, TurnsAwayFromASourceThatFails)
{
    SourceSchedule schedule({0, 1}, 20);
    const auto taken =
        runSchedule(schedule,
                    20,
                    8,
                    [](const ApproachTurn& turn) { return turn.source == ApproachSource::Boxes; });
    EXPECT_LE(taken.at(ApproachSource::Sphere), 4);
    EXPECT_GE(taken.at(ApproachSource::Boxes), 3);  // of nine
}

void expectSameGrasps(const std::vector<Grasp>& a, const std::vector<Grasp>& b)
{
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k)
    {
        EXPECT_EQ(a[k].candidate, b[k].candidate);
        EXPECT_EQ(a[k].source, b[k].source);
        EXPECT_EQ(a[k].X_WH.matrix(), b[k].X_WH.matrix());
        EXPECT_EQ(a[k].positions, b[k].positions);
        EXPECT_EQ(a[k].quality.largestMass, b[k].quality.largestMass);
    }
}

/// Neither threads nor stops change what a mixed plan finds.
TEST(MixedPlan, IsTheSameForAllThreadsAndAfterEveryStop)
{
    const HandModel hand = makeGripper(false);
    const GraspObject object = makeGraspObject("box", makeBox({0.02, 0.03, 0.05}));
    const auto engine = [] { return kinematicClosing(); };
    PlannerOptions options{.candidates = 30, .seed = 3, .jobs = 1, .volumes = 0};
    ASSERT_EQ(options.approach.source, ApproachSource::Mixed);
    const std::vector<Grasp> whole = planGrasps(hand, object, options, engine);
    std::map<std::string, int> sources;
    for (const Grasp& grasp : whole)
    {
        ++sources[grasp.source];
    }
    EXPECT_EQ(sources.size(), 4U);
    options.jobs = 3;
    expectSameGrasps(whole, planGrasps(hand, object, options, engine));
    for (const int stopAfter : {1, 12, 17, 25})
    {
        int begun = 0;
        const std::vector<Grasp> part = planGrasps(
            hand, object, options, engine, {.stop = [&] { return ++begun > stopAfter; }});
        EXPECT_LT(part.size(), whole.size());
        expectSameGrasps(whole, planGrasps(hand, object, options, engine, {.known = part}));
    }
}

/// Two jaws that press with at most F at two points opposite each other. Weight W at an angle t to
/// the line between them takes W cos t from one of the forces, and half of W sin t rests on the
/// friction of each, for they must not turn the object: W (sin t + 2 mu cos t) <= 2 mu F. The worst
/// direction carries 2 mu F / sqrt(1 + 4 mu^2).
TEST(LargestMass, IsThatOfAPinchInClosedForm)
{
    constexpr double kForce = 10.0;
    constexpr double kMu = 0.5;
    constexpr double kGravity = 9.80665;
    const GraspObject object = makeGraspObject("box", makeBox({0.02, 0.03, 0.05}));
    HandModel hand = makeGripper(false);
    Grasp grasp;
    grasp.positions = {0.0, 0.02, 0.02};
    grasp.contacts = {{.link = 1, .point = {-0.02, 0.0, 0.0}, .normal = Eigen::Vector3d::UnitX()},
                      {.link = 2, .point = {0.02, 0.0, 0.0}, .normal = -Eigen::Vector3d::UnitX()}};
    // No efforts are stated: 40 N a jaw are assumed, which is what one may say, too.
    const std::vector<double> usual{40.0, 40.0};
    EXPECT_EQ(largestMassHeld(hand, object, grasp, kMu, 8),
              largestMassHeld(hand, object, grasp, kMu, 8, usual));
    const std::vector<double> unlimited(2, std::numeric_limits<double>::infinity());
    EXPECT_TRUE(std::isinf(largestMassHeld(hand, object, grasp, kMu, 8, unlimited)));
    EXPECT_THROW((void)largestMassHeld(hand, object, grasp, kMu, 8, {usual.data(), 1}),
                 std::invalid_argument);
    for (std::size_t link = 1; link <= 2; ++link)
    {
        hand.robot.tree.links[link].joint.maxEffort = kForce;
    }
    const double exact = 2.0 * kMu * kForce / std::sqrt(1.0 + 4.0 * kMu * kMu) / kGravity;
    const double mass = largestMassHeld(hand, object, grasp, kMu, 32);
    EXPECT_LE(mass, exact * (1.0 + 1e-9));
    EXPECT_GE(mass, 0.75 * exact);
    // Twice the force carries twice the mass; a contact without an opposite one carries nothing.
    for (std::size_t link = 1; link <= 2; ++link)
    {
        hand.robot.tree.links[link].joint.maxEffort = 2.0 * kForce;
    }
    EXPECT_NEAR(largestMassHeld(hand, object, grasp, kMu, 32), 2.0 * mass, 1e-6);
    grasp.contacts.pop_back();
    EXPECT_EQ(largestMassHeld(hand, object, grasp, kMu, 32), 0.0);
}
}  // namespace
}  // namespace bullet_ccd::grasp
