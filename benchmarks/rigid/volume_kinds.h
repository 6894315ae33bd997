/// Hierarchies of other volumes than those of the library, to be compared with.
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"

namespace bullet_ccd::benchmarks
{
/// The kind of volume that the nodes of a hierarchy hold.
enum class VolumeKind : std::uint8_t
{
    RoundedBox,  ///< that of the library: box core with the ball that makes the surface smallest
    Box,         ///< oriented box, no ball
    SweptRectangle,  ///< rectangle core
    SweptLine,       ///< line segment core
    SweptPoint,      ///< ball
    Cheapest,  ///< at every node the smallest core whose surface is at most a tenth above the best
};

/// As buildSsvTree(mesh), which it is for rounded boxes.
[[nodiscard]] SsvTree buildTreeOf(VolumeKind kind, TriangleMesh mesh);
}  // namespace bullet_ccd::benchmarks
