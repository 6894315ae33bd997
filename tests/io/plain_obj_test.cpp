// Large OBJ files of triangles are read by a reader of their own: it must say what the other says.
#include "bullet_ccd/io/plain_obj.h"

#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/obj_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <gmock/gmock.h>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
namespace
{
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A sphere of 81,920 triangles with all that a line may hold: over 5 MB.
std::string sphereText(reference::Random& random)
{
    const TriangleMesh sphere = makeSphere(1.0, 6);
    std::string text = "\xEF\xBB\xBF# a sphere\r\nmtllib none\n\n";
    const std::vector<std::string> ends{"\n", "\r\n", " \n", "# why\n", " # f 1 2\n", "\n\n \t\n"};
    const std::vector<std::string> between{" ", "  ", "\t", " \v"};
    const auto anyOf = [&](const std::vector<std::string>& words) -> const std::string& {
        return words[static_cast<std::size_t>(
            random.integer(0, static_cast<int>(words.size()) - 1))];
    };
    std::size_t next = 0;
    const auto addVertices = [&](std::size_t count)
    {
        for (; next < std::min(count, sphere.vertices.size()); ++next)
        {
            text += random.integer(0, 9) == 0 ? " v" : "v";
            for (const double x : sphere.vertices[next])
            {
                const std::string more = std::to_string(random.integer(0, 999'999'999));
                const auto digits = static_cast<std::size_t>(random.integer(0, 18));
                text += anyOf(between) + std::to_string(x) + (more + more).substr(0, digits) +
                        (x > 0.8 ? "e-0" : "");
            }
            text += anyOf(ends) + (next % 100 == 0 ? "vn 0 0 1\nvt 0 0\ng v\n" : "");
        }
    };
    for (std::size_t i = 0; i < sphere.triangles.size(); ++i)
    {
        addVertices(i);  // now and then behind a face that needs them
        text += "f";
        for (const std::int32_t corner : sphere.triangles[i])
        {
            text += anyOf(between) + std::to_string(corner + 1);
            text += i % 3 == 0 ? "/1/2" : i % 3 == 1 ? "//7" : "";
        }
        text += anyOf(ends) + (i % 1000 == 0 ? "l 1 2\np 1\np\n" : "");
    }
    return text + "v 5 6 7";  // no end of the line
}

TEST(PlainObj, IsReadAsByTheOtherReader)
{
    const TempFolder folder;
    reference::Random random(3);
    for (int i = 0; i < 3; ++i)
    {
        const std::filesystem::path file = folder.write("sphere.obj", sphereText(random));
        const std::optional<PlainObj> plain = readPlainObj(file);
        ASSERT_TRUE(plain);
        PolygonSoup soup = readObj(file);
        EXPECT_EQ(plain->droppedElements, soup.droppedElements);
        EXPECT_GT(plain->droppedElements, 0);
        const TriangleMesh mesh = triangulate(std::move(soup), "sphere");
        EXPECT_EQ(plain->mesh.vertices, mesh.vertices);
        EXPECT_EQ(plain->mesh.triangles, mesh.triangles);
        EXPECT_EQ(mesh.triangles.size(), 81'920u);
    }
}

TEST(PlainObj, WhatIsUnusualIsLeftToTheOtherReader)
{
    const TempFolder folder;
    reference::Random random(4);
    const std::string text = sphereText(random);
    const std::size_t middle = text.find("\nf ", text.size() / 2) + 1;
    for (const char* line : {"f 1 2 3 4\n",
                             "f -1 -2 -3\n",
                             "f 1 2 \\\n3\n",
                             "f +1 2 3\n",
                             "v +1 2 3\n",
                             "# a comment \\\nf 1 2 3\n"})
    {
        const std::filesystem::path file =
            folder.write("sphere.obj", std::string(text).insert(middle, line));
        EXPECT_FALSE(readPlainObj(file)) << line;
        EXPECT_NO_THROW((void)loadMeshFile(file)) << line;
    }
    const auto lines =
        std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(middle), '\n');
    for (const char* line : {"f 1 2\n",
                             "f 1 2 0\n",
                             "f 1 2 x\n",
                             "f 1 2 99999999\n",
                             "f 1 2 9999999999\n",
                             "v 1 2\n",
                             "v 1 2 1e999\n",
                             "v\n"})
    {
        const std::filesystem::path file =
            folder.write("sphere.obj", std::string(text).insert(middle, line));
        EXPECT_FALSE(readPlainObj(file)) << line;
        EXPECT_THAT(
            [&] { (void)loadMeshFile(file); },
            ThrowsMessage<std::runtime_error>(HasSubstr("line " + std::to_string(lines + 1) + ":")))
            << line;
    }
    EXPECT_FALSE(readPlainObj(folder.path() / "absent.obj"));
    EXPECT_FALSE(readPlainObj(folder.write("small.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")));
}
}  // namespace
}  // namespace bullet_ccd::tests
