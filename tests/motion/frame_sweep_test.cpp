/// Boxes of moving links contain them: by millions of samples on random trees.
#include "bullet_ccd/motion/frame_sweep.h"

#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/random_trees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

OrientedBox randomBox(Random& random)
{
    OrientedBox box;
    box.center = random.inBox(0.3);
    box.axes = random.rotation();
    for (int k = 0; k < 3; ++k)
    {
        box.half[k] = random.chance(0.2) ? 0.0 : random.uniform(0.0, 0.4);
    }
    box.radius = random.chance(0.5) ? 0.0 : random.uniform(0.0, 0.1);
    return box;
}

/// A corner of the core plus a point of the ball: extreme points of the volume.
Vector3d extremePoint(Random& random, const OrientedBox& box)
{
    Vector3d point = box.center + box.radius * random.direction();
    for (int k = 0; k < 3; ++k)
    {
        point += (random.chance(0.5) ? 1.0 : -1.0) * box.half[k] * box.axes.col(k);
    }
    return point;
}

TEST(FrameSweep, BoxesContainMillionsOfPointsOfRandomTrees)
{
    Random random(2401);
    int escapes = 0;
    std::int64_t samples = 0;
    int tight = 0;
    int boxes = 0;
    for (int i = 0; i < 1500; ++i)
    {
        const KinematicTree tree = randomBallTree(random, random.integer(2, 9), 0.2);
        JointMotion motion = randomJointMotion(random, tree, random.uniform(0.0, 4.0));
        if (i % 2 == 1)
        {
            addRandomCurves(random, 4.0, motion);
        }
        MovingFrames frames;
        frames.reset(tree, motion);
        const double begin = random.uniform(0.0, 0.9);
        const double end = std::min(1.0, begin + random.logUniform(0.01, 1.0));
        FrameSweep sweep;
        sweep.reset(frames, 0, begin, end);
        const auto link = static_cast<std::int32_t>(tree.size()) - 1;
        const LinkPlace& place = frames.place(link);
        const OrientedBox inLink = randomBox(random);
        OrientedBox inFrame = inLink;
        inFrame.center = place.X_FL * inLink.center;
        inFrame.axes = place.X_FL.linear() * inLink.axes;
        const SweptBox swept = sweep.boxOver(place.frame, inFrame);
        Eigen::AlignedBox3d seen;
        for (int k = 0; k < 30; ++k)
        {
            const double t = begin + (end - begin) * (k < 2 ? k : random.uniform(0.0, 1.0));
            const Isometry3d X = oracleLinkPose(tree, motion, link, t);
            for (int corner = 0; corner < 25; ++corner)
            {
                const Vector3d point = X * extremePoint(random, inLink);
                seen.extend(point);
                escapes += swept.box.contains(point) ? 0 : 1;
                ++samples;
            }
        }
        ++boxes;
        tight += (swept.box.sizes() - seen.sizes()).maxCoeff() <
                         0.5 * (inLink.half.norm() + inLink.radius) + 3.0 * swept.excess
                     ? 1
                     : 0;
    }
    EXPECT_EQ(escapes, 0);
    EXPECT_GT(samples, 1'000'000);
    EXPECT_GT(tight, boxes / 2);
}

