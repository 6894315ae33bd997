#include "benchmarks/reference/bullet/scene.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kFrame = 1.0 / 60.0;

class Kinematic : public testing::TestWithParam<Kind>
{
};

btRigidBody* kinematicPlate(Scene& scene)
{
    btRigidBody* plate = scene.body(scene.box(vec(0.02, 1, 1)), 0.0, poseAt(vec(0, 0, 0)));
    plate->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    plate->setActivationState(DISABLE_DEACTIVATION);
    return plate;
}

btRigidBody* ballAt(Scene& scene, const btVector3& place)
{
    return scene.body(
        scene.keep(std::make_unique<btSphereShape>(btScalar(0.05))), 1.0, poseAt(place));
}

double xOf(const btRigidBody& body)
{
    return double(body.getWorldTransform().getOrigin().x());
}
}  // namespace

TEST_P(Kinematic, ObjectIsSweptThoughItsInterpolationTransformIsSetToo)
{
    // Then Bullet finds no velocity. The plate advances ten times its thickness in a step.
    Scene scene(GetParam(), WorldClass::Rigid);
    btRigidBody* plate = kinematicPlate(scene);
    btRigidBody* ball = ballAt(scene, vec(0.7, 0, 0));
    for (int i = 1; i <= 12; ++i)
    {
        plate->setWorldTransform(poseAt(vec(0.2 * i, 0, 0)));
        plate->setInterpolationWorldTransform(plate->getWorldTransform());
        scene.step(kFrame);
        EXPECT_GT(xOf(*ball), xOf(*plate)) << "step " << i;
        EXPECT_EQ(double(plate->getLinearVelocity().length()), 0.0);
    }
    EXPECT_EQ(scene.counters().m_squeezed, 0);
}

TEST_P(Kinematic, ObjectThatWakesIsSweptAllTheWayThroughAFrameOfManySteps)
{
    Scene scene(GetParam(), WorldClass::Rigid);
    btRigidBody* plate = kinematicPlate(scene);
    btRigidBody* near = ballAt(scene, vec(0.15, 0, 0));
    btRigidBody* far = ballAt(scene, vec(0.5, 0.5, 0));
    near->setActivationState(DISABLE_DEACTIVATION);
    far->setActivationState(DISABLE_DEACTIVATION);
    plate->forceActivationState(ISLAND_SLEEPING);
    for (int i = 0; i < 3; ++i)
    {
        scene.step(kFrame);
    }
    scene.addHooks();
    plate->forceActivationState(DISABLE_DEACTIVATION);
    plate->setWorldTransform(poseAt(vec(0.4, 0, 0)));
    scene.world().stepSimulation(btScalar(4 * kFrame), 4, btScalar(kFrame));
    EXPECT_GT(xOf(*near), xOf(*plate));
    // 0.1 m in a step: never near the other ball.
    EXPECT_NEAR(xOf(*far), 0.5, 1e-6);
}

TEST_P(Kinematic, LiftIsNotCrossedByWhatMovesAlongWithIt)
{
    // Bullet's contacts see the lift 10 cm ahead of what stands on it, which is below it there, so
    // they push it down. It approaches the lift by 0.4 mm to 1.6 cm in a step.
    for (const double approach : {0.025, 0.1, 0.5, 1.0})
    {
        Scene scene(GetParam(), WorldClass::Rigid);
        btRigidBody* lift = scene.body(scene.box(vec(1, 1, 0.015)), 0.0, poseAt(vec(0, 0, 0)));
        lift->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        lift->setActivationState(DISABLE_DEACTIVATION);
        btRigidBody* cube =
            scene.body(scene.box(vec(0.05, 0.05, 0.05)), 1.0, poseAt(vec(0, 0, 0.07)));
        // More than four have neighbours of their own.
        for (const double x : {-0.6, -0.3, 0.3, 0.6})
        {
            scene.body(scene.box(vec(0.05, 0.05, 0.05)), 1.0, poseAt(vec(x, 0, 0.07)))
                ->setLinearVelocity(vec(0, 0, 6));
        }
        cube->setLinearVelocity(vec(0, 0, 6.0 - approach));
        int over = 0;
        for (int i = 1; i <= 90; ++i)
        {
            lift->setWorldTransform(poseAt(vec(0, 0, 0.1 * i)));
            scene.step(kFrame);
            const btVector3 at =
                cube->getWorldTransform().getOrigin() - lift->getWorldTransform().getOrigin();
            // Pushed about like that, it may slide off in the end.
            if (std::max(std::abs(at.x()), std::abs(at.y())) < btScalar(1))
            {
                ++over;
                ASSERT_GT(double(at.z()), 0.015) << approach << " m/s, step " << i;
            }
        }
        EXPECT_GT(over, 60);
        EXPECT_EQ(scene.counters().m_squeezed, 0);
    }
}

