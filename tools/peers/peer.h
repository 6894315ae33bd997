/// Other codes behind one interface: a scene in, contact and time out.
#pragma once

#include "tests/support/rigid_scene.h"

#include <optional>

namespace bullet_ccd::tests
{
struct PeerAnswer
{
    bool contact = false;
    double time = 1.0;
};

/// Fraction of the motion at which FCL's continuousCollide reports a contact: by testing
/// 1,001 poses, or by its conservative advancement. Motions are handed over as two poses and the
/// reference point, the only form that FCL takes.
[[nodiscard]] PeerAnswer fclSampling(const RigidScene& scene);
[[nodiscard]] PeerAnswer fclAdvancement(const RigidScene& scene);
[[nodiscard]] bool hasFcl();

/// Bullet's btContinuousConvexCollision, in double precision, on convex hulls with no margin.
[[nodiscard]] PeerAnswer bulletConvexCast(const RigidScene& scene);
[[nodiscard]] bool hasBullet();
}  // namespace bullet_ccd::tests
