// Solids and their polygons against closed forms.
#include "robots/shapes/polygonize.h"
#include "robots/shapes/solid.h"
#include "tests/robots/mesh_checks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>
#include <random>
#include <stdexcept>

namespace bullet_ccd::shapes
{
namespace
{
constexpr double kPi = std::numbers::pi;

const Eigen::AlignedBox3d kSpace(Eigen::Vector3d::Constant(-0.06), Eigen::Vector3d::Constant(0.06));

void expectGoodSurface(const TriangleMesh& mesh, const Solid& solid)
{
    EXPECT_TRUE(isWatertight(mesh));
    EXPECT_TRUE(tests::everyVertexHasOneFan(mesh));
    EXPECT_GT(tests::worstShape(mesh), 0.1);
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        EXPECT_NEAR(solid(vertex), 0.0, 1e-6);
    }
}

TEST(Polygonize, BallHasTheVolumeOfABallLessTheChordError)
{
    const double radius = 0.03;
    const Solid solid = ball(radius);
    const PolygonizeOptions options{.chordError = 5e-5};
    const TriangleMesh mesh = polygonize(solid, kSpace, options);
    expectGoodSurface(mesh, solid);
    EXPECT_EQ(tests::eulerCharacteristic(mesh), 2);
    const double exact = 4.0 / 3.0 * kPi * std::pow(radius, 3);
    const double shell = 4.0 * kPi * radius * radius * options.chordError;
    const double volume = massProperties(mesh).volume;
    EXPECT_LT(volume, exact);
    EXPECT_GT(volume, exact - 2.0 * shell);
}

TEST(Polygonize, TubeRingIsATorus)
{
    std::vector<TubePoint> ring;
    for (int i = 0; i <= 64; ++i)
    {
        const double angle = 2.0 * kPi * i / 64;
        ring.push_back({{0.04 * std::cos(angle), 0.04 * std::sin(angle), 0.0}, 0.01});
    }
    const Solid solid = tube(ring);
    const TriangleMesh mesh = polygonize(solid, kSpace);
    expectGoodSurface(mesh, solid);
    EXPECT_EQ(tests::eulerCharacteristic(mesh), 0);
    const double exact = 2.0 * kPi * kPi * 0.04 * 0.01 * 0.01;
    EXPECT_NEAR(massProperties(mesh).volume, exact, 0.05 * exact);
}

TEST(Polygonize, FlatFacesAreExactlyFlat)
{
    const Solid solid = roundedBox({0.03, 0.02, 0.01}, 0.003);
    const TriangleMesh mesh = polygonize(solid, kSpace);
    expectGoodSurface(mesh, solid);
    int onTop = 0;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        if (std::abs(vertex.x()) < 0.026 && std::abs(vertex.y()) < 0.016 && vertex.z() > 0.0)
        {
            EXPECT_NEAR(vertex.z(), 0.01, 1e-7);
            ++onTop;
        }
    }
    EXPECT_GT(onTop, 10);
}

TEST(Polygonize, SaysWhenTheSolidLeavesItsBox)
{
    const Eigen::AlignedBox3d small(Eigen::Vector3d::Constant(-0.01), Eigen::Vector3d(0.06, 0, 0));
    try
    {
        static_cast<void>(polygonize(ball(0.03), small));
        FAIL() << "no error";
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_THAT(error.what(), testing::HasSubstr("leaves its box"));
    }
}

TEST(Polygonize, GivesTheSameMeshTwice)
{
    const Solid solid = blend(ball(0.02), moved(ball(0.015), {0.025, 0, 0}), 0.004);
    EXPECT_EQ(contentHash(polygonize(solid, kSpace)), contentHash(polygonize(solid, kSpace)));
}

TEST(Solid, ValuesNeverExceedTheDistanceBetweenTwoPoints)
{
    // Polygonize skips space on the strength of this.
    const Solid vessel = latheShell(
        smoothCurve(Profile{{0.0, 0.002}, {0.02, 0.002}, {0.03, 0.02}, {0.03, 0.05}}, 4), 0.004);
    const Solid solid = blendCut(
        blend(vessel, moved(roundedBox({0.02, 0.01, 0.01}, 0.002), {0.04, 0.0, 0.03}), 0.003),
        stretched(ball(0.02), {1.0, 0.5, 2.0}),
        0.002);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> coordinate(-0.06, 0.06);
    const auto point = [&]
    { return Eigen::Vector3d::NullaryExpr([&] { return coordinate(random); }); };
    int inside = 0;
    for (int i = 0; i < 20000; ++i)
    {
        const Eigen::Vector3d a = point();
        const Eigen::Vector3d b = a + 0.1 * Eigen::Vector3d(point());
        EXPECT_LE(std::abs(solid(a) - solid(b)), (a - b).norm() * (1.0 + 1e-9) + 1e-15);
        inside += solid(a) < 0.0 ? 1 : 0;
    }
    EXPECT_GT(inside, 200);
}
}  // namespace
}  // namespace bullet_ccd::shapes
