#include "benchmarks/reference/bullet/day_parts.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>
#include <BulletDynamics/ConstraintSolver/btSliderConstraint.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace bullet_ccd::reference
{
using namespace day;
namespace
{
DayUnderWay pile(Scene& scene, bool ours, bool meshes, bool meshFloor)
{
    addFloor(scene, 0.01, ours && meshFloor);
    Bodies bodies;
    for (int i = 0; i < 40; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.1), ours && meshes && i % 2 == 0);
        const btVector3 place = vec(0.22 * (i % 3), 0.22 * (i / 3 % 3), 0.2 + 0.25 * (i / 9));
        bodies.push_back(put(scene, cube, 1, place, vec(0, 0, -10)));
    }
    return {.wrong = count(bodies, isBelow)};
}

/// Cubes above each other; the upper ones are faster.
DayUnderWay column(Scene& scene, bool ours, int cubes, double speed)
{
    addFloor(scene, 0.1);
    btCollisionShape* cube = solid(scene, cubic(0.1), ours);
    Bodies bodies;
    for (int i = 0; i < cubes; ++i)
    {
        const btVector3 place = vec(0.5 * (i % std::max(cubes / 5, 1)), 0, 3 + 0.3 * i);
        bodies.push_back(put(scene, cube, 1, place, vec(0, 0, -speed * i)));
    }
    return {.wrong = count(bodies, isLost)};
}

/// Cubes that are put into each other by a tenth of their size, just above the floor.
DayUnderWay heap(Scene& scene, bool ours, int cubes)
{
    addFloor(scene, 1.0);
    Bodies bodies;
    for (int i = 0; i < cubes; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.1), ours && i % 2 == 0);
        const btVector3 place = vec(0.18 * (i % 5), 0.18 * (i / 5 % 5), 0.11 + 0.18 * (i / 25));
        bodies.push_back(put(scene, cube, 1, place));
    }
    return {.wrong = count(bodies, isBelow)};
}

/// Cubes that are put into the floor, this deep.
DayUnderWay spawned(Scene& scene, bool ours, bool meshFloor)
{
    addFloor(scene, 1.0, ours && meshFloor);
    Bodies bodies;
    for (const double depth : {0.0002, 0.001, 0.003, 0.01, 0.03})
    {
        const double x = double(bodies.size());
        btCollisionShape* cube = solid(scene, cubic(0.2), ours);
        bodies.push_back(put(scene, cube, 1, vec(x, 0, 0.2 - depth)));
    }
    return {.wrong = count(bodies,
                           [](btRigidBody& b) { return !(std::abs(heightOf(b) - 0.2) < 0.003); })};
}

/// A heavy cube that falls on a light one.
DayUnderWay heavyOnLight(Scene& scene, bool ours, double ratio)
{
    addFloor(scene, 0.1, ours);
    btRigidBody* light = put(scene, solid(scene, cubic(0.1), ours), 1, vec(0, 0, 0.1));
    btRigidBody* heavy =
        put(scene, solid(scene, cubic(0.3), ours), ratio, vec(0, 0, 6), vec(0, 0, -60));
    return {.wrong = count({light, heavy}, isBelow)};
}

DayUnderWay lift(Scene& scene, bool ours, bool mesh, double speed, double ceiling)
{
    scene.world().setGravity(vec(0, 0, -10));
    btRigidBody* deck = mover(scene, scene.box(vec(2, 2, 0.1)), vec(0, 0, -0.1));
    put(scene, scene.box(vec(2, 2, 0.1)), 0, vec(0, 0, ceiling + 0.1));
    Bodies bodies;
    for (int i = 0; i < 5; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.2), ours && mesh);
        bodies.push_back(put(scene, cube, 1, vec(-1 + 0.5 * i, 0, 0.201)));
    }
    const auto before = [=](int step)
    {
        const double height = std::min(ceiling - 0.05, speed * kDayStep * step);
        deck->setWorldTransform(poseAt(vec(0, 0, height - 0.1)));
    };
    const auto isOut = [=](btRigidBody& body)
    { return !(heightOf(body) > heightOf(*deck)) || heightOf(body) > ceiling + 0.2; };
    return {before, count(bodies, isOut)};
}

