#include "benchmarks/reference/bullet/mechanics.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btGeneric6DofConstraint.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
double heightOf(const btRigidBody& body)
{
    return double(body.getWorldTransform().getOrigin().z());
}

/// What can be changed about a shot at a plate before it is fired.
struct Shot
{
    Scene& scene;
    btRigidBody& plate;
    btRigidBody& missile;
};

/// Shoots a box at a thin plate, 33 cm a step; true if it stays above.
bool isStopped(Kind kind, WorldClass worldClass, const std::function<void(const Shot&)>& prepare)
{
    Scene scene(kind, worldClass);
    btRigidBody* plate = scene.body(scene.boxMesh(vec(0.1, 0.1, 0.001)), 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* missile =
        scene.body(scene.box(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(0, 0, 0.1)));
    missile->setLinearVelocity(vec(0, 0, -20));
    prepare({scene, *plate, *missile});
    scene.step(1.0 / 60.0);
    scene.step(1.0 / 60.0);
    return heightOf(*missile) > 0.0;
}

void reinsert(const Shot& shot, btRigidBody& body, int group, int mask)
{
    shot.scene.world().removeRigidBody(&body);
    shot.scene.world().addRigidBody(&body, group, mask);
}

class Worlds : public testing::TestWithParam<Kind>
{
protected:
    static constexpr std::array kClasses{WorldClass::Rigid, WorldClass::MultiBody};

    static void expectStopped(bool expected,
                              const char* what,
                              const std::function<void(const Shot&)>& prepare)
    {
        for (const WorldClass worldClass : kClasses)
        {
            EXPECT_EQ(isStopped(GetParam(), worldClass, prepare), expected) << what;
        }
    }
};
}  // namespace

TEST_P(Worlds, CoverWhatIsNotExcluded)
{
    expectStopped(true, "all by default", [](const Shot&) {});
    expectStopped(false,
                  "missile",
                  [](const Shot& shot)
                  {
                      shot.scene.ccd().setCcdEnabled(&shot.missile, false);
                      EXPECT_FALSE(shot.scene.ccd().isCcdEnabled(&shot.missile));
                      EXPECT_TRUE(shot.scene.ccd().isCcdEnabled(&shot.plate));
                  });
    expectStopped(false,
                  "plate",
                  [](const Shot& shot) { shot.scene.ccd().setCcdEnabled(&shot.plate, false); });
    expectStopped(true,
                  "taken back",
                  [](const Shot& shot)
                  {
                      shot.scene.ccd().setCcdEnabled(&shot.missile, false);
                      shot.scene.ccd().setCcdEnabled(&shot.missile, true);
                      EXPECT_TRUE(shot.scene.ccd().isCcdEnabled(&shot.missile));
                  });
}

namespace
{
/// An all-free joint, for nothing but its flag.
void connect(const Shot& shot, bool collide)
{
    auto joint =
        std::make_unique<btGeneric6DofConstraint>(shot.missile, btTransform::getIdentity(), false);
    for (int axis = 0; axis < 6; ++axis)
    {
        joint->setLimit(axis, 1, -1);
    }
    shot.scene.addConstraint(std::move(joint), collide);
    auto pair = std::make_unique<btGeneric6DofConstraint>(
        shot.plate, shot.missile, btTransform::getIdentity(), btTransform::getIdentity(), false);
    for (int axis = 0; axis < 6; ++axis)
    {
        pair->setLimit(axis, 1, -1);
    }
    shot.scene.addConstraint(std::move(pair), collide);
}

struct NoneWithGhosts : btOverlapFilterCallback
{
    const btCollisionObject* m_ghost = nullptr;

    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override
    {
        return a->m_clientObject != m_ghost && b->m_clientObject != m_ghost;
    }
};
}  // namespace

