/// Hierarchies on disk, so that a large mesh is ready in milliseconds.
///
/// A file holds the nodes and the order of the triangles, but not the mesh. The caller gives the
/// mesh when the file is loaded, and its content hash says whether the file belongs to it. Numbers
/// are little-endian; the .cpp describes the layout. A file is accepted only if magic, version,
/// volumes, mesh, sizes and checksum are right, and if its indices describe a tree over exactly the
/// triangles of the mesh. So no file can make a query read out of bounds.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <filesystem>

namespace bullet_ccd
{
/// Writes a temporary file beside `path` and renames it.
///
/// Guarantee: whoever reads or writes the same file at the same time sees a complete one.
/// Throws std::runtime_error "<path>: <what>: <remedy>".
BULLET_CCD_API void saveSsvTree(const SsvTree& tree, const std::filesystem::path& path);

/// Loads the hierarchy of `mesh`.
///
/// Guarantee: the result has the same bits that buildSsvTree(mesh) gave where it was saved.
/// Throws std::runtime_error "<path>: <what>: <remedy>" for a file that is missing, truncated,
/// damaged, no hierarchy, or of another version, mesh or kind of volumes. Throws
/// std::invalid_argument for a mesh that buildSsvTree() would refuse.
[[nodiscard]] BULLET_CCD_API SsvTree loadSsvTree(TriangleMesh mesh,
                                                 const std::filesystem::path& path);

/// Name of the file that loadOrBuildSsvTree() keeps for a mesh. It depends on the content of the
/// mesh.
[[nodiscard]] BULLET_CCD_API std::filesystem::path ssvTreeFileName(const TriangleMesh& mesh);

/// Loads the hierarchy from the folder if a right file is there; otherwise builds and saves it. The
/// folder is made if it does not exist. If it cannot be written, the hierarchy is not saved, and
/// that is no error.
/// Throws std::invalid_argument as buildSsvTree() does.
[[nodiscard]] BULLET_CCD_API SsvTree loadOrBuildSsvTree(TriangleMesh mesh,
                                                        const std::filesystem::path& cacheFolder);
}  // namespace bullet_ccd