/// A deck that goes up and down with its cargo.
DayUnderWay elevator(Scene& scene, bool ours)
{
    scene.world().setGravity(vec(0, 0, -10));
    btRigidBody* deck = mover(scene, solid(scene, vec(2, 2, 0.1), ours), vec(0, 0, -0.1));
    Bodies bodies;
    for (int i = 0; i < 6; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.2), ours && i % 2 == 0);
        bodies.push_back(put(scene, cube, 1, vec(-1.2 + 0.5 * i, 0, 0.21)));
    }
    const auto before = [=](int step)
    { deck->setWorldTransform(poseAt(vec(0, 0, 2 * std::sin(1.5 * kDayStep * step) - 0.1))); };
    return {before,
            count(bodies,
                  [=](btRigidBody& b)
                  { return !(std::abs(heightOf(b) - heightOf(*deck) - 0.3) < 0.1); })};
}

DayUnderWay bat(Scene& scene, bool ours, double rate, bool setsInterpolation)
{
    btRigidBody* blade = mover(scene, solid(scene, vec(1, 0.01, 0.2), ours), vec(0, 0, 0));
    Bodies bodies;
    for (int i = 0; i < 8; ++i)
    {
        const btVector3 place = poseAt(vec(0, 0, 0), 0.5 + 0.3 * i) * vec(0.8, 0, 0);
        bodies.push_back(put(scene, ball(scene, 0.05), 1, place));
    }
    const auto before = [=](int step)
    {
        blade->setWorldTransform(poseAt(vec(0, 0, 0), rate * kDayStep * step));
        if (setsInterpolation)
        {
            blade->setInterpolationWorldTransform(blade->getWorldTransform());
        }
    };
    return {before, count(bodies, [](btRigidBody& b) { return speedOf(b) < 0.1; })};
}

DayUnderWay press(Scene& scene, bool ours)
{
    put(scene, scene.box(vec(2, 2, 0.1)), 0, vec(0, 0, -0.1));
    btRigidBody* plate = mover(scene, solid(scene, vec(2, 2, 0.1), ours), vec(0, 0, 1));
    Bodies bodies;
    for (int i = 0; i < 5; ++i)
    {
        bodies.push_back(put(scene, solid(scene, cubic(0.1), ours), 1, vec(0.4 * i - 1, 0, 0.11)));
    }
    const auto before = [=](int step)
    { plate->setWorldTransform(poseAt(vec(0, 0, std::max(0.32, 1 - 0.05 * step)))); };
    return {before, count(bodies, [](btRigidBody& b) { return isBelow(b) || heightOf(b) > 0.4; })};
}

/// A platform that is put elsewhere, with a ball beyond its new place.
DayUnderWay teleport(Scene& scene, bool ours)
{
    addFloor(scene, 1.0);
    btRigidBody* deck = mover(scene, solid(scene, vec(1, 1, 0.2), ours), vec(-15, 0, 0.5));
    btRigidBody* rests = put(scene, ball(scene, 0.5), 1, vec(15, 0, 0.5));
    const auto before = [=](int step)
    { deck->setWorldTransform(poseAt(vec(step < 30 ? -15 : 10, 0, 0.5))); };
    return {before, count({rests}, [](btRigidBody& b) { return speedOf(b) > 0.1; })};
}

enum class Held
{
    Free,
    Slider,
    Motor,
};
/// Something light between a wall and a block that moves on.
DayUnderWay rattle(Scene& scene, bool /*ours*/, Held held)
{
    btRigidBody* block = put(scene, scene.box(cubic(0.2)), 1, vec(1, 0, 0), vec(2, 0, 0));
    block->setActivationState(DISABLE_DEACTIVATION);
    put(scene, scene.box(vec(0.1, 1, 1)), 0, vec(6, 0, 0))->setRestitution(1);
    put(scene, ball(scene, 0.02), 1e-4, vec(3, 0, 0), vec(60, 0, 0))->setRestitution(1);
    if (held != Held::Free)
    {
        auto slider =
            std::make_unique<btSliderConstraint>(*block, btTransform::getIdentity(), true);
        slider->setLowerLinLimit(-9);
        slider->setUpperLinLimit(9);
        slider->setPoweredLinMotor(held == Held::Motor);
        slider->setTargetLinMotorVelocity(-2);  // of the world as seen from the block
        slider->setMaxLinMotorForce(5);
        scene.addConstraint(std::move(slider));
    }
    return {.wrong = count({block}, [](btRigidBody& b) { return !(speedOf(b) > 1.5); })};
}