/// A point on its way along a chain of turns: the tightest there is to contain.
TEST(FrameSweep, OriginsOfFastChainsAreContainedInTheirModels)
{
    // F16 of the catalogue: rates up to 4, intervals up to 1.
    Random random(2402);
    int escapes = 0;
    for (int i = 0; i < 1000; ++i)
    {
        KinematicTree tree = randomBallTree(random, 5, 0.0);
        JointMotion motion = randomJointMotion(random, tree, 4.0);
        if (i % 2 == 1)
        {
            addRandomCurves(random, 4.0, motion);
        }
        MovingFrames frames;
        frames.reset(tree, motion);
        const double begin = random.uniform(0.0, 0.5);
        const double end = begin + random.uniform(0.05, 0.5);
        FrameSweep sweep;
        sweep.reset(frames, 0, begin, end);
        const std::int32_t frame = static_cast<std::int32_t>(frames.frames().size()) - 1;
        if (frame == 0)
        {
            continue;
        }
        const FrameModel& model = sweep.model(frame);
        for (int k = 0; k < 1000; ++k)
        {
            const double s = random.uniform(-1.0, 1.0);
            const double t = 0.5 * (begin + end) + 0.5 * (end - begin) * s;
            const Isometry3d X = frames.stateAt(0, frame, t).X_W;
            for (std::size_t r = 0; r < 3; ++r)
            {
                const auto row = static_cast<Eigen::Index>(r);
                const auto outside = [&](const TaylorModel& p, double value)
                {
                    const double cubic = p.c[0] + s * (p.c[1] + s * (p.c[2] + s * p.c[3]));
                    return std::abs(value - cubic) > p.error + 1e-14 * (1.0 + std::abs(value));
                };
                escapes += outside(model.origin[r], X.translation()[row]) ? 1 : 0;
                for (std::size_t c = 0; c < 3; ++c)
                {
                    const double entry = X.linear()(row, static_cast<Eigen::Index>(c));
                    escapes += outside(model.R[r][c], entry) ? 1 : 0;
                }
            }
        }
    }
    EXPECT_EQ(escapes, 0);
}

TEST(FrameSweep, ExcessFallsWithTheFourthPowerOfTheInterval)
{
    Random random(2403);
    std::vector<double> ratios;
    for (int i = 0; i < 200; ++i)
    {
        KinematicTree tree = planarChain({0.5, 0.5, 0.5, 0.5});
        JointMotion motion{.root = {}, .positions = {0}, .rates = {0}};
        for (std::size_t k = 1; k < tree.size(); ++k)
        {
            tree.links[k].joint.axis = random.direction();
            motion.positions.push_back(random.uniform(-2.0, 2.0));
            motion.rates.push_back(random.uniform(-1.0, 1.0));
        }
        if (i % 2 == 1)
        {
            addRandomCurves(random, 1.0, motion);
        }
        MovingFrames frames;
        frames.reset(tree, motion);
        const std::int32_t last = frames.place(4).frame;
        const OrientedBox point{.center = {0.5, 0, 0}};
        FrameSweep sweep;
        sweep.reset(frames, 0, 0.0, 1.0);
        const double whole = sweep.boxOver(last, point).excess;
        sweep.reset(frames, 0, 0.0, 0.5);
        ratios.push_back(whole / sweep.boxOver(last, point).excess);
    }
    std::nth_element(ratios.begin(), ratios.begin() + 100, ratios.end());
    EXPECT_GT(ratios[100], 11.0);
}

TEST(FrameSweep, APendulumsBoxIsThatOfItsArc)
{
    // A rod from the pivot, turning from 0 to a quarter turn: [0, 1] x [0, 1].
    const KinematicTree tree = planarChain({1.0});
    MovingFrames frames;
    frames.reset(tree, {.root = {}, .positions = {0, 0}, .rates = {0, 1.5707963267948966}});
    FrameSweep sweep;
    sweep.reset(frames, 0, 0.0, 1.0);
    // The frame is aligned with the joint's axis, not with the link.
    OrientedBox rod{.center = {0.5, 0, 0}, .half = {0.5, 0, 0}};
    rod.center = frames.place(1).X_FL * rod.center;
    rod.axes = frames.place(1).X_FL.linear() * rod.axes;
    const SweptBox swept = sweep.boxOver(frames.place(1).frame, rod);
    EXPECT_LT((swept.box.min() - Vector3d(0, 0, 0)).cwiseAbs().maxCoeff(), 0.01);
    EXPECT_LT((swept.box.max() - Vector3d(1, 1, 0)).cwiseAbs().maxCoeff(), 0.01);
    EXPECT_LT(swept.excess, 0.01);
}
}  // namespace
}  // namespace bullet_ccd::tests
