/// Fast things that are shot at thin ones.
#include "benchmarks/reference/bullet/day_parts.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>

#include <array>

namespace bullet_ccd::reference::day
{
namespace
{
enum class Surface
{
    StockSheet,  ///< two triangles of stock Bullet
    Plate,       ///< a box of 1 mm
    MeshPlate,   ///< the same of triangles
    MovingPlate,
    Plane,
};

TriangleMesh sheetOf(double half)
{
    return {.vertices = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}},
            .triangles = {{0, 1, 2}, {0, 2, 3}}};
}

btRigidBody* addSurface(Scene& scene, Surface surface, double half, bool ours)
{
    const bool isMesh = surface == Surface::MeshPlate || surface == Surface::MovingPlate;
    btCollisionShape* shape =
        surface == Surface::StockSheet ? scene.staticMesh(sheetOf(half))
        : surface == Surface::Plane
            ? scene.keep(std::make_unique<btStaticPlaneShape>(vec(0, 0, 1), 0))
            : solid(scene, vec(half, half, 0.0005), isMesh && ours);
    btRigidBody* body =
        put(scene, shape, surface == Surface::MovingPlate ? 1000.0 : 0.0, vec(0, 0, 0));
    body->setGravity(vec(0, 0, 0));
    return body;
}

std::function<bool(btRigidBody&)> isUnder(const btRigidBody* surface, double half)
{
    return [=](btRigidBody& body)
    {
        const btVector3 from = at(body) - at(*surface);
        return !(from.z() > btScalar(-0.02)) &&
               std::max(std::abs(from.x()), std::abs(from.y())) < btScalar(half);
    };
}

/// Rods that turn about all axes while they fall.
DayUnderWay rods(Scene& scene, bool ours, Surface surface)
{
    scene.world().setGravity(vec(0, 0, -10));
    btRigidBody* under = addSurface(scene, surface, 5, ours);
    Bodies bodies;
    for (int i = 0; i < 12; ++i)
    {
        btCollisionShape* rod =
            i % 3 == 0 ? scene.keep(std::make_unique<btCapsuleShapeX>(btScalar(0.01), btScalar(1)))
                       : solid(scene, vec(0.5, 0.01, 0.01), ours && i % 3 == 2);
        const btVector3 place = vec(-4 + 2.6 * (i % 4), -3 + 3 * (i / 4), 0.8 + 0.1 * i);
        bodies.push_back(put(scene, rod, 0.2, place, vec(0, 0, -30 - 20 * i)));
        bodies.back()->setAngularVelocity(vec(20 * (i % 2), 45 - i, 3 * i));
        bodies.back()->setRestitution(btScalar(0.3));
    }
    return watched(bodies, isUnder(under, 5));
}

btCollisionShape* smallShape(Scene& scene, int which, bool ours)
{
    const auto keep = [&](auto made)
    { return static_cast<btCollisionShape*>(scene.keep(std::move(made))); };
    switch (which % 8)
    {
        case 0:
            return keep(std::make_unique<btCylinderShapeZ>(vec(0.025, 0.025, 0.02)));
        case 1:
            return keep(std::make_unique<btConeShapeZ>(btScalar(0.025), btScalar(0.05)));
        case 2:
            return keep(std::make_unique<btSphereShape>(btScalar(0.025)));
        case 3:
            return keep(std::make_unique<btCapsuleShape>(btScalar(0.02), btScalar(0.02)));
        case 4:
        case 5:
        {
            auto hull = std::make_unique<btConvexHullShape>();
            for (int i = 0; i < 20; ++i)
            {
                hull->addPoint(btScalar(0.025) *
                               vec(std::sin(1.3 * i), std::cos(0.7 * i), std::sin(2.1 * i)));
            }
            hull->setMargin(btScalar(which % 8 == 4 ? 0.005 : 0.001));
            return keep(std::move(hull));
        }
        case 6:
        {
            const std::array<btVector3, 2> places{vec(-0.02, 0, 0), vec(0.02, 0, 0)};
            const std::array<btScalar, 2> radii{btScalar(0.02), btScalar(0.02)};
            return keep(std::make_unique<btMultiSphereShape>(places.data(), radii.data(), 2));
        }
        default:
            return solid(scene, vec(0.025, 0.025, 0.02), ours);
    }
}

