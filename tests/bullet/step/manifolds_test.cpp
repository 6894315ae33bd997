#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/bullet/step/btCcdManifolds.h"
#include "bullet_ccd/contact/contact_outline.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

constexpr double kMargin = 5e-4;
constexpr double kShell = 2.0 * kMargin;
constexpr bool kIsDouble = sizeof(btScalar) == sizeof(double);
constexpr double kStep = 1.0 / 240.0;

/// A stock world whose mesh contacts are the library's.
struct ManifoldScene
{
    explicit ManifoldScene(bool multiBody) : dispatcher(&configuration)
    {
        btCcdCollisionAlgorithm::registerAlgorithm(&dispatcher);
        if (multiBody)
        {
            auto own = std::make_unique<btMultiBodyConstraintSolver>();
            world = std::make_unique<btMultiBodyDynamicsWorld>(
                &dispatcher, &broadphase, own.get(), &configuration);
            solver = std::move(own);
        }
        else
        {
            solver = std::make_unique<btSequentialImpulseConstraintSolver>();
            world = std::make_unique<btDiscreteDynamicsWorld>(
                &dispatcher, &broadphase, solver.get(), &configuration);
        }
        world->setGravity(btVector3(0, 0, btScalar(-9.81)));
    }
    ManifoldScene(const ManifoldScene&) = delete;
    ManifoldScene& operator=(const ManifoldScene&) = delete;
    ~ManifoldScene()
    {
        for (const auto& body : bodies)
        {
            world->removeRigidBody(body.get());
        }
        world.reset();
        btCcdCollisionAlgorithm::unregisterAlgorithm(&dispatcher);
    }

    btRigidBody& add(std::unique_ptr<btCollisionShape> shape, double mass, const Vector3d& place)
    {
        btVector3 inertia(0, 0, 0);
        if (mass > 0.0)
        {
            shape->calculateLocalInertia(btScalar(mass), inertia);
        }
        btRigidBody::btRigidBodyConstructionInfo info(
            btScalar(mass), nullptr, shape.get(), inertia);
        info.m_startWorldTransform.setIdentity();
        info.m_startWorldTransform.setOrigin(btCcdToBullet(place));
        shapes.push_back(std::move(shape));
        bodies.push_back(std::make_unique<btRigidBody>(info));
        world->addRigidBody(bodies.back().get());
        bodies.back()->setSleepingThresholds(0, 0);
        return *bodies.back();
    }
    btRigidBody& addMesh(const TriangleMesh& mesh, double mass, const Vector3d& place)
    {
        return add(std::make_unique<btCcdMeshShape>(
                       std::make_shared<const SsvTree>(buildSsvTree(mesh)), btScalar(kMargin)),
                   mass,
                   place);
    }

    void step(int count)
    {
        for (int i = 0; i < count; ++i)
        {
            world->stepSimulation(btScalar(kStep), 1, btScalar(kStep));
        }
    }
    std::vector<btManifoldPoint> points()
    {
        std::vector<btManifoldPoint> all;
        for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
        {
            const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
            for (int k = 0; k < manifold->getNumContacts(); ++k)
            {
                all.push_back(manifold->getContactPoint(k));
            }
        }
        return all;
    }

    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher;
    btDbvtBroadphase broadphase;
    std::unique_ptr<btSequentialImpulseConstraintSolver> solver;
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    std::unique_ptr<btDiscreteDynamicsWorld> world;
};

/// Flat, of cells with shaken corners and diagonals at random.
TriangleMesh raggedFloor(int cells, double half)
{
    Random random(3);
    TriangleMesh mesh;
    const double size = 2.0 * half / cells;
    for (int i = 0; i <= cells; ++i)
    {
        for (int j = 0; j <= cells; ++j)
        {
            const bool inside = i > 0 && j > 0 && i < cells && j < cells;
            const double shake = inside ? 0.3 * size : 0.0;
            mesh.vertices.emplace_back(i * size - half + random.uniform(-shake, shake),
                                       j * size - half + random.uniform(-shake, shake),
                                       0.0);
        }
    }
    for (int i = 0; i < cells; ++i)
    {
        for (int j = 0; j < cells; ++j)
        {
            const int k = i * (cells + 1) + j;
            const int next = k + cells + 1;
            const bool turned = random.chance(0.5);
            mesh.triangles.push_back({k, next, turned ? k + 1 : next + 1});
            mesh.triangles.push_back({turned ? next : k, next + 1, k + 1});
        }
    }
    return mesh;
}

