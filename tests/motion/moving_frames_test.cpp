/// Frames of the joints that move against the chain of all links, and their bounds.
#include "bullet_ccd/motion/moving_frames.h"

#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/random_trees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Scene
{
    KinematicTree tree;
    JointMotion motion;
    MovingFrames frames;
};

Scene randomScene(Random& random, double fastest)
{
    Scene scene;
    scene.tree = randomBallTree(random, random.integer(2, 9), 0.2);
    scene.motion = randomJointMotion(random, scene.tree, fastest);
    if (random.chance(0.5))
    {
        addRandomCurves(random, fastest, scene.motion);
    }
    scene.frames.reset(scene.tree, scene.motion);
    return scene;
}

TEST(MovingFrames, PosesOfLinksAgreeWithComposedTransforms)
{
    Random random(2301);
    int shared = 0;
    for (int i = 0; i < 500; ++i)
    {
        Scene scene = randomScene(random, 5.0);
        const double t = random.uniform(0.0, 1.0);
        for (std::int32_t link = 0; link < static_cast<std::int32_t>(scene.tree.size()); ++link)
        {
            const LinkPlace& place = scene.frames.place(link);
            const Isometry3d X = scene.frames.stateAt(0, place.frame, t).X_W * place.X_FL;
            const Isometry3d expected = oracleLinkPose(scene.tree, scene.motion, link, t);
            ASSERT_LT((X.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-13) << i;
        }
        shared += scene.frames.frames().size() < scene.tree.size() ? 1 : 0;
    }
    EXPECT_GT(shared, 200);
}

TEST(MovingFrames, VelocitiesAgreeWithThoseOfTheTree)
{
    Random random(2302);
    for (int i = 0; i < 500; ++i)
    {
        Scene scene = randomScene(random, 5.0);
        const double t = random.uniform(0.0, 1.0);
        const auto link = static_cast<std::int32_t>(scene.tree.size()) - 1;
        const LinkPlace& place = scene.frames.place(link);
        const MotionState& frame = scene.frames.stateAt(0, place.frame, t);
        const MotionState expected = linkStateAt(scene.tree, scene.motion, kNone, link, t);
        EXPECT_LT((frame.w_W - expected.w_W).norm(), 1e-12) << i;
        const Vector3d arm = expected.X_W.translation() - frame.X_W.translation();
        EXPECT_LT((frame.v_W + frame.w_W.cross(arm) - expected.v_W).norm(), 1e-11) << i;
    }
}

TEST(MovingFrames, StatesSeenFromAFrameAboveAreRelative)
{
    Random random(2303);
    int deep = 0;
    for (int i = 0; i < 500; ++i)
    {
        Scene scene = randomScene(random, 5.0);
        const auto last = static_cast<std::int32_t>(scene.frames.frames().size()) - 1;
        const std::int32_t a = random.integer(0, last);
        const std::int32_t b = random.integer(0, last);
        const std::int32_t base = scene.frames.commonFrame(a, b);
        const double t = random.uniform(0.0, 1.0);
        const Isometry3d inBase = scene.frames.stateAt(base, a, t).X_W;
        const Isometry3d X_WB = scene.frames.stateAt(0, base, t).X_W;
        const Isometry3d X_WA = scene.frames.stateAt(0, a, t).X_W;
        EXPECT_LT((X_WB * inBase).matrix().cwiseAbs().maxCoeff(), 1e3);
        EXPECT_LT(((X_WB * inBase).matrix() - X_WA.matrix()).cwiseAbs().maxCoeff(), 1e-12) << i;
        deep += base != 0 && base != a ? 1 : 0;
    }
    EXPECT_GT(deep, 20);
}

/// The link's bound of the plain sum: no cancellation.
AccelerationBound plainBound(const Scene& scene, std::int32_t link)
{
    return linkAccelerationBound(scene.tree, scene.motion, kNone, link);
}

TEST(MovingFrames, AccelerationBoundHoldsAndIsNotAboveThePlainSum)
{
    Random random(2304);
    constexpr double kStep = 1e-4;
    double tightest = 0.0;
    double gain = 0.0;
    int moving = 0;
    for (int i = 0; i < 1500; ++i)
    {
        Scene scene = randomScene(random, random.uniform(0.0, 6.0));
        const auto link = static_cast<std::int32_t>(scene.tree.size()) - 1;
        const LinkPlace& place = scene.frames.place(link);
        const AccelerationBound bound = scene.frames.accelerationBound(0, place.frame);
        const SpeedBound speed = scene.frames.speedBound(0, place.frame);
        const double offset = place.X_FL.translation().norm();
        const AccelerationBound plain = plainBound(scene, link);
        EXPECT_LE(bound.constant + bound.perRadius * offset,
                  plain.constant + plain.perRadius * offset +
                      1e-9 * (1.0 + plain.constant + plain.perRadius));
        gain += plain.perRadius > 0.1 ? bound.perRadius / plain.perRadius : 0.0;
        for (int sample = 0; sample < 20; ++sample)
        {
            const double r = random.uniform(0.0, 2.0);
            const Vector3d point = r * random.direction();
            const double t = random.uniform(kStep, 1.0 - kStep);
            const auto at = [&](double s) -> Vector3d
            { return scene.frames.stateAt(0, place.frame, s).X_W * point; };
            const Vector3d before = at(t - kStep);
            const Vector3d after = at(t + kStep);
            const double acceleration = (after - 2.0 * at(t) + before).norm() / (kStep * kStep);
            const double allowed = bound.constant + bound.perRadius * r;
            EXPECT_LE(acceleration, allowed * (1.0 + 1e-5) + 2e-6) << i;
            EXPECT_LE((after - before).norm() / (2.0 * kStep),
                      (speed.constant + speed.perRadius * r) * (1.0 + 1e-6) + 1e-9)
                << i;
            tightest = std::max(tightest, allowed > 1.0 ? acceleration / allowed : 0.0);
            moving += allowed > 1.0 ? 1 : 0;
        }
    }
    EXPECT_GT(tightest, 0.9);
    EXPECT_GT(moving, 10000);
    EXPECT_LT(gain, 0.8 * 1500);
}

TEST(MovingFrames, CoaxialJointsThatTurnAgainstEachOtherDoNotAccelerate)
{
    // G14: the links below the second joint rest.
    KinematicTree tree = planarChain({1.0, 1.0});
    tree.links[2].X_PL0 = Isometry3d::Identity();
    MovingFrames frames;
    frames.reset(tree, {.root = {}, .positions = {0, 0, 0}, .rates = {0, 3.0, -3.0}});
    const AccelerationBound bound = frames.accelerationBound(0, frames.place(2).frame);
    EXPECT_LT(bound.constant + bound.perRadius, 1e-12);
}

TEST(MovingFrames, AParallelogramAcceleratesLikeItsFirstLink)
{
    // G03: the second link only translates, on the circle of the first.
    const KinematicTree tree = planarChain({1.0, 0.5});
    MovingFrames frames;
    frames.reset(tree, {.root = {}, .positions = {0, 0, 0}, .rates = {0, 2.0, -2.0}});
    const AccelerationBound bound = frames.accelerationBound(0, frames.place(2).frame);
    EXPECT_NEAR(bound.constant, 4.0, 1e-9);
    EXPECT_LT(bound.perRadius, 1e-9);
}

TEST(MovingFrames, VeryLongChainsHaveABoundToo)
{
    const std::vector<double> lengths(200, 0.1);
    const KinematicTree tree = planarChain(lengths);
    JointMotion motion{.root = {}, .positions = std::vector<double>(201, 0.01), .rates = {}};
    motion.rates.assign(201, 0.01);
    MovingFrames frames;
    frames.reset(tree, motion);
    const std::int32_t last = frames.place(200).frame;
    const AccelerationBound bound = frames.accelerationBound(0, last);
    constexpr double kStep = 1e-4;
    const auto at = [&](double t) { return frames.stateAt(0, last, t).X_W.translation().eval(); };
    const double acceleration = (at(kStep) - 2.0 * at(0.0) + at(-kStep)).norm() / (kStep * kStep);
    EXPECT_GT(acceleration, 0.1);
    EXPECT_LT(acceleration, bound.constant);
}

TEST(MovingFrames, OneTurnOrSlideIsARigidMotion)
{
    Random random(2305);
    int rigid = 0;
    for (int i = 0; i < 1000; ++i)
    {
        Scene scene;
        scene.tree = randomBallTree(random, random.integer(2, 4), 0.2);
        scene.motion = randomJointMotion(random, scene.tree, 4.0);
        for (double& rate : scene.motion.rates)
        {
            rate = random.chance(0.6) ? 0.0 : rate;
        }
        scene.frames.reset(scene.tree, scene.motion);
        const auto link = static_cast<std::int32_t>(scene.tree.size()) - 1;
        const LinkPlace& place = scene.frames.place(link);
        RigidMotion motion;
        if (!asRigidMotion(scene.frames, 0, place.frame, motion))
        {
            EXPECT_GT(scene.frames.frames().size(), 2U);
            continue;
        }
        for (const double t : {0.0, 0.4, 1.0})
        {
            const Isometry3d X = motion.at(t).X_W * place.X_FL;
            const Isometry3d expected = oracleLinkPose(scene.tree, scene.motion, link, t);
            ASSERT_LT((X.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-12) << i;
        }
        rigid += scene.frames.frames().size() > 1 ? 1 : 0;
    }
    EXPECT_GT(rigid, 100);
}

TEST(PartOf, APartOfAMotionIsThatMotion)
{
    Random random(2306);
    for (int i = 0; i < 300; ++i)
    {
        const Scene scene = randomScene(random, 5.0);
        const double begin = random.uniform(0.0, 0.5);
        const double end = random.uniform(0.5, 1.0);
        const JointMotion part = partOf(scene.motion, begin, end);
        const auto link = static_cast<std::int32_t>(scene.tree.size()) - 1;
        const double s = random.uniform(0.0, 1.0);
        const Isometry3d X = oracleLinkPose(scene.tree, part, link, s);
        const Isometry3d expected =
            oracleLinkPose(scene.tree, scene.motion, link, begin + s * (end - begin));
        EXPECT_LT((X.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-12) << i;
    }
}

TEST(BallBetween, TurnsFromOneRotationToTheOther)
{
    Random random(2307);
    for (int i = 0; i < 200; ++i)
    {
        KinematicTree tree = planarChain({1.0});
        tree.links[1].joint.type = JointType::Spherical;
        tree.links[1].X_PL0 = random.pose(1.0);
        const Eigen::Matrix3d start = random.rotation();
        const Eigen::Matrix3d end = random.rotation();
        const JointMotion motion{.root = {},
                                 .positions = {0, 0},
                                 .rates = {0, 0},
                                 .balls = {{}, ballBetween(start, end)}};
        const auto turnAt = [&](double t) -> Eigen::Matrix3d
        {
            return tree.links[1].X_PL0.linear().transpose() *
                   linkStateAt(tree, motion, 0, 1, t).X_W.linear();
        };
        EXPECT_LT((turnAt(0.0) - start).norm(), 1e-13);
        EXPECT_LT((turnAt(1.0) - end).norm(), 1e-13);
        EXPECT_LE(motion.balls[1].rate.norm(), std::numbers::pi + 1e-12);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
