#include "tools/ccd_cli/files/mesh_pair.h"

#include "bullet_ccd/io/mesh_file.h"
#include "tools/support/stopwatch.h"

#include <cstdio>
#include <fmt/format.h>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

std::shared_ptr<const SsvTree> loadTree(const fs::path& path, BuildTree make, MeshPair& times)
{
    const Stopwatch load;
    MeshFile file = loadMeshFile(path);
    times.loadSeconds += load.seconds();
    // The notes of the file also ask whether it is in millimetres; here units are the user's.
    if (file.repair.degenerateTriangles + file.repair.duplicateTriangles > 0)
    {
        fmt::print(stderr, "bullet-ccd: {}: {}\n", path.string(), file.repair.summary());
    }
    const Stopwatch build;
    auto tree = std::make_shared<const SsvTree>(make(std::move(file.mesh)));
    times.buildSeconds += build.seconds();
    return tree;
}
}  // namespace

MeshPair loadMeshPair(const fs::path& fileA, const fs::path& fileB, BuildTree build)
{
    MeshPair pair;
    pair.treeA = loadTree(fileA, build, pair);
    std::error_code error;
    const bool same = fs::equivalent(fileA, fileB, error) && !error;
    pair.treeB = same ? pair.treeA : loadTree(fileB, build, pair);
    return pair;
}
}  // namespace bullet_ccd::tools
