/// What moves in a step of a deformable world, as surfaces: soft bodies, and parts of colliders.
#ifndef BT_CCD_SOFT_PART_H
#define BT_CCD_SOFT_PART_H

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseProxy.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

#include <cstdint>
#include <memory>
#include <vector>

class btSoftBody;

/// Tells an object from others that are or were in the world, maybe at the same address.
[[nodiscard]] inline int btCcdProxyId(const btCollisionObject& object)
{
    const btBroadphaseProxy* proxy = object.getBroadphaseHandle();
    return proxy != nullptr ? proxy->m_uniqueId : 0;
}

/// A surface and where its vertices are at both ends of the step. They move on straight lines.
struct btCcdSoftPart
{
    btCollisionObject* m_object = nullptr;
    btSoftBody* m_soft = nullptr;  ///< the object, if it is a soft body
    std::unique_ptr<bullet_ccd::DeformableSurface> m_surface;
    std::vector<Eigen::Vector3d> m_start;
    std::vector<Eigen::Vector3d> m_end;
    bool m_hasChanged = true;  ///< since the surface was last told of the step

    // Of soft bodies, by node.
    std::vector<double> m_inverseMass;         ///< 0: goes its way whatever it meets [1/kg]
    std::vector<Eigen::Vector3d> m_velocity;   ///< at the end of the step [m/s]
    std::vector<std::int64_t> m_bent;          ///< when the response last moved its end
    std::vector<btCollisionObject*> m_anchor;  ///< what the node hangs on; null if free
    double m_shortestEdge = 0.0;               ///< of the surface, when it was built [m]

    // Of colliders.
    std::shared_ptr<const bullet_ccd::SsvTree> m_tree;  ///< has the mesh
    Eigen::Isometry3d X_SG = Eigen::Isometry3d::Identity();
    double m_radius = 0.0;  ///< the part is all points within this distance of the surface [m]
    btTransform m_startPose;
    btTransform m_endPose;
    btTransform m_freePose;  ///< where it would have ended without soft bodies

    [[nodiscard]] bool isMovable(std::int32_t node) const
    {
        return m_soft != nullptr && m_inverseMass[std::size_t(node)] > 0.0;
    }
    /// Sets the ends of a collider's vertices.
    void setEndPose(const btTransform& pose);
    /// Tells the surface of the step.
    void refit()
    {
        if (m_hasChanged)
        {
            m_surface->setStep(m_start, m_end);
            m_hasChanged = false;
        }
        else
        {
            m_surface->keepStep();
        }
    }
};

#endif  // BT_CCD_SOFT_PART_H