/// Eight shapes of a few centimetres at four speeds.
DayUnderWay smallThings(Scene& scene, bool ours, Surface surface)
{
    scene.world().setGravity(vec(0, 0, -10));
    btRigidBody* under = addSurface(scene, surface, 20, ours);
    constexpr std::array kSpeeds{3, 20, 100, 500};
    Bodies bodies;
    for (int i = 0; i < 32; ++i)
    {
        const btVector3 place = vec(2 * (i % 8) - 8, 2 * (i / 8) - 4, 2);
        const btVector3 velocity = vec(0.3 * i, 1, -kSpeeds[std::size_t(i / 8)]);
        bodies.push_back(put(scene, smallShape(scene, i, ours), 1, place, velocity));
        bodies.back()->setAngularVelocity(vec(i % 7 * 10, 20 - i, 30 + i));
    }
    return watched(bodies, isUnder(under, 19));
}

/// Shapes that are scaled, onto a sheet that is scaled.
DayUnderWay scaledShapes(Scene& scene, bool ours)
{
    scene.world().setGravity(vec(0, 0, -10));
    auto* sheet = static_cast<btBvhTriangleMeshShape*>(scene.staticMesh(sheetOf(4)));
    auto scaled = std::make_unique<btScaledBvhTriangleMeshShape>(sheet, vec(5, 5, 1));
    btRigidBody* under = put(scene, scene.keep(std::move(scaled)), 0, vec(0, 0, 0));
    Bodies bodies;
    for (int i = 0; i < 8; ++i)
    {
        btCollisionShape* shape = smallShape(scene, i, ours);
        shape->setLocalScaling(i == 2 || i == 6 ? vec(3, 3, 3)
                               : i == 3         ? vec(2, 2, 5)
                                                : vec(4, 4, i % 2 == 0 ? 0.5 : 6));
        bodies.push_back(put(scene, shape, 1, vec(3 * i - 12, 0.2, 2), vec(0, 0, -500)));
        bodies.back()->setAngularVelocity(vec(10, 20, 30));
    }
    return watched(bodies, isUnder(under, 19));
}

DayUnderWay nestedCompounds(Scene& scene, bool ours)
{
    btRigidBody* under = addSurface(scene, Surface::Plate, 20, ours);
    btCollisionShape* shape = scene.box(cubic(0.05));
    shape->setLocalScaling(vec(0.5, 2, 0.25));
    Bodies bodies;
    for (int depth = 0; depth < 6; ++depth)
    {
        btCompoundShape* both = scene.keep(std::make_unique<btCompoundShape>());
        const btTransform X(btQuaternion(vec(0, 1, 0), btScalar(0.3 * depth)), vec(0.1, 0, 0));
        both->addChildShape(X, shape);
        both->addChildShape(X.inverse(), shape);
        shape = both;
        bodies.push_back(put(scene, shape, 1, vec(5 * depth - 12, 0, 2), vec(0, 0, -500)));
        bodies.back()->setAngularVelocity(vec(20, 5, 30));
    }
    return watched(bodies, isUnder(under, 19));
}

/// A slow box and a faster one behind it.
DayUnderWay columnsOfTwo(Scene& scene, bool ours, Surface surface)
{
    btRigidBody* under = addSurface(scene, surface, 40, ours);
    scene.world().setGravity(vec(0, 0, -10));
    Bodies bodies;
    for (int i = 0; i < 50; ++i)
    {
        const double slow = 20 + 20 * (i % 10);
        const btVector3 place = vec(2 * (i % 10) - 10, 2 * (i / 10) - 5, 4.5);
        bodies.push_back(put(scene, scene.box(cubic(0.1)), 1, place, vec(0, 0, -slow)));
        bodies.push_back(put(scene,
                             scene.box(cubic(0.1)),
                             1,
                             place + vec(0, 0, 2.4),
                             vec(0, 0, -slow - 40 - 60 * (i / 10))));
    }
    return watched(bodies, isUnder(under, 39));
}

