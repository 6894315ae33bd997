#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using testing::HasSubstr;
using testing::ThrowsMessage;
namespace fs = std::filesystem;

std::string readAll(const fs::path& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void expectSame(const SsvTree& a, const SsvTree& b)
{
    ASSERT_EQ(a.nodes().size(), b.nodes().size());
    EXPECT_EQ(std::memcmp(a.nodes().data(), b.nodes().data(), a.nodes().size_bytes()), 0);
    EXPECT_EQ(a.origin(), b.origin());
    EXPECT_EQ(a.radius(), b.radius());
    ASSERT_EQ(a.mesh().triangles, b.mesh().triangles);
    ASSERT_EQ(a.mesh().vertices, b.mesh().vertices);
    for (std::int32_t slot = 0; slot < static_cast<std::int32_t>(a.mesh().triangles.size()); ++slot)
    {
        ASSERT_EQ(a.triangle(slot), b.triangle(slot));
        ASSERT_EQ(a.corners(slot), b.corners(slot));
    }
}

class SsvTreeFile : public testing::Test
{
protected:
    TempFolder m_folder;
    TriangleMesh m_mesh = makeTorus(1.0, 0.3, 12, 8);
    SsvTree m_tree = buildSsvTree(m_mesh);
    fs::path m_file = m_folder.path() / "torus.ssv";

    auto loading()
    {
        return [this] { (void)loadSsvTree(m_mesh, m_file); };
    }
};

TEST_F(SsvTreeFile, LoadsWhatWasSaved)
{
    for (const TriangleMesh& mesh : {m_mesh, makeTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})})
    {
        const SsvTree tree = buildSsvTree(mesh);
        saveSsvTree(tree, m_file);
        expectSame(loadSsvTree(mesh, m_file), tree);
    }
}

TEST_F(SsvTreeFile, ARefittedTreeIsSavedForItsNewVertices)
{
    TriangleMesh moved = m_mesh;
    for (Eigen::Vector3d& vertex : moved.vertices)
    {
        vertex = vertex.cwiseProduct(Eigen::Vector3d(1.0, 2.0, 0.5)) + Eigen::Vector3d(5, 6, 7);
    }
    m_tree.refit(moved.vertices);
    saveSsvTree(m_tree, m_file);
    expectSame(loadSsvTree(moved, m_file), m_tree);
    EXPECT_THAT(loading(), ThrowsMessage<std::runtime_error>(HasSubstr("another mesh")));
}

TEST_F(SsvTreeFile, SaysWhatIsWrong)
{
    EXPECT_THAT(loading(), ThrowsMessage<std::runtime_error>(HasSubstr("cannot be read")));
    EXPECT_THAT(loading(), ThrowsMessage<std::runtime_error>(HasSubstr("torus.ssv")));
    m_folder.write("torus.ssv", "solid torus\n");
    EXPECT_THAT(loading(), ThrowsMessage<std::runtime_error>(HasSubstr("not a hierarchy")));
    EXPECT_THAT([&] { saveSsvTree(m_tree, m_folder.path() / "absent" / "torus.ssv"); },
                ThrowsMessage<std::runtime_error>(HasSubstr("cannot be written")));

    saveSsvTree(m_tree, m_file);
    const std::string good = readAll(m_file);
    std::string other = good;
    other[8] = 99;  // the version
    m_folder.write("torus.ssv", other);
    EXPECT_THAT(loading(), ThrowsMessage<std::runtime_error>(HasSubstr("version 99")));
    other = good;
    other[12] = 4;  // the volumes: balls, which an earlier library could write
    m_folder.write("torus.ssv", other);
    EXPECT_THAT(loading(), ThrowsMessage<std::runtime_error>(HasSubstr("volumes")));
    m_folder.write("torus.ssv", good + "x");
    EXPECT_THAT(loading(), ThrowsMessage<std::runtime_error>(HasSubstr("size is wrong")));

    m_folder.write("torus.ssv", good);
    EXPECT_NO_THROW(loading()());
    TriangleMesh changed = m_mesh;
    changed.vertices[7].y() = std::nextafter(changed.vertices[7].y(), 9.0);
    EXPECT_THAT([&] { (void)loadSsvTree(changed, m_file); },
                ThrowsMessage<std::runtime_error>(HasSubstr("another mesh")));
    changed = m_mesh;
    std::swap(changed.triangles[3], changed.triangles[4]);
    EXPECT_THAT([&] { (void)loadSsvTree(changed, m_file); },
                ThrowsMessage<std::runtime_error>(HasSubstr("another mesh")));
    EXPECT_THROW((void)loadSsvTree({}, m_file), std::invalid_argument);
}

