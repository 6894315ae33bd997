#include "benchmarks/reference/bullet/scene.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kStepOfBudget = 1.0 / 60.0;

/// Ends a run in which a step does not end by itself.
class Watch : public btCcdImpactListener
{
public:
    static constexpr int kMost = 5000;  // of one step

    btCcdAfterImpact onImpact(const btCcdImpact&) override
    {
        if (++m_impacts > kMost)
        {
            throw std::runtime_error("the step does not end");
        }
        return btCcdAfterImpact::Solve;
    }
    void onYield(const btCollisionObject& object, btCcdYield how, const btCcdImpact&) override
    {
        m_yields.insert({&object, how});
    }
    int m_impacts = 0;  // of this step
    std::set<std::pair<const btCollisionObject*, btCcdYield>> m_yields;
};

btRigidBody* kinematic(Scene& scene, btCollisionShape* shape, const btTransform& pose)
{
    btRigidBody* body = scene.body(shape, 0.0, pose);
    body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
    return body;
}
}  // namespace

TEST(Budget, EndsTheStepsOfABatThatTurnsIntoABall)
{
    for (const double speed : {5.0, 50.0})  // [rad/s]
    {
        Scene scene(Kind::World, WorldClass::Rigid);
        btRigidBody* bat = kinematic(scene, scene.boxMesh(vec(1, 0.01, 0.2)), poseAt(vec(0, 0, 0)));
        std::vector<btRigidBody*> balls;
        for (int i = 0; i < 8; ++i)
        {
            const double angle = 0.5 + 0.35 * i;
            balls.push_back(
                scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.03))),
                           1.0,
                           poseAt(vec(0.8 * std::cos(angle), 0.8 * std::sin(angle), 0))));
        }
        Watch watch;
        scene.ccd().setCcdImpactListener(&watch);
        for (int step = 0; step < 30; ++step)
        {
            const double turned = speed * kStepOfBudget * step;
            bat->setWorldTransform(poseAt(vec(0, 0, 0), turned));
            watch.m_impacts = 0;
            ASSERT_NO_THROW(scene.step(kStepOfBudget)) << speed << " rad/s, step " << step;
        }
        // Nothing fixed is near: what the bat presses on gives way, and nothing is squeezed.
        EXPECT_EQ(scene.counters().m_squeezed, 0);
        for (const btRigidBody* ball : balls)
        {
            EXPECT_LT(double(ball->getLinearVelocity().length()), 2.5 * speed);
        }
    }
}

TEST(Budget, EndsTheStepsOfBoxesBetweenAPressAndACeiling)
{
    for (const bool meshes : {false, true})
    {
        for (const double rise : {0.005, 0.02, 0.05})  // in a step [m]
        {
            Scene scene(Kind::World, WorldClass::Rigid);
            const auto shape = [&](const btVector3& half) -> btCollisionShape*
            {
                return meshes ? static_cast<btCollisionShape*>(scene.boxMesh(half))
                              : static_cast<btCollisionShape*>(scene.box(half));
            };
            scene.world().setGravity(vec(0, 0, -10));
            btRigidBody* press = kinematic(scene, shape(vec(2, 2, 0.1)), poseAt(vec(0, 0, 0)));
            scene.body(shape(vec(2, 2, 0.1)), 0.0, poseAt(vec(0, 0, 1)));
            for (int i = 0; i < 5; ++i)
            {
                scene.body(shape(vec(0.2, 0.2, 0.2)), 1.0, poseAt(vec(-1 + 0.5 * i, 0, 0.31)));
            }
            Watch watch;
            scene.ccd().setCcdImpactListener(&watch);
            for (int step = 0; step < 60; ++step)
            {
                // Boxes of 0.4 m, in the end in a gap of 0.05 m.
                press->setWorldTransform(poseAt(vec(0, 0, std::min(0.75, step * rise))));
                watch.m_impacts = 0;
                ASSERT_NO_THROW(scene.step(kStepOfBudget)) << rise << " m a step, step " << step;
            }
        }
    }
}

TEST(Budget, EndsInAllWaysOfGivingWayBetweenAPressAndACeiling)
{
    constexpr double kRise = 0.02;  // in a step [m]
    Scene scene(Kind::World, WorldClass::Rigid);
    btRigidBody* press = kinematic(scene, scene.boxMesh(vec(2, 2, 0.1)), poseAt(vec(0, 0, -0.2)));
    scene.body(scene.boxMesh(vec(2, 2, 0.1)), 0.0, poseAt(vec(0, 0, 1)));
    btRigidBody* cube = scene.body(scene.boxMesh(vec(0.2, 0.2, 0.2)), 1.0, poseAt(vec(0, 0, 0.5)));
    Watch watch;
    scene.ccd().setCcdImpactListener(&watch);
    int step = 0;
    for (; step < 40 && scene.counters().m_squeezed == 0; ++step)
    {
        press->setWorldTransform(poseAt(vec(0, 0, -0.2 + kRise * step)));
        watch.m_impacts = 0;
        ASSERT_NO_THROW(scene.step(kStepOfBudget)) << "step " << step;
        // It is driven by the press and not into the ceiling.
        EXPECT_LT(double(cube->getWorldTransform().getOrigin().z()), 0.7) << "step " << step;
    }
    // The top of the press has 0.4 m to go to the cube, and both 0.2 m to the ceiling.
    EXPECT_NEAR(step, 0.6 / kRise, 1);
    EXPECT_EQ(scene.counters().m_squeezed, 1);
    EXPECT_EQ(scene.counters().m_carried, 1);
    EXPECT_EQ(scene.counters().m_clamps, 1);
    EXPECT_GE(scene.counters().m_settled, 1);
    for (const btCcdYield how :
         {btCcdYield::Settled, btCcdYield::Held, btCcdYield::Carried, btCcdYield::Squeezed})
    {
        EXPECT_EQ(watch.m_yields.count({cube, how}), 1U) << int(how);
    }
}

