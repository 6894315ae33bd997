// The robots as the build writes them: description and meshes together.
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "grasp/hand/hand_model.h"
#include "tests/robots/mesh_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gmock/gmock.h>
#include <map>
#include <numbers>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kDensity = 1500.0;

HandModel load(const std::string& name)
{
    return loadHand(std::filesystem::path(BULLET_CCD_SHARE) / "robots" / name / (name + ".urdf"));
}

std::size_t linkOf(const HandModel& hand, const std::string& name)
{
    const std::int32_t link = hand.robot.tree.findLink(name);
    EXPECT_NE(link, kNone) << name;
    return static_cast<std::size_t>(std::max(link, 0));
}

/// Positions of the preshape, closing joints moved `share` of the way to their limits.
std::vector<double> closedBy(const HandModel& hand, const Preshape& preshape, double share)
{
    const std::vector<double> target = closedPositions(hand, preshape.positions);
    std::vector<double> positions = preshape.positions;
    for (std::size_t i = 0; i < positions.size(); ++i)
    {
        positions[i] += share * (target[i] - positions[i]);
    }
    applyMimics(hand.robot.tree, positions);
    return positions;
}

std::vector<Eigen::Isometry3d> poses(const HandModel& hand, const std::vector<double>& positions)
{
    return linkPoses(hand.robot.tree, Eigen::Isometry3d::Identity(), positions);
}

/// Least distance of all pairs of links that the SRDF leaves to be checked.
double selfClearance(const HandModel& hand, const std::vector<double>& positions)
{
    const std::vector<Eigen::Isometry3d> X = poses(hand, positions);
    double least = 1.0;
    for (const auto& [a, b] : hand.selfPairs)
    {
        const auto i = static_cast<std::size_t>(a);
        const auto j = static_cast<std::size_t>(b);
        least = std::min(
            least,
            treeDistance(*hand.linkTrees[i], *hand.linkTrees[j], X[j].inverse() * X[i], least)
                .distance);
    }
    return least;
}

const Preshape& preshapeOf(const HandModel& hand, const std::string& name)
{
    const auto found = std::ranges::find(hand.preshapes, name, &Preshape::name);
    EXPECT_NE(found, hand.preshapes.end()) << name;
    return found == hand.preshapes.end() ? hand.preshapes.front() : *found;
}

class ShippedRobots : public testing::TestWithParam<const char*>
{
};

TEST_P(ShippedRobots, LoadsWithoutAnythingAssumedOrRepaired)
{
    const HandModel hand = load(GetParam());
    EXPECT_EQ(hand.robot.name, GetParam());
    EXPECT_THAT(hand.robot.notes, testing::IsEmpty());
    EXPECT_THAT(hand.notes, testing::IsEmpty());
    EXPECT_EQ(hand.preshapes.front().name, "open");
    EXPECT_GE(hand.preshapes.size(), 2U);
}

TEST_P(ShippedRobots, LinkMeshesAreClosedAndWellShaped)
{
    const HandModel hand = load(GetParam());
    for (const TriangleMesh& mesh : hand.robot.linkMeshes)
    {
        EXPECT_TRUE(isWatertight(mesh));
        EXPECT_TRUE(tests::everyVertexHasOneFan(mesh));
        EXPECT_EQ(tests::eulerCharacteristic(mesh), 2);
        EXPECT_GT(tests::worstShape(mesh), 0.05);
    }
}

TEST_P(ShippedRobots, InertialsAreThoseOfTheMeshes)
{
    const RobotModel robot = load(GetParam()).robot;
    for (std::size_t i = 0; i < robot.tree.size(); ++i)
    {
        const Link& link = robot.tree.links[i];
        const MassProperties mass = massProperties(robot.linkMeshes[i]);
        EXPECT_NEAR(link.mass, kDensity * mass.volume, 0.01 * link.mass) << link.name;
        EXPECT_LT((link.centerOfMass - mass.center).norm(), 2e-4) << link.name;
        EXPECT_LT((link.inertia - kDensity * mass.inertia).norm(), 0.02 * link.inertia.norm())
            << link.name;
    }
}

