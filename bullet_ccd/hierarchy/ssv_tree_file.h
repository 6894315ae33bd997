/// Hierarchies on disk, so that a large mesh is ready in milliseconds.
///
/// A file holds the nodes and the order of the triangles, not the mesh: that is given when it is
/// loaded, and its content hash says whether the file is about it. Little-endian; layout in the
/// .cpp. A file is taken only if magic, version, options, mesh, sizes and checksum are right, and
/// if its indices describe a tree over exactly the triangles of the mesh, so that no file can make
/// a query read out of bounds.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <filesystem>

namespace bullet_ccd
{
/// Writes the file by renaming a complete temporary one beside it: who reads at the same time, or
/// writes the same, sees a whole file. Throws std::runtime_error "<path>: <what>: <remedy>".
BULLET_CCD_API void saveSsvTree(const SsvTree& tree, const std::filesystem::path& path);

/// The hierarchy of `mesh`, the same bits as buildSsvTree(mesh, options) gave where it was saved.
/// Throws std::runtime_error "<path>: <what>: <remedy>" for a file that is missing, truncated,
/// damaged, not a hierarchy, of another version, mesh or options; std::invalid_argument for a mesh
/// that buildSsvTree() would refuse.
[[nodiscard]] BULLET_CCD_API SsvTree loadSsvTree(TriangleMesh mesh,
                                                 const SsvOptions& options,
                                                 const std::filesystem::path& path);

/// Name of the file that loadOrBuildSsvTree() keeps for a mesh: by its content and the options.
[[nodiscard]] BULLET_CCD_API std::filesystem::path ssvTreeFileName(const TriangleMesh& mesh,
                                                                   const SsvOptions& options);

/// Loads the hierarchy from the folder if it is there and right, else builds and saves it; the
/// folder is made. A folder that cannot be written costs the saving only.
/// Throws std::invalid_argument as buildSsvTree() does.
[[nodiscard]] BULLET_CCD_API SsvTree loadOrBuildSsvTree(TriangleMesh mesh,
                                                        const SsvOptions& options,
                                                        const std::filesystem::path& cacheFolder);
}  // namespace bullet_ccd
