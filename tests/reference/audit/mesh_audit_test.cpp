#include "benchmarks/reference/audit/mesh_audit.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d shift(double x, double y, double z)
{
    return Isometry3d(Eigen::Translation3d(x, y, z));
}

const Isometry3d kHere = Isometry3d::Identity();

TEST(MeshAudit, CornerInABoxHasTheDepthOfTheSmallestOverlap)
{
    const AuditMesh cube(makeBox({0.5, 0.5, 0.5}));
    const PairAudit audit = auditPair(cube, kHere, cube, shift(0.9, 0.8, 0.7));
    EXPECT_GT(audit.crossings, 0);
    EXPECT_NEAR(audit.depth, 0.1, 1e-12);
    EXPECT_FALSE(audit.clean());
}

TEST(MeshAudit, PlaceOfTheDeepestPointIsTheTip)
{
    const AuditMesh large(makeBox({0.5, 0.5, 0.5}));
    const AuditMesh spike(scaled(octahedron(), 0.1));
    Isometry3d X = shift(3.0, -2.0, 1.0);
    X.linear() = Eigen::AngleAxisd(0.7, Vector3d::UnitY()).toRotationMatrix();
    const PairAudit audit = auditPair(large, X, spike, X * shift(0.58, 0.1, 0.2));
    EXPECT_NEAR(audit.depth, 0.02, 1e-12);
    EXPECT_LT((audit.point_W - X * Vector3d(0.48, 0.1, 0.2)).norm(), 1e-12);
}

TEST(MeshAudit, CrossingRodsWithoutVerticesInsideHaveADepth)
{
    const AuditMesh alongX(makeBox({0.5, 0.1, 0.1}));
    const AuditMesh alongY(makeBox({0.1, 0.5, 0.1}));
    const PairAudit audit = auditPair(alongX, kHere, alongY, shift(0.0, 0.0, 0.15));
    EXPECT_NEAR(audit.depth, 0.05, 1e-12);
}

TEST(MeshAudit, ANanometreDecides)
{
    const AuditMesh cube(makeBox({0.5, 0.5, 0.5}));
    EXPECT_TRUE(auditPair(cube, kHere, cube, shift(1.0 + 1e-9, 0.1, 0.2)).clean());
    const PairAudit audit = auditPair(cube, kHere, cube, shift(1.0 - 1e-9, 0.1, 0.2));
    EXPECT_GT(audit.crossings, 0);
    EXPECT_NEAR(audit.depth, 1e-9, 1e-12);
    EXPECT_FALSE(auditPair(cube, kHere, cube, shift(1.0, 0.1, 0.2)).clean());  // touching
}

TEST(MeshAudit, ABallInABallIsContained)
{
    const AuditMesh large(makeSphere(0.5, 3));
    const AuditMesh small(makeBox({0.01, 0.01, 0.01}));
    const PairAudit audit = auditPair(small, shift(0.1, 0.0, 0.0), large, kHere);
    EXPECT_EQ(audit.crossings, 0);
    EXPECT_TRUE(audit.contained);
    EXPECT_NEAR(audit.depth, 0.41, 0.01);
    EXPECT_TRUE(auditPair(large, kHere, small, shift(0.1, 0.0, 0.0)).contained);
}

TEST(MeshAudit, ABallInTheHoleOfARingIsFree)
{
    const AuditMesh ring(makeTorus(0.5, 0.1, 64, 32));
    const AuditMesh ball(makeSphere(0.39, 3));
    EXPECT_TRUE(auditPair(ring, kHere, ball, kHere).clean());
    EXPECT_TRUE(auditPair(ball, kHere, ring, kHere).clean());
    EXPECT_FALSE(auditPair(ring, kHere, ball, shift(0.02, 0.0, 0.0)).clean());
}