TEST_P(Kinematic, LayersThatLandOnEachOtherOnALiftStayLayers)
{
    // Bullet's contacts see the lift up to 33 cm ahead, so that the lowest layer is pushed up into
    // the others in the first step, and they land while the lift runs into what they land on.
    constexpr double kTop = 0.005;
    constexpr double kHalf = 0.05;
    for (const double speed : {1.0, 3.0, 4.0, 6.0, 10.0, 20.0})
    {
        Scene scene(GetParam(), WorldClass::Rigid);
        scene.world().setGravity(vec(0, 0, -9.81));
        btRigidBody* lift = scene.body(scene.boxMesh(vec(2, 2, kTop)), 0.0, poseAt(vec(0, 0, 0)));
        lift->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        lift->setActivationState(DISABLE_DEACTIVATION);
        const double margin = double(lift->getCollisionShape()->getMargin());
        std::vector<btRigidBody*> layers;
        for (int i = 0; i < 6; ++i)
        {
            const int layer = i % 3;
            // The layers of one of the two columns are faster.
            const double gap = i < 3 ? 0.005 : 0.02;
            const double height = kTop + 0.015 + kHalf + layer * (2.0 * kHalf + gap);
            layers.push_back(scene.body(scene.boxMesh(vec(kHalf, kHalf, kHalf)),
                                        1.0,
                                        poseAt(vec(i < 3 ? -0.5 : 0.5, 0, height))));
            layers.back()->setLinearVelocity(vec(0, 0, i < 3 ? speed : 0.0));
        }
        double height = 0.0;
        for (int step = 0; step < 80; ++step)
        {
            lift->setWorldTransform(poseAt(vec(0, 0, height)));
            scene.step(kFrame);
            for (std::size_t i = 0; i < layers.size(); ++i)
            {
                const bool isLowest = i % 3 == 0;
                const btRigidBody& below = isLowest ? *lift : *layers[i - 1];
                const btVector3 apart = layers[i]->getWorldTransform().getOrigin() -
                                        below.getWorldTransform().getOrigin();
                const double gap = double(isLowest ? apart.z() : apart.length()) -
                                   (isLowest ? kTop : kHalf) - kHalf;
                const bool hasDistance = GetParam() == Kind::World && step >= 60;
                ASSERT_GT(gap, hasDistance ? margin / 8.0 : 0.0)
                    << speed << " m/s, step " << step << ", layer " << i;
            }
            height += speed * kFrame;
        }
        EXPECT_EQ(scene.counters().m_squeezed, 0);
        EXPECT_EQ(scene.counters().m_overlaps, 0);
    }
}

TEST_P(Kinematic, ObjectStaysWhereItHasBeenPutWhileOthersArePushedOutOfIt)
{
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, 0, -9.81));
    btRigidBody* lift = scene.body(scene.boxMesh(vec(2, 2, 0.004)), 0.0, poseAt(vec(0, 0, 0)));
    lift->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    lift->setActivationState(DISABLE_DEACTIVATION);
    const btRigidBody* box =
        scene.body(scene.box(vec(0.05, 0.05, 0.04)), 1.0, poseAt(vec(0, 0, 0.05)));
    const btRigidBody* ball = ballAt(scene, vec(0.5, 0, 0.06));
    const auto step = btScalar(kFrame / 4.0);
    scene.addHooks();
    for (int i = 0; i < 40; ++i)
    {
        scene.world().stepSimulation(step, 1, step);
    }
    lift->setWorldTransform(poseAt(vec(0, 0, 0.18)));
    for (int i = 0; i < 3; ++i)
    {
        scene.world().stepSimulation(btScalar(3) * step, 3, step);
        EXPECT_EQ(double(lift->getWorldTransform().getOrigin().z()), double(btScalar(0.18)));
        EXPECT_EQ(lift->getLinearVelocity().length() > btScalar(0), i == 0);
    }
    EXPECT_GT(double(box->getWorldTransform().getOrigin().z()), 0.18);
    EXPECT_GT(double(ball->getWorldTransform().getOrigin().z()), 0.18);
}

TEST_P(Kinematic, ThinLiftCarriesWhatHasFallenOntoIt)
{
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    for (const auto& [speed, half] : {std::pair{6.0, 0.005}, {6.0, 0.01}, {9.0, 0.015}})
    {
        Scene scene(GetParam(), WorldClass::Rigid);
        scene.world().setGravity(vec(0, 0, -9.81));
        btRigidBody* lift = scene.body(scene.box(vec(1, 1, half)), 0.0, poseAt(vec(0, 0, 0)));
        lift->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        lift->setActivationState(DISABLE_DEACTIVATION);
        std::vector<btRigidBody*> boxes;
        for (int i = 0; i < 6; ++i)
        {
            const btVector3 axis = vec(normal(random), normal(random), normal(random));
            const btQuaternion turn(axis.normalized(), btScalar(normal(random)));
            const btVector3 place = vec(0.6 * (i % 3 - 1), 0.6 * (i / 3) - 0.3, 0.15);
            boxes.push_back(
                scene.body(scene.box(vec(0.08, 0.05, 0.05)), 1.0, btTransform(turn, place)));
        }
        for (int i = 0; i < 100; ++i)
        {
            const double height = speed * kFrame * std::max(i - 15, 0);
            lift->setWorldTransform(poseAt(vec(0, 0, height)));
            scene.step(kFrame);
            for (const btRigidBody* box : boxes)
            {
                const btVector3& place = box->getWorldTransform().getOrigin();
                ASSERT_TRUE(double(place.z()) > height || double(place.absolute().x()) > 0.95 ||
                            double(place.absolute().y()) > 0.95)
                    << speed << " m/s, step " << i;
            }
        }
    }
}

