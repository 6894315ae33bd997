/// Soft bodies as surfaces.
#ifndef BT_CCD_SOFT_SURFACE_H
#define BT_CCD_SOFT_SURFACE_H

#include "bullet_ccd/bullet/soft/btCcdSoftPart.h"

#include <BulletSoftBody/btSoftBody.h>

#include <cstdint>
#include <unordered_map>

/// The surface of a soft body where it is now: its faces; of tetrahedra without faces their
/// boundary; nodes inside of tetrahedra as points, so that nothing is squeezed out of its own
/// surface; links with a node that is on none of these (ropes) as triangles that are edges.
[[nodiscard]] bullet_ccd::TriangleMesh btCcdSoftMesh(const btSoftBody& body);

/// Surfaces of soft bodies, kept from step to step.
class btCcdSoftSurfaces
{
public:
    /// The body on its way through the step, as Bullet is going to integrate it. Null if it has no
    /// surface, or a node is not finite (then a message is printed once).
    btCcdSoftPart* find(btSoftBody& body, btScalar timeStep);
    /// Drops the surfaces of bodies that were not asked for since the last call.
    void endRound();

private:
    struct Entry
    {
        btCcdSoftPart m_part;
        std::vector<std::int32_t> m_topology;  ///< that the surface was built from
        bool m_used = false;
        bool m_warned = false;
    };
    std::unordered_map<const btSoftBody*, Entry> m_entries;
    std::vector<std::int32_t> m_topology;  ///< scratch
};

/// Where Bullet is going to put the node.
[[nodiscard]] btVector3 btCcdNextPlace(const btSoftBody& body,
                                       const btSoftBody::Node& node,
                                       btScalar timeStep);

#endif  // BT_CCD_SOFT_SURFACE_H