/// Boxes just above a floor, with a push and a spin.
DayUnderWay nearFloor(Scene& scene, bool ours)
{
    btRigidBody* under = addSurface(scene, Surface::MeshPlate, 40, ours);
    Bodies bodies;
    for (int i = 0; i < 25; ++i)
    {
        constexpr std::array kGaps{0.0002, 0.0004, 0.0005, 0.001, 0.01};
        constexpr std::array kSpins{0, 10, 100, 1000, 2693};
        const double height = 0.1005 + kGaps[std::size_t(i % 5)];
        bodies.push_back(put(scene,
                             scene.box(cubic(0.1)),
                             1,
                             vec(3 * (i % 5), 3 * (i / 5), height),
                             vec(0, 0, -4 * i)));
        bodies.back()->setAngularVelocity(vec(0, 0, kSpins[std::size_t(i / 5)]));
    }
    return watched(bodies, isUnder(under, 39));
}

/// Of each pair, one comes from either side; they are as far off each other as their numbers say.
DayUnderWay headOn(Scene& scene, bool ours)
{
    Bodies right;
    Bodies left;
    for (int i = 0; i < 20; ++i)
    {
        btCollisionShape* plate = solid(scene, vec(0.1, 0.05, 0.02), ours);
        btCollisionShape* globe =
            ours ? static_cast<btCollisionShape*>(scene.mesh(makeSphere(0.1, 3)))
                 : ball(scene, 0.1);
        const btVector3 from = vec(-3 - 0.05 * i, 4 * i, 0.003 * i);
        right.push_back(put(scene, plate, 1, from, vec(100 + 37 * i, 0, 0)));
        right.back()->setAngularVelocity(vec(7 * i, 11 * i, 30));
        left.push_back(put(scene, globe, 1, vec(3, 4 * i, 0), vec(-200, 0, 0)));
    }
    return watched(right,
                   [=](btRigidBody& body)
                   {
                       const auto i = std::ranges::find(right, &body) - right.begin();
                       const btVector3 passed = at(body) - at(*left[std::size_t(i)]);
                       return passed.x() > 0 && std::hypot(passed.y(), passed.z()) < 0.05;
                   });
}

/// Of two cubes in free space the faster one catches the other: they part, and their momentum
/// stays.
DayUnderWay catchUp(Scene& scene, bool ours)
{
    Bodies ahead;
    Bodies behind;
    for (const double speed : {1.0, 10.0, 100.0})
    {
        const double y = 5.0 * double(ahead.size());
        ahead.push_back(
            put(scene, solid(scene, cubic(0.1), ours), 1, vec(0, y, 0), vec(0, 0, -speed)));
        behind.push_back(
            put(scene, solid(scene, cubic(0.1), ours), 1, vec(0, y, 1), vec(0, 0, -3 * speed)));
    }
    return watched(ahead,
                   [=](btRigidBody& body)
                   {
                       const auto i = std::ranges::find(ahead, &body) - ahead.begin();
                       const btRigidBody& other = *behind[std::size_t(i)];
                       const btVector3 sum = body.getLinearVelocity() + other.getLinearVelocity();
                       const double before = 4 * std::pow(10.0, double(i));
                       return heightOf(other) < heightOf(body) + 0.19 ||
                              std::abs(double(sum.z()) + before) > 0.01 * before;
                   });
}

/// The same shots at other lengths of a step.
DayUnderWay volley(Scene& scene, bool ours)
{
    btRigidBody* under = addSurface(scene, Surface::MeshPlate, 40, ours);
    scene.world().setGravity(vec(0, 0, -10));
    Bodies bodies;
    for (int i = 0; i < 10; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.1), ours && i % 2 == 0);
        bodies.push_back(
            put(scene, cube, 1, vec(0.5 * i - 2.5, 0, 3 + 0.3 * i), vec(0, 0, -20 * i)));
    }
    return watched(bodies, isUnder(under, 39));
}

