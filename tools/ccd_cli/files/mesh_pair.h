/// The two bodies of a program run.
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <filesystem>
#include <memory>

namespace bullet_ccd::tools
{
/// Hierarchies of A and B; the same one if both are the same file.
struct MeshPair
{
    std::shared_ptr<const SsvTree> treeA;
    std::shared_ptr<const SsvTree> treeB;
    double loadSeconds = 0.0;   ///< reading the files
    double buildSeconds = 0.0;  ///< building the hierarchies
};

/// Makes a hierarchy of a mesh.
using BuildTree = SsvTree (*)(TriangleMesh mesh);

/// Reads and builds; what had to be repaired in a mesh is said on stderr. Throws as loadMeshFile().
[[nodiscard]] MeshPair loadMeshPair(const std::filesystem::path& fileA,
                                    const std::filesystem::path& fileB,
                                    BuildTree build = buildSsvTree);
}  // namespace bullet_ccd::tools
