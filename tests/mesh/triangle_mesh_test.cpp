#include "bullet_ccd/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <gmock/gmock.h>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>
#include <vector>

namespace bullet_ccd
{
namespace
{
std::string checkMessage(const TriangleMesh& mesh)
{
    try
    {
        checkMesh(mesh, "cup.obj");
    }
    catch (const std::invalid_argument& error)
    {
        return error.what();
    }
    return "no error";
}

/// Every triangle with corners of its own, as STL files store them.
TriangleMesh soupOf(const TriangleMesh& mesh)
{
    TriangleMesh soup;
    for (const auto& [a, b, c] : mesh.triangles)
    {
        appendMesh(soup,
                   makeTriangle(mesh.vertices[static_cast<std::size_t>(a)],
                                mesh.vertices[static_cast<std::size_t>(b)],
                                mesh.vertices[static_cast<std::size_t>(c)]));
    }
    return soup;
}

TEST(CheckMesh, AcceptsAProperMesh)
{
    EXPECT_EQ(checkMessage(makeBox({1, 1, 1})), "no error");
}

TEST(CheckMesh, NamesTheFirstVertexThatIsNotFinite)
{
    TriangleMesh mesh = makeBox({1, 1, 1});
    mesh.vertices[5].y() = std::numeric_limits<double>::quiet_NaN();
    mesh.vertices[6].z() = std::numeric_limits<double>::infinity();
    const std::string message = checkMessage(mesh);
    EXPECT_THAT(message, testing::StartsWith("cup.obj: vertex 5 is (1.000000, nan, 1.000000)"));
    mesh.vertices[5].y() = 0.0;
    EXPECT_THAT(checkMessage(mesh), testing::HasSubstr("vertex 6"));
}

TEST(CheckMesh, NamesTheTriangleWhoseIndexIsOutOfRange)
{
    TriangleMesh mesh = makeBox({1, 1, 1});
    mesh.triangles[7][2] = 8;
    EXPECT_THAT(checkMessage(mesh),
                testing::AllOf(testing::HasSubstr("triangle 7"),
                               testing::HasSubstr("vertex 8"),
                               testing::HasSubstr("8 vertices")));
    mesh.triangles[3][0] = kNone;
    EXPECT_THAT(checkMessage(mesh), testing::HasSubstr("triangle 3 refers to vertex -1"));
}

TEST(CheckMesh, RefusesAMeshWithoutTriangles)
{
    EXPECT_THAT(checkMessage({}), testing::HasSubstr("no triangles (0 vertices)"));
}

TEST(RepairMesh, MergesASoupIntoItsWatertightMesh)
{
    const TriangleMesh sphere = makeSphere(0.1, 2);
    TriangleMesh soup = soupOf(sphere);
    EXPECT_FALSE(isWatertight(soup));
    const MeshRepair repair = repairMesh(soup);
    EXPECT_EQ(repair.mergedVertices,
              static_cast<std::int64_t>(3 * sphere.triangles.size() - sphere.vertices.size()));
    EXPECT_EQ(soup.vertices.size(), sphere.vertices.size());
    EXPECT_TRUE(isWatertight(soup));
    EXPECT_NEAR(massProperties(soup).volume, massProperties(sphere).volume, 1e-15);
}

TEST(RepairMesh, CountsWhatItRemoves)
{
    TriangleMesh mesh = makeBox({1, 1, 1});
    mesh.vertices.emplace_back(7, 7, 7);           // unreferenced
    mesh.vertices.emplace_back(mesh.vertices[0]);  // equal to vertex 0: index 9
    mesh.vertices.emplace_back(0, 1, -1);          // index 10: between vertices 2 and 3
    mesh.triangles.push_back({0, 9, 3});           // two equal corners once merged
    mesh.triangles.push_back({2, 10, 3});          // zero area
    mesh.triangles.push_back({mesh.triangles[4][2], mesh.triangles[4][0], mesh.triangles[4][1]});
    const MeshRepair repair = repairMesh(mesh);
    EXPECT_EQ(repair.mergedVertices, 1);
    EXPECT_EQ(repair.degenerateTriangles, 2);
    EXPECT_EQ(repair.duplicateTriangles, 1);
    EXPECT_EQ(repair.unreferencedVertices, 2);  // (7, 7, 7) and what only the needle used
    EXPECT_EQ(repair.summary(),
              "merged 1 equal vertex, removed 2 degenerate triangles, 1 duplicate triangle, "
              "2 unreferenced vertices");
    EXPECT_EQ(mesh.vertices.size(), 8U);
    EXPECT_TRUE(isWatertight(mesh));
}

TEST(RepairMesh, KeepsTheFirstOfEqualVerticesAndTrianglesAsAllPairsSay)
{
    std::mt19937 random(11);
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    for (int round = 0; round < 50; ++round)
    {
        TriangleMesh mesh;
        for (int i = 0; i < 40; ++i)
        {
            mesh.vertices.emplace_back(below(3), below(3), below(2));
        }
        for (int i = 0; i < 60; ++i)
        {
            mesh.triangles.push_back({below(40), below(40), below(40)});
        }
        const auto firstEqual = [&](std::int32_t vertex)
        {
            return std::find(mesh.vertices.begin(),
                             mesh.vertices.end(),
                             mesh.vertices[static_cast<std::size_t>(vertex)]) -
                   mesh.vertices.begin();
        };
        std::vector<std::array<Eigen::Vector3d, 3>> expected;
        std::set<std::set<std::ptrdiff_t>> known;
        for (const Triangle& t : mesh.triangles)
        {
            const std::set<std::ptrdiff_t> corners{
                firstEqual(t[0]), firstEqual(t[1]), firstEqual(t[2])};
            const auto at = [&](std::size_t k)
            { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
            const bool isFlat = (at(1) - at(0)).cross(at(2) - at(0)).isZero(0.0);
            if (corners.size() == 3 && known.insert(corners).second && !isFlat)
            {
                expected.push_back({at(0), at(1), at(2)});
            }
        }
        repairMesh(mesh);
        std::vector<std::array<Eigen::Vector3d, 3>> found;
        for (const Triangle& t : mesh.triangles)
        {
            const auto at = [&](std::size_t k)
            { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
            found.push_back({at(0), at(1), at(2)});
        }
        ASSERT_EQ(found, expected) << round;
    }
}

TEST(RepairMesh, MergesZerosOfBothSigns)
{
    TriangleMesh mesh{{{0.0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, 0}, {0, 1, 1}},
                      {{0, 1, 2}, {3, 2, 4}}};
    EXPECT_EQ(repairMesh(mesh).mergedVertices, 1);
    EXPECT_EQ(mesh.vertices.size(), 4U);
}

TEST(RepairMesh, KeepsTheNeedleThatHoldsAMeshClosed)
{
    // One edge of a tetrahedron carries a vertex that only one neighbour knows: the needle (0, 1,
    // 4) closes the slit.
    TriangleMesh mesh{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 0, 0}},
                      {{0, 2, 4}, {4, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}, {0, 4, 1}}};
    ASSERT_TRUE(isWatertight(mesh));
    EXPECT_EQ(repairMesh(mesh).degenerateTriangles, 0);
    EXPECT_TRUE(isWatertight(mesh));
    EXPECT_NEAR(massProperties(mesh).volume, 8.0 / 6.0, 1e-15);
}

TEST(RepairMesh, SaysNothingAboutAProperMesh)
{
    TriangleMesh mesh = makeTorus(1.0, 0.3, 12, 8);
    const std::uint64_t before = contentHash(mesh);
    EXPECT_EQ(repairMesh(mesh).summary(), "");
    EXPECT_EQ(contentHash(mesh), before);
}

TEST(IsWatertight, FindsHolesFlippedAndTripledEdges)
{
    TriangleMesh hole = makeBox({1, 1, 1});
    hole.triangles.pop_back();
    EXPECT_FALSE(isWatertight(hole));

    TriangleMesh flipped = makeBox({1, 1, 1});
    std::swap(flipped.triangles[3][0], flipped.triangles[3][1]);
    EXPECT_FALSE(isWatertight(flipped));

    TriangleMesh fin = makeBox({1, 1, 1});
    fin.vertices.emplace_back(3, 3, 3);
    fin.triangles.push_back({0, 2, 8});
    EXPECT_FALSE(isWatertight(fin));

    EXPECT_FALSE(isWatertight(makeTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})));
    EXPECT_FALSE(isWatertight({}));
}