/// Worlds that are this much larger than usual.
DayUnderWay atScale(Scene& scene, bool ours, double scale)
{
    scene.world().setGravity(vec(0, 0, -10 * scale));
    const auto solidOf = [&](const btVector3& half)
    {
        btCollisionShape* shape = solid(scene, half, ours);
        shape->setMargin(btScalar(0.0025 * scale));
        return shape;
    };
    put(scene, solidOf(vec(5 * scale, 5 * scale, 0.01 * scale)), 0, vec(0, 0, -0.01 * scale));
    Bodies bodies;
    for (int i = 0; i < 5; ++i)
    {
        bodies.push_back(put(scene,
                             solidOf(cubic(0.2 * scale)),
                             1,
                             vec((i - 2) * scale, 0, 2 * scale),
                             vec(0, 0, -100 * scale * (i + 1))));
        bodies.back()->setAngularVelocity(vec(3, 5 * i, 7));
    }
    if (ours)
    {
        scene.ccd().setCcdTolerance(1e-3 * scale);
    }
    return watched(bodies,
                   [=](btRigidBody& body)
                   {
                       const btVector3 place = at(body).absolute();
                       return !(heightOf(body) > 0) &&
                              std::max(place.x(), place.y()) < btScalar(4.9 * scale);
                   });
}

/// What is not a number, or nearly none, and a body beside it.
DayUnderWay beyondNumbers(Scene& scene, bool ours, double speed, double spin)
{
    scene.world().setGravity(vec(0, 0, -10));
    put(scene, solid(scene, vec(5, 5, 0.5), ours), 0, vec(0, 0, -0.5));
    btRigidBody* good = put(scene, scene.box(cubic(0.1)), 1, vec(2, 0, 2), vec(0, 0, -200));
    btRigidBody* wild = put(scene, scene.box(cubic(0.1)), 1, vec(0, 0, 2), vec(0, 0, -speed));
    wild->setAngularVelocity(vec(spin, 0, 0));
    return watched({good}, isBelow);
}

/// A pole of 6 mm that turns on a base, at a plate across its way.
DayUnderWay finger(Scene& scene, bool ours, double rate)
{
    btCollisionShape* link = solid(scene, vec(0.45, 0.005, 0.005), ours);
    put(scene, solid(scene, vec(0.0005, 1, 1), ours), 0, vec(0, 1.2, 0));
    btMultiBody* pole = scene.chain({link}, 0.45, poseAt(vec(0, 0, 0)), {0.1});
    pole->setJointVel(0, btScalar(rate));
    const auto passed = std::make_shared<bool>(false);
    const auto look = [=]
    { *passed = *passed || !(pole->getJointPos(0) < btScalar(SIMD_HALF_PI)); };
    return {[=](int) { look(); },
            [=]
            {
                look();
                return *passed ? 1 : 0;
            }};
}

/// A floating chain of six links, thrown at a plate while its joints turn.
DayUnderWay thrownChain(Scene& scene, bool ours, double speed)
{
    put(scene, solid(scene, vec(4, 4, 0.001), ours), 0, vec(0, 0, 0));
    const std::vector<btCollisionShape*> links(6, solid(scene, vec(0.09, 0.01, 0.01), ours));
    auto made =
        std::make_unique<btMultiBody>(6, btScalar(0.1), vec(0.01, 0.01, 0.01), false, false);
    made->setBasePos(vec(-0.6, 0, 0.5));
    for (int i = 0; i < 6; ++i)
    {
        made->setupRevolute(i,
                            btScalar(0.1),
                            vec(0.001, 0.01, 0.01),
                            i - 1,
                            btQuaternion::getIdentity(),
                            vec(0, 1, 0),
                            i == 0 ? vec(0, 0, 0) : vec(0.1, 0, 0),
                            vec(0.1, 0, 0),
                            true);
    }
    made->setHasSelfCollision(false);
    made->finalizeMultiDof();
    btMultiBody* chain = scene.addMultiBody(std::move(made), nullptr, links);
    chain->setBaseVel(vec(0, 0, -speed));
    chain->setBaseOmega(vec(0, 0.1 * speed, 0.2 * speed));
    for (int i = 0; i < 6; ++i)
    {
        chain->setJointVel(i, btScalar((i % 2 == 0 ? -0.1 : 0.1) * speed));
    }
    return {.wrong = [=]
            {
                int below = 0;
                for (int i = 0; i < 6; ++i)
                {
                    const btVector3& p =
                        chain->getLink(i).m_collider->getWorldTransform().getOrigin();
                    below += !(p.z() > btScalar(-0.05)) && p.length() < btScalar(4) ? 1 : 0;
                }
                return below;
            }};
}

