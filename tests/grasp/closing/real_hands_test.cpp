#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/io/mesh_file.h"
#include "grasp/check/penetration_check.h"
#include "grasp/closing/closing.h"
#include "grasp/hand/hand_model.h"
#include "grasp/sim/hand_simulation.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <thread>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Isometry3d;
using grasp::ClosingResult;
using grasp::GraspObject;
using grasp::HandModel;
using grasp::HandSimulation;

std::size_t at(std::int32_t index)
{
    return static_cast<std::size_t>(index);
}

HandModel handFrom(const std::filesystem::path& urdf)
{
    return grasp::loadHand(urdf, std::nullopt, BULLET_CCD_SHARE_FOLDER);
}

/// The hand comes from a random direction and ends with its fingers about the object.
Isometry3d randomApproach(Random& random, const HandModel& hand, const GraspObject& object)
{
    Isometry3d X_WG = Isometry3d::Identity();
    X_WG.linear() = random.rotation();
    X_WG.translation() =
        object.centerOfMass + random.inBox(0.01) - random.uniform(0.0, 0.05) * X_WG.linear().col(2);
    return X_WG * hand.X_RG.inverse();
}

/// Distance of the hand from the object, or 1 mm if it is more.
double smallestGap(const HandModel& hand,
                   const GraspObject& object,
                   const Isometry3d& X_WH,
                   const std::vector<double>& positions)
{
    double gap = 1e-3;  // farther is far enough
    const std::vector<Isometry3d> poses = linkPoses(hand.robot.tree, X_WH, positions);
    for (std::size_t i = 0; i < poses.size(); ++i)
    {
        if (hand.linkTrees[i] != nullptr)
        {
            gap = treeDistance(*hand.linkTrees[i], object.tree, poses[i], gap).distance;
        }
    }
    return gap;
}

/// Links that the object stopped touch it in the end, where and as closely as the closing says.
void expectContactsOfTheFinalPosture(const HandModel& hand,
                                     const GraspObject& object,
                                     const Isometry3d& X_WH,
                                     const ClosingResult& result,
                                     double tolerance = kDefaultTolerance)
{
    const std::vector<Isometry3d> poses = linkPoses(hand.robot.tree, X_WH, result.positions);
    const auto distance = [](const SsvTree& a, const SsvTree& b, const Isometry3d& X_BA)
    { return treeDistance(a, b, X_BA, 1.0).distance; };
    std::vector<std::int32_t> stopped;
    for (const grasp::StopEvent& stop : result.stops)
    {
        if (stop.byObject)
        {
            stopped.push_back(stop.link);
        }
    }
    ASSERT_EQ(result.contacts.size(), stopped.size());
    for (std::size_t i = 0; i < stopped.size(); ++i)
    {
        const grasp::GraspContact& contact = result.contacts[i];
        EXPECT_EQ(contact.link, stopped[i]);
        const SsvTree& link = *hand.linkTrees[at(contact.link)];
        const Isometry3d& X_WL = poses[at(contact.link)];
        // Other points of the two may be nearer, but none is farther apart than the tolerance.
        EXPECT_LE(contact.gap, 1.0005 * tolerance);
        EXPECT_LE(distance(link, object.tree, X_WL), contact.gap + 1e-9);
        const auto pointAt = [&](double along)
        { return buildSsvTree(shifted(cube(1e-10), contact.point - along * contact.normal)); };
        EXPECT_LE(distance(pointAt(0.0), object.tree, Isometry3d::Identity()), 1e-9);
        EXPECT_LE(distance(link, pointAt(contact.gap), X_WL), 1e-9);
    }
}

/// Positions on the way: every joint moves at its constant speed until it stops for good.
std::vector<double> positionsAt(const HandModel& hand,
                                const std::vector<double>& from,
                                const std::vector<double>& to,
                                double time)
{
    std::vector<double> positions = from;
    for (std::size_t i = 1; i < from.size(); ++i)
    {
        const Joint& joint = hand.robot.tree.links[i].joint;
        if (joint.isMovable() && joint.mimicOf == kNone)
        {
            const double speed = (joint.type == JointType::Prismatic ? 0.1 : 1.0) *
                                 (hand.closingSpeeds.empty() ? 1.0 : hand.closingSpeeds[i]);
            const double way = std::min(speed * time, std::abs(to[i] - from[i]));
            positions[i] += std::copysign(way, to[i] - from[i]);
        }
    }
    applyMimics(hand.robot.tree, positions);
    return positions;
}

struct Case
{
    const char* hand;
    const char* object;
};

class RealHand : public testing::TestWithParam<Case>
{
};
}  // namespace