TEST_F(SsvTreeFile, NoticesEveryTruncationAndEveryChangedByte)
{
    saveSsvTree(m_tree, m_file);
    const std::string good = readAll(m_file);
    Random random(1);
    for (int i = 0; i < 300; ++i)
    {
        const int place = i < 64 ? i : random.integer(0, static_cast<int>(good.size()) - 1);
        m_folder.write("torus.ssv", good.substr(0, static_cast<std::size_t>(place)));
        EXPECT_THROW(loading()(), std::runtime_error) << "cut at " << place;
        std::string damaged = good;
        damaged[static_cast<std::size_t>(place)] ^= static_cast<char>(random.integer(1, 255));
        m_folder.write("torus.ssv", damaged);
        EXPECT_THROW(loading()(), std::runtime_error) << "changed at " << place;
    }
}

TEST_F(SsvTreeFile, TheFolderFillsItselfAndReplacesDamagedFiles)
{
    const fs::path folder = m_folder.path() / "cache" / "deep";
    const fs::path file = folder / ssvTreeFileName(m_mesh);
    expectSame(loadOrBuildSsvTree(m_mesh, folder), m_tree);
    const std::string good = readAll(file);
    EXPECT_FALSE(good.empty());
    expectSame(loadOrBuildSsvTree(m_mesh, folder), m_tree);

    std::ofstream(file, std::ios::binary) << good.substr(0, good.size() / 2);
    expectSame(loadOrBuildSsvTree(m_mesh, folder), m_tree);
    EXPECT_EQ(readAll(file), good);
    EXPECT_THROW((void)loadOrBuildSsvTree({}, folder), std::invalid_argument);

    EXPECT_NE(ssvTreeFileName(m_mesh), ssvTreeFileName(makeTorus(1.0, 0.3, 8, 12)));
}

TEST_F(SsvTreeFile, WithoutAPlaceToWriteTheTreeIsBuiltAllTheSame)
{
    const fs::path blocked = m_folder.write("blocked", "a file, not a folder");
    expectSame(loadOrBuildSsvTree(m_mesh, blocked), m_tree);
}

TEST_F(SsvTreeFile, WritersAndReadersAtTheSameTimeSeeWholeFiles)
{
    const fs::path folder = m_folder.path() / "shared";
    std::vector<std::thread> threads;
    std::vector<int> right(4, 0);
    for (std::size_t i = 0; i < right.size(); ++i)
    {
        threads.emplace_back(
            [&, i]
            {
                for (int round = 0; round < 20; ++round)
                {
                    saveSsvTree(m_tree, m_file);
                    const SsvTree tree = loadSsvTree(m_mesh, m_file);
                    right[i] += tree.nodes().size() == m_tree.nodes().size() ? 1 : 0;
                }
            });
    }
    for (std::thread& thread : threads)
    {
        thread.join();
    }
    EXPECT_THAT(right, testing::Each(20));
    EXPECT_EQ(std::distance(fs::directory_iterator(m_folder.path()), fs::directory_iterator()), 1);
}
}  // namespace
}  // namespace bullet_ccd::tests
