/// The reference itself, against closed forms.
#include "benchmarks/reference/oracles/brute_force_distance.h"

#include "benchmarks/reference/scenes/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

const Corners kFlat{Vector3d(0, 0, 0), Vector3d(2, 0, 0), Vector3d(0, 2, 0)};

TEST(BruteForceTriangleDistance, VertexAboveTheInteriorOfAFace)
{
    const Corners above{Vector3d(0.5, 0.5, 1), Vector3d(0.5, 0.5, 3), Vector3d(1, 0.5, 3)};
    const OracleDistance result = bruteForceTriangleDistance(above, kFlat);
    EXPECT_DOUBLE_EQ(result.distance, 1.0);
    EXPECT_LT((result.pointA - Vector3d(0.5, 0.5, 1)).norm(), 1e-15);
    EXPECT_LT((result.pointB - Vector3d(0.5, 0.5, 0)).norm(), 1e-15);
}

TEST(BruteForceTriangleDistance, CrossedEdgesAndParallelEdges)
{
    const Corners wedge{Vector3d(1, -1, 0.25), Vector3d(1, 3, 0.25), Vector3d(1, 0, 5)};
    EXPECT_DOUBLE_EQ(bruteForceTriangleDistance(wedge, kFlat).distance, 0.25);
    const Corners beside{Vector3d(0, -3, 4), Vector3d(2, -3, 4), Vector3d(1, -5, 4)};
    EXPECT_DOUBLE_EQ(bruteForceTriangleDistance(kFlat, beside).distance, 5.0);
}

TEST(BruteForceTriangleDistance, VertexToVertexAndCoplanar)
{
    const Corners away{Vector3d(-3, -4, 0), Vector3d(-9, -4, 0), Vector3d(-3, -9, 0)};
    EXPECT_DOUBLE_EQ(bruteForceTriangleDistance(kFlat, away).distance, 5.0);
}

TEST(BruteForceTriangleDistance, CrossingTrianglesAreAtDistanceZero)
{
    const Corners through{Vector3d(0.5, 0.5, -1), Vector3d(0.5, 0.5, 1), Vector3d(5, 5, 0)};
    const OracleDistance result = bruteForceTriangleDistance(kFlat, through);
    EXPECT_EQ(result.distance, 0.0);
    EXPECT_LT(distanceToTriangle(result.pointA, kFlat), 1e-15);
    EXPECT_LT(distanceToTriangle(result.pointB, through), 1e-15);
}

TEST(BruteForceTriangleDistance, DegenerateTrianglesAreTheirSegmentsAndPoints)
{
    const Vector3d point(0.25, 0.25, -2);
    EXPECT_DOUBLE_EQ(bruteForceTriangleDistance({point, point, point}, kFlat).distance, 2.0);
    const Corners line{Vector3d(-1, 1, 3), Vector3d(0, 1, 3), Vector3d(5, 1, 3)};
    EXPECT_DOUBLE_EQ(bruteForceTriangleDistance(line, kFlat).distance, 3.0);
    const Corners needle{Vector3d(0.5, 0.5, -1), Vector3d(0.5, 0.5, 1), Vector3d(0.5, 0.5, 1)};
    EXPECT_EQ(bruteForceTriangleDistance(needle, kFlat).distance, 0.0);
}

TEST(BruteForceTriangleDistance, IsTheMinimumOverSampledPoints)
{
    Random random(7);
    int apart = 0;
    for (int i = 0; i < 300; ++i)
    {
        Corners a;
        Corners b;
        const Vector3d shift = random.inBox(1.5);
        for (std::size_t k = 0; k < 3; ++k)
        {
            a[k] = random.inBox(1.0);
            b[k] = random.inBox(1.0) + shift;
        }
        const OracleDistance result = bruteForceTriangleDistance(a, b);
        apart += result.distance > 0.0 ? 1 : 0;
        EXPECT_NEAR((result.pointA - result.pointB).norm(), result.distance, 1e-14);
        EXPECT_LT(distanceToTriangle(result.pointA, a), 1e-14);
        EXPECT_LT(distanceToTriangle(result.pointB, b), 1e-14);
        double sampled = 1e9;
        constexpr int kGrid = 24;
        for (int u = 0; u <= kGrid; ++u)
        {
            for (int v = 0; u + v <= kGrid; ++v)
            {
                const Vector3d p = a[0] + (a[1] - a[0]) * u / kGrid + (a[2] - a[0]) * v / kGrid;
                sampled = std::min(sampled, distanceToTriangle(p, b));
            }
        }
        EXPECT_LE(result.distance, sampled + 1e-14);
        const double spacing = ((a[1] - a[0]).norm() + (a[2] - a[0]).norm()) / kGrid;
        EXPECT_GE(result.distance, sampled - spacing);
    }
    EXPECT_GT(apart, 90);
    EXPECT_LT(apart, 290);
}

TEST(BruteForceMeshDistance, BoxesAndSpheresByClosedForm)
{
    EXPECT_DOUBLE_EQ(bruteForceMeshDistance(cube(1.0), cube(1.0), poseOf({5.0, 6.0, 0.0})).distance,
                     5.0);
    const TriangleMesh ball = sphereWithPole(1.0, Vector3d(1, 2, 3));
    const Vector3d pole = Vector3d(1, 2, 3).normalized();
    const TriangleMesh other = sphereWithPole(2.0, -pole);
    const OracleDistance result = bruteForceMeshDistance(other, ball, poseOf(4.0 * pole));
    EXPECT_NEAR(result.distance, 1.0, 1e-14);
    EXPECT_LT((result.pointB - pole).norm(), 1e-14);
    EXPECT_EQ(bruteForceMeshDistance(other, ball, poseOf(2.5 * pole)).distance, 0.0);
}

TEST(BruteForceMeshDistance, SkippingByBallsLosesNothing)
{
    Random random(11);
    for (int i = 0; i < 30; ++i)
    {
        const TriangleMesh a = soup(random, 12, 1.0, 0.4);
        const TriangleMesh b = soup(random, 9, 1.0, 0.4);
        const Eigen::Isometry3d X = random.pose(2.0);
        double expected = 1e9;
        for (std::size_t k = 0; k < a.triangles.size(); ++k)
        {
            Corners corners = cornersOf(a, k);
            for (Vector3d& corner : corners)
            {
                corner = X * corner;
            }
            for (std::size_t m = 0; m < b.triangles.size(); ++m)
            {
                expected = std::min(expected,
                                    bruteForceTriangleDistance(corners, cornersOf(b, m)).distance);
            }
        }
        EXPECT_EQ(bruteForceMeshDistance(a, b, X).distance, expected);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
