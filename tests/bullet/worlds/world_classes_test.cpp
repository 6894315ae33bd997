#include "benchmarks/reference/bullet/scene.h"
#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdDiscreteDynamicsWorld.h"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
double restsAt(const btRigidBody& body)
{
    return double(body.getWorldTransform().getOrigin().z());
}
}  // namespace

namespace
{
std::vector<std::pair<const char*, std::function<std::unique_ptr<btBroadphaseInterface>()>>>
broadphases()
{
    const btVector3 low = vec(-3, -3, -3);
    const btVector3 high = vec(3, 3, 3);
    return {
        {"btDbvtBroadphase", [] { return std::make_unique<btDbvtBroadphase>(); }},
        {"btSimpleBroadphase", [] { return std::make_unique<btSimpleBroadphase>(); }},
        {"btAxisSweep3", [=] { return std::make_unique<btAxisSweep3>(low, high, 100); }},
        {"btAxisSweep3 without a tree",
         [=] { return std::make_unique<btAxisSweep3>(low, high, 100, nullptr, true); }},
        {"bt32BitAxisSweep3", [=] { return std::make_unique<bt32BitAxisSweep3>(low, high, 100); }},
    };
}
}  // namespace

TEST(WorldsOfOurs, FindPairsInEveryBroadphase)
{
    for (const auto& [name, make] : broadphases())
    {
        btDefaultCollisionConfiguration configuration;
        btCollisionDispatcher dispatcher(&configuration);
        const std::unique_ptr<btBroadphaseInterface> broadphase = make();
        btSequentialImpulseConstraintSolver solver;
        btBoxShape plateShape(vec(0.5, 0.5, 0.001));
        btBoxShape boxShape(vec(0.01, 0.01, 0.01));
        btRigidBody plate(btScalar(0), nullptr, &plateShape);
        btRigidBody box(btScalar(0.1), nullptr, &boxShape, vec(1e-5, 1e-5, 1e-5));
        btRigidBody aside(btScalar(0.1), nullptr, &boxShape, vec(1e-5, 1e-5, 1e-5));
        box.setWorldTransform(poseAt(vec(0.1, 0.1, 1)));
        aside.setWorldTransform(poseAt(vec(0.7, 0.1, 1)));
        {
            btCcdDiscreteDynamicsWorld world(
                &dispatcher, broadphase.get(), &solver, &configuration);
            world.setGravity(vec(0, 0, 0));
            for (btRigidBody* body : {&box, &plate, &aside})
            {
                world.addRigidBody(body);
                body->setLinearVelocity(vec(0, 0, -60));
            }
            for (int i = 0; i < 2; ++i)
            {
                world.stepSimulation(btScalar(1.0 / 60.0), 0);
            }
            EXPECT_NEAR(restsAt(box), 0.011, 1e-3) << name;
            EXPECT_NEAR(restsAt(aside), -1.0, 1e-4) << name;
            // Impacts add pairs, which must go with their objects.
            const btBroadphasePairArray& pairs =
                broadphase->getOverlappingPairCache()->getOverlappingPairArray();
            for (int i = 0; i < pairs.size(); ++i)
            {
                for (const btBroadphaseProxy* proxy : {pairs[i].m_pProxy0, pairs[i].m_pProxy1})
                {
                    const auto* object = static_cast<btCollisionObject*>(proxy->m_clientObject);
                    EXPECT_EQ(proxy, object->getBroadphaseHandle()) << name;
                }
            }
            for (btRigidBody* body : {&box, &plate, &aside})
            {
                world.removeRigidBody(body);
            }
        }
        btCcdCollisionAlgorithm::unregisterAlgorithm(&dispatcher);
    }
}

namespace
{
/// A box shot at a thin plate in a deformable world with a cloth in it; its height at the end.
double heightInDeformableWorld(bool withAction)
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btDeformableBodySolver deformableSolver;
    btDeformableMultiBodyConstraintSolver solver;
    solver.setDeformableSolver(&deformableSolver);
    btBoxShape plateShape(vec(0.5, 0.5, 0.001));
    btBoxShape boxShape(vec(0.01, 0.01, 0.01));
    btRigidBody plate(btScalar(0), nullptr, &plateShape);
    btRigidBody box(btScalar(0.1), nullptr, &boxShape, vec(1e-5, 1e-5, 1e-5));
    box.setWorldTransform(poseAt(vec(0, 0, 0.5)));
    double height = 0.0;
    {
        btDeformableMultiBodyDynamicsWorld world(
            &dispatcher, &broadphase, &solver, &configuration, &deformableSolver);
        world.setGravity(vec(0, 0, 0));
        btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(),
                                                           vec(2, 2, 0),
                                                           vec(3, 2, 0),
                                                           vec(2, 3, 0),
                                                           vec(3, 3, 0),
                                                           4,
                                                           4,
                                                           0,
                                                           true);
        world.addSoftBody(cloth);
        world.addRigidBody(&plate);
        world.addRigidBody(&box);
        box.setLinearVelocity(vec(0, 0, -40));
        std::unique_ptr<btCcdAction> action;
        if (withAction)
        {
            action = std::make_unique<btCcdAction>(&world);
            world.addAction(action.get());
        }
        for (int i = 0; i < 5; ++i)
        {
            world.stepSimulation(btScalar(1.0 / 60.0), 0);
        }
        height = restsAt(box);
        if (withAction)
        {
            EXPECT_GT(action->getCcdCounters().m_impacts, 0);
            EXPECT_EQ(action->getCcdCounters().m_unsupported, 1) << "the cloth";
            world.removeAction(action.get());
        }
        world.removeRigidBody(&box);
        world.removeRigidBody(&plate);
        world.removeSoftBody(cloth);
        delete cloth;
    }
    if (withAction)
    {
        btCcdCollisionAlgorithm::unregisterAlgorithm(&dispatcher);
    }
    return height;
}
}  // namespace

TEST(WorldsOfOurs, TheActionKeepsRigidBodiesFromTunnellingInADeformableWorld)
{
    EXPECT_LT(heightInDeformableWorld(false), -1.0);
    EXPECT_GT(heightInDeformableWorld(true), 0.0);
}
}  // namespace bullet_ccd::tests
