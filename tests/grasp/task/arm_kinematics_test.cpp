/// Inverse kinematics against closed forms, and against the forward kinematics of trees.
#include "grasp/task/arm_kinematics.h"

#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "bullet_ccd/io/robot_file.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
using reference::Random;

constexpr double kPi = std::numbers::pi;

/// Three links of 0.5, 0.4 and 0.1 m in a plane; the last one of the tree is the tip.
KinematicTree planarArm()
{
    KinematicTree tree = reference::planarChain({0.5, 0.4, 0.1});
    tree.links.push_back({.name = "tip", .parent = 3});
    tree.links.back().X_PL0.translation().x() = 0.1;
    for (std::size_t i = 1; i <= 3; ++i)
    {
        tree.links[i].joint.lower = -kPi;
        tree.links[i].joint.upper = kPi;
    }
    return tree;
}

Eigen::Isometry3d planarPose(double x, double y, double turn)
{
    Eigen::Isometry3d X(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
    X.translation() = Eigen::Vector3d(x, y, 0.0);
    return X;
}

double wrapped(double angle)
{
    return std::remainder(angle, 2.0 * kPi);
}

TEST(ArmKinematics, FindsBothPosturesOfAPlanarArm)
{
    const KinematicTree tree = planarArm();
    const ArmKinematics arm(tree, 4, Eigen::Isometry3d::Identity());
    Random random(1);
    for (int i = 0; i < 100; ++i)
    {
        // The law of cosines at the elbow; elbows are neither straight nor folded.
        const double elbow = random.uniform(0.3, 2.6);
        const double shoulder = random.uniform(-1.5, 1.5);
        const double wrist = random.uniform(-1.0, 1.0);
        const double turn = shoulder + elbow + wrist;
        const Eigen::Isometry3d tip = planarPose(
            0.5 * std::cos(shoulder) + 0.4 * std::cos(shoulder + elbow) + 0.1 * std::cos(turn),
            0.5 * std::sin(shoulder) + 0.4 * std::sin(shoulder + elbow) + 0.1 * std::sin(turn),
            turn);
        // Mirrored at the line from the shoulder to the wrist.
        const double line =
            shoulder + std::atan2(0.4 * std::sin(elbow), 0.5 + 0.4 * std::cos(elbow));
        const double other = 2.0 * line - shoulder;
        const std::array<std::array<double, 3>, 2> exact{
            {{shoulder, elbow, wrist}, {wrapped(other), -elbow, wrapped(turn - other + elbow)}}};
        const auto found = arm.solve(tip, {0.0, 0.0, 0.0}, {.wanted = 10});
        for (const auto& q : exact)
        {
            EXPECT_TRUE(std::ranges::any_of(found,
                                            [&](const std::vector<double>& each)
                                            {
                                                return std::abs(wrapped(each[0] - q[0])) < 1e-6 &&
                                                       std::abs(wrapped(each[1] - q[1])) < 1e-6 &&
                                                       std::abs(wrapped(each[2] - q[2])) < 1e-6;
                                            }))
                << "elbow " << q[1] << " of pose " << i;
        }
        for (const auto& q : found)
        {
            EXPECT_TRUE((arm.poseAt(q).inverse() * tip).matrix().isIdentity(1e-6));
            EXPECT_NEAR(std::abs(q[1]), elbow, 1e-6);
        }
    }
}

TEST(ArmKinematics, SaysThatAPoseIsOutOfReach)
{
    const KinematicTree tree = planarArm();
    const ArmKinematics arm(tree, 4, Eigen::Isometry3d::Identity());
    const std::vector<double> rest(3, 0.0);
    EXPECT_FALSE(arm.solve(planarPose(0.999, 0.0, 0.0), rest).empty());
    EXPECT_TRUE(arm.solve(planarPose(1.001, 0.0, 0.0), rest).empty());
    EXPECT_TRUE(arm.solve(planarPose(0.5, 2.0, 0.0), rest).empty());
    // Near enough, but the wrist would be 1 m away; above the plane; tilted out of it.
    EXPECT_TRUE(arm.solve(planarPose(0.9, 0.0, kPi), rest).empty());
    Eigen::Isometry3d above = planarPose(0.5, 0.2, 0.1);
    above.translation().z() = 0.01;
    EXPECT_TRUE(arm.solve(above, rest).empty());
    EXPECT_TRUE(
        arm.solve(planarPose(0.5, 0.2, 0.1) * Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()),
                  rest)
            .empty());
}

