#include "bullet_ccd/distance/triangle_distance.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/scenes/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

/// Rounding that a distance may show, in units of the largest coordinate: 64 unit roundoffs.
constexpr double kRounding = 64.0 * 1.2e-16;

double sizeOf(const Corners& a, const Corners& b)
{
    double size = 0.0;
    for (std::size_t k = 0; k < 3; ++k)
    {
        size = std::max({size, a[k].norm(), b[k].norm()});
    }
    return size;
}

struct Pair
{
    Corners a;
    Corners b;
};

Corners randomCorners(Random& random)
{
    return {random.inBox(1.0), random.inBox(1.0), random.inBox(1.0)};
}

Vector3d pointIn(const Corners& corners, Random& random)
{
    double u = random.uniform(0.0, 1.0);
    double v = random.uniform(0.0, 1.0);
    if (u + v > 1.0)
    {
        u = 1.0 - u;
        v = 1.0 - v;
    }
    return corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
}

/// A triangle of unit length with that height.
Corners sliver(Random& random, double height)
{
    const Vector3d start = random.inBox(1.0);
    const Vector3d along = random.direction();
    const Vector3d side = along.cross(random.direction()).normalized();
    return {start, start + along, start + random.uniform(-0.2, 1.2) * along + height * side};
}

void makeCoplanar(Corners& corners)
{
    for (Vector3d& corner : corners)
    {
        corner.z() = 0.25;
    }
}

enum class Kind
{
    Random,
    Apart,
    SegmentAndPoint,
    Sliver,
    Coplanar,
    SharedVertex,
    SharedEdge,
    Touching,
    ParallelEdges,
    AlmostParallelPlanes,
    Count
};

Pair makePair(Kind kind, Random& random)
{
    Pair pair{randomCorners(random), randomCorners(random)};
    auto& [a, b] = pair;
    const Vector3d offset = random.inBox(2.5);
    switch (kind)
    {
        case Kind::Apart:
            std::for_each(b.begin(), b.end(), [&](Vector3d& p) { p += offset; });
            break;
        case Kind::SegmentAndPoint:
            a[2] = random.chance(0.5) ? a[1] : Vector3d(a[0] + 0.25 * (a[1] - a[0]));
            b[2] = b[1] = random.chance(0.3) ? b[0] : b[1];
            break;
        case Kind::Sliver:
            a = sliver(random, random.logUniform(1e-10, 1e-6));
            b = random.chance(0.5) ? sliver(random, random.logUniform(1e-10, 1e-6)) : b;
            break;
        case Kind::Coplanar:
            std::for_each(b.begin(), b.end(), [&](Vector3d& p) { p += offset; });
            makeCoplanar(a);
            makeCoplanar(b);
            break;
        case Kind::SharedVertex:
            b[1] = a[2];
            break;
        case Kind::SharedEdge:
            b[1] = a[2];
            b[0] = a[0];
            break;
        case Kind::Touching:
            b[0] = pointIn(a, random);
            break;
        case Kind::ParallelEdges:
            b[0] = a[0] + offset;
            b[1] = b[0] + random.uniform(-2.0, 2.0) * (a[1] - a[0]) +
                   random.logUniform(1e-16, 1e-6) * random.direction();
            break;
        case Kind::AlmostParallelPlanes:
            for (std::size_t k = 0; k < 3; ++k)
            {
                a[k].z() = 1e-9 * a[k].z();
                b[k].z() = 1e-7 * b[k].z() + 1e-3;
            }
            break;
        default:
            break;
    }
    return pair;
}

Pair transformed(const Pair& pair, double scale, const Eigen::Isometry3d& X)
{
    Pair result = pair;
    for (std::size_t k = 0; k < 3; ++k)
    {
        result.a[k] = scale * (X * pair.a[k]);
        result.b[k] = scale * (X * pair.b[k]);
    }
    return result;
}

/// @return the error in units of the allowed rounding
double checkPair(const Pair& pair, const std::string& what)
{
    const TriangleDistance result = triangleDistance(pair.a, pair.b);
    const OracleDistance expected = bruteForceTriangleDistance(pair.a, pair.b);
    const double allowed = kRounding * sizeOf(pair.a, pair.b);
    const double error = std::abs(result.distance - expected.distance);
    EXPECT_LE(error, allowed) << what << ": " << result.distance << " for " << expected.distance;
    EXPECT_LE(std::abs((result.pointA - result.pointB).norm() - result.distance), allowed) << what;
    EXPECT_LE(distanceToTriangle(result.pointA, pair.a), allowed) << what;
    EXPECT_LE(distanceToTriangle(result.pointB, pair.b), allowed) << what;
    return error / allowed;
}