double energy(const btRigidBody& body)
{
    const btVector3 spin =
        body.getWorldTransform().getBasis().transpose() * body.getAngularVelocity();
    const btVector3 inertia(1 / body.getInvInertiaDiagLocal().x(),
                            1 / body.getInvInertiaDiagLocal().y(),
                            1 / body.getInvInertiaDiagLocal().z());
    return double(0.5 / body.getInvMass() * body.getLinearVelocity().length2() +
                  0.5 * (inertia * spin * spin).dot(btVector3(1, 1, 1)) +
                  9.81 / body.getInvMass() * body.getWorldTransform().getOrigin().z());
}

double speed(const btRigidBody& body)
{
    return double(body.getLinearVelocity().length() + body.getAngularVelocity().length());
}

void expectRest(const btRigidBody& body, const Vector3d& place, const char* what)
{
    const Vector3d at = btCcdToEigen(body.getWorldTransform().getOrigin());
    EXPECT_NEAR(at.z(), place.z(), 0.05 * kShell) << what;
    EXPECT_LT((at - place).head<2>().norm(), 1e-4) << what;
    EXPECT_LT(speed(body), 1e-3) << what;
    const btQuaternion turn = body.getWorldTransform().getRotation();
    EXPECT_LT(double(turn.getAngleShortestPath()), 1e-3) << what;
}

TEST(Manifolds, ABoxMeshComesToRestAtTheShell)
{
    for (const bool multiBody : {false, true})
    {
        ManifoldScene scene(multiBody);
        scene.addMesh(raggedFloor(40, 0.5), 0, Vector3d::Zero());
        btRigidBody& box = scene.addMesh(makeBox({0.05, 0.05, 0.05}), 1, {0.01, 0.02, 0.053});
        const double start = energy(box);
        for (int i = 0; i < 480; ++i)
        {
            scene.step(1);
            EXPECT_LE(energy(box), start * (1.0 + 1e-4)) << i;
        }
        expectRest(box, {0.01, 0.02, 0.05 + kShell}, multiBody ? "multibody world" : "world");
        const std::vector<btManifoldPoint> points = scene.points();
        ASSERT_EQ(points.size(), 4U);
        for (const btManifoldPoint& point : points)
        {
            // Straight up on the floor, which is body 0 of the pair.
            EXPECT_NEAR(std::abs(double(point.m_normalWorldOnB.z())), 1.0, 1e-6);
            EXPECT_GT(point.getLifeTime(), 100);
        }
    }
}

/// Largest vertical speed, and change of the horizontal speed, of a box that slides over a floor of
/// triangles without friction for a second.
struct Slide
{
    double vertical = 0.0;
    double horizontal = 0.0;
    double turn = 0.0;
};

Slide slide(ManifoldScene& scene, btRigidBody& ground, btRigidBody& box)
{
    ground.setFriction(0);
    box.setFriction(0);
    box.setDamping(0, 0);
    // To rest first: what it falls by is not the floor's doing.
    scene.step(120);
    const btVector3 velocity(btScalar(0.8), btScalar(0.55), 0);
    box.setLinearVelocity(velocity);
    Slide worst;
    for (int i = 0; i < 240; ++i)
    {
        scene.step(1);
        const btVector3 v = box.getLinearVelocity();
        worst.vertical = std::max(worst.vertical, std::abs(double(v.z())));
        worst.horizontal =
            std::max(worst.horizontal,
                     std::hypot(double(v.x() - velocity.x()), double(v.y() - velocity.y())));
        worst.turn = std::max(worst.turn, double(box.getAngularVelocity().length()));
    }
    return worst;
}

