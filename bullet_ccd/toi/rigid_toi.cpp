#include "bullet_ccd/toi/rigid_toi.h"

#include "bullet_ccd/distance/tree_distance.h"

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

namespace
{
/// True if the bodies are within the tolerance at t = 0.
bool startTouches(const std::array<MovingBody, 2>& bodies, const ToiOptions& options)
{
    const Eigen::Isometry3d X_BA =
        geometryPoseAt(bodies[1], 0.0).inverse() * geometryPoseAt(bodies[0], 0.0);
    const double reach = options.minimumSeparation + options.tolerance;
    return treeDistance(*bodies[0].tree, *bodies[1].tree, X_BA, reach).triangleA != kNone;
}
}  // namespace

ToiResult rigidToi(const RigidBody& bodyA,
                   const RigidBody& bodyB,
                   const ToiOptions& options,
                   ToiWorkspace& work)
{
    const std::array<MovingBody, 2> bodies{movingBody(bodyA), movingBody(bodyB)};
    constexpr std::array<BodyPair, 1> kPair{BodyPair{.bodyA = 0, .bodyB = 1}};
    FirstContactResult result = firstContact(bodies, kPair, options, work);
    if (result.status == ToiStatus::Separated &&
        (result.startsTouching || (result.mayStartTouching && startTouches(bodies, options))))
    {
        result.status = ToiStatus::TouchingLeaving;
    }
    else if (result.startsPressing && result.status == ToiStatus::Hit)
    {
        result.status = ToiStatus::TouchingPressing;
    }
    return result;
}
}  // namespace bullet_ccd