TEST(ArmKinematics, SlidesAndStaysWithinLimits)
{
    // A slider along x below one along z: where the tip is gives the positions.
    KinematicTree tree;
    tree.links = {{.name = "base"}, {.name = "x", .parent = 0}, {.name = "z", .parent = 1}};
    tree.links[1].joint = {.name = "x",
                           .type = JointType::Prismatic,
                           .axis = Eigen::Vector3d::UnitX(),
                           .lower = -0.2,
                           .upper = 0.5};
    tree.links[2].joint = {.name = "z",
                           .type = JointType::Prismatic,
                           .axis = Eigen::Vector3d::UnitZ(),
                           .lower = 0.0,
                           .upper = 0.5};
    const Eigen::Isometry3d X_WR(Eigen::Translation3d(1.0, 2.0, 3.0));
    const ArmKinematics arm(tree, 2, X_WR);
    const auto at = [&](double x, double z) {
        return arm.solve(X_WR * Eigen::Translation3d(x, 0.0, z), {0.0, 0.0});
    };
    ASSERT_EQ(at(0.3, 0.4).size(), 1U);
    EXPECT_NEAR(at(0.3, 0.4)[0][0], 0.3, 1e-9);
    EXPECT_NEAR(at(0.3, 0.4)[0][1], 0.4, 1e-9);
    EXPECT_EQ(at(-0.2, 0.5).size(), 1U);
    EXPECT_TRUE(at(-0.21, 0.4).empty());
    EXPECT_TRUE(at(0.3, -0.01).empty());
}

/// At least 99 % of the poses at random postures are found; each solution is checked by the forward
/// kinematics of the tree.
void expectFindsPoses(const KinematicTree& tree, std::int32_t link)
{
    Random random(7);
    Eigen::Isometry3d X_WR(random.rotation());
    X_WR.translation() = Eigen::Vector3d(0.3, -0.2, 0.5);
    const ArmKinematics arm(tree, link, X_WR);
    constexpr int kPoses = 1000;
    int solved = 0;
    std::vector<double> start;
    for (const std::int32_t joint : arm.joints())
    {
        const Joint& each = tree.links[static_cast<std::size_t>(joint)].joint;
        start.push_back(0.5 * (each.lower + each.upper));
    }
    for (int i = 0; i < kPoses; ++i)
    {
        std::vector<double> whole(tree.size(), 0.0);
        const auto poseOf = [&](const std::vector<double>& q)
        {
            for (std::size_t k = 0; k < q.size(); ++k)
            {
                whole[static_cast<std::size_t>(arm.joints()[k])] = q[k];
            }
            return linkPoses(tree, X_WR, whole)[static_cast<std::size_t>(link)];
        };
        std::vector<double> q = start;
        for (std::size_t k = 0; k < q.size(); ++k)
        {
            const Joint& joint = tree.links[static_cast<std::size_t>(arm.joints()[k])].joint;
            q[k] = random.uniform(joint.lower, joint.upper);
        }
        const Eigen::Isometry3d wanted = poseOf(q);
        const auto found = arm.solve(wanted, start, {.wanted = 2});
        solved += found.empty() ? 0 : 1;
        for (const std::vector<double>& each : found)
        {
            const Eigen::Isometry3d error = poseOf(each).inverse() * wanted;
            EXPECT_LT(error.translation().norm(), 1.1e-9);
            EXPECT_LT(2.0 * Eigen::Quaterniond(error.linear()).vec().norm(), 1e-6);
            for (std::size_t k = 0; k < each.size(); ++k)
            {
                const Joint& joint = tree.links[static_cast<std::size_t>(arm.joints()[k])].joint;
                EXPECT_GE(each[k], joint.lower);
                EXPECT_LE(each[k], joint.upper);
            }
        }
    }
    EXPECT_GE(solved, 990);
    testing::Test::RecordProperty("solved_" + tree.links[static_cast<std::size_t>(link)].name,
                                  solved);
}

TEST(ArmKinematics, FindsThePosesOfAnArmOfSevenJoints)
{
    const RobotModel robot = loadRobot(BULLET_CCD_SHARE "/robots/arms/seven_joint_arm.urdf");
    expectFindsPoses(robot.tree, robot.tree.findLink("flange"));
}

