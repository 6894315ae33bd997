/// Mesh formats that assimp reads (STL, PLY, DAE, glTF and GLB), read by a program of their own.
///
/// Some broken files crash assimp's readers (wrong counts in a DAE, for instance) or keep them busy
/// for ever. They therefore run in the program `bullet_ccd_mesh_reader`, which is started for each
/// file and sends the mesh back through a pipe: what goes wrong there is an exception here. The
/// process is started by posix_spawn(), so that it does not matter how many threads the caller has.
///
/// The program is looked for under the name in the environment variable BULLET_CCD_MESH_READER;
/// else beside this library, or the program that links it, and in the folder libexec/bullet_ccd
/// beside or above that; else where the build meant to install it.
#pragma once

#include "bullet_ccd/io/polygon_soup.h"

#include <filesystem>

namespace bullet_ccd
{
/// What reading a file may cost. Time is the processor's, so it does not matter how busy the
/// machine is; and what a file may cost grows by 2 s and 64 MiB per MiB of it (and of the files it
/// refers to), several times what the slowest format needs.
struct ReaderLimits
{
    int seconds = 10;
    int mebibytes = 2048;
};

/// All meshes of all nodes, node transforms applied. POSIX.
/// Throws std::runtime_error: "<path>: <what>: <remedy>".
[[nodiscard]] PolygonSoup readInProcess(const std::filesystem::path& path,
                                        const ReaderLimits& limits = {});
}  // namespace bullet_ccd
