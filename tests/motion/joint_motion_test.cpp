#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

/// The link in the frame of `base`, from the definition.
Isometry3d relativePose(const KinematicTree& tree,
                        const JointMotion& motion,
                        std::int32_t base,
                        std::int32_t link,
                        double t)
{
    const Isometry3d X_WL = oracleLinkPose(tree, motion, link, t);
    return base == kNone ? X_WL : oracleLinkPose(tree, motion, base, t).inverse() * X_WL;
}

struct Case
{
    KinematicTree tree;
    JointMotion motion;
    std::int32_t base = kNone;
    std::int32_t link = 0;
};

/// A random link seen from W, from itself or from one of its ancestors.
Case randomCase(Random& random, double fastest)
{
    Case result;
    result.tree = randomTree(random, random.integer(2, 7), 0.2);
    result.motion = randomJointMotion(random, result.tree, fastest);
    if (random.chance(0.5))
    {
        addRandomCurves(random, fastest, result.motion);
    }
    result.link = random.integer(0, static_cast<int>(result.tree.size()) - 1);
    result.base = result.link;
    for (int up = random.integer(0, 6); up > 0 && result.base != kNone; --up)
    {
        result.base = result.tree.links[static_cast<std::size_t>(result.base)].parent;
    }
    return result;
}

TEST(LinkStateAt, PoseAndVelocitiesAgreeWithFiniteDifferences)
{
    Random random(60);
    constexpr double kStep = 1e-5;
    int moving = 0;
    for (int i = 0; i < 500; ++i)
    {
        const auto [tree, motion, base, link] = randomCase(random, 3.0);
        const double t = random.uniform(0.0, 1.0);
        const MotionState state = linkStateAt(tree, motion, base, link, t);
        const Isometry3d now = relativePose(tree, motion, base, link, t);
        EXPECT_LT((state.X_W.matrix() - now.matrix()).cwiseAbs().maxCoeff(), 1e-13) << i;
        const Isometry3d before = relativePose(tree, motion, base, link, t - kStep);
        const Isometry3d after = relativePose(tree, motion, base, link, t + kStep);
        const Vector3d v = (after.translation() - before.translation()) / (2.0 * kStep);
        EXPECT_LT((state.v_W - v).norm(), 1e-6) << i;
        const Eigen::Matrix3d spin =
            (after.linear() - before.linear()) / (2.0 * kStep) * now.linear().transpose();
        EXPECT_LT((state.w_W - Vector3d(spin(2, 1), spin(0, 2), spin(1, 0))).norm(), 1e-6) << i;
        moving += v.norm() > 0.1 ? 1 : 0;
    }
    EXPECT_GT(moving, 200);
}

TEST(LinkAccelerationBound, HoldsForPointsOfRandomChains)
{
    Random random(61);
    constexpr double kStep = 1e-4;
    double tightest = 0.0;
    int moving = 0;
    for (int i = 0; i < 1500; ++i)
    {
        const auto [tree, motion, base, link] = randomCase(random, random.uniform(0.0, 6.0));
        const AccelerationBound bound = linkAccelerationBound(tree, motion, base, link);
        for (int sample = 0; sample < 20; ++sample)
        {
            const double r = random.uniform(0.0, 2.0);
            const Vector3d point = r * random.direction();
            const double t = random.uniform(kStep, 1.0 - kStep);
            const auto at = [&](double s) -> Vector3d
            { return relativePose(tree, motion, base, link, s) * point; };
            const double acceleration =
                (at(t + kStep) - 2.0 * at(t) + at(t - kStep)).norm() / (kStep * kStep);
            const double allowed = bound.constant + bound.perRadius * r;
            // The difference quotient is off by rounding / step^2 and by step^2 times the fourth
            // derivative, which is of the order of the bound times the squared rates.
            EXPECT_LE(acceleration, allowed * (1.0 + 1e-5) + 2e-6) << i;
            tightest = std::max(tightest, allowed > 1.0 ? acceleration / allowed : 0.0);
            moving += allowed > 1.0 ? 1 : 0;
        }
    }
    EXPECT_GT(tightest, 0.9);
    EXPECT_GT(moving, 10000);
}

TEST(LinkAccelerationBound, OfAPendulumIsItsCentripetalAcceleration)
{
    const KinematicTree tree = planarChain({1.0, 1.0});
    const JointMotion motion{.root = {}, .positions = {0, 0.3, 0.7}, .rates = {0, 3.0, 0.0}};
    const AccelerationBound first = linkAccelerationBound(tree, motion, 0, 1);
    EXPECT_NEAR(first.constant + 2.0 * first.perRadius, 18.0, 1e-9);
    // The second link rests on the first: its origin is 1 from the axis.
    const AccelerationBound second = linkAccelerationBound(tree, motion, 0, 2);
    EXPECT_NEAR(second.constant + 2.0 * second.perRadius, 27.0, 1e-9);
    const AccelerationBound none = linkAccelerationBound(tree, motion, 1, 2);
    EXPECT_EQ(none.constant, 0.0);
    EXPECT_EQ(none.perRadius, 0.0);
}

TEST(CommonAncestor, IsTheDeepestLinkAboveBoth)
{
    Random random(62);
    for (int i = 0; i < 100; ++i)
    {
        const KinematicTree tree = randomTree(random, 10, 0.5);
        const std::int32_t a = random.integer(0, 9);
        const std::int32_t b = random.integer(0, 9);
        std::int32_t expected = kNone;
        for (std::int32_t link = 0; link < 10; ++link)
        {
            // Parents come first, so the last one that fits is the deepest.
            if (isAncestorOrSelf(tree, link, a) && isAncestorOrSelf(tree, link, b))
            {
                expected = link;
            }
        }
        EXPECT_EQ(commonAncestor(tree, a, b), expected);
    }
}

TEST(Moves, SaysWhetherAJointBetweenThemTurns)
{
    Random random(63);
    int moving = 0;
    for (int i = 0; i < 500; ++i)
    {
        const auto [tree, motion, base, link] = randomCase(random, 3.0);
        const bool result = moves(tree, motion, base, link);
        double change = 0.0;
        for (const double t : {0.3, 0.7, 1.0})
        {
            change = std::max(change,
                              (relativePose(tree, motion, base, link, t).matrix() -
                               relativePose(tree, motion, base, link, 0.0).matrix())
                                  .norm());
        }
        EXPECT_TRUE(result || change < 1e-13) << i;
        // Fixed joints have rates and curves here, but do not move.
        EXPECT_TRUE(!result || change > 1e-13) << i;
        moving += result ? 1 : 0;
    }
    EXPECT_GT(moving, 200);
    EXPECT_LT(moving, 480);
}
}  // namespace
}  // namespace bullet_ccd::tests
