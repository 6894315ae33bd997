/// Convex pieces in place of a mesh, for simulators that know no other solids.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <cstddef>
#include <vector>

namespace bullet_ccd
{
/// When to cut no further.
struct ConvexPiecesOptions
{
    double accuracy = 1e-3;  ///< of the bulge [m]
    std::size_t most = 128;  ///< pieces
};

/// Pieces of a body, in the frame of its mesh.
struct ConvexPieces
{
    std::vector<TriangleMesh> pieces;  ///< closed and wound outwards
    /// How far it is from the surface, along its outward normals, to where the piece or the empty
    /// space ends, at the most [m]: how thick what the pieces fill is. Looked at from four points
    /// of each triangle, of 150 triangles or more of each piece. It is larger than options.accuracy
    /// only if there are options.most pieces. Hollows inside a solid count, too.
    double bulge = 0.0;
};

/// Cuts the surface by planes, and takes the convex hull of what is between them.
///
/// Guarantee: the pieces contain all of the surface and have no inside in common, up to rounding;
/// parts in a plane get a thickness of a tenth of the accuracy. What is deep inside a solid may be
/// in no piece. The mesh may be a soup; its triangles should be wound outwards. The result is
/// deterministic.
/// How: of the parts that bulge too much, the one that fills most of the empty space in front of
/// its surface is cut in two across its longest axis, until none is left or there are enough.
/// Throws std::invalid_argument for a mesh that checkMesh() refuses, an accuracy that is not
/// positive, or no pieces.
[[nodiscard]] BULLET_CCD_API ConvexPieces convexPieces(const TriangleMesh& mesh,
                                                       const ConvexPiecesOptions& options);
}  // namespace bullet_ccd
