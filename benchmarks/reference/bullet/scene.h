/// Bullet worlds for tests and benchmarks, stock or ours, in whichever precision is compiled.
#pragma once

#include "bullet_ccd/bullet/btCcdAction.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/bullet/btCcdMultiBodyDynamicsWorld.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <array>
#include <functional>
#include <memory>
#include <vector>

class btStridingMeshInterface;
class btTriangleMesh;

namespace bullet_ccd::reference
{
inline constexpr bool kDouble = sizeof(btScalar) == 8;

[[nodiscard]] inline btVector3 vec(double x, double y, double z)
{
    return {btScalar(x), btScalar(y), btScalar(z)};
}

/// Rotation about z, then a shift.
[[nodiscard]] btTransform poseAt(const btVector3& origin, double angleAboutZ = 0.0);

/// As Bullet's own meshes refer to them; they must live as long.
[[nodiscard]] std::unique_ptr<btTriangleMesh> bulletTriangles(const TriangleMesh& mesh);

/// A height for every point of a square grid in the xy plane, whose middle is the origin.
[[nodiscard]] TriangleMesh gridMesh(int side,
                                    double spacing,
                                    const std::function<double(int, int)>& height);

/// How a world treats what is fast.
enum class Kind
{
    Stock,
    StockCcd,  ///< Bullet's own: motion threshold, swept sphere, no penetration allowed
    Action,    ///< a stock world with btCcdAction
    World,     ///< btCcdDiscreteDynamicsWorld or btCcdMultiBodyDynamicsWorld
};
inline constexpr std::array kAllKinds{Kind::Stock, Kind::StockCcd, Kind::Action, Kind::World};
inline constexpr std::array kOurKinds{Kind::Action, Kind::World};

/// Which of Bullet's worlds it is.
enum class WorldClass
{
    MultiBody,  ///< btMultiBodyDynamicsWorld with btMultiBodyConstraintSolver
    Rigid,      ///< btDiscreteDynamicsWorld with btSequentialImpulseConstraintSolver
};

[[nodiscard]] const char* nameOf(Kind kind);
/// One word, for names of tests and arguments of programs.
[[nodiscard]] const char* codeOf(Kind kind);
[[nodiscard]] inline bool isOurs(Kind kind)
{
    return kind == Kind::Action || kind == Kind::World;
}

/// One world and everything in it; no gravity, no damping.
class Scene
{
public:
    explicit Scene(Kind kind, WorldClass worldClass = WorldClass::MultiBody);
    ~Scene();
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    btDiscreteDynamicsWorld& world() { return *m_world; }
    /// Adds the action, if that is the kind and it is not there yet. step() and ccd() do so: the
    /// action comes last and can look at all objects before the first step.
    void addHooks();
    /// Of ours.
    btCcdControl& ccd()
    {
        addHooks();
        return *m_ccd;
    }
    /// Of ours; all zero for the other kinds.
    [[nodiscard]] btCcdCounters counters() const;
    /// Of ours: of the object that lost most [s].
    [[nodiscard]] double lostTime() const;
    void step(double seconds)
    {
        addHooks();
        m_world->stepSimulation(btScalar(seconds), 0);
    }

    btBoxShape* box(const btVector3& halfExtents);
    btCcdMeshShape* mesh(TriangleMesh triangles);
    btCcdMeshShape* boxMesh(const btVector3& halfExtents);
    /// Bullet's static triangle mesh.
    btCollisionShape* staticMesh(const TriangleMesh& triangles);
    /// Bullet's height field in the xy plane, with samples a metre apart, between -10 and 10 m.
    btCollisionShape* heightField(int side, const std::function<double(int, int)>& height);
    /// Keeps a shape alive until the world is gone.
    template <typename Shape>
    Shape* keep(std::unique_ptr<Shape> shape)
    {
        Shape* raw = shape.get();
        m_shapes.push_back(std::move(shape));
        return raw;
    }

    /// Mass 0: static.
    btRigidBody* body(btCollisionShape* shape, double mass, const btTransform& pose);
    /// Chain on a fixed base without geometry: hinges about z, links along x of the shape's length,
    /// centres of mass in the middle. All links may collide, parents with children not.
    /// @param masses of the links; empty: 10 g each
    btMultiBody* chain(const std::vector<btCollisionShape*>& links,
                       double halfLength,
                       const btTransform& base,
                       const std::vector<double>& masses = {});
    /// Takes over a body whose joints are set up: colliders for the base (if it has a shape) and
    /// for the links (null: none), then the body goes into the world. No damping.
    /// @param baseMask what the base collides with
    btMultiBody* addMultiBody(std::unique_ptr<btMultiBody> body,
                              btCollisionShape* base,
                              const std::vector<btCollisionShape*>& links,
                              int baseMask = btBroadphaseProxy::AllFilter);
    void addConstraint(std::unique_ptr<btTypedConstraint> constraint, bool collide = false);
    void addConstraint(std::unique_ptr<btMultiBodyConstraint> constraint);
    /// After joints were set by hand.
    static void placeColliders(btMultiBody& body);

private:
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher;
    btDbvtBroadphase m_broadphase;
    std::unique_ptr<btSequentialImpulseConstraintSolver> m_solver;
    std::vector<std::unique_ptr<btStridingMeshInterface>> m_triangles;
    std::vector<std::vector<btScalar>> m_heights;
    std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
    std::vector<std::unique_ptr<btMultiBody>> m_multiBodies;
    std::vector<std::unique_ptr<btMultiBodyLinkCollider>> m_colliders;
    std::vector<std::unique_ptr<btRigidBody>> m_bodies;
    std::vector<std::unique_ptr<btTypedConstraint>> m_constraints;
    std::vector<std::unique_ptr<btMultiBodyConstraint>> m_multiBodyConstraints;
    std::unique_ptr<btDiscreteDynamicsWorld> m_world;
    btMultiBodyDynamicsWorld* m_multiBodyWorld = nullptr;  // the same, if it is one
    std::unique_ptr<btCcdAction> m_action;
    btCcdControl* m_ccd = nullptr;  // the action or the world
    Kind m_kind;

    void makeMultiBodyWorld();
    void makeRigidWorld();

    void enableStockCcd(btCollisionObject& object) const;
    btMultiBodyLinkCollider* collider(btMultiBody& body, int link, btCollisionShape* shape);
};
}  // namespace bullet_ccd::reference
