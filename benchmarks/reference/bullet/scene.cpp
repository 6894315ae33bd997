#include "benchmarks/reference/bullet/scene.h"

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdDiscreteDynamicsWorld.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>

#include <algorithm>
#include <utility>

namespace bullet_ccd::reference
{
btTransform poseAt(const btVector3& origin, double angleAboutZ)
{
    return btTransform(btQuaternion(btVector3(0, 0, 1), btScalar(angleAboutZ)), origin);
}

std::unique_ptr<btTriangleMesh> bulletTriangles(const TriangleMesh& mesh)
{
    auto triangles = std::make_unique<btTriangleMesh>();
    for (const Triangle& t : mesh.triangles)
    {
        const auto corner = [&](std::size_t k)
        { return btCcdToBullet(mesh.vertices[static_cast<std::size_t>(t[k])]); };
        triangles->addTriangle(corner(0), corner(1), corner(2));
    }
    return triangles;
}

TriangleMesh gridMesh(int side, double spacing, const std::function<double(int, int)>& height)
{
    TriangleMesh mesh;
    for (int i = 0; i < side * side; ++i)
    {
        const int x = i % side;
        const int y = i / side;
        const double half = 0.5 * (side - 1);
        mesh.vertices.emplace_back(spacing * (x - half), spacing * (y - half), height(x, y));
        if (x + 1 < side && y + 1 < side)
        {
            mesh.triangles.push_back({i, i + 1, i + side + 1});
            mesh.triangles.push_back({i, i + side + 1, i + side});
        }
    }
    return mesh;
}

const char* nameOf(Kind kind)
{
    constexpr std::array kNames{"stock", "stock CCD", "ours, action", "ours, world"};
    return kNames[static_cast<std::size_t>(kind)];
}

const char* codeOf(Kind kind)
{
    constexpr std::array kCodes{"Stock", "StockCcd", "Action", "World"};
    return kCodes[static_cast<std::size_t>(kind)];
}

Scene::Scene(Kind kind, WorldClass worldClass) : m_dispatcher(&m_configuration), m_kind(kind)
{
    if (!isOurs(kind))
    {
        // Without it stock Bullet has no contacts at all for these meshes.
        btGImpactCollisionAlgorithm::registerAlgorithm(&m_dispatcher);
    }
    if (worldClass == WorldClass::MultiBody)
    {
        makeMultiBodyWorld();
    }
    else
    {
        makeRigidWorld();
    }
    if (kind == Kind::StockCcd)
    {
        // Below this much per step Bullet ignores its own hits; 40 mm by default.
        m_world->getDispatchInfo().m_allowedCcdPenetration = btScalar(1e-4);
    }
    m_world->setGravity(vec(0, 0, 0));
}

void Scene::addHooks()
{
    if (m_kind == Kind::Action && m_action == nullptr)
    {
        m_action = std::make_unique<btCcdAction>(m_world.get());
        m_world->addAction(m_action.get());
        m_ccd = m_action.get();
    }
}

void Scene::makeMultiBodyWorld()
{
    auto solver = std::make_unique<btMultiBodyConstraintSolver>();
    std::unique_ptr<btMultiBodyDynamicsWorld> world;
    if (m_kind == Kind::World)
    {
        auto ours = std::make_unique<btCcdMultiBodyDynamicsWorld>(
            &m_dispatcher, &m_broadphase, solver.get(), &m_configuration);
        m_ccd = ours.get();
        world = std::move(ours);
    }
    else
    {
        world = std::make_unique<btMultiBodyDynamicsWorld>(
            &m_dispatcher, &m_broadphase, solver.get(), &m_configuration);
    }
    m_multiBodyWorld = world.get();
    m_solver = std::move(solver);
    m_world = std::move(world);
}

void Scene::makeRigidWorld()
{
    m_solver = std::make_unique<btSequentialImpulseConstraintSolver>();
    if (m_kind == Kind::World)
    {
        auto ours = std::make_unique<btCcdDiscreteDynamicsWorld>(
            &m_dispatcher, &m_broadphase, m_solver.get(), &m_configuration);
        m_ccd = ours.get();
        m_world = std::move(ours);
    }
    else
    {
        m_world = std::make_unique<btDiscreteDynamicsWorld>(
            &m_dispatcher, &m_broadphase, m_solver.get(), &m_configuration);
    }
}

void Scene::addConstraint(std::unique_ptr<btTypedConstraint> constraint, bool collide)
{
    m_world->addConstraint(constraint.get(), !collide);
    m_constraints.push_back(std::move(constraint));
}

void Scene::addConstraint(std::unique_ptr<btMultiBodyConstraint> constraint)
{
    m_multiBodyWorld->addMultiBodyConstraint(constraint.get());
    constraint->finalizeMultiDof();
    m_multiBodyConstraints.push_back(std::move(constraint));
}

Scene::~Scene()
{
    for (const auto& constraint : m_multiBodyConstraints)
    {
        m_multiBodyWorld->removeMultiBodyConstraint(constraint.get());
    }
    for (const auto& constraint : m_constraints)
    {
        m_world->removeConstraint(constraint.get());
    }
    for (const auto& collider : m_colliders)
    {
        m_world->removeCollisionObject(collider.get());
    }
    for (const auto& body : m_multiBodies)
    {
        m_multiBodyWorld->removeMultiBody(body.get());
    }
    for (const auto& body : m_bodies)
    {
        m_world->removeRigidBody(body.get());
    }
    if (m_action != nullptr)
    {
        m_world->removeAction(m_action.get());
        m_action.reset();
    }
    m_world.reset();
    if (isOurs(m_kind))
    {
        btCcdCollisionAlgorithm::unregisterAlgorithm(&m_dispatcher);
    }
}

btCcdCounters Scene::counters() const
{
    return m_ccd != nullptr ? m_ccd->getCcdCounters() : btCcdCounters{};
}

double Scene::lostTime() const
{
    double lost = 0.0;
    for (int i = 0; m_ccd != nullptr && i < m_world->getNumCollisionObjects(); ++i)
    {
        const btCollisionObject* object = m_world->getCollisionObjectArray()[i];
        lost = std::max(lost, m_ccd->getCcdLostTime(object));
    }
    return lost;
}

btBoxShape* Scene::box(const btVector3& halfExtents)
{
    btBoxShape* shape = keep(std::make_unique<btBoxShape>(halfExtents));
    shape->setMargin(halfExtents[halfExtents.minAxis()] * btScalar(0.1));
    return shape;
}

btCcdMeshShape* Scene::mesh(TriangleMesh triangles)
{
    return keep(std::make_unique<btCcdMeshShape>(
        std::make_shared<const SsvTree>(buildSsvTree(std::move(triangles)))));
}

btCcdMeshShape* Scene::boxMesh(const btVector3& halfExtents)
{
    return mesh(makeBox(btCcdToEigen(halfExtents)));
}

btCollisionShape* Scene::staticMesh(const TriangleMesh& triangles)
{
    std::unique_ptr<btTriangleMesh> interface = bulletTriangles(triangles);
    btBvhTriangleMeshShape* shape =
        keep(std::make_unique<btBvhTriangleMeshShape>(interface.get(), true));
    m_triangles.push_back(std::move(interface));
    return shape;
}

btCollisionShape* Scene::heightField(int side, const std::function<double(int, int)>& height)
{
    std::vector<btScalar>& heights = m_heights.emplace_back();
    for (int i = 0; i < side * side; ++i)
    {
        heights.push_back(btScalar(height(i % side, i / side)));
    }
    constexpr btScalar kHighest = 10;
    return keep(std::make_unique<btHeightfieldTerrainShape>(side,
                                                            side,
                                                            heights.data(),
                                                            btScalar(1),
                                                            -kHighest,
                                                            kHighest,
                                                            2,
                                                            kDouble ? PHY_DOUBLE : PHY_FLOAT,
                                                            false));
}

btRigidBody* Scene::body(btCollisionShape* shape, double mass, const btTransform& pose)
{
    btVector3 inertia(0, 0, 0);
    if (mass > 0.0)
    {
        shape->calculateLocalInertia(btScalar(mass), inertia);
    }
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape, inertia);
    info.m_startWorldTransform = pose;
    m_bodies.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody* body = m_bodies.back().get();
    m_world->addRigidBody(body);
    body->setActivationState(DISABLE_DEACTIVATION);
    if (mass > 0.0)
    {
        enableStockCcd(*body);
    }
    return body;
}

