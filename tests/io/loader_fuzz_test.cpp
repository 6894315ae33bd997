#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/robot_file.h"
#include "tests/io/mesh_texts.h"
#include "tests/io/mjcf_texts.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd
{
namespace
{
using tests::TempFolder;

struct FuzzCount
{
    int good = 0;
    int refused = 0;
};

/// Loads and checks that the outcome is a valid mesh or a message that names the file.
void tryMesh(const std::filesystem::path& path, FuzzCount& count)
{
    try
    {
        const MeshFile file = loadMeshFile(path);
        checkMesh(file.mesh, "mutated");
        EXPECT_FALSE(file.mesh.triangles.empty());
        ++count.good;
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
        ++count.refused;
    }
}

void tryRobot(const std::filesystem::path& path, FuzzCount& count)
{
    try
    {
        const RobotModel robot = loadRobot(path);
        ASSERT_EQ(robot.linkMeshes.size(), robot.tree.size());
        for (std::size_t i = 0; i < robot.tree.size(); ++i)
        {
            const Link& link = robot.tree.links[i];
            EXPECT_LT(link.parent, static_cast<std::int32_t>(i));
            EXPECT_TRUE(link.X_PL0.matrix().allFinite());
            EXPECT_GT(link.mass, 0.0);
            EXPECT_LE(link.joint.lower, link.joint.upper);
            if (!robot.linkMeshes[i].triangles.empty())
            {
                checkMesh(robot.linkMeshes[i], link.name);
            }
        }
        ++count.good;
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_NE(std::string(error.what()).find(path.filename().string()), std::string::npos)
            << error.what();
        ++count.refused;
    }
}

/// One to four bytes replaced by others.
std::string flipped(const std::string& content, std::mt19937_64& random)
{
    std::string result = content;
    const std::size_t changes = 1 + random() % 4;
    for (std::size_t k = 0; k < changes; ++k)
    {
        result[random() % result.size()] = static_cast<char>(random());
    }
    return result;
}

/// A run of digits replaced by a number that hurts.
std::string withNumber(const std::string& content, std::mt19937_64& random)
{
    const char* const numbers[] = {
        "nan", "-1", "inf", "1e308", "4294967295", "1e-320", "99999999999", "", "2147483647", "0"};
    std::string result = content;
    const std::size_t start = random() % result.size();
    const std::size_t begin = result.find_first_of("0123456789", start);
    if (begin == std::string::npos)
    {
        return result;
    }
    const std::size_t end = std::min(result.find_first_not_of("0123456789.", begin), result.size());
    return result.replace(begin, end - begin, numbers[random() % std::size(numbers)]);
}

/// A part copied over another place.
std::string spliced(const std::string& content, std::mt19937_64& random)
{
    std::string result = content;
    const std::size_t from = random() % content.size();
    const std::size_t length = std::min<std::size_t>(random() % 40, content.size() - from);
    result.insert(random() % content.size(), content.substr(from, length));
    return result;
}

using Try = std::function<void(const std::filesystem::path&, FuzzCount&)>;

FuzzCount fuzz(const TempFolder& folder,
               const std::string& name,
               const std::string& content,
               const Try& tryFile,
               int rounds,
               std::uint64_t seed)
{
    FuzzCount count;
    const std::size_t step = std::max<std::size_t>(1, content.size() / 40);
    for (std::size_t length = 0; length < content.size(); length += step)
    {
        SCOPED_TRACE(name + " cut to " + std::to_string(length) + " bytes");
        tryFile(folder.write(name, content.substr(0, length)), count);
    }
    std::mt19937_64 random(seed);
    for (int round = 0; round < rounds && !testing::Test::HasFailure(); ++round)
    {
        SCOPED_TRACE(name + " seed " + std::to_string(seed) + " round " + std::to_string(round));
        tryFile(folder.write(name, flipped(content, random)), count);
        tryFile(folder.write(name, withNumber(content, random)), count);
        tryFile(folder.write(name, spliced(content, random)), count);
    }
    return count;
}

TEST(LoaderFuzz, MutatedMeshFilesAreValidOrRefusedWithAMessage)
{
    const TempFolder folder;
    std::uint64_t seed = 1;
    for (const auto& [name, content] : tests::allTetraFiles())
    {
        const FuzzCount count =
            fuzz(folder, name, content, tryMesh, tests::longTests() ? 25 : 12, seed++);
        EXPECT_GE(count.good, 3) << name;
        EXPECT_GT(count.refused, 20) << name;
    }
}

const char* const kRobot = R"(<?xml version="1.0"?>
<robot name="fuzzed">
  <link name="base"><inertial><origin xyz="0 0 0.1"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
    <collision><origin xyz="0.1 0 0" rpy="0 0.5 0"/><geometry><box size="0.1 0.2 0.3"/></geometry>
    </collision></link>
  <link name="a"><collision><geometry><mesh filename="tetra.obj" scale="0.1 -0.1 0.1"/></geometry>
    </collision></link>
  <link name="b"><collision><geometry><sphere radius="0.01"/></geometry></collision>
    <collision><geometry><cylinder radius="0.02" length="0.1"/></geometry></collision></link>
  <link name="c"/>
  <joint name="ja" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1.5" effort="10" velocity="2"/></joint>
  <joint name="jb" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.1" effort="10" velocity="2"/>
    <mimic joint="ja" multiplier="0.5" offset="0.1"/></joint>
  <joint name="jc" type="continuous"><origin xyz="0 0 1"/><parent link="b"/><child link="c"/>
    <mimic joint="jb"/></joint>
</robot>
)";

TEST(LoaderFuzz, MutatedUrdfFilesAreValidOrRefusedWithAMessage)
{
    const TempFolder folder;
    folder.write("tetra.obj", tests::tetraObj());
    const FuzzCount count = fuzz(folder, "robot.urdf", kRobot, tryRobot, 200, 77);
    EXPECT_GT(count.good, 100);
    EXPECT_GT(count.refused, 100);
}

/// Names and numbers of MJCF refer to each other, so parts of it are mutated, too: an attribute of
/// one element stands at another one.
TEST(LoaderFuzz, MutatedMjcfFilesAreValidOrRefusedWithAMessage)
{
    const TempFolder folder;
    // Without the large sphere, which has most of the triangles.
    std::string text = tests::kMjcfHand;
    const std::string sphere = "type=\"sphere\" size=\"0.5\"";
    text.replace(text.find(sphere), sphere.size(), "type=\"sphere\" size=\"0.002\"");
    const FuzzCount count =
        fuzz(folder, "robot.xml", text, tryRobot, tests::longTests() ? 400 : 50, 78);
    EXPECT_GT(count.good, 30);
    EXPECT_GT(count.refused, 100);

    std::vector<std::pair<std::size_t, std::size_t>> attributes;  // begin, length
    for (std::size_t end = text.find("=\""); end != std::string::npos; end = text.find("=\"", end))
    {
        const std::size_t begin = text.find_last_of(" \n", end) + 1;
        end = text.find('"', end + 2) + 1;
        attributes.emplace_back(begin, end - begin);
    }
    ASSERT_GT(attributes.size(), 100U);
    std::mt19937_64 random(79);
    FuzzCount moved;
    for (int round = 0; round < 200 && !testing::Test::HasFailure(); ++round)
    {
        SCOPED_TRACE("seed 79 round " + std::to_string(round));
        const auto [to, length] = attributes[random() % attributes.size()];
        const auto [from, size] = attributes[random() % attributes.size()];
        const std::string part = random() % 4 == 0 ? "" : text.substr(from, size);
        std::string mutated = text;
        tryRobot(folder.write("robot.xml", mutated.replace(to, length, part)), moved);
    }
    EXPECT_GT(moved.good, 20);
    EXPECT_GT(moved.refused, 20);
}

TEST(LoaderFuzz, DeeplyNestedFilesAreRefused)
{
    const TempFolder folder;
    std::string xml;
    std::string json = "{\"asset\":";
    for (int i = 0; i < 200000; ++i)
    {
        xml += "<a>";
        json += '[';
    }
    FuzzCount count;
    tryRobot(folder.write("deep.urdf", "<robot name=\"x\">" + xml), count);
    tryMesh(folder.write("deep.dae", "<COLLADA>" + xml), count);
    tryMesh(folder.write("deep.gltf", json), count);
    EXPECT_EQ(count.refused, 3);
}

TEST(LoaderFuzz, CountsThatNoFileCanHoldAreRefusedAtOnce)
{
    const TempFolder folder;
    FuzzCount count;
    std::string ply = tests::tetraPlyBinary();
    ply.replace(ply.find("vertex 4"), 8, "vertex 4000000000");
    tryMesh(folder.write("a.ply", ply), count);
    std::string faces = tests::tetraPlyText();
    faces.replace(faces.find("face 4"), 6, "face 4000000000");
    tryMesh(folder.write("b.ply", faces), count);
    tryMesh(folder.write("a.off", "OFF\n4000000000 4000000000 0\n0 0 0\n"), count);
    std::string gltf = tests::tetraGltf();
    gltf.replace(gltf.find("\"count\":4"), 9, "\"count\":4000000000");
    tryMesh(folder.write("a.gltf", gltf), count);
    std::string stl = tests::tetraStlBinary();
    stl.replace(80, 4, "\xff\xff\xff\x7f");
    tryMesh(folder.write("a.stl", stl), count);
    EXPECT_EQ(count.refused + count.good, 5);
    EXPECT_GE(count.refused, 4);
}
}  // namespace
}  // namespace bullet_ccd
