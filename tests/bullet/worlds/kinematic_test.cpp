#include "benchmarks/reference/bullet/scene.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

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