TEST(TriangleDistance, AgreesWithBruteForceOnAllKindsOfPairs)
{
    constexpr int kPairs = 20000;
    Random random(20);
    for (int k = 0; k < static_cast<int>(Kind::Count); ++k)
    {
        int crossing = 0;
        double worst = 0.0;
        for (int i = 0; i < kPairs && !HasFailure(); ++i)
        {
            Pair pair = makePair(static_cast<Kind>(k), random);
            // Exactly axis-aligned input is a case of its own: transform only every other pair.
            if (i % 2 == 1)
            {
                const double far = random.chance(0.3) ? random.logUniform(1.0, 1e6) : 0.0;
                pair = transformed(pair, random.logUniform(1e-6, 1e6), random.pose(far));
            }
            worst = std::max(
                worst, checkPair(pair, "kind " + std::to_string(k) + " #" + std::to_string(i)));
            crossing += bruteForceTriangleDistance(pair.a, pair.b).distance == 0.0 ? 1 : 0;
        }
        RecordProperty("worst_of_kind_" + std::to_string(k), std::to_string(worst));
        if (static_cast<Kind>(k) == Kind::Random)
        {
            EXPECT_GT(crossing, kPairs / 10);
            EXPECT_LT(crossing, kPairs * 7 / 10);
        }
    }
}

TEST(TriangleDistance, ReportsExactlyZeroForTrianglesThatCross)
{
    Random random(21);
    int crossing = 0;
    int apart = 0;
    for (int i = 0; i < 20000; ++i)
    {
        const Pair pair = makePair(Kind::Random, random);
        const double result = triangleDistance(pair.a, pair.b).distance;
        const double expected = bruteForceTriangleDistance(pair.a, pair.b).distance;
        crossing += expected == 0.0 ? 1 : 0;
        apart += expected > 1e-12 ? 1 : 0;
        EXPECT_TRUE(expected > 0.0 || result == 0.0) << i;
        EXPECT_TRUE(expected < 1e-12 || result > 0.0) << i;
    }
    EXPECT_GT(crossing, 2000);
    EXPECT_GT(apart, 2000);
}

TEST(TriangleDistance, IsSymmetricAndIndependentOfTheOrderOfCorners)
{
    Random random(22);
    for (int i = 0; i < 5000; ++i)
    {
        const auto kind = static_cast<Kind>(random.integer(0, static_cast<int>(Kind::Count) - 1));
        const Pair pair = makePair(kind, random);
        const double allowed = kRounding * sizeOf(pair.a, pair.b);
        const double reference = triangleDistance(pair.a, pair.b).distance;
        EXPECT_NEAR(triangleDistance(pair.b, pair.a).distance, reference, allowed);
        const Corners turned{pair.a[2], pair.a[0], pair.a[1]};
        const Corners flipped{pair.b[1], pair.b[0], pair.b[2]};
        EXPECT_NEAR(triangleDistance(turned, flipped).distance, reference, allowed);
    }
}

// A point is a triangle with three equal corners, a segment one with two.
TEST(TriangleDistance, PointsAndSegmentsAreDegenerateTriangles)
{
    Random random(31);
    for (int trial = 0; trial < 2000; ++trial)
    {
        const Corners a = randomCorners(random);
        const Corners b = trial % 4 == 0 ? sliver(random, 1e-9) : randomCorners(random);
        const double rounding = kRounding * sizeOf(a, b);
        EXPECT_NEAR(pointToTriangle(a[0], b).distance,
                    triangleDistance({a[0], a[0], a[0]}, b).distance,
                    rounding);
        const TriangleDistance edges = segmentToSegment(a[0], a[1], b[0], b[1]);
        EXPECT_NEAR(edges.distance,
                    triangleDistance({a[0], a[1], a[1]}, {b[0], b[1], b[1]}).distance,
                    rounding);
        EXPECT_NEAR((edges.pointA - edges.pointB).norm(), edges.distance, rounding);
    }
}

TEST(TriangleDistance, APlaneShowsNothingFartherThanItIs)
{
    Random random(32);
    int shown = 0;
    constexpr int kTrials = 4000;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const Corners a = trial % 3 == 0 ? sliver(random, 1e-12) : randomCorners(random);
        const Corners b = randomCorners(random);
        const double distance = triangleDistance(a, b).distance;
        EXPECT_FALSE(planeShowsFarther(a, b, distance * (1.0 + 1e-15)));
        shown += planeShowsFarther(a, b, 0.5 * distance) ? 1 : 0;
    }
    EXPECT_GE(shown, kTrials / 4);
}

TEST(TriangleDistance, ClosedForms)
{
    const Corners flat{Vector3d(0, 0, 0), Vector3d(2, 0, 0), Vector3d(0, 2, 0)};
    const Corners above{Vector3d(0.5, 0.5, 1), Vector3d(0.5, 0.5, 3), Vector3d(1, 0.5, 3)};
    EXPECT_DOUBLE_EQ(triangleDistance(flat, above).distance, 1.0);
    EXPECT_EQ(triangleDistance(flat, flat).distance, 0.0);
    const Corners away{Vector3d(-3, -4, 0), Vector3d(-9, -4, 0), Vector3d(-3, -9, 0)};
    EXPECT_DOUBLE_EQ(triangleDistance(flat, away).distance, 5.0);
    const Corners inside{Vector3d(0.25, 0.25, 0), Vector3d(0.5, 0.25, 0), Vector3d(0.25, 0.5, 0)};
    EXPECT_EQ(triangleDistance(flat, inside).distance, 0.0);
}
}  // namespace
}  // namespace bullet_ccd::tests
