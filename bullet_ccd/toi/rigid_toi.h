/// Time of impact of two rigid bodies.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/first_contact.h"

namespace bullet_ccd
{
/// A hierarchy in the body frame and the body's motion X_W(t), t in [0, 1].
struct RigidBody
{
    const SsvTree* tree = nullptr;
    RigidMotion motion{};
    const UserMotion* userMotion = nullptr;  ///< if not null, in place of `motion`
};

/// The body as firstContact() takes it.
[[nodiscard]] BULLET_CCD_API MovingBody movingBody(const RigidBody& body);

/// First time in [0, 1] at which two rigidly moving meshes come within `options.tolerance`.
///
/// Guarantee: no contact for t in [0, result.time); ToiStatus says what each outcome promises.
/// @param options tolerance [m], minimum separation [m], iteration limit
/// @param work    scratch, reusable; one per thread
/// Throws std::invalid_argument for motions that are not finite or a tolerance that is not
/// positive.
[[nodiscard]] BULLET_CCD_API ToiResult rigidToi(const RigidBody& bodyA,
                                                const RigidBody& bodyB,
                                                const ToiOptions& options,
                                                ToiWorkspace& work);
}  // namespace bullet_ccd
