#include "benchmarks/reference/scenes/random.h"
#include "grasp/force/grasp_forces.h"

#include <gtest/gtest.h>

#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
Link randomLink(reference::Random& random, std::int32_t parent, JointType type)
{
    Link link;
    link.parent = parent;
    link.X_PL0 = random.pose(0.2);
    link.joint.type = type;
    link.joint.axis = random.direction();
    return link;
}

/// Two chains with revolute, prismatic and fixed joints and mimics, one that follows an ancestor,
/// one that follows a joint of the other chain.
KinematicTree branchedTree(reference::Random& random)
{
    KinematicTree tree;
    tree.links.push_back({});
    tree.links.push_back(randomLink(random, 0, JointType::Revolute));
    tree.links.push_back(randomLink(random, 1, JointType::Prismatic));
    tree.links.push_back(randomLink(random, 2, JointType::Revolute));
    tree.links.push_back(randomLink(random, 0, JointType::Fixed));
    tree.links.push_back(randomLink(random, 4, JointType::Revolute));
    tree.links.push_back(randomLink(random, 5, JointType::Revolute));
    tree.links[3].joint.mimicOf = 1;
    tree.links[3].joint.mimicMultiplier = -0.7;
    tree.links[3].joint.mimicOffset = 0.1;
    tree.links[6].joint.mimicOf = 1;
    tree.links[6].joint.mimicMultiplier = 1.5;
    tree.links[2].joint.maxEffort = 12.0;
    tree.links[3].joint.maxEffort = 99.0;
    return tree;
}

TEST(HandJacobian, ColumnsAreTheJointsThatFollowNone)
{
    reference::Random random(1);
    const KinematicTree tree = branchedTree(random);
    EXPECT_EQ(independentJoints(tree), (std::vector<std::int32_t>{1, 2, 5}));
    const std::vector<double> limits = effortLimits(tree);
    EXPECT_TRUE(std::isinf(limits[0]));
    EXPECT_EQ(limits[1], 12.0);
    EXPECT_TRUE(std::isinf(limits[2]));
}

TEST(HandJacobian, AgreesWithFiniteDifferencesOfTheForwardKinematics)
{
    constexpr double kStep = 1e-6;
    reference::Random random(2);
    for (int trial = 0; trial < 20; ++trial)
    {
        const KinematicTree tree = branchedTree(random);
        const Eigen::Isometry3d X_WH = random.pose(1.0);
        std::vector<double> positions(tree.size());
        for (double& q : positions)
        {
            q = random.uniform(-1.0, 1.0);
        }
        applyMimics(tree, positions);
        std::vector<GraspContact> contacts;
        for (std::int32_t link = 0; link < 7; ++link)
        {
            contacts.push_back({.link = link, .point = random.inBox(0.5), .normal = {0, 0, 1}});
        }
        const std::vector<Twist> jacobian = handJacobian(tree, X_WH, positions, contacts);
        const std::vector<std::int32_t> joints = independentJoints(tree);
        ASSERT_EQ(jacobian.size(), 3U * 7U);
        const auto poses = linkPoses(tree, X_WH, positions);
        for (std::size_t j = 0; j < joints.size(); ++j)
        {
            const auto posesAt = [&](double offset)
            {
                std::vector<double> moved = positions;
                moved[static_cast<std::size_t>(joints[j])] += offset;
                applyMimics(tree, moved);
                return linkPoses(tree, X_WH, moved);
            };
            const auto after = posesAt(kStep);
            const auto before = posesAt(-kStep);
            for (std::size_t link = 0; link < 7; ++link)
            {
                const Eigen::Vector3d p_L = poses[link].inverse() * contacts[link].point;
                const Eigen::Vector3d velocity =
                    (after[link] * p_L - before[link] * p_L) / (2.0 * kStep);
                const Eigen::AngleAxisd turn(after[link].linear() *
                                             before[link].linear().transpose());
                const Twist& twist = jacobian[7 * j + link];
                EXPECT_LT((twist.head<3>() - velocity).norm(), 1e-8);
                EXPECT_LT((twist.tail<3>() - turn.angle() * turn.axis() / (2.0 * kStep)).norm(),
                          1e-8);
            }
        }
    }
}

TEST(HandJacobian, LinksAndJointsThatDoNotFitAreRefused)
{
    reference::Random random(3);
    KinematicTree tree = branchedTree(random);
    const std::vector<double> positions(tree.size(), 0.0);
    const std::vector<GraspContact> stray = {{.link = 7, .normal = {0, 0, 1}}};
    EXPECT_THROW(
        static_cast<void>(handJacobian(tree, Eigen::Isometry3d::Identity(), positions, stray)),
        std::invalid_argument);
    tree.links[5].joint.type = JointType::Spherical;
    EXPECT_THROW(static_cast<void>(independentJoints(tree)), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::grasp
