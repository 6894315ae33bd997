/// A hand as a btMultiBody with one collider a link.
#pragma once

#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/export.h"
#include "grasp/hand/hand_model.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <memory>
#include <vector>

namespace bullet_ccd::grasp
{
/// Link i of the hand is Bullet's link i - 1, the root its fixed base. A Bullet link frame is the
/// inertial frame of the link (origin at the centre of mass, principal axes), so every collider is
/// a compound that puts the link's mesh, given in the link's own frame, back in its place.
struct HandMultiBody
{
    std::unique_ptr<btMultiBody> body;
    /// Pose of the inertial frame in the link's, one entry a link.
    std::vector<Eigen::Isometry3d> X_LI;
    /// One entry a link, null without geometry.
    std::vector<std::unique_ptr<btCcdMeshShape>> meshes;
    std::vector<std::unique_ptr<btCompoundShape>> shapes;
    std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
};

/// Builds it with all joints at 0. The hierarchies are shared with `hand`, which must outlive it.
[[nodiscard]] BULLET_CCD_API HandMultiBody makeHandMultiBody(const HandModel& hand);
}  // namespace bullet_ccd::grasp