TEST(MassProperties, RotateWithTheBodyAndIgnoreItsPlace)
{
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    const TriangleMesh original = makeCapsule(0.02, 0.09, 20);
    const MassProperties before = massProperties(original);
    for (int i = 0; i < 20; ++i)
    {
        const Eigen::Quaterniond rotation(
            Eigen::Vector4d::NullaryExpr([&] { return normal(random); }).normalized());
        const Eigen::Vector3d shift =
            10.0 * Eigen::Vector3d::NullaryExpr([&] { return normal(random); });
        TriangleMesh moved = original;
        transformMesh(moved, Eigen::Translation3d(shift) * rotation);
        const MassProperties after = massProperties(moved);
        const Eigen::Matrix3d r = rotation.toRotationMatrix();
        EXPECT_NEAR(after.volume, before.volume, 1e-9 * before.volume);
        EXPECT_TRUE(after.center.isApprox(shift + r * before.center, 1e-12));
        EXPECT_TRUE(after.inertia.isApprox(r * before.inertia * r.transpose(), 1e-8));
    }
}

TEST(MassProperties, OfAnOpenOrInsideOutMeshAreThoseOfItsBox)
{
    TriangleMesh open = makeBox({0.5, 1.0, 1.5});
    transformMesh(open, Eigen::Affine3d(Eigen::Translation3d(1, 2, 3)));
    open.triangles.pop_back();
    const MassProperties expected = massProperties(makeBox({0.5, 1.0, 1.5}));
    const MassProperties mass = massProperties(open);
    EXPECT_NEAR(mass.volume, 6.0, 1e-12);
    EXPECT_TRUE(mass.center.isApprox(Eigen::Vector3d(1, 2, 3), 1e-12));
    EXPECT_TRUE(mass.inertia.isApprox(expected.inertia, 1e-12));

    TriangleMesh insideOut = makeSphere(1.0, 1);
    for (Triangle& triangle : insideOut.triangles)
    {
        std::swap(triangle[0], triangle[1]);
    }
    EXPECT_NEAR(massProperties(insideOut).volume, bounds(insideOut).volume(), 1e-12);
}

