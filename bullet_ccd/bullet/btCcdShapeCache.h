/// Hierarchies of collision shapes: shared for btCcdMeshShape, made once for stock shapes.
#ifndef BT_CCD_SHAPE_CACHE_H
#define BT_CCD_SHAPE_CACHE_H

#include "bullet_ccd/bullet/btCcdPrecision.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <BulletCollision/CollisionShapes/btCollisionShape.h>
#include <Eigen/Geometry>

#include <cstdint>
#include <unordered_map>
#include <vector>

/// A mesh that is (part of) a collision shape.
struct btCcdShapePart
{
    const bullet_ccd::SsvTree* m_tree = nullptr;
    Eigen::Isometry3d X_SG = Eigen::Isometry3d::Identity();  ///< mesh frame in the shape's
    bool m_stock = false;  ///< made from a stock shape, not a btCcdMeshShape
};

/// Converts shapes to parts. Covered: btCcdMeshShape; boxes and convex hulls (a hull exact to 1e-4
/// of its size, without its margin); spheres, capsules and cylinders as inscribed polyhedra (chord
/// error 0.1 % of the radius); triangle meshes, height fields; static planes as a square of 1 km
/// about the plane's origin; compounds of all these.
///
/// A conversion is kept while its shape is asked for in every round, and redone when the shape's
/// type, scaling or bounds change. A shape that is changed in place without changing those
/// (vertices moved inside the bounds) must be forgotten by hand.
class btCcdShapeCache
{
public:
    /// Starts a round: conversions that are not used until the next call are dropped then.
    void beginRound();
    /// Appends the parts of `shape`; false (and nothing appended) if a part of it is not covered.
    bool appendParts(const btCollisionShape* shape, std::vector<btCcdShapePart>& parts);
    void forget(const btCollisionShape* shape) { m_entries.erase(shape); }

private:
    struct Entry
    {
        bullet_ccd::SsvTree m_tree;
        int m_type;
        btVector3 m_scaling;
        btVector3 m_boundsMin;
        btVector3 m_boundsMax;
        std::int64_t m_round;
    };

    std::unordered_map<const btCollisionShape*, Entry> m_entries;
    std::int64_t m_round = 0;

    bool append(const btCollisionShape* shape,
                const Eigen::Isometry3d& X_SG,
                std::vector<btCcdShapePart>& parts);
    const bullet_ccd::SsvTree* convert(const btCollisionShape* shape);
};

#endif  // BT_CCD_SHAPE_CACHE_H
