/// What the example programs share: a world with all that Bullet wants for it, bodies, checks.
#pragma once

#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/bullet/btCcdMultiBodyDynamicsWorld.h"

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <string>
#include <vector>

namespace bullet_ccd::examples
{
enum class Engine
{
    Bullet,  ///< as shipped
    Ccd,
};

/// A world, and the bodies that were made for it.
class World
{
public:
    explicit World(Engine engine);
    ~World();
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    btMultiBodyDynamicsWorld& operator*() { return *m_world; }
    btMultiBodyDynamicsWorld* operator->() { return m_world.get(); }
    /// @pre Engine::Ccd
    btCcdMultiBodyDynamicsWorld& ccd();

    /// A body of the given mass [kg], 0 for one that does not move; lives as long as the world.
    btRigidBody* add(std::unique_ptr<btCollisionShape> shape,
                     double mass,
                     const btTransform& pose = btTransform::getIdentity());

private:
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher;
    btDbvtBroadphase m_broadphase;
    btMultiBodyConstraintSolver m_solver;
    std::unique_ptr<btMultiBodyDynamicsWorld> m_world;
    std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
    std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};

[[nodiscard]] btTransform poseAt(double x, double y, double z);

/// Moves a closed mesh into its centre of mass and principal axes, where its inertia is diagonal
/// (btRigidBody knows no other), and returns the pose that puts it back.
[[nodiscard]] Eigen::Isometry3d putIntoPrincipalAxes(TriangleMesh& mesh);

[[nodiscard]] std::unique_ptr<btCcdMeshShape> meshShape(TriangleMesh mesh);

/// Prints "ok" or "FAILED" and what was to be shown; remembers failures for exitCode().
void check(bool holds, const std::string& what);
[[nodiscard]] int exitCode();
}  // namespace bullet_ccd::examples
