#include "bullet_ccd/bullet/shapes/btCcdTiles.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/shapes/btCcdShapeContent.h"
#include "bullet_ccd/bullet/shapes/btCcdTriangles.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>

#include <algorithm>
#include <cmath>

namespace
{
/// A mesh of more triangles is converted piece by piece,
constexpr std::int64_t kLarge = 20000;
/// of about so many triangles, if it is a sheet,
constexpr double kTriangles = 128.0;
/// and so many cells of a height field to a side.
constexpr double kCells = 8.0;
/// No more pieces than these are asked at once: larger ones are taken.
constexpr std::int64_t kMostPieces = 64;
constexpr int kMostLevels = 30;
/// Around a piece [relative to its edge]: more than rounding of btScalar.
constexpr double kSlack = 1e-3;

Eigen::AlignedBox3d boxOf(const btCollisionShape& shape)
{
    btVector3 low;
    btVector3 high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    return {btCcdToEigen(low), btCcdToEigen(high)};
}

std::int64_t trianglesOf(const btStridingMeshInterface& mesh)
{
    std::int64_t count = 0;
    for (int part = 0; part < mesh.getNumSubParts(); ++part)
    {
        btCcdVisitMeshPart(
            mesh, part, [&count](const btCcdMeshPart& data) { count += data.m_triangleCount; });
    }
    return count;
}

/// Cubes that hold so many triangles where the mesh is a sheet.
Eigen::Array3d cubeOf(const btCollisionShape& shape, std::int64_t triangles)
{
    const Eigen::Array3d sizes = boxOf(shape).sizes();
    const double area = sizes.prod() / std::max(sizes.minCoeff(), 1e-12 * sizes.maxCoeff());
    const double edge = std::sqrt(area * kTriangles / double(triangles));
    return Eigen::Array3d::Constant(std::max(edge, 1e-4 * sizes.maxCoeff()));
}
}  // namespace

std::shared_ptr<btCcdTiles> btCcdTiles::of(const btCollisionShape& shape)
{
    const auto tiles = [&](const Eigen::Array3d& edge)
    {
        const auto& concave = static_cast<const btConcaveShape&>(shape);
        std::shared_ptr<btCcdTiles> made(new btCcdTiles(concave, edge));
        const bool isUsable = made->m_box.sizes().allFinite() && edge.allFinite() &&
                              made->m_box.sizes().maxCoeff() > 0.0;
        return isUsable ? made : nullptr;
    };
    const btStridingMeshInterface* mesh = nullptr;
    switch (shape.getShapeType())
    {
        case TERRAIN_SHAPE_PROXYTYPE:
        {
            const auto& terrain = static_cast<const btHeightfieldTerrainShape&>(shape);
            const btCcdHeightGrid grid = btCcdHeightGridOf(terrain);
            if (2 * std::int64_t(grid.m_width) * grid.m_length <= kLarge)
            {
                return nullptr;
            }
            // Columns: the height field does not look at heights.
            Eigen::Array3d sizes = boxOf(shape).sizes();
            const double height = sizes[terrain.getUpAxis()];
            sizes[terrain.getUpAxis()] = 0.0;
            const double side = sizes.maxCoeff();
            Eigen::Array3d edge = Eigen::Array3d::Constant(
                side * kCells / double(std::max(grid.m_width, grid.m_length)));
            edge[terrain.getUpAxis()] = 2.0 * std::max(side, height);
            return tiles(edge);
        }
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
            mesh = static_cast<const btBvhTriangleMeshShape&>(shape).getMeshInterface();
            break;
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
            mesh = static_cast<const btScaledBvhTriangleMeshShape&>(shape)
                       .getChildShape()
                       ->getMeshInterface();
            break;
        default:
            return nullptr;
    }
    const std::int64_t triangles = trianglesOf(*mesh);
    return triangles > kLarge ? tiles(cubeOf(shape, triangles)) : nullptr;
}

btCcdTiles::btCcdTiles(const btConcaveShape& shape, Eigen::Array3d edge)
    : m_shape(shape), m_box(boxOf(shape)), m_edge(std::move(edge))
{
}

