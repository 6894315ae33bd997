/// What the days of programs are made of.
#pragma once

#include "benchmarks/reference/bullet/days.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <set>
#include <vector>

namespace bullet_ccd::reference::day
{
inline constexpr double kDayStep = 1.0 / 60.0;
using Bodies = std::vector<btRigidBody*>;

inline btVector3 at(const btRigidBody& body)
{
    return body.getWorldTransform().getOrigin();
}
inline double heightOf(const btRigidBody& body)
{
    return double(at(body).z());
}
inline double speedOf(const btRigidBody& body)
{
    return double(body.getLinearVelocity().length());
}
inline btVector3 cubic(double half)
{
    return vec(half, half, half);
}
/// Stock Bullet has no meshes that move.
inline btCollisionShape* solid(Scene& scene, const btVector3& half, bool mesh)
{
    return mesh ? static_cast<btCollisionShape*>(scene.boxMesh(half)) : scene.box(half);
}
inline btCollisionShape* ball(Scene& scene, double radius)
{
    return scene.keep(std::make_unique<btSphereShape>(btScalar(radius)));
}
inline btRigidBody* put(Scene& scene,
                        btCollisionShape* shape,
                        double mass,
                        const btVector3& place,
                        const btVector3& velocity = {0, 0, 0})
{
    btRigidBody* body = scene.body(shape, mass, poseAt(place));
    body->setLinearVelocity(velocity);
    return body;
}
inline btRigidBody* mover(Scene& scene, btCollisionShape* shape, const btVector3& place)
{
    btRigidBody* body = put(scene, shape, 0.0, place);
    body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
    return body;
}
inline void addFloor(Scene& scene, double thickness, bool mesh = false)
{
    scene.world().setGravity(vec(0, 0, -10));
    put(scene, solid(scene, vec(20, 20, thickness / 2), mesh), 0, vec(0, 0, -thickness / 2));
}
inline std::function<int()> count(const Bodies& bodies,
                                  const std::function<bool(btRigidBody&)>& wrong)
{
    return [bodies, wrong]
    { return int(std::ranges::count_if(bodies, [&](btRigidBody* body) { return wrong(*body); })); };
}
/// Or not a number.
inline bool isBelow(btRigidBody& body)
{
    return !(heightOf(body) > -0.05) || !(at(body).length() < btScalar(1e4));
}
inline bool isLost(btRigidBody& body)
{
    return isBelow(body) || speedOf(body) > 1;
}

template <typename Make, typename... Settings>
std::function<DayUnderWay(Scene&, bool)> with(Make make, Settings... settings)
{
    return [=](Scene& scene, bool ours) { return make(scene, ours, settings...); };
}

/// Bodies that fared badly at the end, or at the beginning of any step.
inline DayUnderWay watched(
    const Bodies& bodies,
    const std::function<bool(btRigidBody&)>& wrong,
    const std::function<void(int)>& act = [](int) {})
{
    const auto seen = std::make_shared<std::set<btRigidBody*>>();
    const auto look = [=]
    {
        for (btRigidBody* body : bodies)
        {
            if (wrong(*body))
            {
                seen->insert(body);
            }
        }
    };
    return {[=](int step)
            {
                look();
                act(step);
            },
            [=]
            {
                look();
                return int(seen->size());
            }};
}

/// Each file of days has its own.
[[nodiscard]] std::vector<Day> daysOfShots();
[[nodiscard]] std::vector<Day> daysOfFeatures();
[[nodiscard]] std::vector<Day> daysOfMachines();
}  // namespace bullet_ccd::reference::day