TEST(Manifolds, ABoxSlidesOverTheEdgesOfTheFloorWithoutABump)
{
    const TriangleMesh floor = raggedFloor(60, 1.5);
    for (const bool multiBody : {false, true})
    {
        ManifoldScene scene(multiBody);
        btRigidBody& ground = scene.addMesh(floor, 0, Vector3d::Zero());
        btRigidBody& box =
            scene.addMesh(makeBox({0.05, 0.05, 0.05}), 1, {-0.5, -0.4, 0.05 + kShell});
        const Slide worst = slide(scene, ground, box);
        EXPECT_LT(worst.vertical, 1e-6);
        EXPECT_LT(worst.horizontal, 1e-6);
        EXPECT_LT(worst.turn, 1e-5);
    }
    // The control: Bullet's own contacts of a box with such a floor do show its edges.
    ManifoldScene scene(false);
    btTriangleMesh triangles;
    for (const Triangle& t : floor.triangles)
    {
        triangles.addTriangle(btCcdToBullet(floor.vertices[std::size_t(t[0])]),
                              btCcdToBullet(floor.vertices[std::size_t(t[1])]),
                              btCcdToBullet(floor.vertices[std::size_t(t[2])]));
    }
    btRigidBody& ground =
        scene.add(std::make_unique<btBvhTriangleMeshShape>(&triangles, true), 0, Vector3d::Zero());
    auto shape = std::make_unique<btBoxShape>(btVector3(0.05F, 0.05F, 0.05F));
    shape->setMargin(btScalar(kMargin));
    btRigidBody& box = scene.add(std::move(shape), 1, {-0.5, -0.4, 0.0505});
    const Slide stock = slide(scene, ground, box);
    EXPECT_GT(stock.vertical, 0.01);
    EXPECT_GT(stock.horizontal, 0.01);
}

TEST(Manifolds, AStackOfFiveBoxMeshesStands)
{
    for (const bool multiBody : {false, true})
    {
        ManifoldScene scene(multiBody);
        scene.addMesh(raggedFloor(20, 0.5), 0, Vector3d::Zero());
        std::vector<btRigidBody*> stack;
        for (int i = 0; i < 5; ++i)
        {
            const double z = 0.05 + kShell + i * (0.1 + kShell);
            stack.push_back(
                &scene.addMesh(makeBox({0.05, 0.05, 0.05}), 1, {0.001 * (i % 2), 0.0, z}));
        }
        scene.step(480);
        for (std::size_t i = 0; i < stack.size(); ++i)
        {
            const Vector3d at = btCcdToEigen(stack[i]->getWorldTransform().getOrigin());
            const double z = 0.05 + kShell + double(i) * (0.1 + kShell);
            EXPECT_NEAR(at.z(), z, 0.1 * kShell * double(i + 1)) << i;
            // Bullet's solver lets a stack creep: one of its own boxes does so by 1 to 2 mm.
            EXPECT_NEAR(at.x(), 0.001 * double(i % 2), 3e-3) << i;
            EXPECT_NEAR(at.y(), 0.0, 3e-3) << i;
            EXPECT_LT(speed(*stack[i]), 5e-3) << i;
        }
    }
}

/// A way out of one wall leads into the other.
TEST(Manifolds, ABarInANarrowSlotKeepsToItsWalls)
{
    for (const double gap : {1e-3 * kShell, 0.05 * kShell, 0.5 * kShell})
    {
        ManifoldScene scene(false);
        TriangleMesh slot;
        for (const double side : {-1.0, 1.0})
        {
            TriangleMesh wall = makeBox({0.05, 0.3, 0.05});
            transformMesh(wall,
                          Eigen::Affine3d(Eigen::Translation3d(side * (0.1 + gap), 0.0, 0.0)));
            appendMesh(slot, wall);
        }
        scene.addMesh(slot, 0, Vector3d::Zero());
        scene.addMesh(makeBox({0.05, 0.2, 0.03}), 1, Vector3d::Zero());
        scene.world->performDiscreteCollisionDetection();
        const std::vector<btManifoldPoint> points = scene.points();
        EXPECT_EQ(points.size(), 8U) << gap;
        for (const btManifoldPoint& point : points)
        {
            EXPECT_NEAR(std::abs(double(point.m_normalWorldOnB.x())), 1.0, 1e-6) << gap;
            EXPECT_NEAR(double(point.getDistance()), gap - kShell, 1e-7) << gap;
        }
    }
}

