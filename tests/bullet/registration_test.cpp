#include "benchmarks/reference/bullet/scene.h"
#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdDiscreteDynamicsWorld.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// A user's own method: no contacts, and always the same answer.
class Fixed : public btCollisionAlgorithm
{
public:
    struct Func : btCollisionAlgorithmCreateFunc
    {
        btScalar m_answer = 1;
        int m_asked = 0;

        btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                       const btCollisionObjectWrapper*,
                                                       const btCollisionObjectWrapper*) override
        {
            void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(int(sizeof(Fixed)));
            return new (memory) Fixed(*this);
        }
    };

    explicit Fixed(Func& func) : m_func(func) {}
    void processCollision(const btCollisionObjectWrapper*,
                          const btCollisionObjectWrapper*,
                          const btDispatcherInfo&,
                          btManifoldResult*) override
    {
    }
    btScalar calculateTimeOfImpact(btCollisionObject*,
                                   btCollisionObject*,
                                   const btDispatcherInfo&,
                                   btManifoldResult*) override
    {
        ++m_func.m_asked;
        return m_func.m_answer;
    }
    void getAllContactManifolds(btManifoldArray&) override {}

private:
    Func& m_func;
};

struct Holder : btCcdImpactListener
{
    std::vector<double> m_times;

    btCcdAfterImpact onImpact(const btCcdImpact& impact) override
    {
        m_times.push_back(double(impact.m_time));
        return btCcdAfterImpact::Hold;
    }
};
}  // namespace

TEST(Registration, TheTimeOfImpactIsThatOfWhateverAlgorithmIsRegistered)
{
    for (const Kind kind : kOurKinds)
    {
        for (const WorldClass worldClass : {WorldClass::Rigid, WorldClass::MultiBody})
        {
            for (const double answer : {0.25, 1.0})
            {
                Fixed::Func func;
                func.m_answer = btScalar(answer);
                Holder holder;
                Scene scene(kind, worldClass);
                scene.ccd().setCcdImpactListener(&holder);
                static_cast<btCollisionDispatcher*>(scene.world().getDispatcher())
                    ->registerCollisionCreateFunc(
                        SPHERE_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, &func);
                btRigidBody* ball =
                    scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.05))),
                               1.0,
                               poseAt(vec(0, 0, 1)));
                scene.body(scene.box(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, 0)));
                // Boxes among themselves are still ours.
                btRigidBody* box =
                    scene.body(scene.box(vec(0.05, 0.05, 0.05)), 1.0, poseAt(vec(0.5, 0, 1.56)));
                ball->setLinearVelocity(vec(0, 0, -100));
                box->setLinearVelocity(vec(0, 0, -100));
                scene.step(0.04);
                EXPECT_GT(func.m_asked, 0);
                EXPECT_NEAR(
                    double(ball->getWorldTransform().getOrigin().z()), 1.0 - 4.0 * answer, 1e-5);
                EXPECT_NEAR(double(box->getWorldTransform().getOrigin().z()), 0.06, 1e-3);
                ASSERT_EQ(holder.m_times.size(), answer < 1.0 ? 2U : 1U);
                EXPECT_NEAR(holder.m_times.back(), 0.015, 1e-5);
                EXPECT_TRUE(answer == 1.0 || std::abs(holder.m_times[0] - 0.01) < 1e-6);
            }
        }
    }
}

TEST(Registration, WhatIsRegisteredBetweenTheTwoLinesStays)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    Fixed::Func func;
    btCcdCollisionAlgorithm::registerAlgorithm(&dispatcher);
    dispatcher.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, &func);
    btBoxShape plateShape(vec(1, 1, 0.001));
    btBoxShape boxShape(vec(0.01, 0.01, 0.01));
    btSphereShape ballShape(btScalar(0.01));
    btRigidBody plate(btScalar(0), nullptr, &plateShape);
    btRigidBody box(btScalar(0.1), nullptr, &boxShape, vec(1e-5, 1e-5, 1e-5));
    btRigidBody ball(btScalar(0.1), nullptr, &ballShape, vec(1e-5, 1e-5, 1e-5));
    box.setWorldTransform(poseAt(vec(0.1, 0.1, 0.5)));
    ball.setWorldTransform(poseAt(vec(-0.1, 0.1, 0.5)));
    {
        // It registers ours again.
        btCcdDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
        world.setGravity(vec(0, 0, 0));
        for (btRigidBody* body : {&plate, &box, &ball})
        {
            world.addRigidBody(body);
            body->setLinearVelocity(vec(0, 0, -60));
        }
        world.stepSimulation(btScalar(1.0 / 60.0), 0);
        EXPECT_EQ(func.m_asked, 1);
        EXPECT_LT(box.getWorldTransform().getOrigin().z(), btScalar(0));
        EXPECT_GT(ball.getWorldTransform().getOrigin().z(), btScalar(0));
        for (btRigidBody* body : {&plate, &box, &ball})
        {
            world.removeRigidBody(body);
        }
    }
    btCcdCollisionAlgorithm::unregisterAlgorithm(&dispatcher);
}

TEST(Registration, EndsWithItsOwner)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btBoxShape shape(vec(1, 1, 1));
    btCollisionObject object;
    object.setCollisionShape(&shape);
    const btCollisionObjectWrapper wrapper(
        nullptr, &shape, &object, object.getWorldTransform(), -1, -1);
    const auto isOurs = [&]
    {
        btCollisionAlgorithm* algorithm =
            dispatcher.findAlgorithm(&wrapper, &wrapper, nullptr, BT_CONTACT_POINT_ALGORITHMS);
        const bool ours = dynamic_cast<btCcdCollisionAlgorithm*>(algorithm) != nullptr;
        algorithm->~btCollisionAlgorithm();
        dispatcher.freeCollisionAlgorithm(algorithm);
        return ours;
    };
    EXPECT_FALSE(isOurs());
    {
        const btCcdRegistration registration(dispatcher);
        const btCcdDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
        EXPECT_TRUE(isOurs());
    }
    EXPECT_FALSE(isOurs());
}
}  // namespace bullet_ccd::tests
