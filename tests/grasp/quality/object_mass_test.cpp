#include "grasp/quality/object_mass.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <gmock/gmock.h>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
ObjectMass massOfMesh(TriangleMesh mesh, std::optional<double> given = std::nullopt)
{
    return massOf(makeGraspObject("thing", std::move(mesh)), given);
}

TriangleMesh turnedInsideOut(TriangleMesh mesh)
{
    for (Triangle& triangle : mesh.triangles)
    {
        std::swap(triangle[1], triangle[2]);
    }
    return mesh;
}

TEST(ObjectMass, ClosedMeshesCountByTheirVolume)
{
    // Also far from the origin, where volumes cancel.
    TriangleMesh box = makeBox({0.05, 0.1, 0.15});
    transformMesh(box, Eigen::Affine3d(Eigen::Translation3d(100.0, -50.0, 3.0)));
    const ObjectMass mass = massOfMesh(box);
    EXPECT_NEAR(mass.mass, 6.0, 1e-9);
    EXPECT_EQ(mass.source, MassSource::Volume);
    EXPECT_EQ(massText(mass), "6 kg (volume of the closed mesh at 1000 kg/m3)");
    // A torus is far from its hull.
    const ObjectMass torus = massOfMesh(makeTorus(0.1, 0.02, 96, 48));
    const double whole = 1000.0 * 2.0 * std::numbers::pi * std::numbers::pi * 0.1 * 4e-4;
    EXPECT_NEAR(torus.mass, whole, 5e-3 * whole);
    EXPECT_EQ(torus.source, MassSource::Volume);
}

TEST(ObjectMass, OpenMeshesCountByTheirHullAndSaySo)
{
    TriangleMesh open = makeBox({0.05, 0.1, 0.15});
    open.triangles.pop_back();
    const ObjectMass mass = massOfMesh(open);
    EXPECT_NEAR(mass.mass, 6.0, 1e-9);
    EXPECT_EQ(mass.source, MassSource::ConvexHull);
    EXPECT_THAT(massText(mass), ::testing::HasSubstr("convex hull of a mesh that is not closed"));
    // Its bounding box would be 6 / pi as heavy.
    const TriangleMesh sphere = makeSphere(0.05, 4);
    const ObjectMass inside = massOfMesh(turnedInsideOut(sphere));
    EXPECT_EQ(inside.source, MassSource::ConvexHull);
    EXPECT_NEAR(inside.mass, massOfMesh(sphere).mass, 1e-9);
}

TEST(ObjectMass, SheetsCountByTheirAreaAndGivenMassesAsTheyAre)
{
    const ObjectMass sheet =
        massOfMesh(makeTriangle({0.0, 0.0, 0.0}, {0.3, 0.0, 0.0}, {0.0, 0.2, 0.0}));
    EXPECT_NEAR(sheet.mass, 0.03, 1e-12);  // 300 cm2, 1 mm thick
    EXPECT_EQ(sheet.source, MassSource::Surface);
    EXPECT_EQ(massText(sheet), "0.03 kg (surface without volume, 1 mm thick at 1000 kg/m3)");
    const ObjectMass given = massOfMesh(makeSphere(0.05, 2), 0.25);
    EXPECT_EQ(given.mass, 0.25);
    EXPECT_EQ(massText(given), "0.25 kg (given)");
}
}  // namespace
}  // namespace bullet_ccd::grasp
