#include "bullet_ccd/motion/kinematic_tree.h"

#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/random_trees.h"

#include <gtest/gtest.h>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
TEST(KinematicTree, LinkPosesAgreeWithComposedTransforms)
{
    Random random(50);
    for (int i = 0; i < 100; ++i)
    {
        const KinematicTree tree = randomTree(random, random.integer(1, 12), 0.3);
        const JointMotion motion = randomJointMotion(random, tree, 3.0);
        const auto poses = linkPoses(tree, motion.root.X_W0, motion.positions);
        ASSERT_EQ(poses.size(), tree.size());
        for (std::size_t k = 0; k < tree.size(); ++k)
        {
            const auto expected = oracleLinkPose(tree, motion, static_cast<std::int32_t>(k), 0.0);
            EXPECT_LT((poses[k].matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-13);
        }
    }
}

TEST(KinematicTree, LinkInParentTurnsAboutTheAxisOrShiftsAlongIt)
{
    Link link;
    link.X_PL0.translation() = Eigen::Vector3d(1, 2, 3);
    link.joint.axis = Eigen::Vector3d::UnitZ();
    EXPECT_EQ(linkInParent(link, 5.0).matrix(), link.X_PL0.matrix());
    link.joint.type = JointType::Revolute;
    const Eigen::Vector3d turned = linkInParent(link, 0.5) * Eigen::Vector3d::UnitX();
    EXPECT_LT((turned - Eigen::Vector3d(1 + std::cos(0.5), 2 + std::sin(0.5), 3)).norm(), 1e-15);
    link.joint.type = JointType::Prismatic;
    EXPECT_LT((linkInParent(link, 0.5).translation() - Eigen::Vector3d(1, 2, 3.5)).norm(), 1e-15);
}

TEST(KinematicTree, MimicJointsFollowTheirJoint)
{
    KinematicTree tree = planarChain({1.0, 1.0, 1.0});
    tree.links[3].joint.mimicOf = 1;
    tree.links[3].joint.mimicMultiplier = -2.0;
    tree.links[3].joint.mimicOffset = 0.25;
    std::vector<double> positions{9.0, 0.5, 0.75, 7.0};
    applyMimics(tree, positions);
    EXPECT_EQ(positions, (std::vector<double>{9.0, 0.5, 0.75, -0.75}));
}

TEST(KinematicTree, FindsByNameAndKnowsAncestors)
{
    Random random(51);
    KinematicTree tree = randomTree(random, 8, 0.5);
    EXPECT_EQ(tree.findLink("link3"), 3);
    EXPECT_EQ(tree.findJoint("joint5"), 5);
    EXPECT_EQ(tree.findLink("joint5"), kNone);
    EXPECT_EQ(tree.findJoint("nothing"), kNone);
    for (std::int32_t link = 0; link < 8; ++link)
    {
        for (std::int32_t ancestor = 0; ancestor < 8; ++ancestor)
        {
            bool expected = false;
            for (std::int32_t at = link; at != kNone;
                 at = tree.links[static_cast<std::size_t>(at)].parent)
            {
                expected = expected || at == ancestor;
            }
            EXPECT_EQ(isAncestorOrSelf(tree, ancestor, link), expected);
        }
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