TEST_P(ShippedRobots, PreshapesLieWithinLimitsAndClearOfSelfContact)
{
    const HandModel hand = load(GetParam());
    for (const Preshape& preshape : hand.preshapes)
    {
        for (std::size_t i = 1; i < hand.robot.tree.size(); ++i)
        {
            const Joint& joint = hand.robot.tree.links[i].joint;
            EXPECT_GE(preshape.positions[i], joint.lower - 1e-9) << joint.name;
            EXPECT_LE(preshape.positions[i], joint.upper + 1e-9) << joint.name;
        }
        EXPECT_GT(selfClearance(hand, preshape.positions), 1e-3) << preshape.name;
    }
}

TEST_P(ShippedRobots, EveryFingerHasAJointThatCloses)
{
    const HandModel hand = load(GetParam());
    for (const Finger& finger : hand.fingers)
    {
        EXPECT_TRUE(std::ranges::any_of(
            finger.links,
            [&](std::int32_t link)
            { return hand.closingDirections[static_cast<std::size_t>(link)] != 0; }))
            << finger.name;
    }
}

/// Parts of neighbours that are away from their joint must not touch, however the joint turns.
TEST_P(ShippedRobots, NeighboursOverlapAtTheirJointOnly)
{
    const HandModel hand = load(GetParam());
    const KinematicTree& tree = hand.robot.tree;
    constexpr double kJointRegion = 0.023;
    int checked = 0;
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        TriangleMesh away = hand.robot.linkMeshes[i];
        std::erase_if(
            away.triangles,
            [&](const Triangle& t)
            {
                return std::ranges::any_of(
                    t,
                    [&](std::int32_t v)
                    { return away.vertices[static_cast<std::size_t>(v)].norm() < kJointRegion; });
            });
        if (joint.type == JointType::Prismatic || away.triangles.empty())
        {
            continue;
        }
        repairMesh(away);
        const SsvTree tipTree = buildSsvTree(away);
        const auto parent = static_cast<std::size_t>(tree.links[i].parent);
        for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0})
        {
            const double q = joint.lower + share * (joint.upper - joint.lower);
            const double distance =
                treeDistance(tipTree, *hand.linkTrees[parent], linkInParent(tree.links[i], q), 1.0)
                    .distance;
            EXPECT_GT(distance, 5e-4) << joint.name << " at " << q;
            ++checked;
        }
    }
    if (std::string(GetParam()) != "parallel_gripper")
    {
        EXPECT_GT(checked, 20);
    }
}

INSTANTIATE_TEST_SUITE_P(All,
                         ShippedRobots,
                         testing::Values("anthropomorphic_hand",
                                         "three_finger_gripper",
                                         "parallel_gripper"),
                         [](const auto& test) { return std::string(test.param); });

TEST(AnthropomorphicHand, HasSeventeenRevoluteJointsAndTwentyThousandTriangles)
{
    const HandModel hand = load("anthropomorphic_hand");
    ASSERT_EQ(hand.robot.tree.size(), 18U);
    std::size_t triangles = hand.robot.linkMeshes[0].triangles.size();
    for (std::size_t i = 1; i < 18; ++i)
    {
        const Joint& joint = hand.robot.tree.links[i].joint;
        EXPECT_EQ(joint.type, JointType::Revolute) << joint.name;
        EXPECT_EQ(joint.mimicOf, kNone) << joint.name;
        triangles += hand.robot.linkMeshes[i].triangles.size();
    }
    EXPECT_GE(triangles, 19000U);
    EXPECT_LE(triangles, 21000U);
}

