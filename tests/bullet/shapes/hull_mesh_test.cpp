#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/shapes/btCcdHullMesh.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Points = std::vector<Eigen::Vector3d>;

double sizeOf(const Points& points)
{
    return bounds({points, {}}).sizes().norm();
}

/// Closed, convex, around all points, made of some of them.
void expectHull(const Points& points, const std::string& what)
{
    const TriangleMesh hull = btCcdHullMesh(points);
    EXPECT_TRUE(isWatertight(hull)) << what;
    double highest = 0.0;
    for (const Triangle& t : hull.triangles)
    {
        const Eigen::Vector3d& a = hull.vertices[std::size_t(t[0])];
        const Eigen::Vector3d normal = (hull.vertices[std::size_t(t[1])] - a)
                                           .cross(hull.vertices[std::size_t(t[2])] - a)
                                           .normalized();
        for (const Eigen::Vector3d& point : points)
        {
            highest = std::max(highest, normal.dot(point - a));
        }
    }
    EXPECT_LT(highest, 1e-9 * sizeOf(points)) << what;
    for (const Eigen::Vector3d& vertex : hull.vertices)
    {
        EXPECT_NE(std::find(points.begin(), points.end(), vertex), points.end()) << what;
    }
}

Points randomPoints(Random& random, int count, const std::function<Eigen::Vector3d()>& point)
{
    Points points;
    for (int i = 0; i < count; ++i)
    {
        points.push_back(point());
    }
    std::shuffle(points.begin(), points.end(), std::mt19937(unsigned(random.integer(0, 1000))));
    return points;
}
}  // namespace

TEST(HullMesh, EnclosesCloudsOfAllKindsToRounding)
{
    Random random(51);
    for (int trial = 0; trial < 40; ++trial)
    {
        const int count = random.integer(4, 300);
        const double scale = random.logUniform(1e-3, 1e3);
        const Eigen::Vector3d place = random.inBox(10.0 * scale);
        const auto add = [&](const std::string& what, const std::function<Eigen::Vector3d()>& point)
        {
            expectHull(
                randomPoints(
                    random, count, [&]() -> Eigen::Vector3d { return place + scale * point(); }),
                what + " " + std::to_string(trial));
        };
        add("box", [&] { return random.inBox(1.0); });
        add("ball", [&] { return random.direction(); });
        add("plate",
            [&] {
                return Eigen::Vector3d(random.inBox(1.0).cwiseProduct(Eigen::Vector3d(1, 1, 1e-4)));
            });
        add("needle",
            [&] {
                return Eigen::Vector3d(
                    random.inBox(1.0).cwiseProduct(Eigen::Vector3d(1, 1e-3, 1e-3)));
            });
        add("clusters",
            [&] {
                return Eigen::Vector3d(random.inBox(1e-7) +
                                       random.direction().array().round().matrix());
            });
    }
}

TEST(HullMesh, CoplanarAndRepeatedPointsDoNoHarm)
{
    Random random(52);
    for (int trial = 0; trial < 40; ++trial)
    {
        const Eigen::Isometry3d X =
            trial % 2 == 0 ? Eigen::Isometry3d::Identity() : random.pose(1.0);
        const int n = random.integer(2, 6);
        Points grid;
        for (int i = 0; i < n * n * n; ++i)
        {
            grid.push_back(X * (0.1 * Eigen::Vector3d(i % n, i / n % n, i / n / n)));
        }
        expectHull(grid, "grid");
        if (trial % 2 == 0)
        {
            const double edge = 0.1 * (n - 1);
            EXPECT_NEAR(massProperties(btCcdHullMesh(grid)).volume, edge * edge * edge, 1e-12);
        }
        TriangleMesh drum = makeCylinder(0.3, 0.2, random.integer(3, 64));
        drum.vertices.insert(drum.vertices.end(), drum.vertices.begin(), drum.vertices.end());
        for (Eigen::Vector3d& vertex : drum.vertices)
        {
            vertex = X * vertex;
        }
        expectHull(drum.vertices, "drum");
    }
    expectHull(makeSphere(0.3, 3).vertices, "ball");
}

TEST(HullMesh, SinglePrecisionCoordinatesOfATurnedBoxGiveTheBox)
{
    // Faces that are flat to 1e-7 only: any of the true corners may not be lost.
    Random random(53);
    for (int trial = 0; trial < 200; ++trial)
    {
        const Eigen::Isometry3d X = random.pose(0.2);
        Points corners;
        for (const Eigen::Vector3d& corner : makeBox({0.1, 0.2, 0.3}).vertices)
        {
            corners.push_back((X * corner).cast<float>().cast<double>());
        }
        expectHull(corners, "box");
        EXPECT_NEAR(massProperties(btCcdHullMesh(corners)).volume, 0.048, 1e-6);
    }
}

TEST(HullMesh, AlmostCoplanarPointsGiveTheSameSolidInAnyOrder)
{
    // Faces of slivers, whose planes are uncertain: the solid is not.
    Random random(55);
    for (int trial = 0; trial < 300; ++trial)
    {
        const Eigen::Isometry3d X = random.pose(1.0);
        const auto gridPoint = [&]() -> Eigen::Vector3d
        {
            const Eigen::Vector3d p = (2.0 * random.inBox(1.0)).array().round();
            return (X * p).cast<float>().cast<double>();
        };
        Points points = randomPoints(random, 40, gridPoint);
        const TriangleMesh first = btCcdHullMesh(points);
        std::reverse(points.begin(), points.end());
        const TriangleMesh second = btCcdHullMesh(points);
        EXPECT_TRUE(isWatertight(first));
        const double volume = massProperties(first).volume;
        EXPECT_GT(volume, 1.0);
        EXPECT_NEAR(massProperties(second).volume, volume, 1e-10 * volume) << trial;
    }
}

TEST(HullMesh, WhatSpansNoVolumeIsAPolygonASegmentOrAPoint)
{
    Random random(54);
    for (int trial = 0; trial < 50; ++trial)
    {
        const Eigen::Isometry3d X = random.pose(1.0);
        const auto on = [&](double x, double y) -> Eigen::Vector3d
        { return X * Eigen::Vector3d(x, y, 0); };
        Points square{on(0, 0), on(1, 0), on(1, 1), on(0, 1), on(0.5, 0.5), on(0, 0.5), on(0, 0)};
        const TriangleMesh flat = btCcdHullMesh(square);
        double area = 0.0;
        for (const Triangle& t : flat.triangles)
        {
            const Eigen::Vector3d& a = flat.vertices[std::size_t(t[0])];
            area += 0.5 * (flat.vertices[std::size_t(t[1])] - a)
                              .cross(flat.vertices[std::size_t(t[2])] - a)
                              .norm();
        }
        EXPECT_NEAR(area, 1.0, 1e-12);

        const TriangleMesh segment = btCcdHullMesh({on(0.3, 0), on(1, 0), on(-2, 0), on(0.5, 0)});
        ASSERT_EQ(segment.triangles.size(), 1U);
        EXPECT_NEAR((segment.vertices[0] - segment.vertices[1]).norm(), 3.0, 1e-12);
        const TriangleMesh point = btCcdHullMesh({on(1, 2), on(1, 2)});
        EXPECT_EQ(point.vertices.size(), 1U);
    }
    EXPECT_THROW(btCcdHullMesh({}), std::invalid_argument);
    EXPECT_THROW(btCcdHullMesh({{std::numeric_limits<double>::quiet_NaN(), 0, 0}}),
                 std::invalid_argument);
}
}  // namespace bullet_ccd::tests
