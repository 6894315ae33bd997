#include "bullet_ccd/toi/rigid_toi.h"

#include <array>

namespace bullet_ccd
{
MovingBody movingBody(const RigidBody& body)
{
    MovingBody moving{.tree = body.tree, .motion = body.motion};
    if (body.userMotion != nullptr)
    {
        moving.motion = body.userMotion;
    }
    return moving;
}

ToiResult rigidToi(const RigidBody& bodyA,
                   const RigidBody& bodyB,
                   const ToiOptions& options,
                   ToiWorkspace& work)
{
    const std::array<MovingBody, 2> bodies{movingBody(bodyA), movingBody(bodyB)};
    constexpr std::array<BodyPair, 1> kPair{BodyPair{.bodyA = 0, .bodyB = 1}};
    return firstContact(bodies, kPair, options, work);
}
}  // namespace bullet_ccd
