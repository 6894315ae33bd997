/// Things that are built of many bodies, driven or broken.
#include "benchmarks/reference/bullet/day_parts.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>
#include <BulletDynamics/ConstraintSolver/btSliderConstraint.h>
#include <BulletDynamics/Vehicle/btRaycastVehicle.h>

namespace bullet_ccd::reference::day
{
namespace
{
/// The six walls of a room about the origin.
std::vector<std::pair<btVector3, btVector3>> wallsOf(double half, double thickness)
{
    std::vector<std::pair<btVector3, btVector3>> walls;  // half size, place
    for (int axis = 0; axis < 3; ++axis)
    {
        for (const double side : {-1.0, 1.0})
        {
            btVector3 size = cubic(half + thickness);
            size[axis] = btScalar(thickness / 2);
            btVector3 place = vec(0, 0, 0);
            place[axis] = btScalar(side * (half + thickness / 2));
            walls.emplace_back(size, place);
        }
    }
    return walls;
}
void addRoom(Scene& scene, double half, double thickness, bool mesh)
{
    for (const auto& [size, place] : wallsOf(half, thickness))
    {
        put(scene, solid(scene, size, mesh), 0, place);
    }
}
std::function<bool(btRigidBody&)> isOutside(double half)
{
    return [=](btRigidBody& body)
    {
        const btVector3 place = at(body).absolute();
        return !(place[place.maxAxis()] < btScalar(half));
    };
}

/// The floor ends 20 m from the middle.
bool isUnderFloor(btRigidBody& body)
{
    const btVector3 place = at(body).absolute();
    return isBelow(body) && std::max(place.x(), place.y()) < btScalar(19);
}

/// Cubes in a closed room fly apart.
DayUnderWay explosion(Scene& scene, bool ours, bool meshWalls)
{
    addRoom(scene, 1, 0.001, ours && meshWalls);
    Bodies bodies;
    for (int i = 0; i < 27; ++i)
    {
        const btVector3 place = btScalar(0.25) * vec(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        btCollisionShape* cube = solid(scene, cubic(0.08), ours && i % 2 == 0);
        bodies.push_back(put(scene, cube, 1, place, place * btScalar(300) + vec(5, 3, 1)));
        bodies.back()->setRestitution(btScalar(0.8));
    }
    return watched(bodies, isOutside(1.01));
}

/// Gravity that turns round, a hundred times as strong as it is.
DayUnderWay flips(Scene& scene, bool ours)
{
    addRoom(scene, 1, 0.001, false);
    Bodies bodies;
    for (int i = 0; i < 18; ++i)
    {
        const btVector3 place = btScalar(0.4) * vec(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 0.5);
        bodies.push_back(put(scene, solid(scene, cubic(0.08), ours && i % 3 == 0), 1, place));
    }
    return watched(bodies,
                   isOutside(1.01),
                   [=, &scene](int step)
                   {
                       btVector3 gravity = vec(0, 0, 0);
                       gravity[step / 30 % 3] = btScalar(step / 15 % 2 == 0 ? -1000 : 1000);
                       scene.world().setGravity(gravity);
                   });
}

/// A hollow drum that turns, with balls and boxes in it.
DayUnderWay drum(Scene& scene, bool ours, double rate)
{
    btCompoundShape* room = scene.keep(std::make_unique<btCompoundShape>());
    for (const auto& [size, place] : wallsOf(1, 0.01))
    {
        room->addChildShape(poseAt(place), scene.box(size));
    }
    btRigidBody* walls = mover(scene, room, vec(0, 0, 0));
    scene.world().setGravity(vec(0, -10, 0));
    Bodies bodies;
    for (int i = 0; i < 12; ++i)
    {
        const btVector3 place = btScalar(0.3) * vec(i % 3 - 1, i / 3 % 2 - 0.5, i / 6 - 0.5);
        btCollisionShape* shape = i % 2 == 0 ? static_cast<btCollisionShape*>(ball(scene, 0.08))
                                             : solid(scene, cubic(0.08), ours);
        bodies.push_back(put(scene, shape, 1, place));
    }
    return watched(
        bodies,
        [](btRigidBody& body)
        {
            return std::abs(double(at(body).z())) > 1.01 ||
                   std::hypot(double(at(body).x()), double(at(body).y())) > 1.43;
        },
        [=](int step) { walls->setWorldTransform(poseAt(vec(0, 0, 0), rate * kDayStep * step)); });
}

/// A kinematic piston goes to and fro in a closed cylinder.
DayUnderWay piston(Scene& scene, bool ours, double rate)
{
    addRoom(scene, 1, 0.01, false);
    btRigidBody* head = mover(scene, solid(scene, vec(0.98, 0.98, 0.05), ours), vec(0, 0, 0.9));
    Bodies bodies;
    for (int i = 0; i < 9; ++i)
    {
        bodies.push_back(
            put(scene, ball(scene, 0.15), 1, vec(0.5 * (i % 3) - 0.5, 0.5 * (i / 3) - 0.5, -0.5)));
        bodies.back()->setRestitution(btScalar(0.9));
    }
    return watched(
        bodies,
        [=](btRigidBody& body)
        { return isOutside(1.01)(body) || heightOf(body) > heightOf(*head) + 0.05; },
        [=](int step) {
            head->setWorldTransform(
                poseAt(vec(0, 0, 0.4 + 0.5 * std::cos(rate * kDayStep * step))));
        });
}

/// A wall that moves drives boxes before it.
DayUnderWay plough(Scene& scene, bool ours, double speed)
{
    addFloor(scene, 0.1);
    btRigidBody* blade = mover(scene, solid(scene, vec(0.01, 3, 1), ours), vec(-3, 0, 1.001));
    Bodies bodies;
    for (int i = 0; i < 10; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.2), ours && i % 2 == 0);
        bodies.push_back(put(scene, cube, 1, vec(i / 5, 0.8 * (i % 5) - 1.6, 0.21)));
    }
    return watched(
        bodies,
        [=](btRigidBody& body) { return at(body).x() < at(*blade).x() || isBelow(body); },
        [=](int step)
        { blade->setWorldTransform(poseAt(vec(-3 + speed * kDayStep * step, 0, 1.001))); });
}

std::vector<btRigidBody*> addWallOfBricks(Scene& scene, bool ours, double x)
{
    Bodies bricks;
    for (int i = 0; i < 30; ++i)
    {
        btCollisionShape* brick = solid(scene, vec(0.1, 0.2, 0.1), ours && i % 3 == 0);
        const double shift = i / 6 % 2 == 0 ? 0.0 : 0.2;
        bricks.push_back(
            put(scene, brick, 1, vec(x, 0.41 * (i % 6) - 1 + shift, 0.1 + 0.201 * (i / 6))));
    }
    return bricks;
}

/// A heavy ball on a rope swings into a wall of bricks on a thin floor.
DayUnderWay wreckingBall(Scene& scene, bool ours)
{
    addFloor(scene, 0.002, ours);
    Bodies bodies = addWallOfBricks(scene, ours, 0);
    btRigidBody* weight = put(scene, ball(scene, 0.4), 100, vec(-3, 0, 0.6), vec(40, 0, 0));
    scene.addConstraint(std::make_unique<btPoint2PointConstraint>(*weight, vec(3, 0, 5)));
    return watched(bodies, isUnderFloor);
}

DayUnderWay cannon(Scene& scene, bool ours, double speed)
{
    addFloor(scene, 0.01, ours);
    Bodies bodies = addWallOfBricks(scene, ours, 0);
    bodies.push_back(put(scene, ball(scene, 0.2), 20, vec(-5, 0.1, 0.6), vec(speed, 0, -5)));
    return watched(bodies, isUnderFloor);
}

DayUnderWay dominoes(Scene& scene, bool ours)
{
    addFloor(scene, 0.002, ours);
    Bodies bodies;
    for (int i = 0; i < 30; ++i)
    {
        btCollisionShape* tile = solid(scene, vec(0.01, 0.1, 0.2), ours && i % 2 == 0);
        bodies.push_back(put(scene, tile, 1, vec(0.15 * i - 2, 0, 0.201)));
    }
    bodies.push_back(put(scene, ball(scene, 0.05), 1, vec(-4, 0, 0.3), vec(200, 0, 0)));
    return watched(bodies, isUnderFloor);
}

/// Balls on rods in a row: they never change places.
DayUnderWay cradle(Scene& scene, bool /*ours*/, double speed)
{
    scene.world().setGravity(vec(0, 0, -10));
    Bodies bodies;
    for (int i = 0; i < 5; ++i)
    {
        bodies.push_back(put(scene, ball(scene, 0.1), 1, vec(0.2 * i + 0.001 * i, 0, 0)));
        bodies.back()->setRestitution(1);
        auto rod =
            std::make_unique<btHingeConstraint>(*bodies.back(), vec(0, 0, 2), vec(0, 1, 0), true);
        scene.addConstraint(std::move(rod));
    }
    bodies[0]->setLinearVelocity(vec(speed, 0, 0));
    bodies[0]->setAngularVelocity(vec(0, -speed / 2, 0));
    return watched(bodies,
                   [=](btRigidBody& body)
                   {
                       const auto i = std::ranges::find(bodies, &body) - bodies.begin();
                       return i > 0 && at(body).x() < at(*bodies[std::size_t(i) - 1]).x();
                   });
}

/// A rod on a motor that turns a plate's thickness in a thousandth of a step.
DayUnderWay flail(Scene& scene, bool ours, double rate)
{
    put(scene, solid(scene, vec(0.0005, 1, 1), ours), 0, vec(0, 1.2, 0));
    btRigidBody* rod = put(scene, solid(scene, vec(0.45, 0.01, 0.01), ours), 1, vec(0.5, 0, 0));
    auto hinge = std::make_unique<btHingeConstraint>(*rod, vec(-0.5, 0, 0), vec(0, 0, 1), true);
    hinge->enableAngularMotor(true, btScalar(rate), btScalar(1));
    scene.addConstraint(std::move(hinge));
    rod->setAngularVelocity(vec(0, 0, rate));
    rod->setLinearVelocity(vec(0, 0.5 * rate, 0));
    return watched({rod}, [](btRigidBody& body) { return at(body).x() < -0.05; });
}

/// A hammer on a slider beats a plate.
DayUnderWay stamp(Scene& scene, bool ours, double speed)
{
    put(scene, solid(scene, vec(1, 1, 0.0005), ours), 0, vec(0, 0, 0));
    btRigidBody* head = put(scene, solid(scene, cubic(0.1), ours), 5, vec(0, 0, 2));
    const btTransform along(btQuaternion(vec(0, 1, 0), SIMD_HALF_PI), vec(0, 0, 0));
    auto slider = std::make_unique<btSliderConstraint>(*head, along, true);
    slider->setLowerLinLimit(-9);
    slider->setUpperLinLimit(9);
    scene.addConstraint(std::move(slider));
    head->setLinearVelocity(vec(0, 0, -speed));
    return watched(
        {head},
        [](btRigidBody& body) { return !(heightOf(body) > 0); },
        [=](int step)
        {
            if (step % 20 == 19)
            {
                head->setLinearVelocity(vec(0, 0, -speed));
            }
        });
}

/// Planks that hang on each other, and a ball that falls on them.
DayUnderWay bridge(Scene& scene, bool ours, double speed)
{
    scene.world().setGravity(vec(0, 0, -10));
    Bodies planks;
    for (int i = 0; i < 12; ++i)
    {
        const bool isEnd = i == 0 || i == 11;
        planks.push_back(
            put(scene, solid(scene, vec(0.23, 1, 0.02), ours), isEnd ? 0 : 5, vec(0.48 * i, 0, 0)));
        for (const double side : {-0.9, 0.9})
        {
            if (i > 0)
            {
                scene.addConstraint(
                    std::make_unique<btPoint2PointConstraint>(*planks[std::size_t(i) - 1],
                                                              *planks.back(),
                                                              vec(0.24, side, 0),
                                                              vec(-0.24, side, 0)));
            }
        }
    }
    btRigidBody* weight = put(scene, ball(scene, 0.4), 1, vec(2.6, 0, 3), vec(0, 0, -speed));
    return watched({weight}, [](btRigidBody& body) { return !(heightOf(body) > -4); });
}

/// Wagons that hang together, from both sides.
DayUnderWay trains(Scene& scene, bool ours)
{
    Bodies right;
    Bodies left;
    for (int i = 0; i < 5; ++i)
    {
        for (const double side : {-1.0, 1.0})
        {
            Bodies& train = side < 0 ? right : left;
            train.push_back(put(scene,
                                solid(scene, vec(0.2, 0.1, 0.1), ours && i % 2 == 0),
                                1,
                                vec(side * (2 + 0.45 * i), 0, 0),
                                vec(-80 * side, 0, 0)));
            if (i > 0)
            {
                scene.addConstraint(
                    std::make_unique<btPoint2PointConstraint>(*train[std::size_t(i) - 1],
                                                              *train.back(),
                                                              vec(side * 0.225, 0, 0),
                                                              vec(-side * 0.225, 0, 0)));
            }
        }
    }
    // Those on the track.
    return watched({right[0]},
                   [=](btRigidBody& body)
                   {
                       const btVector3 passed = at(body) - at(*left[0]);
                       return passed.x() > btScalar(0.1) &&
                              std::hypot(passed.y(), passed.z()) < 0.1;
                   });
}

/// Cards that lie on each other in the air.
DayUnderWay cards(Scene& scene, bool ours)
{
    addFloor(scene, 0.001, ours);
    Bodies bodies;
    for (int i = 0; i < 16; ++i)
    {
        btCollisionShape* card = solid(scene, vec(0.1, 0.06, 0.001), ours && i % 2 == 0);
        bodies.push_back(put(scene, card, 0.1, vec(0, 0, 0.1 + 0.02 * i), vec(0, 0, -8)));
    }
    return watched(bodies, isUnderFloor);
}

/// Cubes on each other are at rest when the day is over.
DayUnderWay tower(Scene& scene, bool ours, bool mesh)
{
    addFloor(scene, 0.1);
    Bodies bodies;
    for (int i = 0; i < 6; ++i)
    {
        bodies.push_back(
            put(scene, solid(scene, cubic(0.2), ours && mesh), 1, vec(0, 0, 0.201 + 0.401 * i)));
    }
    return {.wrong = count(bodies,
                           [=](btRigidBody& body)
                           {
                               const auto i = std::ranges::find(bodies, &body) - bodies.begin();
                               return !(std::abs(heightOf(body) - 0.2 - 0.4 * double(i)) < 0.05);
                           })};
}

/// Balls fall into a bowl of triangles.
DayUnderWay bowl(Scene& scene, bool /*ours*/)
{
    TriangleMesh mesh;
    constexpr int kRings = 12;
    constexpr int kSides = 24;
    for (int i = 0; i <= kRings; ++i)
    {
        for (int k = 0; k < kSides; ++k)
        {
            const double radius = 2.0 * (i + 0.02) / kRings;
            const double angle = 2 * double(SIMD_PI) * k / kSides;
            mesh.vertices.emplace_back(
                radius * std::cos(angle), radius * std::sin(angle), 0.5 * radius * radius);
            if (i < kRings)
            {
                const int next = (k + 1) % kSides;
                mesh.triangles.push_back({i * kSides + k, (i + 1) * kSides + k, i * kSides + next});
                mesh.triangles.push_back(
                    {i * kSides + next, (i + 1) * kSides + k, (i + 1) * kSides + next});
            }
        }
    }
    put(scene, scene.staticMesh(mesh), 0, vec(0, 0, 0));
    scene.world().setGravity(vec(0, 0, -10));
    Bodies bodies;
    for (int i = 0; i < 30; ++i)
    {
        const btVector3 place =
            vec(0.3 * (i % 5) - 0.6, 0.3 * (i / 5 % 3) - 0.3, 3 + 0.4 * (i / 15));
        bodies.push_back(put(scene, ball(scene, 0.1), 1, place, vec(0, 0, -50)));
    }
    return watched(bodies,
                   [](btRigidBody& body)
                   {
                       return !(heightOf(body) > -0.03) &&
                              std::hypot(double(at(body).x()), double(at(body).y())) < 1.8;
                   });
}

/// Bullet's vehicle drives at a thin wall.
DayUnderWay car(Scene& scene, bool ours, double speed)
{
    addFloor(scene, 1);
    put(scene, solid(scene, vec(0.005, 4, 2), ours), 0, vec(8, 0, 2));
    btRigidBody* chassis =
        put(scene, scene.box(vec(1, 0.5, 0.25)), 800, vec(-8, 0, 0.8), vec(speed, 0, 0));
    struct Wheels
    {
        btRaycastVehicle::btVehicleTuning tuning;
        std::unique_ptr<btDefaultVehicleRaycaster> rays;
        std::unique_ptr<btRaycastVehicle> vehicle;
    };
    const std::shared_ptr<Wheels> drive(new Wheels,
                                        [&scene](Wheels* gone)
                                        {
                                            scene.world().removeVehicle(gone->vehicle.get());
                                            delete gone;
                                        });
    drive->rays = std::make_unique<btDefaultVehicleRaycaster>(&scene.world());
    drive->vehicle = std::make_unique<btRaycastVehicle>(drive->tuning, chassis, drive->rays.get());
    drive->vehicle->setCoordinateSystem(1, 2, 0);
    for (int i = 0; i < 4; ++i)
    {
        drive->vehicle->addWheel(vec(i < 2 ? 0.8 : -0.8, i % 2 == 0 ? 0.5 : -0.5, 0),
                                 vec(0, 0, -1),
                                 vec(0, 1, 0),
                                 btScalar(0.3),
                                 btScalar(0.3),
                                 drive->tuning,
                                 i < 2);
    }
    scene.world().addVehicle(drive->vehicle.get());
    return watched(
        {chassis},
        [](btRigidBody& body) { return at(body).x() > btScalar(8) && heightOf(body) < 4; },
        [=](int) { drive->vehicle->applyEngineForce(btScalar(900), 2); });
}

/// Boxes slide over a floor of many triangles: no edge inside of it throws them up.
DayUnderWay slide(Scene& scene, bool ours)
{
    const TriangleMesh mesh = gridMesh(41, 4, [](int, int) { return 0.0; });
    put(scene, ours ? scene.mesh(mesh) : scene.staticMesh(mesh), 0, vec(0, 0, 0));
    scene.world().setGravity(vec(0, 0, -10));
    Bodies bodies;
    for (int i = 0; i < 8; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.2), ours && i % 2 == 0);
        bodies.push_back(put(scene, cube, 1, vec(-15, 2 * i - 8, 0.201), vec(20 + 10 * i, 0, 0)));
        bodies.back()->setFriction(btScalar(0.1));
    }
    return watched(bodies, [](btRigidBody& b) { return heightOf(b) < 0 || heightOf(b) > 0.6; });
}

