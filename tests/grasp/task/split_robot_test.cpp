/// Robots of one file are split where their hands begin.
#include "grasp/task/split_robot.h"

#include "bullet_ccd/io/robot_file.h"
#include "grasp/hand/hand_model.h"
#include "grasp/task/arm_robot.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <fstream>
#include <gmock/gmock.h>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::grasp
{
namespace
{
using testing::ElementsAre;
using testing::HasSubstr;
using tests::TempFolder;

constexpr double kApart = 0.9;

/// The arm that ships with a hand that ships, as one file.
struct Composed
{
    HandModel hand;
    ArmRobot robot;
    std::filesystem::path file;
};

Composed composed(const std::string& hand, const TempFolder& folder)
{
    Composed r;
    const std::string share = BULLET_CCD_SHARE;
    r.hand = loadHand(share + "/robots/" + hand + "/" + hand + ".urdf");
    r.robot = mountHand(loadRobot(share + "/robots/arms/seven_joint_arm.urdf"),
                        r.hand,
                        "",
                        Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 0.01)));
    r.file = folder.path() / "whole.urdf";
    writeUrdf(wholeRobot(r.robot, r.hand).robot, r.file);
    return r;
}

std::string linkNameOf(const auto& robot, std::int32_t link)
{
    return robot.tree.links[static_cast<std::size_t>(link)].name;
}