TEST_P(Kinematic, WhatLiesOnAFastLiftStaysAtItsDistance)
{
    // Bullet's contacts see the lift 33 cm ahead. What comes a quarter nearer in every step is lost
    // in single precision once the lift is high.
    constexpr double kTop = 0.005;
    constexpr double kHalf = 0.05;
    constexpr double kAdvance = 20.0 * kFrame;
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, 0, -9.81));
    btRigidBody* lift = scene.body(scene.boxMesh(vec(2, 2, kTop)), 0.0, poseAt(vec(0, 0, 0)));
    lift->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    lift->setActivationState(DISABLE_DEACTIVATION);
    const double margin = double(lift->getCollisionShape()->getMargin());
    const btVector3 half = vec(kHalf, kHalf, kHalf);
    const std::vector<btRigidBody*> bodies{
        ballAt(scene, vec(-0.5, 0, 0.07)),
        scene.body(scene.box(half), 1.0, poseAt(vec(0.5, 0, 0.07))),
        scene.body(scene.boxMesh(half), 1.0, poseAt(vec(0, 0, 0.07)))};
    for (btRigidBody* body : bodies)
    {
        body->setLinearVelocity(vec(0, 0, kAdvance / kFrame));
    }
    for (int i = 1; i <= 60; ++i)
    {
        lift->setWorldTransform(poseAt(vec(0, 0, kAdvance * i)));
        scene.step(kFrame);
        for (const btRigidBody* body : bodies)
        {
            const double gap = double(body->getWorldTransform().getOrigin().z() -
                                      lift->getWorldTransform().getOrigin().z()) -
                               kTop - kHalf;
            ASSERT_GT(gap, i < 20 ? 0.0 : margin / 8.0) << "step " << i;
            ASSERT_LT(gap, i < 20 ? 0.02 : 2.0 * margin) << "step " << i;
        }
    }
    EXPECT_GT(scene.counters().m_impacts, 0);
    EXPECT_EQ(scene.counters().m_overlaps, 0);
}

TEST_P(Kinematic, ObjectWithTheVelocityOfAConveyorDoesNotMove)
{
    // As programs set it once the frame has begun, where Bullet has found none.
    struct Belt
    {
        static void begin(btDynamicsWorld* world, btScalar)
        {
            static_cast<btRigidBody*>(world->getWorldUserInfo())->setLinearVelocity(vec(30, 0, 0));
        }
    };
    Scene scene(GetParam(), WorldClass::Rigid);
    btRigidBody* plate = kinematicPlate(scene);
    btRigidBody* behind = ballAt(scene, vec(-0.3, 0, 0));
    scene.step(kFrame);
    scene.world().setInternalTickCallback(&Belt::begin, plate, true);
    for (int i = 0; i < 5; ++i)
    {
        scene.step(kFrame);
    }
    EXPECT_EQ(xOf(*behind), double(btScalar(-0.3)));
    EXPECT_EQ(scene.counters().m_impacts, 0);
}

TEST_P(Kinematic, ObjectThatMeetsTwoAtOnceEndsWhereItHasBeenPut)
{
    Scene scene(GetParam(), WorldClass::Rigid);
    btRigidBody* plate = kinematicPlate(scene);
    const btRigidBody* left = ballAt(scene, vec(0.2, -0.5, 0));
    const btRigidBody* right = ballAt(scene, vec(0.2, 0.5, 0));
    scene.step(kFrame);
    plate->setWorldTransform(poseAt(vec(0.4, 0, 0)));
    scene.step(kFrame);
    EXPECT_EQ(xOf(*plate), double(btScalar(0.4)));
    EXPECT_GE(scene.counters().m_impacts, 2);
    EXPECT_GT(xOf(*left), 0.4);
    EXPECT_GT(xOf(*right), 0.4);
}

INSTANTIATE_TEST_SUITE_P(Ours,
                         Kinematic,
                         testing::ValuesIn(kOurKinds),
                         [](const testing::TestParamInfo<Kind>& test)
                         { return std::string(codeOf(test.param)); });
}  // namespace bullet_ccd::tests