void Scene::enableStockCcd(btCollisionObject& object) const
{
    if (m_kind != Kind::StockCcd)
    {
        return;
    }
    btVector3 low;
    btVector3 high;
    object.getCollisionShape()->getAabb(btTransform::getIdentity(), low, high);
    const btVector3 half = btScalar(0.5) * (high - low);
    // As the manual advises: a sphere inside the shape, every motion that is not tiny.
    object.setCcdSweptSphereRadius(btScalar(0.8) * half[half.minAxis()]);
    object.setCcdMotionThreshold(btScalar(1e-4));
}

btMultiBodyLinkCollider* Scene::collider(btMultiBody& body, int link, btCollisionShape* shape)
{
    m_colliders.push_back(std::make_unique<btMultiBodyLinkCollider>(&body, link));
    m_colliders.back()->setCollisionShape(shape);
    enableStockCcd(*m_colliders.back());
    return m_colliders.back().get();
}

btMultiBody* Scene::addMultiBody(std::unique_ptr<btMultiBody> body,
                                 btCollisionShape* base,
                                 const std::vector<btCollisionShape*>& links,
                                 int baseMask)
{
    body->setLinearDamping(0);
    body->setAngularDamping(0);
    body->setMaxCoordinateVelocity(btScalar(1e4));
    m_multiBodyWorld->addMultiBody(body.get());
    const auto add = [&](int link, btCollisionShape* shape, int mask)
    {
        btMultiBodyLinkCollider* added = collider(*body, link, shape);
        m_world->addCollisionObject(added, btBroadphaseProxy::DefaultFilter, mask);
        return added;
    };
    if (base != nullptr)
    {
        body->setBaseCollider(add(-1, base, baseMask));
    }
    for (int i = 0; i < int(links.size()); ++i)
    {
        if (links[std::size_t(i)] != nullptr)
        {
            body->getLink(i).m_collider =
                add(i, links[std::size_t(i)], btBroadphaseProxy::AllFilter);
        }
    }
    placeColliders(*body);
    m_multiBodies.push_back(std::move(body));
    return m_multiBodies.back().get();
}