/// A rod that is shot at a wall of 1 mm far from the origin, turning.
DayUnderWay shotFarAway(Scene& scene, bool /*ours*/)
{
    constexpr double kFar = 1e3;
    put(scene, scene.box(vec(0.0005, 2, 2)), 0, vec(kFar + 1, 0, 0));
    btCollisionShape* rod = scene.box(vec(0.3, 0.005, 0.005));
    btRigidBody* body = put(scene, rod, 1, vec(kFar, 0, 0), vec(80, 3, 1));
    body->setAngularVelocity(vec(5, 9, 40));
    return {.wrong = count({body}, [](btRigidBody& b) { return at(b).x() > btScalar(kFar + 1); })};
}

DayUnderWay joinedCapsules(Scene& scene, bool /*ours*/, bool collide)
{
    put(scene, scene.box(vec(0.005, 3, 3)), 0, vec(2, 0, 0));
    Bodies bodies;
    for (int i = 0; i < 6; ++i)
    {
        auto limb = std::make_unique<btCapsuleShape>(btScalar(0.05), btScalar(0.3));
        const btVector3 place = vec(0, 0.2 * i, 0.45 * i);
        bodies.push_back(put(scene, scene.keep(std::move(limb)), 1, place, vec(90, 0, 0)));
        if (i > 0)
        {
            btRigidBody& former = *bodies[std::size_t(i) - 1];
            scene.addConstraint(std::make_unique<btPoint2PointConstraint>(
                                    former, *bodies.back(), vec(0, 0.1, 0.22), vec(0, -0.1, -0.22)),
                                collide);
        }
    }
    return {.wrong = count(bodies, [](btRigidBody& b) { return at(b).x() > btScalar(2); })};
}

/// Boxes that come down on hills.
DayUnderWay landing(Scene& scene, bool ours)
{
    const auto hills = [](int x, int y) { return 0.3 * std::sin(0.7 * x) * std::cos(0.5 * y); };
    scene.world().setGravity(vec(0, 0, -10));
    put(scene, scene.heightField(32, hills), 0, vec(0, 0, 0));
    Bodies bodies;
    for (int i = 0; i < 9; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.1), ours && i % 2 == 0);
        const btVector3 place = vec(2 * (i % 3) - 2, 2 * (i / 3) - 2, 3);
        bodies.push_back(put(scene, cube, 1, place, vec(3, 1, -100)));
    }
    return {.wrong = count(bodies,
                           [](btRigidBody& b) {
                               return !(heightOf(b) > -0.5) &&
                                      std::max(std::abs(at(b).x()), std::abs(at(b).y())) < 15;
                           })};
}

/// What programs do to a body while it lives, and then shoot it at a thin floor.
DayUnderWay changed(Scene& scene, bool ours, int what)
{
    put(scene, scene.box(vec(5, 5, 0.005)), 0, vec(0, 0, 0));
    const auto keepCompound = [&] { return scene.keep(std::make_unique<btCompoundShape>()); };
    btCompoundShape* pair = keepCompound();
    btCompoundShape* three = keepCompound();
    btConvexHullShape* hull = scene.keep(std::make_unique<btConvexHullShape>());
    for (int i = 0; i < 8; ++i)
    {
        hull->addPoint(vec(i & 1 ? .1 : -.1, i & 2 ? .1 : -.1, i & 4 ? .1 : -.1));
    }
    btCollisionShape* cube = solid(scene, cubic(0.1), ours);
    pair->addChildShape(poseAt(vec(0, 0, 0)), scene.box(cubic(0.1)));
    pair->addChildShape(poseAt(vec(0.5, 0, 0)), hull);
    three->addChildShape(poseAt(vec(0.1, 0, 0)), scene.box(cubic(0.1)));
    three->addChildShape(poseAt(vec(-0.1, 0, 0)), pair);
    const std::array<btCollisionShape*, 8> shapes{cube, cube, hull, pair, pair, pair, three, pair};
    btRigidBody* body = put(scene, shapes[std::size_t(what)], 1, vec(0, 0, 2));
    const auto change = [=]
    {
        switch (what)
        {
            case 0:
                return cube->setLocalScaling(vec(0.2, 1.5, 0.1));
            case 1:
                return cube->setMargin(btScalar(0.01));
            case 2:
                return hull->addPoint(vec(0, 0, 0.5));
            case 3:
                return pair->addChildShape(poseAt(vec(0, 0.5, 0)), hull);
            case 4:
                return pair->updateChildTransform(1, poseAt(vec(-0.5, 0.2, 0)));
            case 5:
                return pair->removeChildShapeByIndex(0);
            case 6:
                return pair->removeChildShape(hull);
            default:
                return body->setMassProps(btScalar(5), vec(1, 1, 1));
        }
    };
    const auto before = [=](int step)
    {
        if (step % 5 != 0)
        {
            return;
        }
        if (step == 10)
        {
            change();
        }
        body->setWorldTransform(poseAt(vec(0, 0, 2)));
        body->setLinearVelocity(vec(0, 0, -300));
        body->setAngularVelocity(vec(3, 2, 1));
        body->activate();
    };
    return {before, count({body}, [](btRigidBody& b) { return !(heightOf(b) > 0); })};
}

}  // namespace