/// What bounces between two plates without loss stays between them and keeps its speed.
DayUnderWay pingPong(Scene& scene, bool ours)
{
    for (const double side : {-1.0, 1.0})
    {
        put(scene, solid(scene, vec(5, 5, 0.001), ours), 0, vec(0, 0, side))->setRestitution(1);
    }
    Bodies bodies;
    for (int i = 0; i < 10; ++i)
    {
        bodies.push_back(
            put(scene, ball(scene, 0.05), 1, vec(0.4 * i - 2, 0, 0), vec(0, 0, 30 + 30 * i)));
        bodies.back()->setRestitution(1);
    }
    return watched(bodies,
                   [=](btRigidBody& body)
                   {
                       const auto i = double(std::ranges::find(bodies, &body) - bodies.begin());
                       return std::abs(heightOf(body)) > 1.01 ||
                              std::abs(speedOf(body) - 30 - 30 * i) > 0.3 * (1 + i);
                   });
}

/// Balls that rest in a row until one comes at them.
DayUnderWay sleepers(Scene& scene, bool ours, double speed)
{
    addFloor(scene, 0.5);
    put(scene, scene.box(vec(0.001, 1, 1)), 0, vec(4, 0, 0.5));
    Bodies bodies;
    for (int i = 0; i < 10; ++i)
    {
        bodies.push_back(
            put(scene, solid(scene, cubic(0.1), ours && i % 2 == 0), 1, vec(0.3 * i, 0, 0.1005)));
        bodies.back()->forceActivationState(ISLAND_SLEEPING);
    }
    put(scene, ball(scene, 0.1), 5, vec(-3, 0, 0.15), vec(speed, 0, 0));
    return watched(bodies, [](btRigidBody& b) { return at(b).x() > 4 && heightOf(b) < 0.9; });
}