TEST(Manifolds, ATubeStandsOnItsRing)
{
    ManifoldScene scene(false);
    scene.addMesh(raggedFloor(40, 0.5), 0, Vector3d::Zero());
    // A mug without a handle: outer wall, foot ring below a raised bottom.
    const TriangleMesh mug = makeRevolved({{0.0, -0.04},
                                           {0.025, -0.04},
                                           {0.028, -0.045},
                                           {0.032, -0.045},
                                           {0.035, -0.04},
                                           {0.035, 0.045},
                                           {0.032, 0.045},
                                           {0.032, -0.037},
                                           {0.0, -0.037}},
                                          64);
    btRigidBody& body = scene.addMesh(mug, 0.3, {0.01, 0.02, 0.045 + 1.5 * kShell});
    scene.step(480);
    expectRest(body, {0.01, 0.02, 0.045 + kShell}, "mug");
    EXPECT_EQ(scene.points().size(), 4U);
    for (const btManifoldPoint& point : scene.points())
    {
        const btVector3 onBody = body.getWorldTransform().invXform(point.getPositionWorldOnA());
        EXPECT_NEAR(std::hypot(double(onBody.x()), double(onBody.y())), 0.032, 1e-4);
    }
}

TEST(Manifolds, ABumpyFootComesToRest)
{
    ManifoldScene scene(false);
    scene.addMesh(raggedFloor(40, 0.5), 0, Vector3d::Zero());
    // A disc with bumps of 40 micrometres, of which three or four carry it.
    Random random(9);
    std::vector<Eigen::Vector2d> profile{{0.0, -0.02}};
    for (int i = 1; i <= 10; ++i)
    {
        profile.emplace_back(0.004 * i, -0.02);
    }
    profile.emplace_back(0.04, 0.02);
    profile.emplace_back(0.0, 0.02);
    TriangleMesh disc = makeRevolved(profile, 48);
    for (Vector3d& v : disc.vertices)
    {
        v.z() += v.z() < 0.0 ? random.uniform(0.0, 4e-5) : 0.0;
    }
    btRigidBody& body = scene.addMesh(disc, 0.3, {0.01, 0.02, 0.02 + 1.5 * kShell});
    scene.step(480);
    const btVector3 place = body.getWorldTransform().getOrigin();
    EXPECT_NEAR(double(place.z()), 0.02 + kShell, 0.05 * kShell);
    EXPECT_LT(std::hypot(double(place.x()) - 0.01, double(place.y()) - 0.02), 5e-4);
    // A rocking body of that size would turn by 0.1 rad/s and more.
    EXPECT_LT(speed(body), 1e-2);
    EXPECT_LE(scene.points().size(), std::size_t(kPointsPerPatch));
}

TEST(Manifolds, ConvexShapesRestOnAMeshByTheirOwnSize)
{
    ManifoldScene scene(false);
    scene.addMesh(raggedFloor(20, 0.5), 0, Vector3d::Zero());
    btRigidBody& ball = scene.add(
        std::make_unique<btSphereShape>(btScalar(0.03)), 1, {0.1, 0.1, 0.03 + 1.2 * kMargin});
    btRigidBody& capsule =
        scene.add(std::make_unique<btCapsuleShapeX>(btScalar(0.02), btScalar(0.1)),
                  1,
                  {-0.2, 0.1, 0.02 + 1.2 * kMargin});
    btRigidBody& box = scene.add(std::make_unique<btBoxShape>(btVector3(0.05F, 0.04F, 0.03F)),
                                 1,
                                 {0.2, -0.2, 0.03 + 1.2 * kMargin});
    for (btRigidBody* body : {&ball, &capsule})
    {
        body->setRollingFriction(0.01F);
        body->setSpinningFriction(0.01F);
    }
    scene.step(480);
    EXPECT_NEAR(double(ball.getWorldTransform().getOrigin().z()), 0.03 + kMargin, 0.1 * kMargin);
    EXPECT_NEAR(double(capsule.getWorldTransform().getOrigin().z()), 0.02 + kMargin, 0.1 * kMargin);
    EXPECT_NEAR(double(box.getWorldTransform().getOrigin().z()), 0.03 + kMargin, 0.1 * kMargin);
    for (const btRigidBody* body : {&ball, &capsule, &box})
    {
        EXPECT_LT(speed(*body), 1e-3);
    }
}