TEST(MeshAudit, FindsEveryCrossingOfBruteForce)
{
    Random random(11);
    const AuditMesh ring(makeTorus(0.05, 0.02, 12, 8));
    const AuditMesh capsule(makeCapsule(0.015, 0.08, 10));
    int crossed = 0;
    constexpr int kTrials = 200;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const Isometry3d X_WA = random.pose(0.02);
        const Isometry3d X_WB = random.pose(0.07);
        const Isometry3d X_AB = X_WA.inverse() * X_WB;
        std::int64_t expected = 0;
        for (std::size_t i = 0; i < ring.mesh().triangles.size(); ++i)
        {
            const GridTriangle a = ring.corners(static_cast<std::int32_t>(i), kHere);
            for (std::size_t k = 0; k < capsule.mesh().triangles.size(); ++k)
            {
                expected +=
                    trianglesMeet(a, capsule.corners(static_cast<std::int32_t>(k), X_AB)) ? 1 : 0;
            }
        }
        EXPECT_EQ(auditPair(ring, X_WA, capsule, X_WB).crossings, expected) << trial;
        crossed += expected > 0 ? 1 : 0;
    }
    EXPECT_GT(crossed, kTrials * 3 / 10);
    EXPECT_LT(crossed, kTrials * 9 / 10);
}

TEST(MeshAudit, DistanceAgreesWithTheOracle)
{
    Random random(13);
    const AuditMesh ring(makeTorus(0.5, 0.2, 12, 8));
    for (int trial = 0; trial < 500; ++trial)
    {
        const Vector3d point = random.inBox(0.8);
        EXPECT_NEAR(ring.distance(point), distanceToMesh(point, ring.mesh()), 1e-14);
    }
}

class MeshAuditScene : public testing::Test
{
protected:
    AuditMesh m_cube{makeBox({0.5, 0.5, 0.5})};
    AuditScene m_scene{.parts = {{&m_cube, 0}, {&m_cube, 1}, {&m_cube, 2}},
                       .fixed = {false, false, false}};
    BodyPoses m_poses{kHere, shift(0.9, 0.0, 0.0), shift(0.0, 0.7, 0.0)};
};

TEST_F(MeshAuditScene, NamesTheDeepestPairAndCountsAll)
{
    const AuditResult result = auditPoses(m_scene, m_poses, 1.5);
    EXPECT_EQ(result.intersecting, 3);
    EXPECT_EQ(result.bodyA, 0);
    EXPECT_EQ(result.bodyB, 2);
    EXPECT_EQ(result.time, 1.5);
    EXPECT_NEAR(result.worst.depth, 0.3, 1e-12);
}

TEST_F(MeshAuditScene, LeavesOutIgnoredAndFixedPairs)
{
    m_scene.ignored = {{0, 2}};
    m_scene.fixed = {true, true, false};
    const AuditResult result = auditPoses(m_scene, m_poses, 0.0);
    EXPECT_EQ(result.intersecting, 1);
    EXPECT_EQ(result.bodyA, 1);
    EXPECT_EQ(result.bodyB, 2);
}

TEST_F(MeshAuditScene, PartsAreWhereTheirBodiesCarryThem)
{
    m_scene.parts[1].X_BM = shift(5.0, 0.0, 0.0);
    m_scene.parts[2].body = 0;
    EXPECT_TRUE(auditPoses(m_scene, m_poses, 0.0).clean());
}

TEST(MeshAudit, BetweenPosesTurnsAtConstantRate)
{
    Isometry3d to = shift(2.0, 0.0, 4.0);
    to.linear() = Eigen::AngleAxisd(std::numbers::pi / 2.0, Vector3d::UnitZ()).toRotationMatrix();
    const Isometry3d middle = betweenPoses(kHere, to, 0.5);
    EXPECT_LT((middle.translation() - Vector3d(1.0, 0.0, 2.0)).norm(), 1e-15);
    EXPECT_LT((middle.linear() * Vector3d::UnitX() - Vector3d(1.0, 1.0, 0.0).normalized()).norm(),
              1e-15);
    EXPECT_TRUE(betweenPoses(to, to, 0.3).isApprox(to));
}
}  // namespace
}  // namespace bullet_ccd::tests
