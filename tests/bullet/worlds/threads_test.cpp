#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/btCcdAction.h"
#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdDiscreteDynamicsWorld.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/bullet/btCcdMultiBodyDynamicsWorld.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <LinearMath/btThreads.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <memory>
#include <oneapi/tbb/global_control.h>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// Bullet asks every algorithm on several threads, if it has been built thread-safe; else on one.
struct Tasks
{
    Tasks()
    {
        btITaskScheduler* scheduler = btCreateDefaultTaskScheduler();
        if (scheduler != nullptr)
        {
            scheduler->setNumThreads(4);
        }
        btSetTaskScheduler(scheduler != nullptr ? scheduler : btGetSequentialTaskScheduler());
    }
};

/// A pile of cubes that are meshes, balls and hulls, at speed; how many are below the floor then.
int throughFloor(btDiscreteDynamicsWorld& world)
{
    const auto cube = btCcdMeshShape::fromMesh(makeBox({0.1, 0.1, 0.1}));
    btSphereShape ball(btScalar(0.1));
    btConvexHullShape hull;
    for (int i = 0; i < 8; ++i)
    {
        hull.addPoint({btScalar(i % 2 == 0 ? -0.1 : 0.1),
                       btScalar(i / 2 % 2 == 0 ? -0.1 : 0.1),
                       btScalar(i / 4 == 0 ? -0.1 : 0.1)});
    }
    btBoxShape plate({50, 50, btScalar(0.005)});
    world.setGravity({0, 0, -10});
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    const auto add = [&](btCollisionShape* shape, btScalar mass, const btVector3& place)
    {
        btVector3 inertia(0, 0, 0);
        shape->calculateLocalInertia(std::max(mass, btScalar(1)), inertia);
        bodies.push_back(std::make_unique<btRigidBody>(mass, nullptr, shape, inertia));
        bodies.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
        world.addRigidBody(bodies.back().get());
    };
    add(&plate, 0, {0, 0, 0});
    for (int i = 0; i < 40; ++i)
    {
        btCollisionShape* shape = i % 3 == 0   ? static_cast<btCollisionShape*>(cube.get())
                                  : i % 3 == 1 ? &ball
                                               : static_cast<btCollisionShape*>(&hull);
        add(shape,
            1,
            {btScalar(0.21 * (i % 4)),
             btScalar(0.21 * (i / 4 % 4)),
             btScalar(0.2 + 0.3 * (i / 16))});
        bodies.back()->setLinearVelocity({0, 0, -20});
    }
    int through = 0;
    {
        const std::unique_ptr<btCcdAction> action = dynamic_cast<btCcdControl*>(&world) == nullptr
                                                        ? std::make_unique<btCcdAction>(&world)
                                                        : nullptr;
        if (action != nullptr)
        {
            world.addAction(action.get());
        }
        for (int i = 0; i < 40; ++i)
        {
            world.stepSimulation(btScalar(1.0 / 60.0), 0);
        }
        if (action != nullptr)
        {
            world.removeAction(action.get());
        }
    }
    for (const auto& body : bodies)
    {
        through += body->getWorldTransform().getOrigin().z() < btScalar(-0.01) ? 1 : 0;
        world.removeRigidBody(body.get());
    }
    return through;
}
}  // namespace

TEST(WorldsOfSeveralThreads, LetNothingThrough)
{
    const Tasks tasks;
    btDefaultCollisionConfiguration configuration;
    for (const bool ours : {false, true})
    {
        btCollisionDispatcherMt dispatcher(&configuration);
        btDbvtBroadphase broadphase;
        btSequentialImpulseConstraintSolver solver;
        btConstraintSolverPoolMt pool(2);
        const btCcdRegistration registration(dispatcher);
        std::unique_ptr<btDiscreteDynamicsWorld> world;
        if (ours)
        {
            world = std::make_unique<btCcdDiscreteDynamicsWorld>(
                &dispatcher, &broadphase, &solver, &configuration);
        }
        else
        {
            world = std::make_unique<btDiscreteDynamicsWorldMt>(
                &dispatcher, &broadphase, &pool, nullptr, &configuration);
        }
        EXPECT_EQ(throughFloor(*world), 0) << ours;
    }
}

