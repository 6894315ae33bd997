// Queries must not depend on what bounds the triangles: every kind of volume, built, refitted or
// loaded, gives the same answers.
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/mesh/make_mesh.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <gtest/gtest.h>

#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

constexpr double kTolerance = 1e-6;

RigidMotion randomPass(Random& random)
{
    const Vector3d from = random.direction();
    RigidMotion motion;
    motion.X_W0.linear() = random.rotation();
    motion.X_W0.translation() = 3.5 * from;
    motion.v_W = -4.0 * from + 3.0 * random.direction();
    motion.w_W = 2.0 * random.direction();
    return motion;
}

/// Distances are exact whatever the volumes, times certified: they differ by what the tolerance
/// allows along the motion.
void expectSameAnswers(const SsvTree& a, const SsvTree& b, Random& random, int queries)
{
    int hits = 0;
    ToiWorkspace work;
    for (int i = 0; i < queries; ++i)
    {
        const RigidMotion motion = randomPass(random);
        const auto distance = [&](const SsvTree& tree, double t)
        { return treeDistance(tree, tree, motion.at(t).X_W, 100.0).distance; };
        EXPECT_NEAR(distance(a, 0.2), distance(b, 0.2), 1e-12);
        const auto toi = [&](const SsvTree& tree)
        {
            return rigidToi({.tree = &tree, .motion = motion},
                            {.tree = &tree, .motion = restAt(Eigen::Isometry3d::Identity())},
                            {.tolerance = kTolerance},
                            work);
        };
        const ToiResult fromA = toi(a);
        const ToiResult fromB = toi(b);
        EXPECT_EQ(fromA.status, fromB.status);
        if (fromA.status == ToiStatus::Hit)
        {
            ++hits;
            EXPECT_NEAR(distance(a, fromB.time), 0.0, kTolerance);
            EXPECT_GT(distance(a, fromB.time), 0.0);
            EXPECT_NEAR(fromA.time, fromB.time, 1e-3);
        }
    }
    EXPECT_GT(hits, queries / 5);
    EXPECT_LT(hits, queries);
}

TEST(SsvTreeQueries, EveryKindGivesTheSameAnswers)
{
    Random random(1);
    const TriangleMesh mesh = makeTorus(1.0, 0.3, 32, 16);
    const SsvTree boxes = buildSsvTree(mesh, {.kind = SsvKind::Box});
    for (const SsvKind kind : {SsvKind::RoundedBox,
                               SsvKind::SweptRectangle,
                               SsvKind::SweptLine,
                               SsvKind::SweptPoint,
                               SsvKind::Cheapest})
    {
        expectSameAnswers(boxes, buildSsvTree(mesh, {.kind = kind}), random, 20);
    }
}

TEST(SsvTreeQueries, ARefittedTreeGivesTheAnswersOfOneBuiltAnew)
{
    Random random(2);
    for (const SsvKind kind : {SsvKind::Box, SsvKind::RoundedBox, SsvKind::Cheapest})
    {
        const TriangleMesh mesh = makeTorus(1.0, 0.3, 32, 16);
        SsvTree refitted = buildSsvTree(mesh, {.kind = kind});
        TriangleMesh moved = mesh;
        for (Vector3d& p : moved.vertices)
        {
            p = Vector3d(p.x() * (1.0 + 0.4 * p.y()), 0.8 * p.y(), p.z() + 0.5 * p.x() * p.x()) +
                random.inBox(0.02);
        }
        refitted.refit(moved.vertices);
        expectSameAnswers(refitted, buildSsvTree(moved, {.kind = kind}), random, 30);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