TEST(AnthropomorphicHand, FingersAreFourAlikeWithTheLengthsAndLimitsOfTheOriginal)
{
    const HandModel hand = load("anthropomorphic_hand");
    const KinematicTree& tree = hand.robot.tree;
    ASSERT_EQ(hand.fingers.size(), 4U);
    for (const std::string finger : {"thumb", "fore", "middle", "ring"})
    {
        for (const std::string bone : {"_knuckle", "_proximal", "_medial", "_distal"})
        {
            EXPECT_EQ(contentHash(hand.robot.linkMeshes[linkOf(hand, finger + bone)]),
                      contentHash(hand.robot.linkMeshes[linkOf(hand, "fore" + bone)]));
        }
        const auto linkNamed = [&](const std::string& bone) -> const Link&
        { return tree.links[linkOf(hand, finger + bone)]; };
        EXPECT_NEAR(linkNamed("_medial").X_PL0.translation().norm(), 0.067816, 1e-9);
        EXPECT_NEAR(linkNamed("_distal").X_PL0.translation().norm(), 0.029980, 1e-9);
        const double tip =
            bounds(hand.robot.linkMeshes[linkOf(hand, finger + "_distal")]).max().z();
        EXPECT_NEAR(tip, 0.029, 1e-9);
        const auto expectLimits = [&](const std::string& bone, double lower, double upper)
        {
            EXPECT_NEAR(linkNamed(bone).joint.lower, lower * kDegree, 1e-4);
            EXPECT_NEAR(linkNamed(bone).joint.upper, upper * kDegree, 1e-4);
        };
        expectLimits("_knuckle", -15.0, 15.0);
        expectLimits("_proximal", -4.0, 75.0);
        expectLimits("_medial", 4.0, 75.0);
        expectLimits("_distal", 4.0, 75.0);
    }
}

Eigen::Vector3d fingertip(const HandModel& hand,
                          const std::vector<Eigen::Isometry3d>& X,
                          const std::string& finger)
{
    return X[linkOf(hand, finger + "_distal")] * Eigen::Vector3d(0.0, 0.0, 0.029);
}

TEST(AnthropomorphicHand, FingertipFollowsThePublishedKinematics)
{
    const HandModel hand = load("anthropomorphic_hand");
    const double q1 = 0.2;
    const double q2 = 0.5;
    const double q3 = 0.7;
    std::vector<double> positions(hand.robot.tree.size(), 0.0);
    positions[linkOf(hand, "middle_knuckle")] = q1;
    positions[linkOf(hand, "middle_proximal")] = q2;
    positions[linkOf(hand, "middle_medial")] = q3;
    positions[linkOf(hand, "middle_distal")] = q3;
    const Eigen::Vector3d tip =
        fingertip(hand, poses(hand, positions), "middle") -
        hand.robot.tree.links[linkOf(hand, "middle_knuckle")].X_PL0.translation();
    const double along =
        0.067816 * std::cos(q2) + 0.02998 * std::cos(q2 + q3) + 0.029 * std::cos(q2 + 2.0 * q3);
    const double down =
        0.067816 * std::sin(q2) + 0.02998 * std::sin(q2 + q3) + 0.029 * std::sin(q2 + 2.0 * q3);
    EXPECT_TRUE(
        tip.isApprox(Eigen::Vector3d(down, -std::sin(q1) * along, std::cos(q1) * along), 1e-6))
        << tip.transpose();
}

TEST(AnthropomorphicHand, ThumbOpposesTheFingersAroundASixCentimetreObject)
{
    const HandModel hand = load("anthropomorphic_hand");
    const Preshape& open = preshapeOf(hand, "open");
    const Eigen::Vector3d center = hand.X_RG.translation();
    const auto openPoses = poses(hand, open.positions);
    EXPECT_GT((fingertip(hand, openPoses, "thumb") - fingertip(hand, openPoses, "middle")).norm(),
              0.10)
        << "wide enough for a bottle";
    double share = 0.0;
    double gap = 1.0;
    while (gap > 0.06 && share < 1.0)
    {
        share += 0.002;
        const auto X = poses(hand, closedBy(hand, open, share));
        gap = (fingertip(hand, X, "thumb") - fingertip(hand, X, "middle")).norm();
    }
    ASSERT_LT(share, 0.5);
    const std::vector<double> holding = closedBy(hand, open, share);
    const auto X = poses(hand, holding);
    const Eigen::Vector3d across = fingertip(hand, X, "thumb") - fingertip(hand, X, "middle");
    EXPECT_GT(across.dot(hand.X_RG.linear().col(0)), 0.9 * across.norm()) << "along +x";
    for (const std::string finger : {"thumb", "fore", "middle", "ring"})
    {
        EXPECT_LT((fingertip(hand, X, finger) - center).norm(),
                  0.85 * (fingertip(hand, openPoses, finger) - center).norm())
            << finger;
    }
    // Links keep clear of each other all the way.
    for (double s = 0.0; s <= share; s += 0.05)
    {
        EXPECT_GT(selfClearance(hand, closedBy(hand, open, s)), 1e-3) << s;
    }
}

