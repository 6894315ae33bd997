/// The SIMD kernel against what it promises, and against its reference in double precision.
#include "bullet_ccd/toi/kernels/node_batch.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/toi/search/pair_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

constexpr double kBatchTolerance = 1e-3;

/// Two bodies near each other: one at rest, both turning, or turning together.
std::array<MovingBody, 2> randomBodies(Random& random, const SsvTree& treeA, const SsvTree& treeB)
{
    std::array<MovingBody, 2> bodies;
    const std::array<const SsvTree*, 2> trees{&treeA, &treeB};
    const bool together = random.chance(0.3);
    const Vector3d commonSpin = 2.0 * random.direction();
    for (std::size_t i = 0; i < 2; ++i)
    {
        RigidMotion motion{.X_W0 = random.pose(2.0)};
        motion.v_W = random.inBox(3.0);
        motion.reference_B = random.inBox(0.5);
        if (i == 0 || random.chance(0.5))
        {
            motion.w_W = together ? commonSpin : Vector3d(4.0 * random.inBox(1.0));
        }
        bodies[i] = {.tree = trees[i], .motion = motion};
        bodies[i].X_BG = random.pose(0.3);
    }
    return bodies;
}

std::vector<std::int32_t> trianglesBelow(const SsvTree& tree, std::int32_t node)
{
    std::vector<std::int32_t> triangles;
    std::vector<std::int32_t> open{node};
    while (!open.empty())
    {
        const SsvNode& n = tree.nodes()[static_cast<std::size_t>(open.back())];
        open.pop_back();
        if (n.isLeaf())
        {
            triangles.push_back(tree.triangle(n.first));
        }
        for (std::int32_t k = 0; k < n.count; ++k)
        {
            open.push_back(n.first + k);
        }
    }
    return triangles;
}

/// Distance of the triangles below two nodes at time t, all against all.
double distanceBelow(const std::array<MovingBody, 2>& bodies,
                     const std::array<std::vector<std::int32_t>, 2>& triangles,
                     double t)
{
    std::array<std::vector<TriangleCorners>, 2> placed;
    for (std::size_t i = 0; i < 2; ++i)
    {
        const SsvTree& tree = *bodies[i].tree;
        const Eigen::Isometry3d X = geometryPoseAt(bodies[i], t);
        for (const std::int32_t triangle : triangles[i])
        {
            TriangleCorners corners = tree.cornersOfTriangle(triangle);
            for (Vector3d& corner : corners)
            {
                corner = X * (corner + tree.origin());
            }
            placed[i].push_back(corners);
        }
    }
    double distance = 1e300;
    for (const TriangleCorners& a : placed[0])
    {
        for (const TriangleCorners& b : placed[1])
        {
            distance = std::min(distance, bruteForceTriangleDistance(a, b).distance);
        }
    }
    return distance;
}

TEST(NodeBatch, StepsKeepTheirMarginAndAreAsLongAsInDoublePrecision)
{
    Random random(71);
    const SsvTree treeA = buildSsvTree(soup(random, 40, 1.0, 0.4));
    const SsvTree treeB = buildSsvTree(soup(random, 30, 0.8, 0.6));
    ToiOptions options;
    options.tolerance = kBatchTolerance;
    PairScene scene;
    ToiCounters counters;
    std::vector<double> ratios;
    int checked = 0;
    constexpr std::array<BodyPair, 1> kPair{BodyPair{.bodyA = 0, .bodyB = 1}};
    for (int i = 0; i < 250; ++i)
    {
        const auto bodies = randomBodies(random, treeA, treeB);
        scene.reset(bodies, kPair, options);
        std::array<NodePair, NodeBatch::kLanes> batch;
        for (NodePair& p : batch)
        {
            p = {.time = random.uniform(0.0, 0.9),
                 .pair = 0,
                 .nodeA = random.integer(0, static_cast<int>(treeA.nodes().size()) - 1),
                 .nodeB = random.integer(0, static_cast<int>(treeB.nodes().size()) - 1)};
        }
        std::array<float, NodeBatch::kLanes> steps;
        scene.steps(batch, counters, steps.data());
        for (std::size_t lane = 0; lane < batch.size(); ++lane)
        {
            const NodePair& p = batch[lane];
            const double step = static_cast<double>(steps[lane]);
            const double margin = scene.pair(0).limits.margin();
            const Step reference = nodeStep(
                scene.stateAt(0, p.time, counters).motion, margin, scene.nodeA(p), scene.nodeB(p));
            if (reference.time > 1e-3 && reference.time < 10.0)
            {
                ratios.push_back(step / reference.time);
            }
            const std::array<std::vector<std::int32_t>, 2> below{trianglesBelow(treeA, p.nodeA),
                                                                 trianglesBelow(treeB, p.nodeB)};
            const double end = std::min(1.0, p.time + step);
            if (step <= 0.0 || below[0].size() * below[1].size() > 200)
            {
                continue;
            }
            ++checked;
            for (int k = 1; k <= 6; ++k)
            {
                const double t = p.time + (end - p.time) * k / 6.0;
                EXPECT_GE(distanceBelow(bodies, below, t), margin)
                    << "scene " << i << ", lane " << lane << ", t " << t;
            }
        }
    }
    EXPECT_GT(checked, 500);
    ASSERT_GT(ratios.size(), 500U);
    std::sort(ratios.begin(), ratios.end());
    // Approximate roots cost half a thousandth; single precision in between a little more.
    EXPECT_GT(ratios[ratios.size() / 2], 0.996);
    EXPECT_GT(ratios[ratios.size() / 50], 0.9);
    EXPECT_LT(ratios[ratios.size() * 49 / 50], 1.01);
}

TEST(NodeBatch, LanesDoNotDependOnEachOther)
{
    Random random(72);
    const SsvTree tree = buildSsvTree(soup(random, 100, 1.0, 0.3));
    PairScene scene;
    ToiCounters counters;
    constexpr std::array<BodyPair, 1> kPair{BodyPair{.bodyA = 0, .bodyB = 1}};
    for (int i = 0; i < 50; ++i)
    {
        const auto bodies = randomBodies(random, tree, tree);
        scene.reset(bodies, kPair, {});
        std::array<NodePair, NodeBatch::kLanes> batch;
        for (NodePair& p : batch)
        {
            p = {.time = random.uniform(0.0, 0.9),
                 .pair = 0,
                 .nodeA = random.integer(0, static_cast<int>(tree.nodes().size()) - 1),
                 .nodeB = random.integer(0, static_cast<int>(tree.nodes().size()) - 1)};
        }
        std::array<float, NodeBatch::kLanes> together;
        scene.steps(batch, counters, together.data());
        for (std::size_t lane = 0; lane < batch.size(); ++lane)
        {
            float alone = -1.0F;
            scene.steps({&batch[lane], 1}, counters, &alone);
            EXPECT_EQ(alone, together[lane]) << "scene " << i << ", lane " << lane;
        }
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
