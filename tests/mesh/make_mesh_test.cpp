// Every maker against the exact volume and inertia of the polyhedron it makes (not of the smooth
// shape that the polyhedron approximates).
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace bullet_ccd
{
namespace
{
constexpr double kPi = std::numbers::pi;
constexpr double kRounding = 1e-12;  // relative: sums of at most some thousand terms

double polygonArea(int n, double radius)
{
    return 0.5 * n * radius * radius * std::sin(2.0 * kPi / n);
}

/// Frustum over similar polygons of areas `a` and `b`.
double frustumVolume(double a, double b, double height)
{
    return height * (a + b + std::sqrt(a * b)) / 3.0;
}

/// No vertex may be left over and all triangles must have area.
void expectClean(const TriangleMesh& mesh)
{
    checkMesh(mesh, "mesh");
    EXPECT_TRUE(isWatertight(mesh));
    TriangleMesh copy = mesh;
    EXPECT_EQ(repairMesh(copy).summary(), "");
    for (const auto& [a, b, c] : mesh.triangles)
    {
        const Eigen::Vector3d& p = mesh.vertices[static_cast<std::size_t>(a)];
        const Eigen::Vector3d ab = mesh.vertices[static_cast<std::size_t>(b)] - p;
        const Eigen::Vector3d ac = mesh.vertices[static_cast<std::size_t>(c)] - p;
        EXPECT_GT(ab.cross(ac).norm(), 0.0);
    }
}

void expectEuler(const TriangleMesh& mesh, std::int64_t characteristic)
{
    const auto vertices = static_cast<std::int64_t>(mesh.vertices.size());
    const auto faces = static_cast<std::int64_t>(mesh.triangles.size());
    EXPECT_EQ(vertices - faces * 3 / 2 + faces, characteristic);
}

TEST(MakeMesh, BoxHasTheVolumeAndInertiaOfABox)
{
    const TriangleMesh box = makeBox({0.5, 1.0, 1.5});
    expectClean(box);
    expectEuler(box, 2);
    EXPECT_EQ(box.triangles.size(), 12U);
    const MassProperties mass = massProperties(box);
    EXPECT_NEAR(mass.volume, 6.0, 6.0 * kRounding);
    EXPECT_NEAR(mass.center.norm(), 0.0, kRounding);
    const Eigen::Matrix3d expected = Eigen::Vector3d(6.5, 5.0, 2.5).asDiagonal();  // V/12 (b² + c²)
    EXPECT_TRUE(mass.inertia.isApprox(expected, kRounding)) << mass.inertia;
    EXPECT_TRUE(inertiaAtMass(box, 3.0).isApprox(0.5 * expected, kRounding));
    // Of a sheet, which has no volume.
    TriangleMesh sheet = box;
    transformMesh(sheet, Eigen::Affine3d(Eigen::Scaling(1.0, 1.0, 0.0)));
    const Eigen::Matrix3d flat = Eigen::Vector3d(1.0, 0.25, 1.25).asDiagonal();
    EXPECT_EQ(massProperties(sheet).volume, 0.0);
    EXPECT_TRUE(inertiaAtMass(sheet, 3.0).isApprox(flat, kRounding));
}

TEST(MakeMesh, SphereWithoutSubdivisionIsTheRegularIcosahedron)
{
    const double radius = 0.7;
    const TriangleMesh mesh = makeSphere(radius, 0);
    expectClean(mesh);
    const double edge = radius / std::sin(2.0 * kPi / 5.0);
    const double volume = 5.0 * (3.0 + std::sqrt(5.0)) / 12.0 * edge * edge * edge;
    const double inertia = (3.0 + std::sqrt(5.0)) / 20.0 * volume * edge * edge;
    const MassProperties mass = massProperties(mesh);
    EXPECT_NEAR(mass.volume, volume, volume * kRounding);
    EXPECT_TRUE(mass.inertia.isApprox(inertia * Eigen::Matrix3d::Identity(), kRounding));
}

TEST(MakeMesh, SphereVerticesLieOnTheSphereAndItsVolumeConverges)
{
    double previousError = std::numeric_limits<double>::infinity();
    for (int subdivisions = 0; subdivisions <= 4; ++subdivisions)
    {
        const TriangleMesh mesh = makeSphere(2.0, subdivisions);
        expectClean(mesh);
        expectEuler(mesh, 2);
        EXPECT_EQ(mesh.triangles.size(), 20U << (2 * subdivisions));
        for (const Eigen::Vector3d& vertex : mesh.vertices)
        {
            EXPECT_NEAR(vertex.norm(), 2.0, 2.0 * kRounding);
        }
        const double error = 32.0 / 3.0 * kPi - massProperties(mesh).volume;
        EXPECT_GT(error, 0.0) << "an inscribed polyhedron is smaller than its sphere";
        EXPECT_LT(error, 0.45 * previousError) << "second order in the edge length";
        previousError = error;
    }
}

TEST(MakeMesh, CylinderIsThePrismOverARegularPolygon)
{
    for (const int n : {3, 4, 17, 64})
    {
        const double radius = 0.3;
        const double height = 1.1;
        const TriangleMesh mesh = makeCylinder(radius, height, n);
        expectClean(mesh);
        expectEuler(mesh, 2);
        const double theta = 2.0 * kPi / n;
        const double area = polygonArea(n, radius);
        const double polar =
            n / 12.0 * std::pow(radius, 4) * std::sin(theta) * (2.0 + std::cos(theta));
        const double across = 0.5 * polar * height + area * std::pow(height, 3) / 12.0;
        const MassProperties mass = massProperties(mesh);
        EXPECT_NEAR(mass.volume, area * height, kRounding);
        const Eigen::Matrix3d expected =
            Eigen::Vector3d(across, across, polar * height).asDiagonal();
        EXPECT_TRUE(mass.inertia.isApprox(expected, kRounding)) << n << "\n" << mass.inertia;
    }
}

TEST(MakeMesh, CapsuleIsAPrismBetweenTwoStacksOfFrusta)
{
    for (const double height : {0.0, 0.4})
    {
        const int n = 16;
        const double radius = 0.25;
        const TriangleMesh mesh = makeCapsule(radius, height, n);
        expectClean(mesh);
        expectEuler(mesh, 2);
        const int steps = 4;
        double volume = polygonArea(n, radius) * height;
        for (int i = 0; i < steps; ++i)
        {
            const double low = 0.5 * kPi * i / steps;
            const double high = 0.5 * kPi * (i + 1) / steps;
            volume += 2.0 * frustumVolume(polygonArea(n, radius * std::cos(low)),
                                          polygonArea(n, radius * std::cos(high)),
                                          radius * (std::sin(high) - std::sin(low)));
        }
        EXPECT_NEAR(massProperties(mesh).volume, volume, kRounding);
        EXPECT_NEAR(bounds(mesh).max().z(), radius + 0.5 * height, kRounding);
        EXPECT_NEAR(bounds(mesh).min().z(), -radius - 0.5 * height, kRounding);
    }
}

TEST(MakeMesh, TorusFollowsPappusForPolygons)
{
    const int n = 24;
    const int m = 10;
    const TriangleMesh mesh = makeTorus(1.0, 0.25, n, m);
    expectClean(mesh);
    expectEuler(mesh, 0);
    const double volume = n * std::sin(2.0 * kPi / n) * 1.0 * polygonArea(m, 0.25);
    EXPECT_NEAR(massProperties(mesh).volume, volume, kRounding);
}

TEST(MakeMesh, RevolvedHollowProfileHasTheVolumeOfItsShell)
{
    // A cup: outer radius 2, inner radius 1, height 3, floor 1.
    const TriangleMesh cup = makeRevolved({{0, 0}, {2, 0}, {2, 3}, {1, 3}, {1, 1}, {0, 1}}, 12);
    expectClean(cup);
    expectEuler(cup, 2);
    const double expected = 3.0 * polygonArea(12, 2.0) - 2.0 * polygonArea(12, 1.0);
    EXPECT_NEAR(massProperties(cup).volume, expected, expected * kRounding);
}

TEST(MakeMesh, LoftedSquareTowerIsAFrustumAndCollapsedRingsArePoles)
{
    const auto square = [](double half, double z) -> std::vector<Eigen::Vector3d> {
        return {{half, -half, z}, {half, half, z}, {-half, half, z}, {-half, -half, z}};
    };
    const TriangleMesh frustum =
        makeLofted([&](int station) { return square(2.0 - 0.5 * station, station); }, 3);
    expectClean(frustum);
    expectEuler(frustum, 2);
    EXPECT_NEAR(massProperties(frustum).volume, frustumVolume(16.0, 4.0, 2.0), kRounding * 100);

    const TriangleMesh octahedron =
        makeLofted([&](int station) { return square(station == 1 ? 1.0 : 0.0, station); }, 3);
    expectClean(octahedron);
    EXPECT_EQ(octahedron.triangles.size(), 8U);
    EXPECT_NEAR(massProperties(octahedron).volume, 8.0 / 3.0, kRounding * 10);
}

TEST(MakeMesh, SizesThatMakeNoSolidAreRefusedWithTheirValue)
{
    const auto messageOf = [](auto make) -> std::string
    {
        try
        {
            make();
        }
        catch (const std::invalid_argument& error)
        {
            return error.what();
        }
        return "no error";
    };
    EXPECT_THAT(messageOf([] { static_cast<void>(makeSphere(-1.5, 2)); }),
                testing::HasSubstr("radius is -1.5"));
    EXPECT_THAT(messageOf(
                    [] {
                        static_cast<void>(makeBox({1.0, 0.0, 1.0}));
                    }),
                testing::HasSubstr("half extent is 0.0"));
    EXPECT_THAT(messageOf([] { static_cast<void>(makeCylinder(1.0, 1.0, 2)); }),
                testing::HasSubstr("segments is 2"));
    EXPECT_THAT(messageOf([] { static_cast<void>(makeCapsule(1.0, std::nan(""), 8)); }),
                testing::HasSubstr("height is negative or NaN"));
    EXPECT_THAT(messageOf([] { static_cast<void>(makeTorus(1.0, 1.5, 8, 8)); }),
                testing::HasSubstr("major less minor radius is -0.5"));
    EXPECT_THAT(messageOf(
                    [] {
                        static_cast<void>(makeRevolved({{0, 0}, {-1, 0}, {0, 1}}, 8));
                    }),
                testing::HasSubstr("radius is negative"));
}
}  // namespace
}  // namespace bullet_ccd