/// Of the box, which must meet that of the shape.
btCcdTiles::Range btCcdTiles::rangeOf(const Eigen::AlignedBox3d& box, int level) const
{
    const Eigen::Array3d edge = m_edge * std::ldexp(1.0, level);
    const auto indexOf = [&](const Eigen::Vector3d& point) -> Eigen::Array3i
    {
        const Eigen::Array3d inside =
            point.cwiseMax(m_box.min()).cwiseMin(m_box.max()) - m_box.min();
        return (inside / edge).floor().cast<int>();
    };
    return {level, indexOf(box.min()), indexOf(box.max())};
}

std::vector<const btCcdTiles::Piece*> btCcdTiles::near(const Eigen::AlignedBox3d& box)
{
    std::vector<const Piece*> pieces;
    if (!m_box.intersects(box))
    {
        return pieces;
    }
    Range range = rangeOf(box, 0);
    while (range.count() > kMostPieces && range.m_level < kMostLevels)
    {
        range = rangeOf(box, range.m_level + 1);
    }
    for (int x = range.m_first.x(); x <= range.m_last.x(); ++x)
    {
        for (int y = range.m_first.y(); y <= range.m_last.y(); ++y)
        {
            for (int z = range.m_first.z(); z <= range.m_last.z(); ++z)
            {
                const Piece& piece = pieceAt({range.m_level, x, y, z, 1});
                if (piece.m_tree != nullptr)
                {
                    pieces.push_back(&piece);
                }
            }
        }
    }
    return pieces;
}

/// Two tiles wide, where a box of the size of a tile always fits in.
const btCcdTiles::Piece& btCcdTiles::around(const Eigen::AlignedBox3d& box)
{
    Range range = rangeOf(box, 0);
    while ((range.m_last - range.m_first).maxCoeff() > 1 && range.m_level < kMostLevels)
    {
        range = rangeOf(box, range.m_level + 1);
    }
    return pieceAt({range.m_level, range.m_first.x(), range.m_first.y(), range.m_first.z(), 2});
}

const btCcdTiles::Piece& btCcdTiles::pieceAt(const Place& place)
{
    const std::lock_guard lock(m_mutex);
    const auto [found, isNew] = m_pieces.try_emplace(place);
    Piece& piece = found->second;
    if (isNew)
    {
        const Eigen::Array3d edge = m_edge * std::ldexp(1.0, place[0]);
        const Eigen::Array3d first(place[1], place[2], place[3]);
        const Eigen::Array3d low = m_box.min().array() + (first - kSlack) * edge;
        const Eigen::Array3d high = m_box.min().array() + (first + place[4] + kSlack) * edge;
        btCcdTriangleCollector collector;
        m_shape.processAllTriangles(
            &collector, btCcdToBullet(low.matrix()), btCcdToBullet(high.matrix()));
        if (!collector.m_ids.empty())
        {
            bullet_ccd::TriangleMesh mesh = collector.m_mesh;
            bullet_ccd::repairMesh(mesh);
            piece.m_triangleIds = btCcdIdsOf(mesh, collector);
            piece.m_tree = std::make_shared<const bullet_ccd::SsvTree>(
                bullet_ccd::buildSsvTree(std::move(mesh)));
        }
    }
    return piece;
}

btCcdShapePart btCcdPieceOf(const btCcdShapePart& part, const btCcdTiles::Piece& piece)
{
    btCcdShapePart result = part;
    result.m_tiles = nullptr;
    result.m_tree = piece.m_tree;
    result.m_triangleIds = piece.m_triangleIds;
    return result;
}

btCcdBall btCcdBallOf(const btCcdShapePart& part)
{
    if (part.m_tiles != nullptr)
    {
        const Eigen::AlignedBox3d& box = part.m_tiles->box();
        return {part.X_SG * box.center(), 0.5 * box.diagonal().norm()};
    }
    return {part.X_SG * part.m_tree->origin(), part.m_tree->radius() + part.m_radius};
}

Eigen::AlignedBox3d btCcdBoxIn(const Eigen::Isometry3d& X, const Eigen::AlignedBox3d& box)
{
    const Eigen::Vector3d center = X * box.center();
    const Eigen::Vector3d half = X.linear().cwiseAbs() * (0.5 * box.sizes());
    return {center - half, center + half};
}
