/// Models of collision shapes for continuous collision detection: shared for btCcdMeshShape, made
/// once for stock shapes.
#ifndef BT_CCD_SHAPE_CACHE_H
#define BT_CCD_SHAPE_CACHE_H

#include "bullet_ccd/bullet/btCcdPrecision.h"
#include "bullet_ccd/convex/convex_shape.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <BulletCollision/CollisionShapes/btCollisionShape.h>
#include <Eigen/Geometry>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

/// Part of the sum of margins that a pair with contacts of the library's own can lose.
inline constexpr double btCcdReserveOfMargin = 1.0 - 1.0 / 4.0 - 1.0 / 16.0;
/// Half of what a mesh's margin is good for belongs to whatever it meets.
inline constexpr double btCcdShareOfMargin = 0.5 * btCcdReserveOfMargin;
/// Of a plane, which has no end [m].
inline constexpr double btCcdPlaneReach = 1e6;

/// How deep the core lies in a convex shape whose planes are `inner` from its middle: half of that,
/// less than rounding can add.
constexpr double btCcdCoreDepth(double inner)
{
    return 0.5 * inner * (1.0 - 1e-9);
}

/// How Bullet names a triangle of a mesh to callbacks.
struct btCcdTriangleId
{
    int m_part = 0;
    int m_index = 0;

    friend bool operator==(const btCcdTriangleId&, const btCcdTriangleId&) = default;
};

/// True if there is nothing that could meet anything: a compound without children, or btEmptyShape.
[[nodiscard]] bool btCcdIsEmpty(const btCollisionShape& shape);

class btCcdTiles;

/// A shape without triangles, with its radius, and where it is in the mesh frame of a part.
struct btCcdExactShape
{
    bullet_ccd::ConvexShape m_shape;
    Eigen::Isometry3d X_GE = Eigen::Isometry3d::Identity();
};

/// One body of a collision shape: the points within m_radius of a mesh. A sphere is a point and a
/// radius, a capsule a segment and a radius: no tessellation.
struct btCcdShapePart
{
    std::shared_ptr<const bullet_ccd::SsvTree> m_tree;       ///< null if it comes in pieces
    Eigen::Isometry3d X_SG = Eigen::Isometry3d::Identity();  ///< mesh frame in the shape's
    double m_radius = 0.0;                                   ///< [m]
    /// What stock Bullet adds around the triangles in discrete contacts [m]: two meshes rest at the
    /// sum of their margins. 0 for convex shapes, whose margin is part of the shape.
    double m_margin = 0.0;

    /// An unbounded plane, z = 0 of the mesh frame; the mesh is a piece of it about the origin of
    /// that frame. See btCcdMeshPose().
    bool m_isPlane = false;

    /// Discrete contacts with it are this library's: a btCcdMeshShape or GImpact mesh.
    bool m_ownContacts = false;

    /// Of a large mesh; null for others.
    std::shared_ptr<btCcdTiles> m_tiles;

    /// By triangle of the hierarchy's mesh; null: part 0, and the index of the triangle.
    std::shared_ptr<const std::vector<btCcdTriangleId>> m_triangleIds;

    /// What lies deep inside a convex shape, shrunk about an inner point; null for meshes, which
    /// have no inside. Two shapes whose cores have not met are on the sides they came from.
    std::shared_ptr<const bullet_ccd::SsvTree> m_core;
    double m_coreRadius = 0.0;  ///< [m]
    double m_depth = 0.0;       ///< every point of the core is at least this far inside [m]

    /// The same two as exact shapes where the shape is simple enough: queries of these take a
    /// hundredth of the time.
    std::optional<btCcdExactShape> m_exact;
    std::optional<btCcdExactShape> m_exactCore;
};

/// Pose in the shape of the part's mesh, as something at `point_S` (shape frame) meets it. That is
/// X_SG but for a plane, whose mesh is moved within the plane to below the point: a piece as wide
/// as the world would cost the precision of what happens on a millimetre of it.
Eigen::Isometry3d btCcdMeshPose(const btCcdShapePart& part, const Eigen::Vector3d& point_S);