TEST(Budget, OfAStepHoldsWhatStillMeets)
{
    // Four balls between two plates, 20 mm apart, at 100 m/s: 50 impacts of each in a step.
    const auto run = [](const btCcdBudget& budget)
    {
        Scene scene(Kind::World, WorldClass::Rigid);
        scene.ccd().setCcdBudget(budget);
        scene.body(scene.box(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, -0.02)))->setRestitution(1);
        scene.body(scene.box(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, 0.02)))->setRestitution(1);
        std::vector<btRigidBody*> balls;
        for (int i = 0; i < 4; ++i)
        {
            balls.push_back(scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.005))),
                                       0.1,
                                       poseAt(vec(0.1 * i, 0, 0))));
            balls.back()->setRestitution(1);
            balls.back()->setFriction(0);
            balls.back()->setLinearVelocity(vec(0, 0, 100));
        }
        scene.step(0.01);
        for (const btRigidBody* ball : balls)
        {
            EXPECT_LT(std::abs(double(ball->getWorldTransform().getOrigin().z())), 0.005 + 1e-4);
        }
        return scene.counters();
    };
    // One impact after the other: the first ten are answered, then each ball is held once.
    const btCcdCounters few = run({.m_impactsPerBody = 1000, .m_impactsPerStep = 10});
    EXPECT_LE(few.m_impacts, 10 + 4);
    EXPECT_EQ(few.m_clamps, 4);
    EXPECT_EQ(few.m_settled, 0);
    const btCcdCounters noTime = run({.m_impactsPerBody = 1000, .m_seconds = 1e-9});
    EXPECT_EQ(noTime.m_clamps, 4);
    EXPECT_EQ(noTime.m_subSteps, 0);
    const btCcdCounters all = run({.m_impactsPerBody = 1000});
    EXPECT_EQ(all.m_clamps, 0);
    // Each ball bounces from each plate twice; then contact is no longer taken for a bounce.
    EXPECT_EQ(all.m_impacts, 4 * 5);
}

TEST(Budget, EndsTheQueriesOfLinksThatTurnMillionsOfTimesInAStep)
{
    // One of them took minutes. What gives up is held where it is certain.
    constexpr double kHalfLink = 0.15;
    constexpr double kHalfWidth = 0.01;
    constexpr double kWall = 0.5;
    for (const Kind kind : kOurKinds)
    {
        Scene scene(kind);
        scene.body(scene.box(vec(0.001, 1, 1)), 0.0, poseAt(vec(kWall, 0, 0)));
        const btRigidBody* ball =
            scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.05))),
                       1.0,
                       poseAt(vec(-3, 0, 0)));
        scene.world().setGravity(vec(0, 0, -10));
        btCollisionShape* link = scene.box(vec(kHalfLink, kHalfWidth, kHalfWidth));
        btMultiBody* chain = scene.chain({link, link}, kHalfLink, poseAt(vec(0, 0, 0)));
        chain->setMaxCoordinateVelocity(btScalar(1e30));
        chain->setJointVel(0, btScalar(1e9));  // [rad/s]
        chain->setJointVel(1, btScalar(-1e9));
        scene.addHooks();
        for (int step = 0; step < 2; ++step)
        {
            scene.step(kStepOfBudget);
            // Stock shapes sink in by half of their depth at most.
            const btTransform& end = chain->getLink(1).m_collider->getWorldTransform();
            EXPECT_LT(double((end * vec(kHalfLink, 0, 0)).x()), kWall + 0.5 * kHalfWidth);
        }
        EXPECT_GE(scene.counters().m_iterationLimits, 1);
        EXPECT_LT(double(ball->getWorldTransform().getOrigin().z()), -0.005);
    }
}

TEST(Budget, RefusesLimitsThatAreNone)
{
    Scene scene(Kind::World);
    EXPECT_THROW(scene.ccd().setCcdBudget({.m_impactsPerBody = -1}), std::invalid_argument);
    EXPECT_THROW(scene.ccd().setCcdBudget({.m_impactsPerInstant = -1}), std::invalid_argument);
    EXPECT_THROW(scene.ccd().setCcdBudget({.m_impactsPerStep = -1}), std::invalid_argument);
    EXPECT_THROW(scene.ccd().setCcdBudget({.m_seconds = std::nan("")}), std::invalid_argument);
    EXPECT_EQ(scene.ccd().getCcdBudget().m_impactsPerBody, btCcdBudget{}.m_impactsPerBody);
}
}  // namespace bullet_ccd::tests
