// The parts of convexToi(), each against something slow and obvious.
#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/queries/convex_queries.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/convex/box_separation.h"
#include "bullet_ccd/convex/closest_points.h"
#include "bullet_ccd/convex/convex_pair.h"
#include "bullet_ccd/convex/support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd::tests
{
namespace
{
using Eigen::Vector3d;
using reference::Random;

Placement placementOf(const Eigen::Isometry3d& X)
{
    return {.R = X.linear(), .p = X.translation()};
}

/// The gap along a direction, from all corners: what every other gap is compared with.
double slowGap(const TriangleMesh& a,
               const TriangleMesh& b,
               const Placement& pose,
               const Vector3d& n)
{
    double farthestA = -std::numeric_limits<double>::infinity();
    double nearestB = std::numeric_limits<double>::infinity();
    for (const Vector3d& v : a.vertices)
    {
        farthestA = std::max(farthestA, n.dot(pose.R * v + pose.p));
    }
    for (const Vector3d& v : b.vertices)
    {
        nearestB = std::min(nearestB, n.dot(v));
    }
    return nearestB - farthestA;
}

/// The best of the fifteen axes of two boxes, written down as it is defined.
double slowBoxGap(const TriangleMesh& a, const TriangleMesh& b, const Placement& pose)
{
    double best = -std::numeric_limits<double>::infinity();
    const auto offer = [&](const Vector3d& axis)
    {
        if (axis.norm() > 1e-5)
        {
            const Vector3d n = axis.normalized();
            best = std::max({best, slowGap(a, b, pose, n), slowGap(a, b, pose, -n)});
        }
    };
    for (int i = 0; i < 3; ++i)
    {
        offer(pose.R.col(i));
        offer(Vector3d::Unit(i));
        for (int j = 0; j < 3; ++j)
        {
            offer(pose.R.col(i).cross(Vector3d::Unit(j)));
        }
    }
    return best;
}

TEST(ConvexParts, SineAndCosineAreThoseOfTheLibrary)
{
    Random random(1);
    for (int i = 0; i < 20000; ++i)
    {
        const double scale = random.logUniform(1e-9, 3e5);
        const double angle = i == 0 ? 0.0 : random.uniform(-scale, scale);
        const auto [found, other] = sinesAndCosines(angle, 0.5 * angle);
        EXPECT_EQ(other.sine, sinesAndCosines(0.0, 0.5 * angle)[1].sine);
        EXPECT_NEAR(found.sine, std::sin(angle), 3e-16) << angle;
        EXPECT_NEAR(found.cosine, std::cos(angle), 3e-16) << angle;
    }
}

TEST(ConvexParts, SupportPointsAreOnTheShapeAndFarthest)
{
    Random random(2);
    const std::vector<Vector3d> corners{{1, 0, 0}, {0, 2, 0}, {0, 0, 0.5}, {-1, -1, -1}};
    const std::vector<ConvexShape> shapes{sphereShape(0.5),
                                          capsuleShape(0.1, 0.7),
                                          boxShape({0.3, 0.5, 0.7}),
                                          cylinderShape(0.4, 0.6),
                                          coneShape(0.4, 0.6),
                                          hullShape(corners)};
    for (const ConvexShape& shape : shapes)
    {
        for (int i = 0; i < 200; ++i)
        {
            Vector3d n = random.direction();
            if (i % 4 == 0)
            {
                n[random.integer(0, 2)] = 0.0;
            }
            const Vector3d p = supportPoint(shape, n);
            EXPECT_NEAR(n.dot(p), supportHeight(shape, n), 1e-15);
            EXPECT_LE(p.norm(), shape.coreRadius * (1.0 + 1e-15));
            // No point of the core is farther: it is a point that some direction finds.
            const Vector3d other = supportPoint(shape, random.direction());
            EXPECT_LE(n.dot(other), n.dot(p) + 1e-15);
        }
    }
}

TEST(ConvexParts, BoxAxesAreTheBestOfAll)
{
    Random random(3);
    int apart = 0;
    constexpr int kPairs = 3000;
    for (int i = 0; i < kPairs; ++i)
    {
        const Vector3d halfA = random.inBox(0.5).cwiseAbs() + Vector3d::Constant(0.05);
        const Vector3d halfB = random.inBox(0.5).cwiseAbs() + Vector3d::Constant(0.05);
        const TriangleMesh a = makeBox(halfA);
        const TriangleMesh b = makeBox(halfB);
        Eigen::Isometry3d X = random.pose(1.0);
        if (i % 5 == 0)
        {
            X.linear() = Eigen::AngleAxisd(random.chance(0.5) ? 0.0 : random.logUniform(1e-9, 1e-2),
                                           random.direction())
                             .toRotationMatrix();
        }
        const Placement pose = placementOf(X);
        const BoxAxis axis = bestBoxAxis(halfA, halfB, pose);
        const double slow = slowBoxGap(a, b, pose);
        if (axis.gap <= 0.0)
        {
            EXPECT_LE(slow, 1e-10);
            continue;
        }
        ++apart;
        EXPECT_NEAR(slowGap(a, b, pose, axis.normal), axis.gap, 1e-9);
        EXPECT_NEAR(axis.gap, slow, 1e-9);
        const double distance = reference::bruteForceMeshDistance(a, b, X).distance;
        EXPECT_LE(axis.gap, distance + 1e-9);
        ClosestPoints points;
        if (facingPoints(halfA, halfB, pose, axis, points))
        {
            EXPECT_NEAR(axis.gap, distance, 1e-9);
            EXPECT_NEAR((points.pointB - points.pointA).norm(), distance, 1e-9);
        }
    }
    EXPECT_GT(apart, kPairs / 3);
    EXPECT_LT(apart, kPairs);
}

TEST(ConvexParts, ClosestPointsAreThoseOfTheTriangles)
{
    int apart = 0;
    constexpr int kPairs = 1500;
    Simplex warm;
    for (int i = 0; i < kPairs; ++i)
    {
        const auto family = static_cast<std::uint64_t>(
            i % 2 == 0 ? reference::ConvexFamily::Hulls : reference::ConvexFamily::Rounded);
        const reference::ConvexQueryCase query = reference::convexQuery(
            family + reference::kConvexFamilies * static_cast<std::uint64_t>(i));
        Random random(static_cast<std::uint64_t>(i));
        const Eigen::Isometry3d X = random.pose(0.9);
        Simplex simplex;
        const ClosestPoints found = closestPoints(query.shapes[0].shape,
                                                  query.shapes[1].shape,
                                                  placementOf(X),
                                                  std::numeric_limits<double>::infinity(),
                                                  false,
                                                  simplex);
        const TriangleMesh& a = query.shapes[0].inner;
        const TriangleMesh& b = query.shapes[1].inner;
        const double distance = reference::bruteForceMeshDistance(a, b, X).distance;
        if (found.distance == 0.0)
        {
            // The solids meet: no direction separates them.
            for (int k = 0; k < 50; ++k)
            {
                EXPECT_LE(slowGap(a, b, placementOf(X), random.direction()), 1e-12);
            }
            continue;
        }
        ++apart;
        EXPECT_NEAR(found.distance, distance, 1e-9) << i;
        EXPECT_NEAR((found.pointA - found.pointB).norm(), found.distance, 1e-12);
        EXPECT_LE(found.gap, distance + 1e-12);
        EXPECT_NEAR(found.gap, slowGap(a, b, placementOf(X), found.normal), 1e-12);
        EXPECT_GE(found.gap, distance - 1e-6);
    }
    EXPECT_GT(apart, kPairs / 4);
    EXPECT_LT(apart, kPairs);
}

/// What certifies: between two times, the gap is above the chord less its sag, for any direction
/// and however it turns.
TEST(ConvexParts, GapsAreSemiConcave)
{
    Random random(5);
    double closest = std::numeric_limits<double>::infinity();
    for (std::uint64_t seed = 1; seed <= 600; ++seed)
    {
        const reference::ConvexQueryCase query = reference::convexQuery(seed);
        if (query.family == reference::ConvexFamily::Ground)
        {
            continue;
        }
        const ConvexBody a = query.body(0);
        const ConvexBody b = query.body(1);
        const ConvexPair pair(ConvexCourse(a, b), a, b);
        const double begin = random.uniform(0.0, 0.9);
        ConvexPlaces places;
        pair.at(begin, places);
        using With = TurningDirection::With;
        const std::array<With, 3> kinds{With::BodyA, With::BodyB, With::Itself};
        const Vector3d n = random.direction();
        const GapAlong along(pair,
                             places,
                             {.n = n,
                              .n_B = places.RB().transpose() * n,
                              .with = kinds[static_cast<std::size_t>(random.integer(0, 2))],
                              .w = random.inBox(3.0)});
        EXPECT_NEAR(along.gap(), along.gapAt(begin), 1e-13 * (1.0 + std::abs(along.gap())));
        const double length = random.uniform(0.0, 1.0 - begin);
        const double last = along.gapAt(begin + length);
        for (int k = 1; k < 40; ++k)
        {
            const double s = length * k / 40.0;
            const double bound = along.gap() + (last - along.gap()) * s / length -
                                 0.5 * along.bend() * s * (length - s);
            const double truth = along.gapAt(begin + s);
            EXPECT_GE(truth, bound - 1e-12) << seed;
            closest = std::min(closest, (truth - bound) / (1e-9 + along.bend() * length * length));
        }
    }
    EXPECT_LT(closest, 0.02);  // the bound is not idle
}

TEST(ConvexParts, CertifiedRootsAreWhereTheBoundEnds)
{
    Random random(6);
    int roots = 0;
    for (int i = 0; i < 5000; ++i)
    {
        const double first = random.logUniform(1e-12, 1.0);
        const double last = random.uniform(-1.0, 1.0);
        const double length = random.logUniform(1e-9, 1.0);
        const double bend = random.chance(0.2) ? 0.0 : random.logUniform(1e-6, 1e3);
        const double root = certifiedRoot(first, last, length, bend);
        const auto bound = [&](double s)
        { return first + (last - first) * s / length - 0.5 * bend * s * (length - s); };
        const double scale = 1e-12 * (first + std::abs(last) + bend * length * length);
        for (int k = 0; k <= 20; ++k)
        {
            EXPECT_GE(bound(root * k / 20.0), -scale);
        }
        if (root < length)
        {
            ++roots;
            EXPECT_NEAR(bound(root), 0.0, scale);
        }
        else
        {
            EXPECT_GE(last, -scale);
        }
    }
    EXPECT_GT(roots, 1000);
}
}  // namespace
}  // namespace bullet_ccd::tests