/// A ball in a barrel of four thin plates.
DayUnderWay barrel(Scene& scene, bool ours)
{
    for (int side = 0; side < 4; ++side)
    {
        const double sign = side < 2 ? -1 : 1;
        const btVector3 size = side % 2 == 0 ? vec(5, 0.0005, 0.2) : vec(5, 0.2, 0.0005);
        const btVector3 place = side % 2 == 0 ? vec(0, sign * 0.11, 0) : vec(0, 0, sign * 0.11);
        put(scene, solid(scene, size, ours), 0, place);
    }
    Bodies bodies;
    for (int i = 0; i < 5; ++i)
    {
        bodies.push_back(put(
            scene, ball(scene, 0.05), 1, vec(i - 4, 0, 0), vec(100 + 60 * i, 90 - 15 * i, 20 * i)));
        bodies.back()->setRestitution(btScalar(0.7));
    }
    return watched(bodies,
                   [](btRigidBody& body)
                   {
                       const btVector3 p = at(body).absolute();
                       return p.x() < btScalar(4.9) && std::max(p.y(), p.z()) > btScalar(0.12);
                   });
}

/// Two hinged flaps that a motor slams shut on balls.
DayUnderWay flaps(Scene& scene, bool ours)
{
    scene.world().setGravity(vec(0, 0, -10));
    for (const double side : {-1.0, 1.0})
    {
        btRigidBody* flap =
            put(scene, solid(scene, vec(0.5, 1, 0.005), ours), 2, vec(0.52 * side, 0, 0));
        auto hinge =
            std::make_unique<btHingeConstraint>(*flap, vec(0.5 * side, 0, 0), vec(0, 1, 0), true);
        hinge->setLimit(btScalar(-0.05), btScalar(0.05));
        scene.addConstraint(std::move(hinge));
    }
    Bodies bodies;
    for (int i = 0; i < 6; ++i)
    {
        bodies.push_back(put(scene,
                             ball(scene, 0.15),
                             0.1,
                             vec(0.3 * (i % 3) - 0.3, 0.5 * (i / 3), 1),
                             vec(0, 0, -60)));
    }
    return watched(bodies,
                   [](btRigidBody& body) {
                       return heightOf(body) < -0.3 && heightOf(body) > -3 &&
                              std::abs(double(at(body).x())) < 0.9;
                   });
}
}  // namespace