TEST(AnthropomorphicHand, FingersCurlClearOfPalmAndNeighboursWhenTheThumbIsAside)
{
    const HandModel hand = load("anthropomorphic_hand");
    std::vector<double> positions = preshapeOf(hand, "open").positions;
    positions[linkOf(hand, "thumb_base")] = 0.0;
    for (const std::string finger : {"fore", "middle", "ring"})
    {
        for (const std::string bone : {"_proximal", "_medial", "_distal"})
        {
            const std::size_t link = linkOf(hand, finger + bone);
            positions[link] = hand.robot.tree.links[link].joint.upper;
        }
    }
    EXPECT_GT(selfClearance(hand, positions), 1e-3);
}

TEST(ThreeFingerGripper, CouplesSpreadAndDistalJoints)
{
    const HandModel hand = load("three_finger_gripper");
    int driven = 0;
    int mimics = 0;
    for (std::size_t i = 1; i < hand.robot.tree.size(); ++i)
    {
        (hand.robot.tree.links[i].joint.mimicOf == kNone ? driven : mimics) += 1;
    }
    EXPECT_EQ(driven, 4);
    EXPECT_EQ(mimics, 4);
    EXPECT_EQ(hand.fingers.size(), 3U);
}

TEST(ThreeFingerGripper, TipsMeetOverThePalmInEveryPreshape)
{
    const HandModel hand = load("three_finger_gripper");
    for (const Preshape& preshape : hand.preshapes)
    {
        // Closed until the bones stand upright: q = 90 degrees.
        std::vector<double> positions = preshape.positions;
        const auto before = poses(hand, positions);
        for (const std::string finger : {"finger_1", "finger_2", "finger_3"})
        {
            positions[linkOf(hand, finger + "_proximal")] = 90.0 * kDegree;
        }
        applyMimics(hand.robot.tree, positions);
        const auto after = poses(hand, positions);
        for (const std::string finger : {"finger_1", "finger_2", "finger_3"})
        {
            const std::size_t link = linkOf(hand, finger + "_distal");
            const Eigen::Vector3d tip(0.0, 0.0, 0.056);
            const Eigen::Vector3d center = hand.X_RG.translation();
            EXPECT_LT((after[link] * tip - center).norm(),
                      0.6 * (before[link] * tip - center).norm())
                << preshape.name << " " << finger;
        }
    }
}

TEST(ParallelGripper, OpensFromZeroToAHundredMillimetres)
{
    const HandModel hand = load("parallel_gripper");
    for (const double opening : {0.0, 0.04, 0.1})
    {
        std::vector<double> positions(hand.robot.tree.size(), 0.0);
        positions[linkOf(hand, "left_jaw")] = 0.5 * opening;
        applyMimics(hand.robot.tree, positions);
        const auto X = poses(hand, positions);
        const auto extentAlongX = [&](const std::string& name)
        {
            TriangleMesh mesh = hand.robot.linkMeshes[linkOf(hand, name)];
            transformMesh(mesh, Eigen::Affine3d(X[linkOf(hand, name)]));
            return bounds(mesh);
        };
        EXPECT_NEAR(extentAlongX("left_jaw").min().x(), 0.5 * opening, 1e-6);
        EXPECT_NEAR(extentAlongX("right_jaw").max().x(), -0.5 * opening, 1e-6);
    }
    EXPECT_EQ(hand.closingDirections[linkOf(hand, "left_jaw")], -1);
    // The grasp frame lies between the pads.
    const TriangleMesh& jaw = hand.robot.linkMeshes[linkOf(hand, "left_jaw")];
    EXPECT_GT(hand.X_RG.translation().z(), 0.070 + 0.036);
    EXPECT_LT(hand.X_RG.translation().z(), 0.070 + bounds(jaw).max().z());
}
}  // namespace
}  // namespace bullet_ccd::grasp