TEST(Manifolds, ABoxMeshRestsOnAPlaneAndOnABox)
{
    ManifoldScene scene(false);
    scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0)), 0, {0, 0, 0});
    auto plate = std::make_unique<btBoxShape>(btVector3(0.2F, 0.2F, 0.01F));
    scene.add(std::move(plate), 0, {1, 0, 0.1});
    const btRigidBody& onPlane =
        scene.addMesh(makeBox({0.05, 0.05, 0.05}), 1, {0.01, 0.02, 0.05 + 1.5 * kMargin});
    const btRigidBody& onBox =
        scene.addMesh(makeBox({0.05, 0.05, 0.05}), 1, {1.01, 0.02, 0.16 + 1.5 * kMargin});
    scene.step(480);
    EXPECT_NEAR(double(onPlane.getWorldTransform().getOrigin().z()), 0.05 + kMargin, 0.1 * kMargin);
    EXPECT_NEAR(double(onBox.getWorldTransform().getOrigin().z()), 0.16 + kMargin, 0.1 * kMargin);
    EXPECT_LT(speed(onPlane), 1e-3);
    EXPECT_LT(speed(onBox), 1e-3);
}

TEST(Manifolds, ImpulsesAreInheritedFromTheSecondStepOn)
{
    ManifoldScene scene(false);
    scene.addMesh(raggedFloor(20, 0.5), 0, Vector3d::Zero());
    scene.addMesh(makeBox({0.05, 0.05, 0.05}), 1, {0.01, 0.02, 0.05 + kShell});
    scene.step(1);
    for (int i = 0; i < 20; ++i)
    {
        // What the next step's solver starts from: the contacts are found anew, not yet solved.
        scene.world->performDiscreteCollisionDetection();
        double sum = 0.0;
        for (const btManifoldPoint& point : scene.points())
        {
            sum += double(point.m_appliedImpulse);
            EXPECT_EQ(point.getLifeTime() > 0, true);
        }
        // Weight times step.
        EXPECT_NEAR(sum, 9.81 * kStep, 0.2 * 9.81 * kStep) << i;
        scene.step(1);
    }
}

struct Wrapped
{
    Wrapped(const btCollisionShape& shape, btCollisionObject& object)
        : wrapper(nullptr, &shape, &object, object.getWorldTransform(), -1, -1)
    {
    }
    btCollisionObjectWrapper wrapper;
};