/// A collision shape: all of its parts (a compound has several).
struct btCcdShapeModel
{
    std::vector<btCcdShapePart> m_parts;  ///< not empty
    double m_reach = 0.0;    ///< all of the shape is within this distance of its origin [m]
    double m_depth = 0.0;    ///< smallest of the parts [m]
    bool m_hasMesh = false;  ///< some part has no inside
    /// Smallest margin of the parts with contacts of the library's own [m]; infinite without.
    double m_ownMargin = std::numeric_limits<double>::infinity();
    bool m_isOwn = false;  ///< contacts of all parts are the library's own
    /// A child of a compound, also nested, that is not covered; null if all are.
    const btCollisionShape* m_uncovered = nullptr;
    /// What the shape can lose, by motion or by sinking in, before another can pass it [m].
    double m_reserve = 0.0;
};

/// Hierarchies by content: meshes with the same vertices and triangles share one for as long as
/// somebody keeps it.
class btCcdTreeStore
{
public:
    /// Throws std::invalid_argument as buildSsvTree() does.
    std::shared_ptr<const bullet_ccd::SsvTree> tree(bullet_ccd::TriangleMesh mesh);
    void dropUnused();
    /// Large ones come from files there, and go there; empty: none.
    void keepIn(const std::filesystem::path& folder) { m_folder = folder; }
    /// Writes the file of one that is large, if there is none.
    void keep(const bullet_ccd::SsvTree& tree) const;

private:
    static constexpr std::size_t kLarge = 1000;  // triangles

    std::filesystem::path m_folder;
    std::unordered_map<std::uint64_t, std::weak_ptr<const bullet_ccd::SsvTree>> m_trees;
};

/// Converts shapes. Covered, exactly: btCcdMeshShape, boxes, spheres, multi-spheres of one radius
/// (scaled alike in all directions), capsules, convex hulls and other polyhedra with their margin,
/// triangles, triangle meshes (static, scaled, GImpact), height fields. As inscribed polyhedra
/// (chord error 0.1 % of the radius): cylinders and cones. Static planes are squares of 200 km
/// about the plane's origin. Compounds of all these, nested.
///
/// Large height fields and stock meshes are converted piece by piece (btCcdTiles).
///
/// Of a compound, the children that are covered are; what is empty needs no cover.
///
/// A model is kept while its shape is asked for now and then, and made again when what defines the
/// shape changes: type, scaling, margin, bounds, children, mesh interface, number of points, and a
/// sample of points and heights. All of the content is compared when an object with the shape comes
/// into a world (check()), so that a shape may be freed and another one made at its address. Points
/// and heights that are changed in place while the object stays must be forgotten by hand.
///
/// What convex hulls of more than 32 points and triangle meshes were converted to lately (200,000
/// triangles) is shared by all caches of the program, and outlives them.
class btCcdShapeCache
{
public:
    /// The model, or null if no part of the shape is covered. Valid until the shape changes, is
    /// forgotten, or endRound() drops it.
    const btCcdShapeModel* find(const btCollisionShape* shape);
    /// Makes the model anew if anything about the shape has changed.
    void check(const btCollisionShape* shape);
    /// Once a step: now and then drops models that were not asked for in the last kRoundsKept
    /// rounds.
    void endRound();
    /// Children of a compound too.
    void forget(const btCollisionShape* shape);
    /// See btCcdTreeStore.
    void keepIn(const std::filesystem::path& folder) { m_trees.keepIn(folder); }
    void keep(const btCcdShapeModel& model) const;

private:
    static constexpr std::int64_t kRoundsKept = 1000;

    struct Entry
    {
        btCcdShapeModel m_model;
        bool m_covered = false;
        std::uint64_t m_fingerprint = 0;
        std::uint64_t m_content = 0;
        std::int64_t m_round = 0;
    };

    std::unordered_map<const btCollisionShape*, Entry> m_entries;
    btCcdTreeStore m_trees;
    std::int64_t m_round = 1;  // 0: an entry that is not made yet

    /// Without parts if not covered.
    btCcdShapeModel convert(const btCollisionShape& shape);
};

#endif  // BT_CCD_SHAPE_CACHE_H