TEST(ArmKinematics, FindsThePosesOfArmsThatAreSold)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(panda, "arms/panda/panda_arm_hand.urdf");
    BULLET_CCD_TEST_DATA_OR_SKIP(iiwa, "arms/iiwa7/iiwa7.urdf");
    BULLET_CCD_TEST_DATA_OR_SKIP(xarm, "arms/xarm7/xarm7.urdf");
    for (const auto& [file, link] :
         {std::pair(panda, "panda_hand"), std::pair(iiwa, "ee_link"), std::pair(xarm, "link_eef")})
    {
        SCOPED_TRACE(link);
        const RobotModel robot = loadRobot(file);
        expectFindsPoses(robot.tree, robot.tree.findLink(link));
    }
}

TEST(ArmKinematics, FollowsAStraightLineAndKeepsWithinLimits)
{
    KinematicTree tree = planarArm();
    const std::vector<double> start{0.4, -0.9, 0.3};
    const ArmKinematics free(tree, 4, Eigen::Isometry3d::Identity());
    Eigen::Isometry3d tip = free.poseAt(start);
    std::vector<double> q = start;
    for (int i = 0; i < 10; ++i)
    {
        tip.translation().x() -= 0.01;
        const auto next = free.follow(tip, q, 0.2);
        ASSERT_TRUE(next.has_value());
        EXPECT_TRUE((free.poseAt(*next).inverse() * tip).matrix().isIdentity(1e-6));
        q = *next;
    }
    EXPECT_LT(q[1], -0.9);  // nearer means more bent
    EXPECT_FALSE(free.follow(free.poseAt(start), {0.4, 0.9, 0.3}, 0.2).has_value())
        << "the other posture is far away";
    tree.links[2].joint.lower = -0.9;
    const ArmKinematics limited(tree, 4, Eigen::Isometry3d::Identity());
    EXPECT_FALSE(limited.follow(tip, start, 1.0).has_value());
}

TEST(ArmKinematics, JointsWithoutLimitsAndOfManyTurns)
{
    KinematicTree tree = planarArm();
    for (std::size_t i = 1; i <= 3; ++i)
    {
        tree.links[i].joint.lower = i == 1 ? -std::numeric_limits<double>::infinity() : 2.0 * kPi;
        tree.links[i].joint.upper = i == 1 ? std::numeric_limits<double>::infinity() : 4.0 * kPi;
    }
    const ArmKinematics arm(tree, 4, Eigen::Isometry3d::Identity());
    const std::vector<double> q{0.3, 2.0 * kPi + 0.8, 2.0 * kPi + 0.5};
    const auto found = arm.solve(arm.poseAt(q), {0.0, 7.0, 7.0}, {.wanted = 4});
    ASSERT_FALSE(found.empty());
    for (const auto& each : found)
    {
        for (std::size_t k = 1; k < 3; ++k)
        {
            EXPECT_GE(each[k], 2.0 * kPi);
            EXPECT_LE(each[k], 4.0 * kPi);
        }
        EXPECT_TRUE((arm.poseAt(each).inverse() * arm.poseAt(q)).matrix().isIdentity(1e-6));
    }
}

TEST(ArmKinematics, RefusesWhatIsNoChain)
{
    const KinematicTree tree = planarArm();
    const Eigen::Isometry3d X_WR = Eigen::Isometry3d::Identity();
    EXPECT_THROW(ArmKinematics(tree, 0, X_WR), std::invalid_argument);
    EXPECT_THROW(ArmKinematics(tree, 5, X_WR), std::invalid_argument);
    KinematicTree mimics = tree;
    mimics.links[2].joint.mimicOf = 1;
    EXPECT_THROW(ArmKinematics(mimics, 4, X_WR), std::invalid_argument);
    const ArmKinematics arm(tree, 4, X_WR);
    EXPECT_THROW((void)arm.poseAt({0.0}), std::invalid_argument);
    EXPECT_THROW((void)arm.solve(X_WR, {0.0}), std::invalid_argument);
    Eigen::Isometry3d nowhere = X_WR;
    nowhere.translation().x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)arm.solve(nowhere, {0.0, 0.0, 0.0}), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::grasp