TEST(Manifolds, ThePairMayBeAskedInEitherOrder)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btCcdShapeCache cache;
    btCcdMeshShape boxShape(std::make_shared<const SsvTree>(buildSsvTree(makeBox({1, 1, 1}))),
                            btScalar(0.01));
    btCcdMeshShape floorShape(std::make_shared<const SsvTree>(buildSsvTree(floorAt(0, 5))),
                              btScalar(0.01));
    btCollisionObject box;
    btCollisionObject floor;
    box.setCollisionShape(&boxShape);
    floor.setCollisionShape(&floorShape);
    box.setWorldTransform(btTransform(btQuaternion(btVector3(0, 0, 1), btScalar(0.3)),
                                      btVector3(btScalar(0.1), btScalar(0.2), btScalar(1.015))));
    Wrapped a(boxShape, box);
    Wrapped b(floorShape, floor);
    btCcdManifolds manifolds(dispatcher);
    btManifoldArray found;
    const auto ask = [&](const Wrapped& x, const Wrapped& y)
    {
        btManifoldResult result(&x.wrapper, &y.wrapper);
        manifolds.update(x.wrapper,
                         *cache.find(x.wrapper.getCollisionShape()),
                         y.wrapper,
                         *cache.find(y.wrapper.getCollisionShape()),
                         nullptr,
                         result);
        found.resize(0);
        manifolds.appendTo(found);
    };
    ask(a, b);
    ASSERT_EQ(found.size(), 1);
    ASSERT_EQ(found[0]->getNumContacts(), 4);
    std::vector<btManifoldPoint> before;
    for (int i = 0; i < 4; ++i)
    {
        found[0]->getContactPoint(i).m_appliedImpulse = btScalar(i + 1);
        before.push_back(found[0]->getContactPoint(i));
        EXPECT_NEAR(double(before.back().m_normalWorldOnB.z()), 1.0, 1e-6);
        EXPECT_NEAR(double(before.back().getDistance()), 0.015 - 0.02, 1e-6);
        // Half the shell to either side.
        EXPECT_NEAR(double(before.back().getPositionWorldOnB().z()), 0.01, 1e-6);
        EXPECT_NEAR(double(before.back().getPositionWorldOnA().z()), 0.005, 1e-6);
    }
    // The other way round: the same manifold keeps its order, points and impulses.
    ask(b, a);
    ASSERT_EQ(found.size(), 1);
    ASSERT_EQ(found[0]->getNumContacts(), 4);
    EXPECT_EQ(found[0]->getBody0(), &box);
    for (int i = 0; i < 4; ++i)
    {
        const btManifoldPoint& point = found[0]->getContactPoint(i);
        EXPECT_NEAR(double(point.m_normalWorldOnB.z()), 1.0, 1e-6);
        EXPECT_NEAR(double(point.getDistance()), 0.015 - 0.02, 1e-6);
        EXPECT_TRUE(
            std::any_of(before.begin(),
                        before.end(),
                        [&](const btManifoldPoint& p)
                        {
                            return (p.m_localPointA - point.m_localPointA).length() < 1e-5 &&
                                   (p.m_localPointB - point.m_localPointB).length() < 1e-5 &&
                                   p.m_appliedImpulse == point.m_appliedImpulse;
                        }));
    }
    // A pair that starts that way is the mirror image.
    btCcdManifolds mirrored(dispatcher);
    btManifoldResult result(&b.wrapper, &a.wrapper);
    mirrored.update(
        b.wrapper, *cache.find(&floorShape), a.wrapper, *cache.find(&boxShape), nullptr, result);
    found.resize(0);
    mirrored.appendTo(found);
    ASSERT_EQ(found.size(), 1);
    ASSERT_EQ(found[0]->getNumContacts(), 4);
    EXPECT_EQ(found[0]->getBody0(), &floor);
    for (int i = 0; i < 4; ++i)
    {
        EXPECT_NEAR(double(found[0]->getContactPoint(i).m_normalWorldOnB.z()), -1.0, 1e-6);
    }
}

TEST(Manifolds, ASharedManifoldTakesAllPointsInItsOwnOrder)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btCcdShapeCache cache;
    btCcdMeshShape boxShape(std::make_shared<const SsvTree>(buildSsvTree(makeBox({1, 1, 1}))),
                            btScalar(0.01));
    btCcdMeshShape floorShape(std::make_shared<const SsvTree>(buildSsvTree(floorAt(0, 5))),
                              btScalar(0.01));
    btCollisionObject box;
    btCollisionObject floor;
    box.setCollisionShape(&boxShape);
    floor.setCollisionShape(&floorShape);
    box.setWorldTransform(
        btTransform(btQuaternion::getIdentity(), btVector3(0, 0, btScalar(1.02))));
    Wrapped a(boxShape, box);
    Wrapped b(floorShape, floor);
    for (const bool swapped : {false, true})
    {
        btPersistentManifold* shared = swapped ? dispatcher.getNewManifold(&floor, &box)
                                               : dispatcher.getNewManifold(&box, &floor);
        {
            btCcdManifolds manifolds(dispatcher);
            btManifoldResult result(&a.wrapper, &b.wrapper);
            manifolds.update(a.wrapper,
                             *cache.find(&boxShape),
                             b.wrapper,
                             *cache.find(&floorShape),
                             shared,
                             result);
            btManifoldArray own;
            manifolds.appendTo(own);
            EXPECT_EQ(own.size(), 0);
        }
        ASSERT_EQ(shared->getNumContacts(), 4);
        for (int i = 0; i < 4; ++i)
        {
            const btManifoldPoint& point = shared->getContactPoint(i);
            EXPECT_NEAR(double(point.m_normalWorldOnB.z()), swapped ? -1.0 : 1.0, 1e-6);
            EXPECT_NEAR(double(point.m_localPointA.z()), swapped ? 0.01 : -1.01, 1e-5);
        }
        dispatcher.releaseManifold(shared);
    }
}

