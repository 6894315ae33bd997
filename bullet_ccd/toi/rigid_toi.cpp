#include "bullet_ccd/toi/rigid_toi.h"

#include <array>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

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
    FirstContactResult result = firstContact(bodies, kPair, options, work);
    if (result.startsTouching && result.status == ToiStatus::Separated)
    {
        result.status = ToiStatus::TouchingLeaving;
    }
    else if (result.startsPressing && result.status == ToiStatus::Hit)
    {
        result.status = ToiStatus::TouchingPressing;
    }
    return result;
}

std::vector<ToiResult> rigidTois(std::span<const RigidBodyPair> pairs, const ToiOptions& options)
{
    std::vector<ToiResult> results(pairs.size());
    tbb::enumerable_thread_specific<ToiWorkspace> workspaces;
    tbb::parallel_for(
        std::size_t{0},
        pairs.size(),
        [&](std::size_t i)
        { results[i] = rigidToi(pairs[i].bodyA, pairs[i].bodyB, options, workspaces.local()); });
    return results;
}
}  // namespace bullet_ccd
