// Files that take long to read: 250 MiB, and 50 MiB six times at once.
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/reader_process.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/io/mesh_texts.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace bullet_ccd
{
namespace
{
using tests::TempFolder;

TEST(LargeFiles, FiveMillionTrianglesAreReadWhole)
{
    const TempFolder folder;
    const TriangleMesh sphere = makeSphere(1.0, 9);
    const MeshFile file = loadMeshFile(folder.write("sphere.stl", tests::stlBinary(sphere)));
    EXPECT_EQ(file.mesh.triangles.size(), sphere.triangles.size());
}

TEST(LargeFiles, SixReadsOfAMillionTrianglesAtATime)
{
    const TempFolder folder;
    const TriangleMesh sphere = makeSphere(1.0, 8);
    const std::filesystem::path path = folder.write("sphere.stl", tests::stlBinary(sphere));
    std::atomic<int> right = 0;
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < 6; ++i)
        {
            threads.emplace_back(
                [&]
                { right += readInProcess(path).polygonEnds.size() == sphere.triangles.size(); });
        }
    }
    EXPECT_EQ(right, 6);
}
}  // namespace
}  // namespace bullet_ccd