TEST(Manifolds, AnAngleOnAStepHasAManifoldForEachWallThatPersists)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btCcdShapeCache cache;
    // Lies on the step and leans against its wall.
    btCcdMeshShape angleShape(
        std::make_shared<const SsvTree>(buildSsvTree(
            merged({box({-1, -0.4, 0}, {0.3, 0.4, 0.3}), box({0, -0.4, -0.5}, {0.3, 0.4, 0})}))),
        btScalar(0.01));
    btCcdMeshShape stepShape(
        std::make_shared<const SsvTree>(buildSsvTree(box({-2, -2, -1}, {0, 2, 0}))),
        btScalar(0.01));
    btCollisionObject angle;
    btCollisionObject step;
    angle.setCollisionShape(&angleShape);
    step.setCollisionShape(&stepShape);
    btCcdManifolds manifolds(dispatcher);
    btManifoldArray found;
    const btPersistentManifold* floorManifold = nullptr;
    for (int i = 0; i < 10; ++i)
    {
        // Now one, now the other is the deeper: the order of the patches changes.
        const bool first = i % 2 == 0;
        angle.setWorldTransform(btTransform(btQuaternion::getIdentity(),
                                            btVector3(btScalar(first ? 0.015 : 0.01),
                                                      btScalar(0.001 * i),
                                                      btScalar(first ? 0.01 : 0.015))));
        Wrapped a(angleShape, angle);
        Wrapped b(stepShape, step);
        btManifoldResult result(&a.wrapper, &b.wrapper);
        manifolds.update(a.wrapper,
                         *cache.find(&angleShape),
                         b.wrapper,
                         *cache.find(&stepShape),
                         nullptr,
                         result);
        found.resize(0);
        manifolds.appendTo(found);
        ASSERT_EQ(found.size(), 2);
        for (int k = 0; k < 2; ++k)
        {
            EXPECT_EQ(found[k]->getNumContacts(), 4);
            EXPECT_EQ(found[k]->getContactPoint(0).getLifeTime(), i);
            if (found[k]->getContactPoint(0).m_normalWorldOnB.z() > 0.9)
            {
                EXPECT_TRUE(floorManifold == nullptr || floorManifold == found[k]);
                floorManifold = found[k];
            }
        }
    }
    EXPECT_NE(floorManifold, nullptr);
    // Away: the points go, one empty manifold stays.
    angle.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 0, 3)));
    Wrapped a(angleShape, angle);
    Wrapped b(stepShape, step);
    btManifoldResult result(&a.wrapper, &b.wrapper);
    manifolds.update(
        a.wrapper, *cache.find(&angleShape), b.wrapper, *cache.find(&stepShape), nullptr, result);
    EXPECT_EQ(dispatcher.getNumManifolds(), 1);
    EXPECT_EQ(dispatcher.getManifoldByIndexInternal(0)->getNumContacts(), 0);
}

struct Closest : btCollisionWorld::ContactResultCallback
{
    btScalar addSingleResult(btManifoldPoint& point,
                             const btCollisionObjectWrapper*,
                             int,
                             int,
                             const btCollisionObjectWrapper*,
                             int,
                             int) override
    {
        ++m_count;
        m_least = std::min(m_least, double(point.getDistance()));
        return 0;
    }
    int m_count = 0;
    double m_least = 1e9;
};

TEST(Manifolds, AContactTestReachesAsFarAsItAsks)
{
    ManifoldScene scene(false);
    btRigidBody& ground = scene.addMesh(raggedFloor(20, 0.5), 0, Vector3d::Zero());
    btRigidBody& box = scene.addMesh(makeBox({0.05, 0.05, 0.05}), 1, {0.01, 0.02, 0.05 + 0.02});
    Closest near;
    scene.world->contactPairTest(&ground, &box, near);
    EXPECT_EQ(near.m_count, 0);
    Closest far;
    far.m_closestDistanceThreshold = btScalar(0.03);
    scene.world->contactPairTest(&ground, &box, far);
    EXPECT_EQ(far.m_count, 4);
    EXPECT_NEAR(far.m_least, 0.02 - kShell, 1e-6);
}

