/// Pairs that turn about one axis: what is said never to meet never does, and few pairs are looked
/// at where surfaces of revolution keep their distance.
#include "bullet_ccd/toi/search/turn_profiles.h"

#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/toi/least_distance.h"
#include "bullet_ccd/toi/search/pair_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A link that turns about a joint of a base, which may move.
KinematicTree hinge(Random& random)
{
    KinematicTree tree;
    tree.links.resize(2);
    Link& link = tree.links[1];
    link.parent = 0;
    link.X_PL0 = random.pose(0.3);
    link.joint.type = JointType::Revolute;
    link.joint.axis = random.direction();
    return tree;
}

TEST(TurnProfiles, WhatNeverMeetsIsApartAtAllTimes)
{
    Random random(11);
    PairScene scene;
    int apart = 0;
    int near = 0;
    double closest = 1.0;
    for (int i = 0; i < 400; ++i)
    {
        const KinematicTree tree = hinge(random);
        JointMotion motion = randomJointMotion(random, tree, 6.0);
        motion.rates[1] = random.uniform(-6.0, 6.0);
        if (random.chance(0.3))
        {
            addRandomCurves(random, 2.0, motion);
        }
        const SsvTree first = buildSsvTree(soup(random, 8, 0.3, 0.2));
        const SsvTree second = buildSsvTree(soup(random, 8, 0.3, 0.2));
        std::array<MovingBody, 2> bodies{
            MovingBody{.tree = &first,
                       .motion = LinkMotion{.tree = &tree, .motion = &motion, .link = 0},
                       .X_BG = random.pose(0.2)},
            MovingBody{.tree = &second,
                       .motion = LinkMotion{.tree = &tree, .motion = &motion, .link = 1},
                       .X_BG = random.pose(0.2)}};
        if (random.chance(0.3))
        {
            bodies[0].motion = restAt(random.pose(0.3));
            bodies[1].motion = RigidMotion{.X_W0 = random.pose(0.3),
                                           .w_W = random.uniform(0.0, 6.0) * random.direction(),
                                           .reference_B = 0.2 * random.direction()};
        }
        if (random.chance(0.5))
        {
            std::swap(bodies[0], bodies[1]);
        }
        const std::array<BodyPair, 1> pairs{BodyPair{.bodyA = 0, .bodyB = 1}};
        const double reach = random.uniform(0.0, 0.2);
        scene.reset(bodies, pairs, {.tolerance = 1e-6, .minimumSeparation = reach});
        while (scene.pair(0).untilTurn > 0)
        {
            scene.noteTriangles(0);
        }
        ASSERT_NE(scene.pair(0).turning, kNone);
        for (int k = 0; k < 200; ++k)
        {
            const double t = random.uniform(0.0, 1.0);
            const auto cornersAt = [&](const MovingBody& body, std::int32_t triangle)
            {
                TriangleCorners corners = body.tree->cornersOfTriangle(triangle);
                for (Vector3d& corner : corners)
                {
                    corner = geometryPoseAt(body, t) * (corner + body.tree->origin());
                }
                return corners;
            };
            const auto leafOf = [&](const SsvTree& of)
            {
                std::int32_t node = 0;
                do
                {
                    node = random.integer(0, static_cast<int>(of.nodes().size()) - 1);
                } while (!of.nodes()[static_cast<std::size_t>(node)].isLeaf());
                return node;
            };
            const NodePair p{
                .pair = 0, .nodeA = leafOf(*bodies[0].tree), .nodeB = leafOf(*bodies[1].tree)};
            const double distance =
                triangleDistance(
                    cornersAt(bodies[0], bodies[0].tree->triangle(scene.nodeA(p).first)),
                    cornersAt(bodies[1], bodies[1].tree->triangle(scene.nodeB(p).first)))
                    .distance;
            if (scene.neverMeets(p))
            {
                ASSERT_GT(distance, reach) << i;
                closest = std::min(closest, distance - reach);
                ++apart;
            }
            else
            {
                ++near;
            }
            // What is below the roots is nearer still.
            ASSERT_FALSE(!scene.neverMeets(p) &&
                         scene.neverMeets({.pair = 0, .nodeA = 0, .nodeB = 0}));
        }
    }
    EXPECT_GT(apart, 5000);
    EXPECT_GT(near, 5000);
    EXPECT_LT(closest, 5e-3);
}

/// A shaft of 90 facets in a sleeve of 60. The shaft turns: facet after facet passes facet, at the
/// same distance.
TEST(TurnProfiles, AShaftInASleeveTakesFewPairs)
{
    constexpr double kShaft = 0.05;
    constexpr int kFacets = 60;
    const double sleeve = 0.06 / std::cos(std::numbers::pi / kFacets);
    const SsvTree inner = buildSsvTree(makeCylinder(kShaft, 0.2, 90));
    const SsvTree outer = buildSsvTree(
        makeRevolved({{sleeve, -0.1}, {0.08, -0.1}, {0.08, 0.1}, {sleeve, 0.1}}, kFacets));
    KinematicTree tree;
    tree.links.resize(3);
    tree.links[1].parent = 0;
    tree.links[1].X_PL0.translation() = Vector3d(0.3, 0.1, 0.2);
    tree.links[1].joint.type = JointType::Revolute;
    tree.links[1].joint.axis = Vector3d::UnitY();
    tree.links[2].parent = 1;
    tree.links[2].joint.type = JointType::Revolute;
    tree.links[2].joint.axis = Vector3d::UnitZ();
    const std::array<const SsvTree*, 3> trees{nullptr, &outer, &inner};
    const std::array<std::pair<std::int32_t, std::int32_t>, 1> selfPairs{std::pair{1, 2}};
    JointMotion motion{.root = {}, .positions = {0.0, 0.2, 0.1}, .rates = {0.0, 2.0, 3.0}};
    for (const bool curves : {false, true})
    {
        if (curves)
        {
            motion.curves.assign(3, {0.5, -0.3, 0.0, 0.0});
        }
        ToiWorkspace work;
        const ArticulatedLeastDistance least = leastDistance(
            ArticulatedBody{
                .tree = &tree, .linkTrees = trees, .motion = &motion, .selfPairs = selfPairs},
            std::span<const RigidBody>{},
            {.tolerance = 1e-7},
            work);
        EXPECT_EQ(least.status, ToiStatus::Separated);
        EXPECT_LE(least.distance, 0.01 + 1e-14);
        EXPECT_GE(least.distance, 0.01 - 1e-7);
        EXPECT_LT(least.counters.trianglePairs + least.counters.nodePairs, 20000);
    }
    // The same of two rigid bodies, of which the other may turn, and which may fly on together.
    for (const ToiStrategy strategy :
         {ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A})
    {
        for (const Vector3d& v : {Vector3d(0.0, 0.0, 0.0), Vector3d(1.0, -2.0, 3.0)})
        {
            const RigidMotion turns{.v_W = v, .w_W = {0.0, 0.0, 3.0}};
            const RigidMotion flies{.v_W = v};
            for (const bool innerTurns : {false, true})
            {
                ToiWorkspace work;
                const ToiResult rigid = rigidToi(
                    {.tree = &outer, .motion = innerTurns ? flies : turns},
                    {.tree = &inner, .motion = innerTurns ? turns : flies},
                    {.tolerance = 1e-7, .minimumSeparation = 0.01 - 2e-7, .strategy = strategy},
                    work);
                EXPECT_EQ(rigid.status, ToiStatus::Separated);
                EXPECT_LT(rigid.counters.trianglePairs + rigid.counters.nodePairs, 10000);
            }
        }
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
