/// Large meshes, converted piece by piece where something comes near them.
#ifndef BT_CCD_TILES_H
#define BT_CCD_TILES_H

#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"

#include <Eigen/Geometry>

#include <array>
#include <map>
#include <mutex>

class btConcaveShape;

/// The triangles of a height field or of a stock triangle mesh, on a regular grid in the shape's
/// frame. A piece is a hierarchy over all triangles that meet its box, and some more. It is made
/// when it is asked for, and kept. The shape must stay as it is and alive while pieces are asked
/// for.
class btCcdTiles
{
public:
    struct Piece
    {
        std::shared_ptr<const bullet_ccd::SsvTree> m_tree;  ///< null: there are no triangles
        std::shared_ptr<const std::vector<btCcdTriangleId>> m_triangleIds;
    };

    /// Null if the mesh is not large enough to be worth it, or is of another kind.
    static std::shared_ptr<btCcdTiles> of(const btCollisionShape& shape);

    /// Everything that meets the box (shape frame [m]), in pieces that are not much larger. Few:
    /// the larger the box, the larger they are. The pieces live as long as this.
    [[nodiscard]] std::vector<const Piece*> near(const Eigen::AlignedBox3d& box);
    /// Everything that meets the box and has something in it, in one piece with some room around.
    [[nodiscard]] const Piece& around(const Eigen::AlignedBox3d& box);
    [[nodiscard]] const Eigen::AlignedBox3d& box() const { return m_box; }
    /// For drawing: what has been made so far.
    template <typename Visit>
    void forPieces(const Visit& visit) const
    {
        for (const auto& [place, piece] : m_pieces)
        {
            if (piece.m_tree != nullptr)
            {
                visit(piece);
            }
        }
    }

private:
    /// Level, three indices, and how many tiles wide it is.
    using Place = std::array<int, 5>;
    struct Range
    {
        int m_level = 0;
        Eigen::Array3i m_first;
        Eigen::Array3i m_last;
        [[nodiscard]] std::int64_t count() const
        {
            return (m_last - m_first + 1).cast<std::int64_t>().prod();
        }
    };

    std::mutex m_mutex;  // of the pieces
    const btConcaveShape& m_shape;
    Eigen::AlignedBox3d m_box;  // of the shape
    Eigen::Array3d m_edge;      // of a tile at level 0; they double from level to level
    std::map<Place, Piece> m_pieces;

    btCcdTiles(const btConcaveShape& shape, Eigen::Array3d edge);
    [[nodiscard]] Range rangeOf(const Eigen::AlignedBox3d& box, int level) const;
    [[nodiscard]] const Piece& pieceAt(const Place& place);
};

/// One piece of a large mesh as a part of its own.
[[nodiscard]] btCcdShapePart btCcdPieceOf(const btCcdShapePart& part,
                                          const btCcdTiles::Piece& piece);

/// A ball that holds all of a part (shape frame).
struct btCcdBall
{
    Eigen::Vector3d m_center;
    double m_radius;
};
[[nodiscard]] btCcdBall btCcdBallOf(const btCcdShapePart& part);

/// The box about a box in another frame.
[[nodiscard]] Eigen::AlignedBox3d btCcdBoxIn(const Eigen::Isometry3d& X,
                                             const Eigen::AlignedBox3d& box);

#endif  // BT_CCD_TILES_H
