#include "grasp/quality/hull_about_origin.h"

#include "tests/grasp/quality/brute_hull.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <thread>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
using tests::bruteHull;
using tests::BruteHull;

Eigen::MatrixXd randomPoints(std::mt19937& random, Eigen::Index dimension, Eigen::Index count)
{
    std::normal_distribution<double> normal;
    return Eigen::MatrixXd::NullaryExpr(dimension, count, [&] { return normal(random); });
}

Eigen::MatrixXd crossPolytope(Eigen::Index dimension)
{
    Eigen::MatrixXd points(dimension, 2 * dimension);
    points << Eigen::MatrixXd::Identity(dimension, dimension),
        -Eigen::MatrixXd::Identity(dimension, dimension);
    return points;
}

Eigen::MatrixXd cube(Eigen::Index dimension)
{
    Eigen::MatrixXd points(dimension, Eigen::Index{1} << dimension);
    for (Eigen::Index i = 0; i < points.cols(); ++i)
    {
        for (Eigen::Index k = 0; k < dimension; ++k)
        {
            points(k, i) = ((i >> k) & 1) != 0 ? 1.0 : -1.0;
        }
    }
    return points;
}

double factorial(Eigen::Index n)
{
    return std::tgamma(static_cast<double>(n) + 1.0);
}

TEST(HullAboutOrigin, CrossPolytopesHaveTheirClosedFormBallAndVolume)
{
    for (Eigen::Index d = 2; d <= 6; ++d)
    {
        const HullAboutOrigin hull = hullAboutOrigin(crossPolytope(d));
        EXPECT_FALSE(hull.flat);
        EXPECT_NEAR(hull.radius, 1.0 / std::sqrt(static_cast<double>(d)), 1e-14) << d;
        EXPECT_NEAR(hull.volume, std::pow(2.0, d) / factorial(d), 1e-12) << d;
    }
}

// The facets of a cube have 2^(d-1) corners: qhull has to merge.
TEST(HullAboutOrigin, CubesWhoseFacetsAreMergedHaveTheirClosedFormBallAndVolume)
{
    for (Eigen::Index d = 2; d <= 6; ++d)
    {
        const HullAboutOrigin hull = hullAboutOrigin(cube(d));
        EXPECT_NEAR(hull.radius, 1.0, 1e-14) << d;
        EXPECT_NEAR(hull.volume, std::pow(2.0, d), 1e-10) << d;
    }
}

TEST(HullAboutOrigin, LinearMapScalesTheVolumeByItsDeterminant)
{
    std::mt19937 random(3);
    for (int trial = 0; trial < 20; ++trial)
    {
        const Eigen::MatrixXd map = randomPoints(random, 6, 6);
        const double expected = std::pow(2.0, 6) * std::abs(map.determinant());
        const HullAboutOrigin hull = hullAboutOrigin(map * cube(6));
        EXPECT_NEAR(hull.volume, expected, 1e-9 * expected);
    }
}

TEST(HullAboutOrigin, NeedleThinHullKeepsItsBallAndVolume)
{
    for (const double thickness : {1e-3, 1e-5, 1e-7})
    {
        Eigen::MatrixXd points = cube(6);
        points.row(4) *= thickness;
        const HullAboutOrigin hull = hullAboutOrigin(points);
        EXPECT_FALSE(hull.flat);
        EXPECT_NEAR(hull.radius, thickness, 1e-9 * thickness);
        EXPECT_NEAR(hull.volume, 64.0 * thickness, 1e-9 * thickness);
    }
}

TEST(HullAboutOrigin, FlatHullsAreAnAnswer)
{
    EXPECT_TRUE(hullAboutOrigin(Eigen::MatrixXd(6, 0)).flat);
    EXPECT_TRUE(hullAboutOrigin(Eigen::MatrixXd::Ones(6, 1)).flat);
    EXPECT_TRUE(hullAboutOrigin(Eigen::MatrixXd::Ones(6, 40)).flat);
    Eigen::MatrixXd points = cube(6);
    points.row(2).setZero();
    const HullAboutOrigin hull = hullAboutOrigin(points);
    EXPECT_TRUE(hull.flat);
    EXPECT_EQ(hull.radius, 0.0);
    EXPECT_EQ(hull.volume, 0.0);
    // Flat in a direction that no axis shows, up to rounding.
    std::mt19937 random(5);
    const Eigen::MatrixXd turn = randomPoints(random, 6, 6).householderQr().householderQ();
    EXPECT_TRUE(hullAboutOrigin(turn * points).flat);
}