TEST_P(Worlds, LetThroughWhatBulletFilters)
{
    constexpr int kGhosts = 64;
    expectStopped(false,
                  "mask of the plate",
                  [](const Shot& shot)
                  {
                      reinsert(shot, shot.missile, kGhosts, -1);
                      reinsert(shot, shot.plate, btBroadphaseProxy::StaticFilter, ~kGhosts);
                  });
    expectStopped(false,
                  "mask of the missile",
                  [](const Shot& shot)
                  {
                      reinsert(shot,
                               shot.missile,
                               btBroadphaseProxy::DefaultFilter,
                               ~btBroadphaseProxy::StaticFilter);
                  });
    expectStopped(true,
                  "both want each other",
                  [](const Shot& shot) { reinsert(shot, shot.missile, kGhosts, -1); });
    expectStopped(false,
                  "ignored by the plate",
                  [](const Shot& shot)
                  { shot.plate.setIgnoreCollisionCheck(&shot.missile, true); });
    expectStopped(false,
                  "ignored by the missile",
                  [](const Shot& shot)
                  { shot.missile.setIgnoreCollisionCheck(&shot.plate, true); });
    expectStopped(
        false, "joined, without collision", [](const Shot& shot) { connect(shot, false); });
    expectStopped(true, "joined, with collision", [](const Shot& shot) { connect(shot, true); });
    expectStopped(false,
                  "no contact response",
                  [](const Shot& shot)
                  {
                      shot.missile.setCollisionFlags(shot.missile.getCollisionFlags() |
                                                     btCollisionObject::CF_NO_CONTACT_RESPONSE);
                  });
    NoneWithGhosts filter;
    for (const bool ghost : {false, true})
    {
        expectStopped(!ghost,
                      "filter of the pair cache",
                      [&](const Shot& shot)
                      {
                          filter.m_ghost = ghost ? &shot.missile : nullptr;
                          shot.scene.world().getPairCache()->setOverlapFilterCallback(&filter);
                      });
    }
}

namespace
{
/// Two links that fold onto each other, with room at the joint; angle after 0.1 s at 10 rad/s.
double foldedTo(Kind kind, bool parentCollision)
{
    Scene scene(kind);
    auto body = std::make_unique<btMultiBody>(2, btScalar(0), vec(1, 1, 1), true, false);
    for (int i = 0; i < 2; ++i)
    {
        body->setupRevolute(i,
                            btScalar(0.01),
                            vec(1e-5, 1e-5, 1e-5),
                            i - 1,
                            btQuaternion::getIdentity(),
                            vec(0, 0, 1),
                            i == 0 ? vec(0, 0, 0) : vec(0.02, 0, 0),
                            vec(0.02, 0, 0),
                            !parentCollision);
    }
    body->finalizeMultiDof();
    btCcdMeshShape* rod = scene.boxMesh(vec(0.015, 0.001, 0.004));
    btMultiBody* added = scene.addMultiBody(std::move(body), nullptr, {rod, rod});
    added->setJointPos(1, btScalar(2.5));
    Scene::placeColliders(*added);
    added->setJointVel(1, 10);
    scene.step(0.1);
    scene.step(0.1);
    // By how much the angle between the two links grew, whoever gave way.
    return double(added->getJointPos(1));
}
}  // namespace

TEST_P(Worlds, ParentAndChildLinksMeetUnlessTheFlagForbidsIt)
{
    EXPECT_LT(foldedTo(GetParam(), true), 3.1415);
    EXPECT_GT(foldedTo(GetParam(), false), 3.4);
}

namespace
{
/// A ball at rest, asleep, and one that comes along at 30 m/s, half a metre a step.
struct SleepingScene
{
    SleepingScene(Kind kind, WorldClass worldClass, double offset) : m_scene(kind, worldClass)
    {
        btCollisionShape* shape = m_scene.keep(std::make_unique<btSphereShape>(btScalar(0.01)));
        m_sleeper = m_scene.body(shape, 0.1, poseAt(vec(0, 0, 0)));
        m_runner = m_scene.body(shape, 0.1, poseAt(vec(-0.7, offset, 0)));
        for (btRigidBody* ball : {m_sleeper, m_runner})
        {
            ball->setRestitution(1);
            ball->setFriction(0);
        }
        m_sleeper->forceActivationState(ISLAND_SLEEPING);
        m_runner->setLinearVelocity(vec(30, 0, 0));
    }
    void run(int steps)
    {
        for (int i = 0; i < steps; ++i)
        {
            m_scene.step(1.0 / 60.0);
        }
    }

    Scene m_scene;
    btRigidBody* m_sleeper;
    btRigidBody* m_runner;
};
}  // namespace

TEST_P(Worlds, SleepersSleepUntilTheyAreHitAndThenTakeTheirShare)
{
    for (const WorldClass worldClass : kClasses)
    {
        SleepingScene missed(GetParam(), worldClass, 0.05);
        missed.run(6);
        EXPECT_EQ(missed.m_sleeper->getActivationState(), ISLAND_SLEEPING);
        EXPECT_EQ(missed.m_sleeper->getWorldTransform().getOrigin(), btVector3(0, 0, 0));
        EXPECT_NEAR(double(missed.m_runner->getWorldTransform().getOrigin().x()), 2.3, 1e-4);

        SleepingScene hit(GetParam(), worldClass, 0.0);
        hit.run(6);
        EXPECT_NE(hit.m_sleeper->getActivationState(), ISLAND_SLEEPING);
        // An action's impacts are answered by the next step, which corrects positions as well.
        const double exact = GetParam() == Kind::World ? 1e-3 : 0.03;
        EXPECT_NEAR(double(hit.m_sleeper->getLinearVelocity().x()), 30.0, exact);
        EXPECT_NEAR(double(hit.m_runner->getLinearVelocity().x()), 0.0, exact);
        EXPECT_NEAR(momentumOf(hit.m_scene).linear.x(), 3.0, 1e-5);
        EXPECT_LT(double(hit.m_runner->getWorldTransform().getOrigin().x()), 0.0);
        EXPECT_GT(hit.m_sleeper->getWorldTransform().getOrigin().x(), btScalar(1));
    }
}

