#include "bullet_ccd/io/mesh_file.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <gmock/gmock.h>
#include <ostream>
#include <stdexcept>
#include <string>

namespace bullet_ccd
{
namespace
{
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using tests::TempFolder;

struct OffText
{
    std::string what;
    std::string content;
};

void PrintTo(const OffText& text, std::ostream* stream)
{
    *stream << text.what;
}

class OffTetrahedron : public testing::TestWithParam<OffText>
{
};

/// Corners (0,0,0), (1,0,0), (0,1,0), (0,0,1) in this order, wound outwards: volume 1/6.
TEST_P(OffTetrahedron, IsReadHoweverItIsLaidOut)
{
    const TempFolder folder;
    const MeshFile file = loadMeshFile(folder.write("a.off", GetParam().content));
    ASSERT_EQ(file.mesh.vertices.size(), 4U);
    EXPECT_EQ(file.mesh.vertices[0], Eigen::Vector3d(0, 0, 0));
    EXPECT_EQ(file.mesh.vertices[3], Eigen::Vector3d(0, 0, 1));
    EXPECT_EQ(file.mesh.triangles.size(), 4U);
    EXPECT_TRUE(isWatertight(file.mesh));
    EXPECT_DOUBLE_EQ(massProperties(file.mesh).volume, 1.0 / 6.0);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    OffTetrahedron,
    testing::Values(
        OffText{"as everybody writes it",
                "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
        OffText{"without a line end at the end",
                "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3"},
        OffText{"tabs",
                "OFF\n4\t4\t6\n0\t0\t0\n\t1\t0\t0\n0\t1\t0\t\n0\t0\t1\n3\t0\t2\t1\n3\t\t0 1\t3\n"
                "3\t0\t3\t2\n3\t1\t2\t3\n"},
        OffText{"lines that end as in DOS",
                "OFF\r\n4 4 6\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n0 0 1\r\n3 0 2 1\r\n3 0 1 3\r\n"
                "3 0 3 2\r\n3 1 2 3\r\n"},
        OffText{"lines that end as on old Macintoshes",
                "OFF\r4 4 6\r0 0 0\r1 0 0 # right\r0 1 0\r0 0 1\r3 0 2 1\r3 0 1 3\r3 0 3 2\r"
                "3 1 2 3\r"},
        OffText{"comments",
                "# a tetrahedron\nOFF # of four\n# faces\n4 4 6# edges, too\n0 0 0 # origin\n"
                "# 9 9 9\n1 0 0\n0 1 0\n#\n0 0 1\n3 0 2 1 # bottom\n# and\n3 0 1 3\n3 0 3 2\n"
                "3 1 2 3#\n# end"},
        OffText{"blank lines",
                "\n\nOFF\n\n4 4 6\n\n\n0 0 0\n \n1 0 0\n\t\n0 1 0\n0 0 1\n\n3 0 2 1\n\n3 0 1 3\n"
                "3 0 3 2\n\n3 1 2 3\n\n \n"},
        OffText{"several vertices on a line",
                "OFF\n4 4 6\n0 0 0  1 0 0\n0 1 0  0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
        OffText{"several faces on a line",
                "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1 3 0 1 3\n3 0 3 2 3 1 2 3\n"},
        OffText{"one line", "OFF 4 4 6 0 0 0 1 0 0 0 1 0 0 0 1 3 0 2 1 3 0 1 3 3 0 3 2 3 1 2 3"},
        OffText{
            "one number on a line",
            "OFF\n4\n4\n6\n0\n0\n0\n1\n0\n0\n0\n1\n0\n0\n0\n1\n3\n0\n2\n1\n3\n0\n1\n3\n3\n0\n3\n"
            "2\n3\n1\n2\n3\n"},
        OffText{"counts behind the keyword",
                "OFF4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
        OffText{"no keyword",
                "4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
        OffText{"no number of edges",
                "OFF\n4 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
        OffText{"the number of edges on a line of its own",
                "OFF\n4 4\n6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
        OffText{"signs and exponents",
                "OFF\n4 4 6\n+0 -0 0\n+1e0 0 0e3\n0 1.0 0.\n0 .0 10E-1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n"
                "3 1 2 3\n"},
        OffText{"colours of faces, of any number",
                "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1 255 0 0\n3 0 1 3 0.5 0.5 0.5 1\n"
                "3 0 3 2 7\n3 1 2 3\n"},
        OffText{"colours of vertices, of four numbers",
                "COFF\n4 4 6\n0 0 0 255 0 0 255\n1 0 0 0 1 2 3\n0 1 0 4 5 6 7\n0 0 1 1 1 1 1\n"
                "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
        OffText{"colours of vertices, of three numbers",
                "COFF\n4 4 6\n0 0 0 255 0 0\n1 0 0 0 1 2\n0 1 0 4 5 6\n0 0 1 1 1 1\n"
                "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
        OffText{"colours of vertices that the keyword does not promise",
                "OFF\n4 4 6\n0 0 0 1 0 0\n1 0 0 0 1 2\n0 1 0 4 5 6\n0 0 1 1 1 1\n"
                "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
        OffText{"normals",
                "NOFF\n4 4 6\n0 0 0 0 0 -1\n1 0 0 1 0 0\n0 1 0 0 1 0\n0 0 1 0 0 1\n"
                "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"},
        OffText{"all that a vertex can have, on one line",
                "STCN4OFF 4 4 6 0 0 0 2  0 0 1  1 1 1 1  0 0   2 0 0 2  0 0 1  1 1 1 1  0 0\n"
                "0 3 0 3  0 0 1  1 1 1 1  0 0   0 0 4 4  0 0 1  1 1 1 1  0 0\n"
                "3 0 2 1 3 0 1 3 3 0 3 2 3 1 2 3\n"},
        OffText{"a dimension",
                "nOFF\n3\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n"
                "3 1 2 3\n"}));

TEST(OffFile, NumbersAreReadInDoublePrecision)
{
    const TempFolder folder;
    const MeshFile file =
        loadMeshFile(folder.write("a.off", "OFF\n3 1 0\n0 0 0.1\n1 0 0\n0 1 0\n3 0 1 2\n"));
    EXPECT_EQ(file.mesh.vertices[0].z(), 0.1);
}

TEST(OffFile, PointsAndLinesAreDroppedWithANote)
{
    const TempFolder folder;
    const MeshFile file = loadMeshFile(
        folder.write("a.off", "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n1 0\n3 0 1 2\n2 0 1\n"));
    EXPECT_EQ(file.mesh.triangles.size(), 1U);
    EXPECT_THAT(file.notes, testing::ElementsAre("ignored 2 lines and points"));
}

class BrokenOff : public testing::TestWithParam<OffText>
{
};

TEST_P(BrokenOff, SaysWhereAndWhat)
{
    const TempFolder folder;
    const std::filesystem::path path = folder.write("a.off", GetParam().content);
    try
    {
        static_cast<void>(loadMeshFile(path));
        FAIL() << "was accepted";
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_THAT(error.what(),
                    AllOf(StartsWith(path.string() + ": "), HasSubstr(GetParam().what)));
    }
}

INSTANTIATE_TEST_SUITE_P(
    All,
    BrokenOff,
    testing::Values(
        OffText{"line 1: 'XOFF' is no kind of OFF", "XOFF\n3 1 0\n"},
        OffText{"line 2: number of vertices is 'three'", "OFF\nthree 1 0\n"},
        OffText{"number of faces is missing", "OFF\n3\n"},
        OffText{"number of vertices is '-3'", "OFF\n-3 1 0\n"},
        OffText{"number of vertices is '4000000000'", "OFF\n4000000000 1 0\n"},
        OffText{"line 4: vertex 1 of 3: coordinate y is 'x'",
                "OFF\n3 1 0\n0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n"},
        OffText{"vertex 2 of 2000000000: coordinate x is missing",
                "OFF\n2000000000 0 0\n0 0 0\n1 0 0\n"},
        OffText{"line 6: face 0: corner 2 is '3', a vertex in [0, 3)",
                "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"},
        OffText{"face 0: corner 1 is '-1'", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n"},
        OffText{"face 1: corner count is missing", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        OffText{"line 7: '3' stands behind the last of 3 vertices and 1 faces",
                "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 2 1\n"},
        OffText{"dimension 4 is not in [1, 3]", "nOFF\n4\n3 1 0\n"},
        OffText{"binary OFF: convert it", "OFF BINARY\n\3\0\0\0"}));
}  // namespace
}  // namespace bullet_ccd
