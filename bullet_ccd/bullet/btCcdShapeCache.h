/// Models of collision shapes for continuous collision detection: shared for btCcdMeshShape, made
/// once for stock shapes.
#ifndef BT_CCD_SHAPE_CACHE_H
#define BT_CCD_SHAPE_CACHE_H

#include "bullet_ccd/bullet/btCcdPrecision.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <BulletCollision/CollisionShapes/btCollisionShape.h>
#include <Eigen/Geometry>

#include <cstdint>
#include <limits>
#include <memory>
#include <unordered_map>
#include <vector>

/// One body of a collision shape: the points within m_radius of a mesh. A sphere is a point and a
/// radius, a capsule a segment and a radius: no tessellation.
struct btCcdShapePart
{
    std::shared_ptr<const bullet_ccd::SsvTree> m_tree;
    Eigen::Isometry3d X_SG = Eigen::Isometry3d::Identity();  ///< mesh frame in the shape's
    double m_radius = 0.0;                                   ///< [m]
    /// What stock Bullet adds around the triangles in discrete contacts [m]: two meshes rest at the
    /// sum of their margins. 0 for convex shapes, whose margin is part of the shape.
    double m_margin = 0.0;

    /// Discrete contacts with it are this library's: a btCcdMeshShape or GImpact mesh.
    bool m_ownContacts = false;

    /// What lies deep inside a convex shape, shrunk about an inner point; null for meshes, which
    /// have no inside. Two shapes whose cores have not met are on the sides they came from.
    std::shared_ptr<const bullet_ccd::SsvTree> m_core;
    double m_coreRadius = 0.0;  ///< [m]
    double m_depth = 0.0;       ///< every point of the core is at least this far inside [m]
};

/// A collision shape: all of its parts (a compound has several).
struct btCcdShapeModel
{
    std::vector<btCcdShapePart> m_parts;  ///< not empty
    double m_reach = 0.0;  ///< all of the shape is within this distance of its origin [m]
    double m_depth = 0.0;  ///< smallest of the parts [m]
    bool m_hasMesh = false;  ///< some part has no inside
    /// Smallest margin of the parts with contacts of the library's own [m]; infinite without.
    double m_ownMargin = std::numeric_limits<double>::infinity();
    /// Motion per step that cannot take the shape past another, whichever [m]: see btCcdStepper.
    double m_reserve = 0.0;
};

/// Converts shapes. Covered, exactly: btCcdMeshShape, boxes, spheres, multi-spheres of one sphere,
/// capsules, convex hulls with their margin, triangles, triangle meshes (static, scaled, GImpact),
/// height fields. As inscribed polyhedra (chord error 0.1 % of the radius): cylinders and cones.
/// Static planes are squares of 200 km about the plane's origin. Compounds of all these, nested.
///
/// A model is kept while its shape is asked for now and then, and made again when what defines the
/// shape changes: type, scaling, bounds, points, children, mesh interface. Triangle meshes whose
/// vertices are moved in place must be forgotten by hand.
class btCcdShapeCache
{
public:
    /// The model, or null if a part of the shape is not covered. Valid until the shape changes or
    /// endRound() drops it.
    const btCcdShapeModel* find(const btCollisionShape* shape);
    /// Once a step: drops models that were not asked for in the last kRoundsKept rounds.
    void endRound();
    void forget(const btCollisionShape* shape) { m_entries.erase(shape); }

private:
    static constexpr std::int64_t kRoundsKept = 1000;

    struct Entry
    {
        btCcdShapeModel m_model;
        bool m_covered;
        std::uint64_t m_fingerprint;
        std::int64_t m_round;
    };

    std::unordered_map<const btCollisionShape*, Entry> m_entries;
    std::int64_t m_round = 0;
};

#endif  // BT_CCD_SHAPE_CACHE_H
