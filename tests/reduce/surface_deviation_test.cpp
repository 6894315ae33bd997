#include "bullet_ccd/reduce/reduce_mesh.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>
#include <random>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

/// Greatest distance of sampled points of `surface` from all triangles of `other`, by points of a
/// fine grid over each triangle and distances to a much finer cloud of points: no code is shared
/// with what is tested.
double sampledDeviation(const TriangleMesh& surface, const TriangleMesh& other, int steps)
{
    const auto samples = [steps](const TriangleMesh& mesh, int finer)
    {
        std::vector<Vector3d> points;
        const int n = steps * finer;
        for (const Triangle& t : mesh.triangles)
        {
            const Vector3d& a = mesh.vertices[static_cast<std::size_t>(t[0])];
            const Vector3d& b = mesh.vertices[static_cast<std::size_t>(t[1])];
            const Vector3d& c = mesh.vertices[static_cast<std::size_t>(t[2])];
            for (int i = 0; i <= n; ++i)
            {
                for (int j = 0; i + j <= n; ++j)
                {
                    points.push_back(a + (b - a) * i / n + (c - a) * j / n);
                }
            }
        }
        return points;
    };
    const std::vector<Vector3d> cloud = samples(other, 4);
    double farthest = 0.0;
    for (const Vector3d& point : samples(surface, 1))
    {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vector3d& q : cloud)
        {
            nearest = std::min(nearest, (point - q).squaredNorm());
        }
        farthest = std::max(farthest, std::sqrt(nearest));
    }
    return farthest;
}

TEST(SurfaceDeviation, OfABoxFromALargerOneIsTheDistanceOfTheFaces)
{
    const TriangleMesh small = makeBox({0.1, 0.2, 0.3});
    const TriangleMesh large = makeBox({0.11, 0.22, 0.33});
    const Deviation inside = surfaceDeviation(small, buildSsvTree(large), 0.0);
    EXPECT_LE(inside.lower, 0.03 + 1e-12);
    EXPECT_GE(inside.upper, 0.03 - 1e-12);
    EXPECT_LE(inside.upper, 1.0101 * 0.03);
    // The corner of the large box is the farthest from the small one.
    const double corner = Vector3d(0.01, 0.02, 0.03).norm();
    const Deviation outside = surfaceDeviation(large, buildSsvTree(small), 0.0);
    EXPECT_LE(outside.lower, corner + 1e-12);
    EXPECT_GE(outside.upper, corner - 1e-12);
    EXPECT_LE(outside.upper, 1.0101 * corner);
}

TEST(SurfaceDeviation, CountsPointsInsideTriangles)
{
    // A large triangle over a plate with a bump's worth of air: its corners are on the plate, its
    // middle is over a hole of radius 1.
    TriangleMesh ring = makeTorus(2.0, 0.1, 64, 24);
    const TriangleMesh lid = makeTriangle(
        {2.1, 0.0, 0.0}, {-1.05, 2.1 * std::sqrt(0.75), 0.0}, {-1.05, -2.1 * std::sqrt(0.75), 0.0});
    const Deviation deviation = surfaceDeviation(lid, buildSsvTree(ring), 0.0);
    // The centre is 1.9 from the inner equator, to the chord error of 64 segments and 24 sides.
    const double chord = 1.9 * (1.0 - std::cos(std::numbers::pi / 64.0));
    EXPECT_GE(deviation.upper, 1.9 - chord);
    EXPECT_LE(deviation.lower, 1.9 + chord);
    EXPECT_LE(deviation.upper, 1.0101 * (1.9 + chord));
}

TEST(SurfaceDeviation, IsZeroForTheSameSurfaceInOtherTriangles)
{
    const TriangleMesh coarse = makeBox({1.0, 1.0, 1.0});
    TriangleMesh fine;
    // Every triangle as four.
    for (const Triangle& t : coarse.triangles)
    {
        const auto at = [&](int k)
        { return coarse.vertices[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])]; };
        const auto mid = [&](int j, int k) -> Vector3d { return 0.5 * (at(j) + at(k)); };
        appendMesh(fine, makeTriangle(at(0), mid(0, 1), mid(2, 0)));
        appendMesh(fine, makeTriangle(mid(0, 1), at(1), mid(1, 2)));
        appendMesh(fine, makeTriangle(mid(2, 0), mid(1, 2), at(2)));
        appendMesh(fine, makeTriangle(mid(0, 1), mid(1, 2), mid(2, 0)));
    }
    EXPECT_LE(surfaceDeviation(coarse, buildSsvTree(fine), 0.0).upper, 1e-11);
    EXPECT_LE(surfaceDeviation(fine, buildSsvTree(coarse), 0.0).upper, 1e-11);
}

TEST(SurfaceDeviation, HoldsAgainstSamplesOnRandomSurfaces)
{
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> noise(-0.1, 0.1);
    for (int round = 0; round < 3; ++round)
    {
        TriangleMesh a = makeSphere(1.0, 1);
        TriangleMesh b = makeSphere(1.0, 2);
        for (TriangleMesh* mesh : {&a, &b})
        {
            for (Vector3d& vertex : mesh->vertices)
            {
                vertex += Vector3d(noise(random), noise(random), noise(random));
            }
        }
        const Deviation deviation = surfaceDeviation(a, buildSsvTree(b), 0.0);
        const double sampled = sampledDeviation(a, b, 6);
        EXPECT_GE(deviation.upper, sampled - 0.02);  // the cloud is 0.02 coarse
        EXPECT_LE(deviation.lower, sampled + 0.07);  // the grid is 0.06 coarse
        EXPECT_LE(deviation.upper, 1.0101 * deviation.lower);
        EXPECT_GT(sampled, 0.05);
    }
}

TEST(SurfaceDeviation, EndsAtTheLimit)
{
    const SsvTree tree = buildSsvTree(makeBox({1.0, 1.0, 1.0}));
    const TriangleMesh far = makeBox({2.0, 2.0, 2.0});
    const Deviation deviation = surfaceDeviation(far, tree, 0.0, 0.5);
    EXPECT_GT(deviation.lower, 0.5);
    EXPECT_TRUE(std::isinf(deviation.upper));
    EXPECT_THROW((void)surfaceDeviation(far, tree, -1.0), std::invalid_argument);
    EXPECT_THROW((void)surfaceDeviation({}, tree, 0.0), std::invalid_argument);
}

TEST(SurfaceDeviation, EndsWhenItIsStopped)
{
    // Between concentric spheres the bound of one per cent takes long.
    const SsvTree tree = buildSsvTree(makeSphere(1.0, 5));
    const TriangleMesh inner = makeSphere(0.9999, 5);
    const auto ask = [&](const StopCondition& stop)
    { return surfaceDeviation(inner, tree, 0.0, HUGE_VAL, stop); };
    EXPECT_THROW((void)ask(stopAfter(0.0)), QueryStopped);
    EXPECT_THROW((void)ask(stopAfter(1e-3)), QueryStopped);
    const std::atomic<bool> isCancelled = true;
    EXPECT_THROW((void)ask({.isCancelled = &isCancelled}), QueryStopped);
    EXPECT_NEAR(ask(stopAfter(1e9)).lower, 1e-4, 5e-6);
}
}  // namespace
}  // namespace bullet_ccd