btMultiBody* Scene::chain(const std::vector<btCollisionShape*>& links,
                          double halfLength,
                          const btTransform& base,
                          const std::vector<double>& masses)
{
    auto body = std::make_unique<btMultiBody>(
        int(links.size()), btScalar(0), vec(1e-5, 1e-5, 1e-5), true, false);
    body->setBaseWorldTransform(base);
    for (int i = 0; i < int(links.size()); ++i)
    {
        const double mass = masses.empty() ? 0.01 : masses[std::size_t(i)];
        const btVector3 inertia = vec(1e-3, 1e-3, 1e-3) * btScalar(mass);
        const btVector3 pivot = i == 0 ? vec(0, 0, 0) : vec(halfLength, 0, 0);
        body->setupRevolute(i,
                            btScalar(mass),
                            inertia,
                            i - 1,
                            btQuaternion::getIdentity(),
                            vec(0, 0, 1),
                            pivot,
                            vec(halfLength, 0, 0),
                            true);
    }
    body->finalizeMultiDof();
    // The base collider is needed to stop links for good; it is out of everything's way.
    return addMultiBody(std::move(body), box(vec(1e-3, 1e-3, 1e-3)), links, 0);
}

void Scene::placeColliders(btMultiBody& body)
{
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body.forwardKinematics(rotations, origins);
    body.updateCollisionObjectWorldTransforms(rotations, origins);
}
}  // namespace bullet_ccd::reference
