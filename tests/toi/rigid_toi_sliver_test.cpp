/// Triangles whose normals are rounding, and clearances that leave little room for it.
#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/toi/kernels/triangle_approach.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <gtest/gtest.h>

#include <cmath>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

constexpr ToiStrategy kStrategies[] = {
    ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A};

ToiResult query(const TriangleMesh& a,
                const TriangleMesh& b,
                const RigidMotion& motion,
                const ToiOptions& options)
{
    const SsvTree treeA = buildSsvTree(a);
    const SsvTree treeB = buildSsvTree(b);
    ToiWorkspace work;
    return rigidToi({.tree = &treeA, .motion = motion}, {.tree = &treeB}, options, work);
}

/// A contact is one: the bodies are as near as the tolerance says.
void expectNoFalseContact(const TriangleMesh& a,
                          const TriangleMesh& b,
                          const RigidMotion& motion,
                          const ToiOptions& options)
{
    const ToiResult result = query(a, b, motion, options);
    ASSERT_NE(result.status, ToiStatus::IterationLimit);
    if (isContact(result.status))
    {
        const double distance = bruteForceMeshDistance(a, b, motion.at(result.time).X_W).distance;
        EXPECT_LE(distance, options.tolerance + 1e-12) << "reported at t = " << result.time;
    }
}

/// A triangle whose corners lie on a line, exactly: the cross product of its edges is rounding
/// wherever products are contracted.
TEST(RigidToiSlivers, CollinearCornersAreNotMetFromFarAway)
{
    constexpr double s = 6.2;
    RigidMotion motion;
    motion.X_W0.translation() = Vector3d(-4.5, 7.25, 5);
    motion.v_W = Vector3d(2.625, -7, -3.625);
    for (const ToiStrategy strategy : kStrategies)
    {
        SCOPED_TRACE(nameOf(strategy));
        expectNoFalseContact(
            triangle({-0.625, 0.625, -0.875}, {0.25, 0.625, 0.625}, {-0.625, 0.75, -0.5}),
            triangle({s, -s, 0}, {2 * s, -2 * s, -s}, {0, 0, s}),
            motion,
            {.tolerance = 1e-4, .strategy = strategy});
    }
}

Vector3d latticePoint(Random& random)
{
    return 0.125 * Vector3d(random.integer(-8, 8), random.integer(-8, 8), random.integer(-8, 8));
}

/// Three points of a lattice that lie on a line, times a number that is no binary fraction.
TriangleCorners collinearCorners(Random& random)
{
    const Vector3d a = latticePoint(random);
    const Vector3d along = latticePoint(random);
    const double scale = random.uniform(0.5, 8.0);
    return {scale * a,
            scale * (a + random.integer(1, 3) * along),
            scale * (a - random.integer(0, 2) * along)};
}

/// What the closest points of two triangles say bounds their distance from above, what the gap
/// along their direction says bounds it from below, whatever the triangles look like.
TEST(RigidToiSlivers, LowerBoundsAreNeverAboveUpperBounds)
{
    Random random(5);
    RelativeMotion rest{};
    rest.R[0] = rest.R[4] = rest.R[8] = 1.0;
    const auto sliver = [&]
    {
        if (random.chance(0.5))
        {
            return collinearCorners(random);
        }
        const Vector3d a = random.inBox(1.0);
        const Vector3d along = random.inBox(1.0);
        const Vector3d width = random.logUniform(1e-17, 1.0) * random.inBox(1.0);
        return TriangleCorners{a, a + along, a + random.uniform(-0.5, 1.5) * along + width};
    };
    for (int i = 0; i < 20000; ++i)
    {
        const TriangleCorners a = sliver();
        TriangleCorners b = sliver();
        const Vector3d shift = random.logUniform(1e-6, 3.0) * random.inBox(1.0);
        for (Vector3d& corner : b)
        {
            corner += shift;
        }
        TriangleApproach approach{};
        approachTriangles(rest, a[0].data(), b[0].data(), 0.0, approach);
        const double exact = bruteForceTriangleDistance(a, b).distance;
        ASSERT_GE(approach.distance, exact - 1e-13) << i;
        ASSERT_LE(approach.gap, exact + 1e-13) << i;
        ASSERT_GE(triangleDistance(a, b).distance, exact - 1e-13) << i;
    }
}

/// At a clearance the direction of the closest points is known to rounding over the clearance, and
/// what that costs over the size of a triangle exceeds a small tolerance.
TEST(RigidToiSlivers, SmallClearancesWithSmallTolerancesAreAnswered)
{
    const TriangleMesh box = makeBox({1, 1, 1});
    const SsvTree tree = buildSsvTree(box);
    Random random(3);
    ToiWorkspace work;
    for (int i = 0; i < 150; ++i)
    {
        RigidBody falling{.tree = &tree};
        falling.motion.X_W0 = random.pose(0.0);
        falling.motion.X_W0.translation() = Vector3d(0.3, 0.2, 4);
        falling.motion.v_W = Vector3d(0.1, 0.2, -4);
        falling.motion.w_W = 3.0 * random.inBox(1.0);
        const ToiOptions options{.tolerance = random.logUniform(3e-12, 1e-9),
                                 .minimumSeparation = random.logUniform(1e-8, 1e-3)};
        const ToiResult hit = rigidToi(falling, {.tree = &tree}, options, work);
        ASSERT_EQ(hit.status, ToiStatus::Hit) << i << ": tolerance " << options.tolerance
                                              << ", clearance " << options.minimumSeparation;
        const double distance =
            bruteForceMeshDistance(box, box, falling.motion.at(hit.time).X_W).distance;
        EXPECT_NEAR(distance, options.minimumSeparation, options.tolerance + 1e-14);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