std::vector<Day> daysOfMachines()
{
    return {
        {"explosion in a box", "through", 60, with(explosion, false)},
        {"explosion in a mesh", "through", 60, with(explosion, true)},
        {"gravity that turns", "through", 90, with(flips)},
        {"drum at 3 rad/s", "through", 90, with(drum, 3)},
        {"drum at 30 rad/s", "outside", 60, with(drum, 30)},
        {"piston", "through", 90, with(piston, 5)},
        {"fast piston", "through", 60, with(piston, 40)},
        {"plough", "through", 60, with(plough, 5)},
        {"plough at 50 m/s", "through", 20, with(plough, 50)},
        {"wrecking ball", "through", 90, with(wreckingBall)},
        {"cannon at 150 m/s", "through", 60, with(cannon, 150)},
        {"cannon at 600 m/s", "through", 60, with(cannon, 600)},
        {"dominoes", "through", 90, with(dominoes)},
        {"cradle at 3 m/s", "passed", 60, with(cradle, 3)},
        {"cradle at 40 m/s", "passed", 6, with(cradle, 40)},
        {"flail at 60 rad/s", "through", 10, with(flail, 60)},
        {"stamp", "through", 60, with(stamp, 100)},
        {"bridge", "through", 90, with(bridge, 20)},
        {"trains", "through", 40, with(trains)},
        {"cards", "through", 90, with(cards)},
        {"tower of boxes", "fallen", 180, with(tower, false)},
        {"tower of meshes", "fallen", 180, with(tower, true)},
        {"bowl", "through", 90, with(bowl)},
        {"car at 30 m/s", "through", 60, with(car, 30)},
        {"car at 200 m/s", "through", 30, with(car, 200)},
        {"slide over edges", "thrown", 60, with(slide)},
        {"ping-pong", "out", 60, with(pingPong)},
        {"row asleep, 300 m/s", "through", 60, with(sleepers, 300)},
        {"barrel", "through", 40, with(barrel)},
        {"flaps", "through", 40, with(flaps)},
    };
}
}  // namespace bullet_ccd::reference::day
