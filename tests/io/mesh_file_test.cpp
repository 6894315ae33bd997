#include "bullet_ccd/io/mesh_file.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/io/mesh_texts.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>
#include <ostream>
#include <random>
#include <stdexcept>

namespace bullet_ccd
{
namespace
{
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using tests::TempFolder;

/// Message of the exception that loading throws, or "" if it throws none.
std::string loadError(const std::filesystem::path& path, const MeshFileOptions& options = {})
{
    try
    {
        static_cast<void>(loadMeshFile(path, options));
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return "";
}

TEST(MeshFile, EveryFormatGivesTheSameClosedTetrahedron)
{
    const TempFolder folder;
    for (const auto& [name, content] : tests::allTetraFiles())
    {
        SCOPED_TRACE(name);
        const MeshFile file = loadMeshFile(folder.write(name, content));
        EXPECT_EQ(file.mesh.vertices.size(), 4U);
        EXPECT_EQ(file.mesh.triangles.size(), 4U);
        EXPECT_TRUE(isWatertight(file.mesh));
        EXPECT_NEAR(massProperties(file.mesh).volume, 1.0 / 6.0, 1e-15);
        EXPECT_TRUE(file.notes.empty());
    }
}

TEST(MeshFile, ExtensionIsReadInAnyCase)
{
    const TempFolder folder;
    EXPECT_EQ(loadMeshFile(folder.write("A.STL", tests::tetraStlText())).mesh.triangles.size(), 4U);
}

TEST(MeshFile, WrittenObjReadsBackBitForBit)
{
    const TempFolder folder;
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> exponent(-12.0, 6.0);
    TriangleMesh mesh = makeSphere(0.1, 3);
    for (Eigen::Vector3d& vertex : mesh.vertices)
    {
        vertex *= std::pow(10.0, exponent(random)) * std::numbers::pi;
    }
    writeObj(mesh, folder.path() / "a.obj");
    const MeshFile file = loadMeshFile(folder.path() / "a.obj");
    EXPECT_EQ(file.mesh.vertices, mesh.vertices);
    EXPECT_EQ(file.mesh.triangles, mesh.triangles);
    EXPECT_EQ(contentHash(file.mesh), contentHash(mesh));
}

TEST(MeshFile, WritingIntoAMissingFolderSaysSo)
{
    const TempFolder folder;
    try
    {
        writeObj(makeBox({1, 1, 1}), folder.path() / "no" / "a.obj");
        FAIL();
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_THAT(error.what(), HasSubstr("a.obj: cannot be written"));
    }
}

TEST(MeshFile, ScaleAppliesToCoordinates)
{
    const TempFolder folder;
    const MeshFile file = loadMeshFile(folder.write("a.obj", tests::tetraObj()), {.scale = 0.5});
    EXPECT_NEAR(massProperties(file.mesh).volume, 1.0 / 48.0, 1e-15);
}

TEST(MeshFile, ScaleThatIsNoPositiveNumberIsRefused)
{
    const TempFolder folder;
    const std::filesystem::path path = folder.write("a.obj", tests::tetraObj());
    for (const double scale : {0.0, -1.0, std::nan(""), HUGE_VAL})
    {
        EXPECT_THAT(loadError(path, {.scale = scale}),
                    AllOf(StartsWith(path.string()), HasSubstr("scale")));
    }
}

TEST(MeshFile, LargeExtentsRaiseTheQuestionOfMillimetres)
{
    const TempFolder folder;
    const std::filesystem::path path =
        folder.write("a.obj", "v 0 0 0\nv 120 0 0\nv 0 80 0\nf 1 2 3\n");
    const MeshFile file = loadMeshFile(path);
    ASSERT_EQ(file.notes.size(), 1U);
    EXPECT_THAT(file.notes[0], AllOf(HasSubstr("120 x 80 x 0 m"), HasSubstr("scale 0.001")));
    EXPECT_TRUE(loadMeshFile(path, {.scale = 0.001}).notes.empty());
}

TEST(MeshFile, ConcavePolygonKeepsItsAreaAndItsNotch)
{
    // An L of area 3; its reflex corner is (1, 1).
    const TempFolder folder;
    const MeshFile file = loadMeshFile(folder.write(
        "l.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 3 4 5 6 1 2\n"));
    ASSERT_EQ(file.mesh.triangles.size(), 4U);
    double area = 0.0;
    for (const Triangle& t : file.mesh.triangles)
    {
        const auto corner = [&](std::size_t k)
        { return file.mesh.vertices[static_cast<std::size_t>(t[k])]; };
        const Eigen::Vector3d twice = (corner(1) - corner(0)).cross(corner(2) - corner(0));
        EXPECT_GT(twice.z(), 0.0) << "a triangle lies on its back";
        area += 0.5 * twice.z();
    }
    EXPECT_DOUBLE_EQ(area, 3.0);
}

TEST(MeshFile, ConcavePolygonsOfOtherFormatsAreCutTheSameWay)
{
    const TempFolder folder;
    const MeshFile file =
        loadMeshFile(folder.write("l.off",
                                  "OFF\n6 1 0\n0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n"
                                  "6 2 3 4 5 0 1\n"));
    double area = 0.0;
    for (const Triangle& t : file.mesh.triangles)
    {
        const auto corner = [&](std::size_t k)
        { return file.mesh.vertices[static_cast<std::size_t>(t[k])]; };
        area += 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
    }
    EXPECT_DOUBLE_EQ(area, 3.0);
}

TEST(MeshFile, ObjTakesContinuedLinesCommentsAndForeignLineEnds)
{
    const TempFolder folder;
    const MeshFile file = loadMeshFile(
        folder.write("a.obj",
                     "mtllib x.mtl\r\nv 0 0 0 # origin\r\nv +1e0 0 \\\r\n 0\r\nv 0 1 0 0.5\r\n"
                     "vn 0 0 1\r\nusemtl x\r\ns off\r\nf 1/1/1 2/2/2 3/3/3"));
    EXPECT_EQ(file.mesh.triangles.size(), 1U);
    EXPECT_EQ(file.mesh.vertices[1], Eigen::Vector3d(1, 0, 0));
}

TEST(MeshFile, ObjMayBeginWithAByteOrderMark)
{
    const TempFolder folder;
    const MeshFile file = loadMeshFile(
        folder.write("a.obj", "\xEF\xBB\xBFv 5 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n"));
    ASSERT_EQ(file.mesh.vertices.size(), 3U);
    EXPECT_EQ(file.mesh.vertices[0], Eigen::Vector3d(5, 0, 0));
}

TEST(MeshFile, LinesAndPointsAreDroppedWithANote)
{
    const TempFolder folder;
    const MeshFile file = loadMeshFile(folder.write("a.obj", tests::tetraObj() + "l 1 2\np 3\n"));
    EXPECT_THAT(file.notes, testing::ElementsAre("ignored 2 lines and points"));
}

TEST(MeshFile, RepairsAreReported)
{
    const TempFolder folder;
    const MeshFile file =
        loadMeshFile(folder.write("a.obj", tests::tetraObj() + "f 1 1 2\nf 2 3 4\n"));
    EXPECT_EQ(file.repair.degenerateTriangles, 1);
    EXPECT_EQ(file.repair.duplicateTriangles, 1);
    EXPECT_EQ(file.notes.size(), 1U);
    EXPECT_EQ(file.mesh.triangles.size(), 4U);
}

TEST(MeshFile, DaeUnitIsAppliedAndUpAxisIsNot)
{
    const TempFolder folder;
    const MeshFile file =
        loadMeshFile(folder.write("a.dae",
                                  tests::tetraDae("<unit name=\"centimetre\" meter=\"0.01\"/>"
                                                  "<up_axis>X_UP</up_axis>",
                                                  "2 0 0 0 0 3 0 0 0 0 5 0 0 0 0 1")));
    const Eigen::AlignedBox3d box = bounds(file.mesh);
    EXPECT_TRUE(box.min().isZero(1e-9));
    EXPECT_TRUE(box.max().isApprox(Eigen::Vector3d(0.02, 0.03, 0.05), 1e-6));
}

TEST(MeshFile, MirroringNodesKeepTheOutsideOutside)
{
    const TempFolder folder;
    const MeshFile file = loadMeshFile(
        folder.write("a.dae", tests::tetraDae("", "-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1")));
    EXPECT_NEAR(massProperties(file.mesh).volume, 1.0 / 6.0, 1e-7);
    EXPECT_NEAR(massProperties(file.mesh).center.x(), -0.25, 1e-7);
}

/// File name, content, and what the message must say.
struct BrokenFile
{
    std::string name;
    std::string content;
    std::string message;
};

void PrintTo(const BrokenFile& broken, std::ostream* stream)
{
    *stream << broken.name << ": " << broken.content;
}

class BrokenMeshFile : public testing::TestWithParam<BrokenFile>
{
};

TEST_P(BrokenMeshFile, SaysWhereAndWhat)
{
    const TempFolder folder;
    const std::filesystem::path path = folder.write(GetParam().name, GetParam().content);
    EXPECT_THAT(loadError(path),
                AllOf(StartsWith(path.string() + ": "), HasSubstr(GetParam().message)));
}

INSTANTIATE_TEST_SUITE_P(
    All,
    BrokenMeshFile,
    testing::Values(
        BrokenFile{"a.obj", "", "empty"},
        BrokenFile{"a.xyz", "1 2 3", "extension '.xyz'"},
        BrokenFile{"a.obj", "v 0 0 0\nv 1 0\n", "line 2: vertex 2: coordinate z is missing"},
        BrokenFile{"a.obj", "v 0 0 zero\n", "line 1: vertex 1: coordinate z is 'zero'"},
        BrokenFile{"a.obj", "v 0 0 1e999\n", "coordinate z is '1e999'"},
        BrokenFile{"a.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "vertex 0"},
        BrokenFile{"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "line 4: face has 2 corners"},
        BrokenFile{"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "line 4: face: corner '0'"},
        BrokenFile{"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "corner '-4'"},
        BrokenFile{"a.obj",
                   "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
                   "a.obj: line 4: face refers to vertex 9, but the file has 3: "},
        BrokenFile{"a.obj",
                   "f 1 2 3\nf 2 5 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n",
                   "line 2: face refers to vertex 5, but the file has 4"},
        BrokenFile{"a.obj", "v 0 0 0\nv 1 0 0\n", "no faces among 2 vertices"},
        BrokenFile{"a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "zero area"},
        BrokenFile{"a.stl", "what is this", "export the mesh again"},
        BrokenFile{"a.ply", "ply\nformat ascii 1.0\nend_header\n", "export"},
        BrokenFile{"a.off", "OFF\n0 0 0\n", "export"},
        BrokenFile{"a.dae", "<COLLADA", "export the mesh again"},
        BrokenFile{"a.gltf", "{\"asset\":", "export the mesh again"},
        BrokenFile{"a.glb", "glTF", "export the mesh again"}));

TEST(MeshFile, TextOfAPlyThatEndsEarlyIsRefusedWhereverItEnds)
{
    const TempFolder folder;
    const std::string whole = tests::tetraPlyText();
    const std::string lastFaces = "3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    for (std::size_t missing = 2; missing < lastFaces.size(); ++missing)
    {
        EXPECT_THAT(
            loadError(folder.write("cut.ply", whole.substr(0, whole.size() - missing))),
            AllOf(HasSubstr("cut.ply: the file ends"), HasSubstr("of 4: export the mesh again")))
            << missing;
    }
}

TEST(MeshFile, MissingFilesAndFoldersAreNamed)
{
    const TempFolder folder;
    EXPECT_THAT(loadError(folder.path() / "no.obj"), HasSubstr("no.obj: no such file"));
    std::filesystem::create_directories(folder.path() / "folder.obj");
    EXPECT_THAT(loadError(folder.path() / "folder.obj"), HasSubstr("folder.obj: not a file"));
}
}  // namespace
}  // namespace bullet_ccd