TEST(HullAboutOrigin, OriginOutsideGivesNoBallButTheVolume)
{
    Eigen::MatrixXd points = crossPolytope(6);
    points.row(1).array() += 1.5;
    const HullAboutOrigin hull = hullAboutOrigin(points);
    EXPECT_EQ(hull.radius, 0.0);
    EXPECT_NEAR(hull.volume, 64.0 / 720.0, 1e-12);
}

// Random clouds shifted so that the origin is inside of about half of them.
TEST(HullAboutOrigin, AgreesWithTheEnumerationOfAllFacets)
{
    std::mt19937 random(7);
    int inside = 0;
    int trials = 0;
    for (Eigen::Index d = 3; d <= 6; ++d)
    {
        for (int trial = 0; trial < 30; ++trial, ++trials)
        {
            Eigen::MatrixXd points = randomPoints(random, d, 2 * d + 2);
            points.row(0).array() += 0.3;
            const BruteHull expected = bruteHull(points);
            const HullAboutOrigin hull = hullAboutOrigin(points);
            EXPECT_NEAR(hull.radius, expected.radius, 1e-11);
            if (expected.radius > 0.0)
            {
                ++inside;
                EXPECT_NEAR(hull.volume, expected.volume, 1e-10 * expected.volume);
            }
        }
    }
    EXPECT_GT(inside, trials / 4);
    EXPECT_LT(inside, 3 * trials / 4);
}

// Q01: unit forces along +-x, +-y, +-z.
TEST(HullAboutOrigin, SixFrictionlessForcesSpanAnOctahedron)
{
    const HullAboutOrigin hull = hullAboutOrigin(crossPolytope(3));
    EXPECT_NEAR(hull.radius, 1.0 / std::sqrt(3.0), 1e-14);
    EXPECT_NEAR(hull.volume, 4.0 / 3.0, 1e-13);
}

// Q02: forces of two opposite contacts with m-sided friction pyramids.
TEST(HullAboutOrigin, AntipodalForcePyramidsReachFrictionTimesCosine)
{
    for (const double friction : {0.2, 0.5, 1.5})
    {
        for (const int edges : {4, 6, 8, 16, 64})
        {
            Eigen::MatrixXd forces(3, 2 * edges);
            for (int i = 0; i < edges; ++i)
            {
                const double phi = 2.0 * std::numbers::pi * i / edges;
                const Eigen::Vector2d tangent =
                    friction * Eigen::Vector2d(std::cos(phi), std::sin(phi));
                forces.col(i) << tangent, 1.0;
                forces.col(edges + i) << tangent, -1.0;
            }
            const double expected = std::min(1.0, friction * std::cos(std::numbers::pi / edges));
            EXPECT_NEAR(hullAboutOrigin(forces).radius, expected, 1e-13);
        }
    }
}

// Q03: three frictional contacts on the unit disc, wrenches (fx, fy, moment).
TEST(HullAboutOrigin, ThreePlanarContactsReachTheFrictionCoefficient)
{
    for (const double friction : {0.1, 0.3, 0.5, 0.7, 0.9})
    {
        Eigen::MatrixXd wrenches(3, 6);
        for (int i = 0; i < 3; ++i)
        {
            const double phi = 2.0 * std::numbers::pi * i / 3.0;
            const Eigen::Vector2d normal(-std::cos(phi), -std::sin(phi));
            const Eigen::Vector2d tangent(-std::sin(phi), std::cos(phi));
            wrenches.col(2 * i) << normal + friction * tangent, friction;
            wrenches.col(2 * i + 1) << normal - friction * tangent, -friction;
        }
        EXPECT_NEAR(hullAboutOrigin(wrenches).radius, friction, 1e-13);
    }
}

TEST(HullAboutOrigin, ThreadsComputeTheSameBits)
{
    std::mt19937 random(11);
    const Eigen::MatrixXd points = randomPoints(random, 6, 60);
    const HullAboutOrigin expected = hullAboutOrigin(points);
    std::vector<HullAboutOrigin> results(8);
    std::vector<std::thread> threads;
    for (HullAboutOrigin& result : results)
    {
        threads.emplace_back([&] { result = hullAboutOrigin(points); });
    }
    for (std::thread& thread : threads)
    {
        thread.join();
    }
    EXPECT_GT(expected.radius, 0.0);
    for (const HullAboutOrigin& result : results)
    {
        EXPECT_EQ(result.radius, expected.radius);
        EXPECT_EQ(result.volume, expected.volume);
    }
}
}  // namespace
}  // namespace bullet_ccd::grasp
