#include "bullet_ccd/toi/rigid_toi.h"

#include <array>

namespace bullet_ccd
{
ToiResult rigidToi(const RigidBody& bodyA,
                   const RigidBody& bodyB,
                   const ToiOptions& options,
                   ToiWorkspace& work)
{
    const std::array<MovingBody, 2> bodies{MovingBody{.tree = bodyA.tree, .motion = bodyA.motion},
                                           MovingBody{.tree = bodyB.tree, .motion = bodyB.motion}};
    constexpr std::array<BodyPair, 1> kPair{BodyPair{.bodyA = 0, .bodyB = 1}};
    return firstContact(bodies, kPair, options, work);
}
}  // namespace bullet_ccd
