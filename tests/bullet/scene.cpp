#include "tests/bullet/scene.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/make_mesh.h"

#include <utility>

namespace bullet_ccd::tests
{
btTransform poseAt(const btVector3& origin, double angleAboutZ)
{
    return btTransform(btQuaternion(btVector3(0, 0, 1), btScalar(angleAboutZ)), origin);
}

Scene::Scene(Kind kind) : m_dispatcher(&m_configuration)
{
    if (kind == Kind::Ccd)
    {
        m_world = std::make_unique<btCcdMultiBodyDynamicsWorld>(
            &m_dispatcher, &m_broadphase, &m_solver, &m_configuration);
    }
    else
    {
        m_world = std::make_unique<btMultiBodyDynamicsWorld>(
            &m_dispatcher, &m_broadphase, &m_solver, &m_configuration);
    }
    m_world->setGravity(vec(0, 0, 0));
}

Scene::~Scene()
{
    for (const auto& collider : m_colliders)
    {
        m_world->removeCollisionObject(collider.get());
    }
    for (const auto& body : m_multiBodies)
    {
        m_world->removeMultiBody(body.get());
    }
    for (const auto& body : m_bodies)
    {
        m_world->removeRigidBody(body.get());
    }
}

btCcdMultiBodyDynamicsWorld& Scene::ccd()
{
    return dynamic_cast<btCcdMultiBodyDynamicsWorld&>(*m_world);
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
    m_world->addRigidBody(m_bodies.back().get());
    m_bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    return m_bodies.back().get();
}

btMultiBody* Scene::chain(const std::vector<btCollisionShape*>& links,
                          double halfLength,
                          const btTransform& base)
{
    const btVector3 inertia = vec(1e-5, 1e-5, 1e-5);
    auto body = std::make_unique<btMultiBody>(int(links.size()), btScalar(0), inertia, true, false);
    body->setBaseWorldTransform(base);
    for (int i = 0; i < int(links.size()); ++i)
    {
        const btVector3 pivot = i == 0 ? vec(0, 0, 0) : vec(halfLength, 0, 0);
        body->setupRevolute(i,
                            btScalar(0.01),
                            inertia,
                            i - 1,
                            btQuaternion::getIdentity(),
                            vec(0, 0, 1),
                            pivot,
                            vec(halfLength, 0, 0),
                            true);
    }
    body->finalizeMultiDof();
    body->setLinearDamping(0);
    body->setAngularDamping(0);
    body->setMaxCoordinateVelocity(btScalar(1e4));
    m_world->addMultiBody(body.get());
    // The base collider is needed to stop links for good; it is out of everything's way.
    const auto add = [&](int link, btCollisionShape* shape)
    {
        m_colliders.push_back(std::make_unique<btMultiBodyLinkCollider>(body.get(), link));
        m_colliders.back()->setCollisionShape(shape);
        m_world->addCollisionObject(m_colliders.back().get(),
                                    btBroadphaseProxy::DefaultFilter,
                                    link < 0 ? 0 : int(btBroadphaseProxy::AllFilter));
        return m_colliders.back().get();
    };
    body->setBaseCollider(add(-1, box(vec(1e-3, 1e-3, 1e-3))));
    for (int i = 0; i < int(links.size()); ++i)
    {
        body->getLink(i).m_collider = add(i, links[std::size_t(i)]);
    }
    placeColliders(*body);
    m_multiBodies.push_back(std::move(body));
    return m_multiBodies.back().get();
}

void Scene::placeColliders(btMultiBody& body)
{
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body.forwardKinematics(rotations, origins);
    body.updateCollisionObjectWorldTransforms(rotations, origins);
}
}  // namespace bullet_ccd::tests