/// Thin things that land flat or on their points.
DayUnderWay coinsAndNeedles(Scene& scene, bool ours)
{
    btRigidBody* under = addSurface(scene, Surface::MeshPlate, 20, ours);
    Bodies bodies;
    for (int i = 0; i < 40; ++i)
    {
        btCollisionShape* coin =
            scene.keep(std::make_unique<btCylinderShapeZ>(vec(0.02, 0.02, 0.001)));
        btCollisionShape* needle =
            scene.keep(std::make_unique<btConeShapeZ>(btScalar(0.002), btScalar(0.1)));
        bodies.push_back(put(scene,
                             i % 2 == 0 ? coin : needle,
                             0.01,
                             vec(0.3 * (i % 8), 0.3 * (i / 8), 0.5),
                             vec(0, 0, -3 * (i + 1))));
        bodies.back()->setAngularVelocity(vec(i % 5, i % 3, 9));
    }
    return watched(bodies, isUnder(under, 19));
}

DayUnderWay hail(Scene& scene, bool ours, Surface surface, double radius)
{
    btRigidBody* under = addSurface(scene, surface, 20, ours);
    Bodies bodies;
    for (int i = 0; i < 60; ++i)
    {
        bodies.push_back(put(scene,
                             ball(scene, radius),
                             0.01,
                             vec(0.2 * (i % 8), 0.2 * (i / 8), 1 + 0.1 * (i % 7)),
                             vec(i % 3, i % 5, -100 - i)));
        bodies.back()->setRestitution(btScalar(0.5));
    }
    return watched(bodies, isUnder(under, 19));
}

/// Stones of random corners.
DayUnderWay stones(Scene& scene, bool ours)
{
    btRigidBody* under = addSurface(scene, Surface::StockSheet, 20, ours);
    Bodies bodies;
    for (int i = 0; i < 20; ++i)
    {
        auto hull = std::make_unique<btConvexHullShape>();
        for (int k = 0; k < 12; ++k)
        {
            const double angle = i + 1.7 * k;
            hull->addPoint(btScalar(0.2) *
                           vec(std::sin(angle), std::cos(1.3 * angle), std::sin(2.1 * k)));
        }
        hull->setMargin(btScalar(0.005));
        bodies.push_back(put(
            scene, scene.keep(std::move(hull)), 1, vec(i % 5, i / 5, 2), vec(0, 0, -80 - 5 * i)));
        bodies.back()->setAngularVelocity(vec(i, 3 * i, 5));
    }
    return watched(bodies, isUnder(under, 19));
}

/// A hammer turns about a point far from its head.
DayUnderWay hammers(Scene& scene, bool ours)
{
    btRigidBody* under = addSurface(scene, Surface::Plate, 20, ours);
    Bodies bodies;
    for (int i = 0; i < 8; ++i)
    {
        btCompoundShape* hammer = scene.keep(std::make_unique<btCompoundShape>());
        hammer->addChildShape(poseAt(vec(0.3, 0, 0)), scene.box(vec(0.3, 0.01, 0.01)));
        hammer->addChildShape(poseAt(vec(0.6, 0, 0)), scene.box(vec(0.03, 0.1, 0.03)));
        bodies.push_back(put(scene, hammer, 1, vec(2 * i - 8, 0, 1.5), vec(0, 0, -20 * i)));
        bodies.back()->setAngularVelocity(vec(0, 30 + 20 * i, 5));
    }
    return watched(bodies, isUnder(under, 19));
}

/// A disc and a rod that spin fast above a sheet.
DayUnderWay spinners(Scene& scene, bool ours)
{
    scene.world().setGravity(vec(0, 0, -10));
    btRigidBody* under = addSurface(scene, Surface::StockSheet, 20, ours);
    Bodies bodies;
    for (int i = 0; i < 6; ++i)
    {
        btCollisionShape* disc =
            scene.keep(std::make_unique<btCylinderShapeZ>(vec(0.3, 0.3, 0.01)));
        btCollisionShape* rod = scene.box(vec(1, 0.01, 0.01));
        bodies.push_back(
            put(scene, i % 2 == 0 ? disc : rod, 1, vec(4 * i - 10, 0, 0.5), vec(0, 0, -5)));
        bodies.back()->setAngularVelocity(vec(i % 2 == 0 ? 3 : 0, 0.5 * i, 100 * (i + 1)));
    }
    return watched(bodies, isUnder(under, 19));
}