std::string errorOf(const RobotModel& robot, const std::vector<std::string>& named = {})
{
    try
    {
        (void)findHandRoots(robot, std::nullopt, named);
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return "";
}

class SplitRobots : public testing::TestWithParam<const char*>
{
};

TEST_P(SplitRobots, AreTheArmAndTheHandThatTheyWereMadeOf)
{
    const TempFolder folder;
    const Composed whole = composed(GetParam(), folder);
    const RobotModel robot = loadRobot(whole.file);
    const std::vector<std::int32_t> roots = findHandRoots(robot, std::nullopt, {});
    ASSERT_EQ(roots.size(), 1U);
    const SplitRobot split = splitRobot(robot, roots.front());
    EXPECT_EQ(split.arm.tree.size() + split.hand.tree.size(), robot.tree.size());
    const HandModel hand =
        handOf(splitRobot(robot, roots.front()).hand, robot.tree, whole.hand.srdfFile);
    const ArmRobot again = mountHand(split.arm, hand, split.flange, split.X_FH);

    // The same fingers, and all links where they were.
    ASSERT_EQ(hand.fingers.size(), whole.hand.fingers.size());
    EXPECT_EQ(again.joints.size(), whole.robot.joints.size());
    std::vector<double> before(whole.robot.tree.size(), 0.0);
    std::vector<double> after(again.tree.size(), 0.0);
    for (std::size_t i = 1; i < before.size(); ++i)
    {
        const Joint& joint = whole.robot.tree.links[i].joint;
        if (joint.isMovable())
        {
            before[i] = 0.3 * joint.lower + 0.7 * joint.upper;
            const std::int32_t same = again.tree.findJoint(joint.name);
            ASSERT_NE(same, kNone) << joint.name;
            after[static_cast<std::size_t>(same)] = before[i];
        }
    }
    const Eigen::Isometry3d X_WR = Eigen::Isometry3d::Identity();
    const auto X_WLBefore = linkPoses(whole.robot.tree, X_WR, before);
    const auto X_WLAfter = linkPoses(again.tree, X_WR, after);
    for (std::size_t i = 0; i < before.size(); ++i)
    {
        const Link& link = whole.robot.tree.links[i];
        const std::int32_t same = again.tree.findLink(link.name);
        ASSERT_NE(same, kNone) << link.name;
        const auto k = static_cast<std::size_t>(same);
        EXPECT_TRUE(X_WLBefore[i].isApprox(X_WLAfter[k], 1e-9)) << link.name;
        EXPECT_EQ(whole.robot.linkTrees[i] == nullptr, again.linkTrees[k] == nullptr) << link.name;
    }
}

INSTANTIATE_TEST_SUITE_P(Hands,
                         SplitRobots,
                         testing::Values("parallel_gripper",
                                         "three_finger_gripper",
                                         "anthropomorphic_hand"));

TEST(SplitRobot, HandsAreNamedByEndEffectorsAndByUsers)
{
    const TempFolder folder;
    const Composed whole = composed("parallel_gripper", folder);
    const RobotModel robot = loadRobot(whole.file);
    const std::int32_t palm = robot.tree.findLink(linkNameOf(whole.robot, whole.robot.handRoot));
    const std::string finger =
        linkNameOf(robot, whole.robot.ofHand(whole.hand.fingers[0].links[0]));
    const std::filesystem::path srdf = folder.path() / "whole.srdf";
    const auto write = [&](const std::string& parent, const std::string& link)
    {
        std::ofstream(srdf)
            << "<robot name=\"r\"><group name=\"hand\"><link name=\"" << link
            << "\"/></group><group name=\"arm\"><chain base_link=\"" << robot.tree.links[0].name
            << "\" tip_link=\"flange\"/></group>"
            << "<group_state name=\"home\" group=\"arm\"><joint name=\"elbow_joint\" "
               "value=\"-1\"/></group_state>"
            << "<disable_collisions link1=\"flange\" link2=\"" << link << "\" reason=\"Adjacent\"/>"
            << "<end_effector name=\"e\" parent_link=\"" << parent << "\" group=\"hand\"/></robot>";
    };
    write("flange", finger);
    EXPECT_THAT(findHandRoots(robot, srdf, {}), ElementsAre(palm));
    // What it says of the arm is left out.
    const HandModel hand = handOf(splitRobot(robot, palm).hand, robot.tree, srdf);
    EXPECT_EQ(hand.fingers.size(), 2U);
    EXPECT_THAT(findHandRoots(robot, srdf, std::vector<std::string>{finger}),
                ElementsAre(robot.tree.findLink(finger)))
        << "what is named goes before the SRDF";
    write("flange", "forearm");
    EXPECT_THROW((void)findHandRoots(robot, srdf, {}), std::runtime_error);
    write("flansh", finger);
    EXPECT_THROW((void)findHandRoots(robot, srdf, {}), std::runtime_error);
}

TEST(SplitRobot, APalmThatAJointMovesIsCarriedByALinkWithoutShape)
{
    const TempFolder folder;
    const Composed whole = composed("parallel_gripper", folder);
    RobotModel robot = loadRobot(whole.file);
    const std::int32_t palm = robot.tree.findLink(linkNameOf(whole.robot, whole.robot.handRoot));
    robot.tree.links[static_cast<std::size_t>(palm)].joint = {
        .name = "wrist", .type = JointType::Revolute, .axis = Eigen::Vector3d::UnitZ()};
    EXPECT_THAT(findHandRoots(robot, std::nullopt, {}), ElementsAre(palm));
    const SplitRobot split = splitRobot(robot, palm);
    EXPECT_EQ(split.flange, linkNameOf(robot, palm) + "_carrier");
    EXPECT_NE(split.arm.tree.findJoint("wrist"), kNone);
    EXPECT_TRUE(split.X_FH.isApprox(Eigen::Isometry3d::Identity()));
    const HandModel hand = handOf(splitRobot(robot, palm).hand, robot.tree, whole.hand.srdfFile);
    EXPECT_EQ(mountHand(split.arm, hand, split.flange, split.X_FH).joints.size(), 8U);
}

/// Two of them on one root, the right one first.
RobotModel twice(const RobotModel& one)
{
    RobotModel both;
    both.name = "both";
    both.file = "both.urdf";
    both.tree.links.push_back({.name = "world"});
    both.linkMeshes.emplace_back();
    for (const char* side : {"right_", "left_"})
    {
        const auto first = static_cast<std::int32_t>(both.tree.size());
        for (std::size_t i = 0; i < one.tree.size(); ++i)
        {
            Link link = one.tree.links[i];
            link.name = side + link.name;
            link.joint.name = side + link.joint.name;
            link.joint.mimicOf += link.joint.mimicOf == kNone ? 0 : first;
            link.parent = i == 0 ? 0 : link.parent + first;
            if (i == 0)
            {
                link.X_PL0.translation().y() = (first == 1 ? -0.5 : 0.5) * kApart;
            }
            both.tree.links.push_back(link);
            both.linkMeshes.push_back(one.linkMeshes[i]);
        }
    }
    return both;
}

TEST(SplitRobot, TwoArmsOfOneRobotAreLeftAndRight)
{
    const TempFolder folder;
    const Composed whole = composed("three_finger_gripper", folder);
    RobotModel both = twice(loadRobot(whole.file));
    const std::vector<std::int32_t> roots = findHandRoots(both, std::nullopt, {});
    ASSERT_EQ(roots.size(), 2U);
    const std::array<SplitRobot, 2> arms = splitArms(both, {roots[0], roots[1]});
    for (std::size_t side = 0; side < 2; ++side)
    {
        const std::string prefix = side == 0 ? "left_" : "right_";
        EXPECT_EQ(arms[side].arm.tree.links[0].name, "world");
        EXPECT_EQ(arms[side].arm.tree.size() + arms[side].hand.tree.size(),
                  whole.robot.tree.size() + 1);
        for (std::size_t i = 1; i < arms[side].arm.tree.size(); ++i)
        {
            EXPECT_EQ(arms[side].arm.tree.links[i].name.rfind(prefix, 0), 0U);
        }
        EXPECT_EQ(arms[side].flange, prefix + "wrist_turn");
    }
    // A torso that turns or has a shape is refused, and so is one hand twice.
    EXPECT_THROW((void)splitArms(both, {roots[0], roots[0]}), std::runtime_error);
    both.linkMeshes[0] = makeBox({0.1, 0.1, 0.1});
    EXPECT_THROW((void)splitArms(both, {roots[0], roots[1]}), std::runtime_error);
}

TEST(SplitRobot, SaysWhatItDoesNotFind)
{
    const RobotModel arm = loadRobot(BULLET_CCD_SHARE "/robots/arms/seven_joint_arm.urdf");
    EXPECT_THAT(errorOf(arm), HasSubstr("does not divide into fingers"));
    EXPECT_THAT(errorOf(arm, {"flansh"}), HasSubstr("did you mean 'flange'?"));
    EXPECT_THROW((void)splitRobot(arm, 0), std::runtime_error);
    const RobotModel hand =
        loadRobot(BULLET_CCD_SHARE "/robots/parallel_gripper/parallel_gripper.urdf");
    EXPECT_THAT(errorOf(hand), HasSubstr("a hand without an arm?"));
}

TEST(SplitRobot, ArmsWithHandsOfTheData)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(one, "arms/combined/iiwa7_sah.urdf");
    BULLET_CCD_TEST_DATA_OR_SKIP(two, "arms/combined/dual_iiwa7_sah.urdf");
    BULLET_CCD_TEST_DATA_OR_SKIP(panda, "arms/panda/panda_arm_hand.urdf");
    const RobotModel single = loadRobot(one);
    const std::vector<std::int32_t> roots = findHandRoots(single, std::nullopt, {});
    ASSERT_EQ(roots.size(), 1U);
    EXPECT_EQ(linkNameOf(single, roots[0]), "ee_link");
    const RobotModel dual = loadRobot(two);
    const std::vector<std::int32_t> both = findHandRoots(dual, std::nullopt, {});
    ASSERT_EQ(both.size(), 2U);
    const std::array<SplitRobot, 2> arms = splitArms(dual, {both[0], both[1]});
    EXPECT_EQ(arms[0].flange, "left_link_7");
    EXPECT_EQ(arms[1].flange, "right_link_7");
    EXPECT_EQ(linkNameOf(loadRobot(panda), findHandRoots(loadRobot(panda), std::nullopt, {})[0]),
              "panda_link8");
}
}  // namespace
}  // namespace bullet_ccd::grasp
