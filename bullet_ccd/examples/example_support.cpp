#include "bullet_ccd/examples/example_support.h"

#include <Eigen/Eigenvalues>

#include <cstdio>
#include <utility>

namespace bullet_ccd::examples
{
namespace
{
int failures = 0;
}

World::World(Engine engine) : m_dispatcher(&m_configuration)
{
    if (engine == Engine::Ccd)
    {
        m_world = std::make_unique<btCcdMultiBodyDynamicsWorld>(
            &m_dispatcher, &m_broadphase, &m_solver, &m_configuration);
    }
    else
    {
        m_world = std::make_unique<btMultiBodyDynamicsWorld>(
            &m_dispatcher, &m_broadphase, &m_solver, &m_configuration);
    }
}

World::~World()
{
    for (const auto& body : m_bodies)
    {
        m_world->removeRigidBody(body.get());
    }
}

btCcdMultiBodyDynamicsWorld& World::ccd()
{
    return dynamic_cast<btCcdMultiBodyDynamicsWorld&>(*m_world);
}

btRigidBody* World::add(std::unique_ptr<btCollisionShape> shape,
                        double mass,
                        const btTransform& pose)
{
    btVector3 inertia(0, 0, 0);
    if (mass > 0.0)
    {
        shape->calculateLocalInertia(btScalar(mass), inertia);
    }
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape.get(), inertia);
    info.m_startWorldTransform = pose;
    m_shapes.push_back(std::move(shape));
    m_bodies.push_back(std::make_unique<btRigidBody>(info));
    m_world->addRigidBody(m_bodies.back().get());
    return m_bodies.back().get();
}

btTransform poseAt(double x, double y, double z)
{
    return btTransform(btQuaternion::getIdentity(),
                       btVector3(btScalar(x), btScalar(y), btScalar(z)));
}

Eigen::Isometry3d putIntoPrincipalAxes(TriangleMesh& mesh)
{
    const MassProperties solid = massProperties(mesh);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(solid.inertia);
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = principal.eigenvectors();
    if (X.linear().determinant() < 0.0)
    {
        X.linear().col(2) *= -1.0;
    }
    X.translation() = solid.center;
    transformMesh(mesh, Eigen::Affine3d(X.inverse()));
    return X;
}

std::unique_ptr<btCcdMeshShape> meshShape(TriangleMesh mesh)
{
    return std::make_unique<btCcdMeshShape>(
        std::make_shared<const SsvTree>(buildSsvTree(std::move(mesh))));
}

void check(bool holds, const std::string& what)
{
    std::printf("%s: %s\n", holds ? "ok" : "FAILED", what.c_str());
    failures += holds ? 0 : 1;
}

int exitCode()
{
    return failures == 0 ? 0 : 1;
}
}  // namespace bullet_ccd::examples