TEST_P(RealHand, NeverPenetratesOnTheWayNorAtTheEnd)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(handFile, std::string("hands/") + GetParam().hand);
    BULLET_CCD_TEST_DATA_OR_SKIP(objectFile, std::string("objects/") + GetParam().object);
    const HandModel hand = handFrom(handFile);
    const GraspObject object = grasp::makeGraspObject("object", loadMeshFile(objectFile).mesh);
    const std::vector<double>& open = hand.preshapes.front().positions;
    HandSimulation simulation(hand, object);
    Random random(7);
    int closed = 0;
    std::size_t stops = 0;
    for (int trial = 0; trial < 60 && closed < 6; ++trial)
    {
        const Isometry3d X_WH = randomApproach(random, hand, object);
        const ClosingResult result = simulation.close(X_WH, open, {});
        if (result.status == ToiStatus::Overlapping)
        {
            EXPECT_LT(smallestGap(hand, object, X_WH, open), 1e-9);
            continue;
        }
        ASSERT_NE(result.status, ToiStatus::IterationLimit);
        ++closed;
        stops += result.stops.size();
        EXPECT_GT(smallestGap(hand, object, X_WH, result.positions), 0.0);
        EXPECT_TRUE(grasp::checkPenetration(hand, object, X_WH, result.positions).clean());
        for (std::size_t i = 1; i < result.stops.size(); ++i)
        {
            EXPECT_LE(result.stops[i - 1].time, result.stops[i].time);
        }
        expectContactsOfTheFinalPosture(hand, object, X_WH, result);
        for (int sample = 0; sample < 25; ++sample)
        {
            // Joints at their usual speed are there within two seconds, slow ones at the last stop.
            const double end =
                sample % 2 == 0 || result.stops.empty() ? 2.0 : result.stops.back().time;
            const double time = end * sample / 24.0;
            const std::vector<double> on = positionsAt(hand, open, result.positions, time);
            EXPECT_GT(smallestGap(hand, object, X_WH, on), 0.0) << "after " << time << " s";
        }
        std::vector<double> coupled = result.positions;
        applyMimics(hand.robot.tree, coupled);
        for (std::size_t i = 0; i < coupled.size(); ++i)
        {
            EXPECT_NEAR(coupled[i], result.positions[i], 1e-9);
        }
    }
    EXPECT_GE(closed, 3) << "the test is vacuous";
    EXPECT_GE(stops, static_cast<std::size_t>(closed));
}

namespace
{
std::set<std::int32_t> linksOf(const ClosingResult& result)
{
    std::set<std::int32_t> links;
    for (const grasp::StopEvent& stop : result.stops)
    {
        links.insert(stop.link);
    }
    return links;
}

/// Same links in contact, and every joint within 0.01 (rad or m).
bool alike(const ClosingResult& a, const ClosingResult& b)
{
    bool near = a.status == b.status && linksOf(a) == linksOf(b);
    for (std::size_t i = 0; i < a.positions.size(); ++i)
    {
        near = near && std::abs(a.positions[i] - b.positions[i]) <= 0.01;
    }
    return near;
}

/// Closes at random poses until `wanted` closings were possible; the engines must agree.
void expectEnginesAgree(const HandModel& hand,
                        const GraspObject& object,
                        const grasp::ClosingOptions& options,
                        int wanted)
{
    const std::vector<double>& open = hand.preshapes.front().positions;
    HandSimulation simulation(hand, object);
    const grasp::CloseHand kinematic = grasp::kinematicClosing();
    Random random(11);
    int closed = 0;
    int same = 0;
    for (int trial = 0; trial < 200 && closed < wanted; ++trial)
    {
        const Isometry3d X_WH = randomApproach(random, hand, object);
        const ClosingResult expected = simulation.close(X_WH, open, options);
        const ClosingResult result = kinematic(hand, object, X_WH, open, options);
        EXPECT_EQ(result.status == ToiStatus::Overlapping,
                  expected.status == ToiStatus::Overlapping);
        if (expected.status != ToiStatus::Overlapping)
        {
            ++closed;
            same += alike(result, expected) ? 1 : 0;
            EXPECT_TRUE(grasp::checkPenetration(hand, object, X_WH, result.positions).clean());
            expectContactsOfTheFinalPosture(hand, object, X_WH, result);
        }
    }
    EXPECT_GE(closed, 5) << "the test is vacuous";
    EXPECT_GE(same, closed - closed / 20);
}
}  // namespace