/// Rings that stock Bullet has as GImpact meshes, as ours has them.
DayUnderWay rings(Scene& scene, bool ours)
{
    btRigidBody* under = addSurface(scene, Surface::Plate, 20, ours);
    Bodies bodies;
    for (int i = 0; i < 10; ++i)
    {
        btCollisionShape* ring =
            ours ? static_cast<btCollisionShape*>(scene.mesh(makeTorus(0.2, 0.02, 24, 8)))
                 : scene.box(vec(0.22, 0.22, 0.02));
        bodies.push_back(put(scene, ring, 1, vec(2 * i - 10, 0, 1), vec(0, 0, -10 - 15 * i)));
        bodies.back()->setAngularVelocity(vec(5 * i, 40, 3));
    }
    return watched(bodies, isUnder(under, 19));
}
}  // namespace

std::vector<Day> daysOfShots()
{
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    constexpr WorldClass kLinks = WorldClass::MultiBody;
    constexpr double kFrame = 1.0 / 60.0;
    return {
        {"rods at a sheet", "through", 60, with(rods, Surface::StockSheet)},
        {"rods at a plate", "through", 60, with(rods, Surface::Plate)},
        {"rods at a mesh plate", "through", 60, with(rods, Surface::MeshPlate)},
        {"rods at a moving plate", "through", 60, with(rods, Surface::MovingPlate)},
        {"small things on a sheet", "through", 90, with(smallThings, Surface::StockSheet)},
        {"on a plate", "through", 90, with(smallThings, Surface::Plate)},
        {"on a mesh plate", "through", 90, with(smallThings, Surface::MeshPlate)},
        {"on a plane", "through", 90, with(smallThings, Surface::Plane)},
        {"scaled shapes", "through", 30, with(scaledShapes)},
        {"nested compounds", "through", 30, with(nestedCompounds)},
        {"two on a sheet", "through", 40, with(columnsOfTwo, Surface::StockSheet)},
        {"two on a plate", "through", 40, with(columnsOfTwo, Surface::Plate)},
        {"two on a mesh plate", "through", 40, with(columnsOfTwo, Surface::MeshPlate)},
        {"just above a mesh plate", "through", 10, with(nearFloor)},
        {"meshes head on", "through", 30, with(headOn)},
        {"one catches another", "wrong", 60, with(catchUp)},
        {"steps of 1 ms", "through", 1000, with(volley), 1e-3},
        {"steps of 1/240 s", "through", 240, with(volley), 1.0 / 240.0},
        {"steps of 1 s", "through", 3, with(volley), 1.0},
        {"0.4 mm boxes", "through", 60, with(atScale, 1e-3)},
        {"4 mm boxes", "through", 60, with(atScale, 1e-2)},
        {"400 m boxes", "through", 60, with(atScale, 1e3)},
        {"beside NaN", "through", 60, with(beyondNumbers, kNone, 0)},
        {"beside 1e30 m/s", "through", 60, with(beyondNumbers, 1e30, 0)},
        {"beside 1e12 rad/s", "through", 60, with(beyondNumbers, 1e12, 1e12)},
        {"finger, 50 rad/s", "through", 30, with(finger, 50), kFrame, kLinks},
        {"finger, 1,000 rad/s", "through", 30, with(finger, 1000), kFrame, kLinks},
        {"finger, 5,000 rad/s", "through", 30, with(finger, 5000), kFrame, kLinks},
        {"chain at 40 m/s", "through", 30, with(thrownChain, 40), kFrame, kLinks},
        {"chain at 200 m/s", "through", 30, with(thrownChain, 200), kFrame, kLinks},
        {"coins and needles", "through", 60, with(coinsAndNeedles)},
        {"hail of 5 mm on a sheet", "through", 60, with(hail, Surface::StockSheet, 0.005)},
        {"hail of 2 mm on a plate", "through", 60, with(hail, Surface::Plate, 0.002)},
        {"hail of 5 cm on a mesh", "through", 60, with(hail, Surface::MeshPlate, 0.05)},
        {"stones on a sheet", "through", 60, with(stones)},
        {"hammers", "through", 60, with(hammers)},
        {"spinning discs and rods", "through", 60, with(spinners)},
        {"rings at a plate", "through", 60, with(rings)},
    };
}
}  // namespace bullet_ccd::reference::day