std::vector<Day> days()
{
    std::vector<Day> all{
        {"boxes on a thin box", "through", 180, with(pile, false, false)},
        {"boxes on a thin mesh", "through", 180, with(pile, false, true)},
        {"boxes and meshes on it", "through", 180, with(pile, true, true)},
        {"column of four", "lost", 300, with(column, 4, 5)},
        {"forty, to 39 m/s", "lost", 300, with(column, 40, 1)},
        {"forty, to 195 m/s", "lost", 300, with(column, 40, 5)},
        {"forty, to 780 m/s", "lost", 300, with(column, 40, 20)},
        {"a hundred in each other", "through", 120, with(heap, 100)},
        {"put into a box", "not out", 180, with(spawned, false)},
        {"put into a mesh", "not out", 180, with(spawned, true)},
        {"100 kg on 1 kg", "through", 120, with(heavyOnLight, 1e2)},
        {"1,000 kg on 1 kg", "through", 120, with(heavyOnLight, 1e3)},
        {"lift with boxes", "lost", 200, with(lift, false, 1, 9)},
        {"lift with meshes", "lost", 200, with(lift, true, 1, 9)},
        {"lift into a ceiling", "outside", 240, with(lift, false, 3, 2.9)},
        {"up and down", "lost", 600, with(elevator)},
        {"bat at 5 rad/s", "missed", 60, with(bat, 5, false)},
        {"bat at 50 rad/s", "missed", 12, with(bat, 50, false)},
        {"bat that sets all", "missed", 12, with(bat, 50, true)},
        {"press", "lost", 90, with(press)},
        {"platform put elsewhere", "thrown", 60, with(teleport)},
        {"rattle", "stopped", 60, with(rattle, Held::Free)},
        {"rattle on a slider", "stopped", 60, with(rattle, Held::Slider)},
        {"rattle with a motor", "stopped", 60, with(rattle, Held::Motor)},
        {"1 km from the origin", "through", 10, with(shotFarAway)},
        {"joined capsules", "through", 60, with(joinedCapsules, false)},
        {"the same, colliding", "through", 60, with(joinedCapsules, true)},
        {"landing on hills", "through", 60, with(landing)},
        {"scaled", "through", 15, with(changed, 0)},
        {"another margin", "through", 15, with(changed, 1)},
        {"point added", "through", 15, with(changed, 2)},
        {"child added", "through", 15, with(changed, 3)},
        {"child moved", "through", 15, with(changed, 4)},
        {"child removed", "through", 15, with(changed, 5)},
        {"grandchild removed", "through", 15, with(changed, 6)},
        {"mass changed", "through", 15, with(changed, 7)},
    };
    for (const std::vector<Day>& more : {daysOfShots(), daysOfFeatures(), daysOfMachines()})
    {
        all.insert(all.end(), more.begin(), more.end());
    }
    return all;
}

int play(const Day& day, Kind kind, const std::function<void(Scene&, double)>& step)
{
    Scene scene(kind, day.worldClass);
    const DayUnderWay underWay = day.begin(scene, isOurs(kind));
    scene.addHooks();
    for (int i = 0; i < day.steps; ++i)
    {
        underWay.before(i);
        step(scene, day.seconds);
    }
    return underWay.wrong();
}
}  // namespace bullet_ccd::reference