namespace
{
/// Of another kind than Bullet's.
class OtherDispatcher : public btDispatcher
{
public:
    btCollisionAlgorithm* findAlgorithm(const btCollisionObjectWrapper*,
                                        const btCollisionObjectWrapper*,
                                        btPersistentManifold*,
                                        ebtDispatcherQueryType) override
    {
        return nullptr;
    }
    btPersistentManifold* getNewManifold(const btCollisionObject*,
                                         const btCollisionObject*) override
    {
        return nullptr;
    }
    void releaseManifold(btPersistentManifold*) override {}
    void clearManifold(btPersistentManifold*) override {}
    bool needsCollision(const btCollisionObject*, const btCollisionObject*) override
    {
        return false;
    }
    bool needsResponse(const btCollisionObject*, const btCollisionObject*) override
    {
        return false;
    }
    void dispatchAllCollisionPairs(btOverlappingPairCache*,
                                   const btDispatcherInfo&,
                                   btDispatcher*) override
    {
    }
    int getNumManifolds() const override { return 0; }
    btPersistentManifold* getManifoldByIndexInternal(int) override { return nullptr; }
    btPersistentManifold** getInternalManifoldPointer() override { return nullptr; }
    btPoolAllocator* getInternalManifoldPool() override { return nullptr; }
    const btPoolAllocator* getInternalManifoldPool() const override { return nullptr; }
    void* allocateCollisionAlgorithm(int) override { return nullptr; }
    void freeCollisionAlgorithm(void*) override {}
};
}  // namespace

/// Queries of meshes are asked on as many threads as there are.
TEST(WorldsOfSeveralThreads, GoTheSameWayWithAnyNumberOfThem)
{
    const auto run = [](Kind kind, std::size_t threads)
    {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        Random random(7);
        Scene scene(kind, WorldClass::Rigid);
        scene.world().setGravity(vec(0, 0, -10));
        scene.body(scene.boxMesh(vec(3, 3, 0.1)), 0.0, poseAt(vec(0, 0, -0.1)));
        btCcdMeshShape* ring = scene.mesh(makeTorus(0.2, 0.06, 16, 8));
        btCcdMeshShape* ball = scene.mesh(makeSphere(0.15, 1));
        std::vector<btRigidBody*> bodies;
        for (int i = 0; i < 18; ++i)
        {
            const btVector3 place =
                vec(0.35 * (i % 3) - 0.35, 0.35 * (i / 3 % 3) - 0.35, 0.3 + 0.4 * (i / 9));
            bodies.push_back(scene.body(i % 2 == 0 ? ring : ball, 1.0, poseAt(place)));
            bodies.back()->setLinearVelocity(
                vec(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-20, 0)));
            bodies.back()->setAngularVelocity(vec(random.uniform(-9, 9), 0, 3));
        }
        for (int i = 0; i < 40; ++i)
        {
            scene.step(1.0 / 60.0);
        }
        std::vector<btTransform> poses;
        for (const btRigidBody* body : bodies)
        {
            poses.push_back(body->getWorldTransform());
        }
        const btCcdCounters counters = scene.counters();
        EXPECT_GT(counters.m_impacts, 100);
        return std::tuple(poses, counters.m_queries, counters.m_impacts, counters.m_overlaps);
    };
    for (const Kind kind : kOurKinds)
    {
        const auto alone = run(kind, 1);
        EXPECT_TRUE(alone == run(kind, 2)) << codeOf(kind);
        EXPECT_TRUE(alone == run(kind, 8)) << codeOf(kind);
    }
}

TEST(WorldsOfSeveralThreads, RefuseADispatcherThatIsNotOneOfBullets)
{
    OtherDispatcher dispatcher;
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDefaultCollisionConfiguration configuration;
    btDiscreteDynamicsWorld stock(&dispatcher, &broadphase, &solver, &configuration);
    for (const bool action : {false, true})
    {
        try
        {
            if (action)
            {
                const btCcdAction ccd(&stock);
            }
            else
            {
                const btCcdDiscreteDynamicsWorld world(
                    &dispatcher, &broadphase, &solver, &configuration);
            }
            FAIL() << action;
        }
        catch (const std::invalid_argument& error)
        {
            EXPECT_NE(std::string(error.what()).find("btCollisionDispatcherMt"), std::string::npos);
        }
    }
}

TEST(WorldsOfSeveralThreads, OfMultiBodiesMayGetAnotherSolver)
{
    const Tasks tasks;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcherMt dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btMultiBodyConstraintSolver first;
    btConstraintSolverPoolMt pool(2);
    const btCcdRegistration registration(dispatcher);
    btCcdMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &first, &configuration);
    world.setConstraintSolver(&pool);
    EXPECT_EQ(throughFloor(world), 0);
    EXPECT_GT(world.getCcdCounters().m_subSteps, 0);
}
}  // namespace bullet_ccd::tests