TEST(TransformMesh, MirrorsKeepTheVolumePositive)
{
    TriangleMesh mesh = makeLofted(
        [](int station) -> std::vector<Eigen::Vector3d>
        {
            const double z = station;
            return {{1, 0, z}, {0, 1 + z, z}, {-0.5, -1, z}};
        },
        2);
    const MassProperties before = massProperties(mesh);
    transformMesh(mesh, Eigen::Affine3d(Eigen::Scaling(-1.0, 1.0, 2.0)));
    const MassProperties after = massProperties(mesh);
    EXPECT_TRUE(isWatertight(mesh));
    EXPECT_NEAR(after.volume, 2.0 * before.volume, 1e-12);
    EXPECT_NEAR(after.center.x(), -before.center.x(), 1e-12);
}

TEST(AppendMesh, AddsVolumesOfDisjointParts)
{
    TriangleMesh mesh = makeBox({1, 1, 1});
    TriangleMesh other = makeSphere(0.5, 2);
    transformMesh(other, Eigen::Affine3d(Eigen::Translation3d(5, 0, 0)));
    const double sum = massProperties(mesh).volume + massProperties(other).volume;
    appendMesh(mesh, other);
    EXPECT_TRUE(isWatertight(mesh));
    EXPECT_NEAR(massProperties(mesh).volume, sum, 1e-12);
    EXPECT_NEAR(bounds(mesh).max().x(), 5.5, 0.05);
}

TEST(ContentHash, ChangesWithEveryPartOfTheContent)
{
    const TriangleMesh mesh = makeBox({1, 1, 1});
    const std::uint64_t hash = contentHash(mesh);
    EXPECT_EQ(contentHash(makeBox({1, 1, 1})), hash);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    {
        TriangleMesh changed = mesh;
        changed.vertices[i].z() = std::nextafter(changed.vertices[i].z(), 9.0);
        EXPECT_NE(contentHash(changed), hash);
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        TriangleMesh changed = mesh;
        std::swap(changed.triangles[i][0], changed.triangles[i][1]);
        EXPECT_NE(contentHash(changed), hash);
    }
    EXPECT_NE(contentHash({}), hash);
}
}  // namespace
}  // namespace bullet_ccd