TEST_P(Worlds, ASleepingFingerIsHitByWhatIsFast)
{
    Scene scene(GetParam());
    btMultiBody* finger =
        scene.chain({scene.boxMesh(vec(0.05, 0.002, 0.01))}, 0.05, btTransform::getIdentity());
    finger->setCanSleep(true);
    finger->goToSleep();
    finger->getLinkCollider(0)->forceActivationState(ISLAND_SLEEPING);
    finger->getBaseCollider()->forceActivationState(ISLAND_SLEEPING);
    scene.step(1.0 / 60.0);
    EXPECT_FALSE(finger->isAwake());
    btRigidBody* ball = scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.005))),
                                   0.01,
                                   poseAt(vec(0.08, -0.3, 0)));
    ball->setLinearVelocity(vec(0, 30, 0));
    double turned = 0.0;
    for (int i = 0; i < 4; ++i)
    {
        scene.step(1.0 / 60.0);
        turned = std::max(turned, double(finger->getJointVel(0)));
    }
    EXPECT_TRUE(finger->isAwake());
    // The finger is 10 g, its middle 5 cm from the hinge: it has become fast.
    EXPECT_GT(turned, 50.0);
    EXPECT_LT(double(ball->getLinearVelocity().y()), 29.0);
}

namespace
{
/// A thin plate that the program moves along z at that speed.
struct KinematicPlate
{
    KinematicPlate(Scene& scene, double speed)
        : m_body(scene.body(scene.box(vec(0.2, 0.2, 0.001)), 0.0, poseAt(vec(0, 0, 0)))),
          m_speed(speed)
    {
        m_body->setCollisionFlags(m_body->getCollisionFlags() |
                                  btCollisionObject::CF_KINEMATIC_OBJECT);
    }
    void move(double timeStep)
    {
        m_height += m_speed * timeStep;
        m_body->setWorldTransform(poseAt(vec(0, 0, m_height)));
    }

    btRigidBody* m_body;
    double m_speed;
    double m_height = 0.0;
};
}  // namespace

TEST(WorldsOfOurs, AFastKinematicPlateTakesAlongWhatItMeets)
{
    for (const WorldClass worldClass : {WorldClass::Rigid, WorldClass::MultiBody})
    {
        Scene scene(Kind::World, worldClass);
        KinematicPlate plate(scene, 10.0);  // 17 cm a step
        btRigidBody* box = scene.body(scene.box(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(0, 0, 1)));
        for (int i = 0; i < 12; ++i)
        {
            plate.move(1.0 / 60.0);
            scene.step(1.0 / 60.0);
            EXPECT_EQ(heightOf(*plate.m_body), double(btScalar(plate.m_height)));
            EXPECT_GT(heightOf(*box), plate.m_height) << "step " << i;
        }
        EXPECT_GT(heightOf(*box), 1.1);
        EXPECT_NEAR(double(box->getLinearVelocity().z()), 10.0, 1.0);
    }
}

TEST_P(Worlds, AKinematicPlateStopsWhatIsFastAndIsNeverMovedItself)
{
    for (const WorldClass worldClass : kClasses)
    {
        Scene scene(GetParam(), worldClass);
        KinematicPlate plate(scene, 0.06);  // a millimetre a step
        btRigidBody* box =
            scene.body(scene.box(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(0, 0, 0.5)));
        box->setLinearVelocity(vec(0, 0, -30));
        for (int i = 0; i < 10; ++i)
        {
            plate.move(1.0 / 60.0);
            scene.step(1.0 / 60.0);
            EXPECT_EQ(heightOf(*plate.m_body), double(btScalar(plate.m_height)));
            EXPECT_GT(heightOf(*box), plate.m_height);
        }
        EXPECT_GT(scene.counters().m_impacts, 0);
        EXPECT_EQ(scene.ccd().getCcdLostTime(plate.m_body), 0.0);
    }
}

INSTANTIATE_TEST_SUITE_P(Ours,
                         Worlds,
                         testing::ValuesIn(kOurKinds),
                         [](const testing::TestParamInfo<Kind>& test)
                         { return std::string(codeOf(test.param)); });
}  // namespace bullet_ccd::tests
