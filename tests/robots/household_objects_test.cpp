#include "robots/shapes/household_objects.h"

#include "bullet_ccd/io/mesh_file.h"
#include "robots/shapes/large_objects.h"
#include "tests/robots/mesh_checks.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <gmock/gmock.h>
#include <map>
#include <stdexcept>

namespace bullet_ccd::shapes
{
namespace
{
/// Loops that a hand or a finger fits through: each takes 2 off the Euler characteristic.
const std::map<std::string, int> kHandles = {{"mug", 1}, {"jug", 1}};

class HouseholdObjects : public testing::TestWithParam<std::string>
{
};

void expectGoodObject(const std::string& family, const TriangleMesh& mesh)
{
    EXPECT_TRUE(isWatertight(mesh));
    EXPECT_TRUE(tests::everyVertexHasOneFan(mesh));
    EXPECT_GT(tests::worstShape(mesh), 0.05);
    const auto handles = kHandles.find(family);
    EXPECT_EQ(tests::eulerCharacteristic(mesh),
              2 - 2 * (handles == kHandles.end() ? 0 : handles->second));
    EXPECT_GE(mesh.triangles.size(), 1500U);
    EXPECT_LE(mesh.triangles.size(), 16000U);

    const Eigen::AlignedBox3d extent = bounds(mesh);
    EXPECT_NEAR(extent.min().z(), 0.0, 1e-12);
    EXPECT_NEAR(extent.center().x(), 0.0, 1e-12);
    EXPECT_NEAR(extent.center().y(), 0.0, 1e-12);
    EXPECT_GT(extent.sizes().minCoeff(), 0.015) << "all can be grasped";
    EXPECT_LT(extent.sizes().maxCoeff(), 0.35);
    const double volume = massProperties(mesh).volume;
    EXPECT_GT(volume, 1e-5);
    EXPECT_LT(volume, extent.volume());
}

TEST_P(HouseholdObjects, ShippedObjectIsClosedWellShapedAndOfGraspableSize)
{
    const MeshFile file =
        loadMeshFile(std::filesystem::path(BULLET_CCD_SHARE) / "objects" / (GetParam() + ".obj"));
    EXPECT_EQ(file.repair.summary(), "");
    expectGoodObject(GetParam(), file.mesh);
}

/// Those that take seconds to make are left to the long tests.
class DrawnObjects : public testing::TestWithParam<std::string>
{
};

std::vector<std::string> drawnFamilies()
{
    std::vector<std::string> families = objectFamilies();
    if (!tests::longTests())
    {
        for (const char* slow : {"bowl", "glass", "jug", "pan", "plate", "wine_glass"})
        {
            std::erase(families, slow);
        }
    }
    return families;
}

TEST_P(DrawnObjects, AreGoodTooAndAllDifferent)
{
    const std::uint64_t seed = 977 * GetParam().size() + static_cast<unsigned char>(GetParam()[0]);
    const TriangleMesh first = makeObject(GetParam(), seed);
    const TriangleMesh second = makeObject(GetParam(), seed + 1);
    expectGoodObject(GetParam(), first);
    expectGoodObject(GetParam(), second);
    EXPECT_GT((bounds(first).sizes() - bounds(second).sizes()).norm(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(EveryFamily,
                         HouseholdObjects,
                         testing::ValuesIn(objectFamilies()),
                         [](const auto& test) { return test.param; });

INSTANTIATE_TEST_SUITE_P(EveryFamily,
                         DrawnObjects,
                         testing::ValuesIn(drawnFamilies()),
                         [](const auto& test) { return test.param; });

TEST(LargeObjects, AreFourteenClosedSurfacesThatAreLargeAndLight)
{
    EXPECT_EQ(largeObjectNames().size(), 14U);
    for (const std::string& name : largeObjectNames())
    {
        const MeshFile file = loadMeshFile(std::filesystem::path(BULLET_CCD_SHARE) /
                                           "objects/large" / (name + ".obj"));
        EXPECT_EQ(file.repair.summary(), "") << name;
        EXPECT_TRUE(isWatertight(file.mesh)) << name;
        EXPECT_TRUE(tests::everyVertexHasOneFan(file.mesh)) << name;
        const Eigen::AlignedBox3d extent = bounds(file.mesh);
        EXPECT_NEAR(extent.min().z(), 0.0, 1e-12) << name;
        EXPECT_NEAR(extent.center().x(), 0.0, 1e-12) << name;
        EXPECT_NEAR(extent.center().y(), 0.0, 1e-12) << name;
        EXPECT_GE(extent.sizes().y(), 0.3) << name;
        // One to three kilograms, as of water.
        const double volume = massProperties(file.mesh).volume;
        EXPECT_GT(volume, 8e-4) << name;
        EXPECT_LT(volume, 3e-3) << name;
    }
    EXPECT_THROW(static_cast<void>(makeLargeObject("ship")), std::invalid_argument);
}

TEST(HouseholdObjectFamilies, AreAtLeastFourteen)
{
    EXPECT_GE(objectFamilies().size(), 14U);
}

TEST(HouseholdObjectFamilies, SameSeedGivesTheSameMesh)
{
    for (const std::string family : {"banana", "can", "spoon"})
    {
        EXPECT_EQ(contentHash(makeObject(family, 5)), contentHash(makeObject(family, 5)));
    }
}

TEST(HouseholdObjectFamilies, CoarseObjectsAreClosedAndHaveFewerTriangles)
{
    // Edges of a coarse wine glass are longer than its walls are thick.
    for (const char* family : {"wine_glass", "ball"})
    {
        const TriangleMesh fine = makeObject(family, 1034);
        const TriangleMesh coarse = makeObject(family, 1034, 2.0);
        EXPECT_TRUE(isWatertight(coarse)) << family;
        EXPECT_LT(coarse.triangles.size(), fine.triangles.size() / 2) << family;
        const double volume = massProperties(fine).volume;
        EXPECT_NEAR(massProperties(coarse).volume, volume, 0.2 * volume) << family;
    }
    EXPECT_THROW(static_cast<void>(makeObject("ball", 1, 0.5)), std::invalid_argument);
}

TEST(HouseholdObjectFamilies, UnknownFamilyIsRefusedWithTheKnownOnes)
{
    try
    {
        static_cast<void>(makeObject("teapot"));
        FAIL() << "no error";
    }
    catch (const std::invalid_argument& error)
    {
        EXPECT_THAT(
            error.what(),
            testing::AllOf(testing::HasSubstr("'teapot'"), testing::HasSubstr("mug, bottle")));
    }
}

TEST(Mug, StandsOnItsBaseAndIsHollow)
{
    const TriangleMesh mug = makeObject("mug");
    // A solid cylinder of the same size would have five times the volume.
    const Eigen::Vector3d size = bounds(mug).sizes();
    const double solid = 0.25 * 3.14 * size.y() * size.y() * size.z();
    EXPECT_LT(massProperties(mug).volume, 0.4 * solid);
    // The handle sticks out along x.
    EXPECT_GT(size.x(), 1.25 * size.y());
}
}  // namespace
}  // namespace bullet_ccd::shapes