TEST(Manifolds, WhatTheSolverDoesNotProcessIsNotLookedFor)
{
    // How many points there are at a distance, by the threshold of either body.
    const auto count = [](double distance, double ofGround, double ofBox)
    {
        ManifoldScene scene(false);
        btRigidBody& ground = scene.addMesh(raggedFloor(20, 0.5), 0, Vector3d::Zero());
        btRigidBody& box =
            scene.addMesh(makeBox({0.05, 0.05, 0.05}), 1, {0.01, 0.02, 0.05 + distance});
        ground.setContactProcessingThreshold(btScalar(ofGround));
        box.setContactProcessingThreshold(btScalar(ofBox));
        scene.world->performDiscreteCollisionDetection();
        return scene.points().size();
    };
    constexpr double kAny = 1e9;
    EXPECT_EQ(count(1.7 * kShell, kAny, kAny), 4U);
    EXPECT_EQ(count(1.7 * kShell, 0.5 * kShell, kAny), 0U);
    EXPECT_EQ(count(1.7 * kShell, kAny, 0.5 * kShell), 0U);
    EXPECT_EQ(count(1.4 * kShell, kAny, 0.5 * kShell), 4U);
    // Whatever it is, what touches is held.
    EXPECT_EQ(count(1.1 * kShell, 0.0, -1.0), 4U);
}

int started = 0;
int ended = 0;
int destroyed = 0;

TEST(Manifolds, CallbacksTellOfTheStartAndTheEndOfContactOnce)
{
    ManifoldScene scene(false);
    scene.addMesh(raggedFloor(20, 0.5), 0, Vector3d::Zero());
    btRigidBody& box = scene.addMesh(makeBox({0.05, 0.05, 0.05}), 1, {0.01, 0.02, 0.05 + kShell});
    gContactStartedCallback = [](btPersistentManifold* const&) { ++started; };
    gContactEndedCallback = [](btPersistentManifold* const&) { ++ended; };
    gContactDestroyedCallback = [](void*) { return ++destroyed > 0; };
    scene.step(1);
    btPersistentManifold* manifold = scene.dispatcher.getManifoldByIndexInternal(0);
    ASSERT_EQ(manifold->getNumContacts(), 4);
    for (int i = 0; i < 4; ++i)
    {
        manifold->getContactPoint(i).m_userPersistentData = &scene;
    }
    scene.step(100);
    EXPECT_EQ(started, 1);
    EXPECT_EQ(ended, 0);
    EXPECT_EQ(destroyed, 0);
    for (int i = 0; i < 4; ++i)
    {
        EXPECT_EQ(manifold->getContactPoint(i).m_userPersistentData, &scene);
    }
    box.setLinearVelocity(btVector3(0, 0, 3));
    scene.step(10);
    EXPECT_EQ(started, 1);
    EXPECT_EQ(ended, 1);
    EXPECT_EQ(destroyed, 4);
    gContactStartedCallback = nullptr;
    gContactEndedCallback = nullptr;
    gContactDestroyedCallback = nullptr;
}

TEST(Manifolds, ChildrenOfCompoundsHaveContactsInEitherOrder)
{
    for (const bool floorFirst : {true, false})
    {
        ManifoldScene scene(false);
        const auto addFloor = [&] { scene.addMesh(raggedFloor(20, 0.5), 0, Vector3d::Zero()); };
        if (floorFirst)
        {
            addFloor();
        }
        auto child = std::make_unique<btCcdMeshShape>(
            std::make_shared<const SsvTree>(buildSsvTree(makeBox({0.02, 0.02, 0.02}))),
            btScalar(kMargin));
        auto compound = std::make_unique<btCompoundShape>();
        for (const double x : {-0.05, 0.05})
        {
            btTransform X = btTransform::getIdentity();
            X.setOrigin(btVector3(btScalar(x), 0, 0));
            compound->addChildShape(X, child.get());
        }
        btRigidBody& body = scene.add(std::move(compound), 1, {0, 0, 0.02 + kShell});
        scene.shapes.push_back(std::move(child));
        if (!floorFirst)
        {
            addFloor();
        }
        scene.step(480);
        expectRest(body, {0, 0, 0.02 + kShell}, floorFirst ? "floor first" : "floor last");
        EXPECT_EQ(scene.points().size(), 8U);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