/// Tolerances coarser than usual look at less of the meshes, and nothing else changes.
TEST_P(RealHand, KeepsAnAccuracyOnTheFullMeshes)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(handFile, std::string("hands/") + GetParam().hand);
    BULLET_CCD_TEST_DATA_OR_SKIP(objectFile, std::string("objects/") + GetParam().object);
    const HandModel hand = handFrom(handFile);
    const GraspObject object = grasp::makeGraspObject("object", loadMeshFile(objectFile).mesh);
    const std::vector<double>& open = hand.preshapes.front().positions;
    const grasp::CloseHand close = grasp::kinematicClosing();
    const int wanted = longTests() ? 40 : 4;
    for (const double accuracy : {1e-5, 1e-4, 5e-4, 1e-3, 5e-3})
    {
        Random random(5);
        int closed = 0;
        std::size_t touched = 0;
        for (int trial = 0; trial < 40 * wanted && closed < wanted; ++trial)
        {
            const Isometry3d X_WH = randomApproach(random, hand, object);
            const ClosingResult result =
                close(hand, object, X_WH, open, {.tolerance = accuracy, .contactThreshold = 1e-2});
            ASSERT_NE(result.status, ToiStatus::IterationLimit);
            if (result.status == ToiStatus::Overlapping)
            {
                continue;
            }
            ++closed;
            touched += result.contacts.size();
            EXPECT_TRUE(grasp::checkPenetration(hand, object, X_WH, result.positions).clean())
                << accuracy;
            expectContactsOfTheFinalPosture(hand, object, X_WH, result, accuracy);
        }
        EXPECT_EQ(closed, wanted) << "the test is vacuous";
        EXPECT_GT(touched, 0U) << "the test is vacuous";
    }
}

TEST_P(RealHand, KinematicAndSimulatedClosingAgree)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(handFile, std::string("hands/") + GetParam().hand);
    BULLET_CCD_TEST_DATA_OR_SKIP(objectFile, std::string("objects/") + GetParam().object);
    const HandModel hand = handFrom(handFile);
    const GraspObject object = grasp::makeGraspObject("object", loadMeshFile(objectFile).mesh);
    expectEnginesAgree(hand, object, {}, 20);
    expectEnginesAgree(hand, object, {.order = grasp::ClosingOrder::OneByOne}, 10);
}

INSTANTIATE_TEST_SUITE_P(
    HandSimulation,
    RealHand,
    testing::Values(Case{"schunk_sah/schunk_sah_right_mesh.urdf", "ycb_16k/025_mug.obj"},
                    Case{"barrett/barrett_mesh.urdf", "ycb_16k/011_banana.obj"},
                    Case{"panda_gripper/panda_gripper_mesh.urdf", "ycb_16k/037_scissors.obj"},
                    Case{"shadow/shadow_right_mesh.urdf", "ycb_16k/056_tennis_ball.ply"}),
    [](const auto& test)
    {
        const std::string hand = test.param.hand;
        return hand.substr(0, hand.find('/'));
    });

namespace
{
bool same(const ClosingResult& a, const ClosingResult& b)
{
    return a.status == b.status && a.positions == b.positions && a.steps == b.steps &&
           std::equal(a.stops.begin(),
                      a.stops.end(),
                      b.stops.begin(),
                      b.stops.end(),
                      [](const grasp::StopEvent& x, const grasp::StopEvent& y)
                      { return x.link == y.link && x.time == y.time && x.byObject == y.byObject; });
}
}  // namespace

TEST(HandSimulation, ResultsDoNotDependOnHistoryOrThreads)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(handFile, "hands/schunk_sah/schunk_sah_right_mesh.urdf");
    BULLET_CCD_TEST_DATA_OR_SKIP(objectFile, "objects/ycb_4k/025_mug.obj");
    const HandModel hand = handFrom(handFile);
    const GraspObject object = grasp::makeGraspObject("mug", loadMeshFile(objectFile).mesh);
    const std::vector<double>& open = hand.preshapes.front().positions;
    Random random(3);
    std::vector<Isometry3d> poses;
    for (int i = 0; i < 8; ++i)
    {
        poses.push_back(randomApproach(random, hand, object));
    }

    const auto closeAll = [&](bool backwards)
    {
        const grasp::CloseHand close = grasp::simulatedClosing()();
        std::vector<ClosingResult> results(poses.size());
        for (std::size_t i = 0; i < poses.size(); ++i)
        {
            const std::size_t k = backwards ? poses.size() - 1 - i : i;
            results[k] = close(hand, object, poses[k], open, {});
        }
        return results;
    };
    std::vector<ClosingResult> forwards;
    std::vector<ClosingResult> backwards;
    std::thread first([&] { forwards = closeAll(false); });
    std::thread second([&] { backwards = closeAll(true); });
    first.join();
    second.join();
    int moved = 0;
    for (std::size_t i = 0; i < poses.size(); ++i)
    {
        const ClosingResult fresh = HandSimulation(hand, object).close(poses[i], open, {});
        EXPECT_TRUE(same(fresh, forwards[i]));
        EXPECT_TRUE(same(fresh, backwards[i]));
        moved += fresh.steps > 0 ? 1 : 0;
    }
    EXPECT_GE(moved, 3) << "the test is vacuous";
}
}  // namespace bullet_ccd::tests
