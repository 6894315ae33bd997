#include "benchmarks/reference/bullet/scene.h"
#include "bullet_ccd/bullet/btCcdControl.h"

#include <BulletCollision/CollisionShapes/btMinkowskiSumShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kExact = kDouble ? 1e-12 : 2e-6;
constexpr double kHalfLength = 0.02;

btCcdMeshShape* rod(Scene& scene)
{
    return scene.boxMesh(vec(kHalfLength, 0.001, 0.004));
}

/// Notes impacts and answers all of them in one way.
struct Recorder : btCcdImpactListener
{
    btCcdAfterImpact m_answer = btCcdAfterImpact::Hold;
    std::vector<btCcdImpact> m_impacts;

    btCcdAfterImpact onImpact(const btCcdImpact& impact) override
    {
        m_impacts.push_back(impact);
        return m_answer;
    }
};

/// A block in the way of a finger of one link that turns about z at the origin.
btRigidBody* addBlock(Scene& scene)
{
    return scene.body(scene.box(vec(0.005, 0.005, 0.005)), 0.0, poseAt(vec(0.03, -0.02, 0.0)));
}

/// Joint position at which the lower face of the rod meets the block's corner (0.035, -0.015), up
/// to the tolerance: the corner is at distance r, the face 1 mm off the link's axis.
double touchAngle()
{
    const double r = std::hypot(0.035, 0.015);
    return std::atan2(-0.015, 0.035) + std::asin(0.001 / r);
}
}  // namespace

TEST(Impact, ListenerLearnsWhoMeetsWhenAndWhere)
{
    Scene scene(Kind::World);
    btRigidBody* block = addBlock(scene);
    btMultiBody* finger = scene.chain({rod(scene)}, kHalfLength, btTransform::getIdentity());
    finger->setJointVel(0, -2);
    Recorder recorder;
    scene.ccd().setCcdImpactListener(&recorder);
    scene.step(0.5);

    ASSERT_EQ(recorder.m_impacts.size(), 1U);
    const btCcdImpact& impact = recorder.m_impacts.front();
    const bool linkFirst = impact.m_objectB == block;
    EXPECT_EQ(linkFirst ? impact.m_objectA : impact.m_objectB, finger->getLink(0).m_collider);
    EXPECT_EQ(linkFirst ? impact.m_linkA : impact.m_linkB, 0);
    EXPECT_EQ(linkFirst ? impact.m_linkB : impact.m_linkA, btCcdImpact::kNoLink);
    // A mesh is stopped at its margin, at most a sixteenth above it.
    const double shell = btCcdMeshShape::kDefaultMargin * (1.0 + 1.0 / 16.0);
    const double late = shell / (2.0 * std::hypot(0.035, 0.015));
    EXPECT_LE(double(impact.m_time), -touchAngle() / 2.0 + 1e-6);
    EXPECT_GE(double(impact.m_time), -touchAngle() / 2.0 - 1.1 * late);
    EXPECT_NEAR(double(finger->getJointPos(0)), -2.0 * double(impact.m_time), 1e-6);
    EXPECT_LT(double(impact.m_pointA.distance(vec(0.035, -0.015, impact.m_pointA.z()))),
              1.1 * shell);
    // From A to B, across the face of the rod.
    const btVector3 down(std::sin(finger->getJointPos(0)), -std::cos(finger->getJointPos(0)), 0);
    EXPECT_NEAR(double(impact.m_normal.dot(down)), linkFirst ? 1.0 : -1.0, 1e-3);
}

TEST(Impact, HeldBodyKeepsItsVelocityAndOthersLoseNoTime)
{
    Scene scene(Kind::World);
    addBlock(scene);
    btMultiBody* finger = scene.chain({rod(scene)}, kHalfLength, btTransform::getIdentity());
    finger->setJointVel(0, -2);
    btMultiBody* other = scene.chain({rod(scene)}, kHalfLength, poseAt(vec(0, 1, 0)));
    other->setJointVel(0, -2);
    btRigidBody* free = scene.body(scene.boxMesh(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(0, 2, 0)));
    free->setLinearVelocity(vec(0, 0, 3));
    Recorder recorder;
    scene.ccd().setCcdImpactListener(&recorder);
    scene.step(0.5);

    EXPECT_NEAR(double(finger->getJointVel(0)), -2.0, 1e-6);  // next step the solver answers
    EXPECT_GT(double(finger->getJointPos(0)), touchAngle());
    EXPECT_NEAR(double(other->getJointPos(0)), -1.0, 1e-6);
    EXPECT_NEAR(double(free->getWorldTransform().getOrigin().z()), 1.5, 1e-6);
    const btCcdCounters& counters = scene.ccd().getCcdCounters();
    EXPECT_EQ(counters.m_impacts, 1);
    EXPECT_EQ(counters.m_clamps, 1);
    EXPECT_NEAR(counters.m_lostTime, 0.5 + double(finger->getJointPos(0)) / 2.0, 1e-5);
    EXPECT_NEAR(
        scene.ccd().getCcdLostTime(finger->getLink(0).m_collider), counters.m_lostTime, 1e-12);
    EXPECT_EQ(scene.ccd().getCcdLostTime(free), 0.0);
    EXPECT_EQ(counters.m_unsupported, 0);
}

TEST(Impact, SolverAnswersAtOnceAndNobodyLosesTime)
{
    Scene scene(Kind::World);
    addBlock(scene);
    btMultiBody* finger = scene.chain({rod(scene)}, kHalfLength, btTransform::getIdentity());
    finger->setJointVel(0, -2);
    scene.step(0.5);
    const btCcdCounters& counters = scene.ccd().getCcdCounters();
    EXPECT_EQ(counters.m_impacts, 1);
    EXPECT_EQ(counters.m_subSteps, 1);
    EXPECT_EQ(counters.m_clamps, 0);
    EXPECT_EQ(counters.m_lostTime, 0.0);
    // What is left of its speed closes the rest of the shell within the step.
    EXPECT_LE(double(finger->getJointVel(0)), 0.0);
    EXPECT_GT(double(finger->getJointVel(0)), -0.01);
}

TEST(Impact, BouncingBallsSwapTheirVelocitiesInTheMiddleOfTheStep)
{
    // Equal masses, restitution 1, head on and fast: each passes its velocity on at the impact.
    Scene scene(Kind::World);
    btCollisionShape* sphere = scene.keep(std::make_unique<btSphereShape>(btScalar(0.01)));
    btRigidBody* a = scene.body(sphere, 0.1, poseAt(vec(-0.11, 0, 0)));
    btRigidBody* b = scene.body(sphere, 0.1, poseAt(vec(0.11, 0, 0)));
    for (btRigidBody* ball : {a, b})
    {
        ball->setRestitution(1);
        ball->setFriction(0);
    }
    a->setLinearVelocity(vec(30, 0, 0));
    b->setLinearVelocity(vec(-10, 0, 0));
    scene.step(0.01);
    EXPECT_EQ(scene.ccd().getCcdCounters().m_impacts, 1);
    EXPECT_NEAR(double(a->getLinearVelocity().x()), -10.0, 1e-4);
    EXPECT_NEAR(double(b->getLinearVelocity().x()), 30.0, 1e-4);
    // They meet 5 ms after the start, where a is at 0.04.
    EXPECT_NEAR(double(a->getWorldTransform().getOrigin().x()), 0.04 - 10 * 0.005, 1e-3);
    EXPECT_NEAR(double(b->getWorldTransform().getOrigin().x()), 0.06 + 30 * 0.005, 1e-3);
}

TEST(Impact, StoppedLinkFreezesAndTheRestOfTheFingerGoesOn)
{
    Scene scene(Kind::World);
    addBlock(scene);
    btMultiBody* finger =
        scene.chain({rod(scene), rod(scene)}, kHalfLength, btTransform::getIdentity());
    finger->setJointVel(0, -2);
    finger->setJointVel(1, btScalar(1.5));
    scene.ccd().stopLinkOnFirstContact(finger, 0);
    scene.step(0.5);

    EXPECT_TRUE(finger->isLinkKinematic(0));
    EXPECT_FALSE(finger->isLinkKinematic(1));
    const double stopped = double(finger->getJointPos(0));
    EXPECT_GT(stopped, touchAngle());
    EXPECT_LT(stopped, touchAngle() + 0.02);
    // The distal joint moved at its solved velocity for the whole step.
    EXPECT_NEAR(double(finger->getJointPos(1)), 0.5 * double(finger->getJointVel(1)), 10 * kExact);
    EXPECT_EQ(scene.ccd().getCcdCounters().m_lostTime, 0.0);

    // Frozen means frozen, whatever moves below.
    for (int i = 0; i < 20; ++i)
    {
        scene.step(0.01);
    }
    EXPECT_EQ(double(finger->getJointPos(0)), stopped);
}

TEST(Impact, StopLinkNeedsColliders)
{
    btMultiBody bare(1, btScalar(0), vec(1, 1, 1), true, false);
    bare.setupRevolute(0,
                       btScalar(1),
                       vec(1, 1, 1),
                       -1,
                       btQuaternion::getIdentity(),
                       vec(0, 0, 1),
                       vec(0, 0, 0),
                       vec(1, 0, 0));
    bare.finalizeMultiDof();
    bare.setJointVel(0, 1);
    EXPECT_FALSE(btCcdStopLink(bare, 0));
    EXPECT_EQ(bare.getJointVel(0), btScalar(1));
}

TEST(Impact, PairWithinTheShellCanLeaveAndSlide)
{
    // A box in the middle of the shell over a wide plate moves sideways, then away.
    Scene scene(Kind::World);
    const double gap = btCcdMeshShape::kDefaultMargin;
    btRigidBody* plate = scene.body(scene.boxMesh(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, -0.01)));
    btRigidBody* box =
        scene.body(scene.boxMesh(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(0, 0, 0.01 + gap)));
    plate->setFriction(0);
    box->setLinearVelocity(vec(1, 0, 0));
    for (int i = 0; i < 10; ++i)
    {
        scene.step(0.01);
    }
    EXPECT_NEAR(double(box->getWorldTransform().getOrigin().x()), 0.1, 1e-5);
    const double height = double(box->getWorldTransform().getOrigin().z());
    EXPECT_GT(height, 0.01 + 0.99 * gap);
    EXPECT_LT(height, 0.01 + 4.0 * gap);  // the solver has pushed it out
    box->setLinearVelocity(vec(0, 0, 1));
    scene.step(0.01);
    EXPECT_NEAR(double(box->getWorldTransform().getOrigin().z()), height + 0.01, 1e-5);
    EXPECT_EQ(scene.ccd().getCcdCounters().m_impacts, 0);
}

TEST(Impact, ListenerThatStopsNothingCostsTimeButLetsNothingThrough)
{
    Scene scene(Kind::World);
    Recorder recorder;
    recorder.m_answer = btCcdAfterImpact::Continue;
    scene.ccd().setCcdImpactListener(&recorder);
    scene.body(scene.boxMesh(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, -0.01)));
    btRigidBody* box =
        scene.body(scene.boxMesh(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(0, 0, 0.05)));
    // Every time it may lose a third of its distance at most, until that is so small a part (1/32
    // in single precision, 1/10000 in double) of 5/16 of the sum of the margins that it is left
    // there.
    const double leftAt = (kDouble ? 1e-4 : 1.0 / 32.0) * (5.0 / 16.0);
    const double least = 2.0 * btCcdMeshShape::kDefaultMargin * leftAt * (2.0 / 3.0);
    for (int i = 0; i < 50; ++i)
    {
        box->setLinearVelocity(vec(0, 0, -50));
        scene.step(0.01);
        EXPECT_GT(double(box->getWorldTransform().getOrigin().z()) - 0.01, least);
    }
    EXPECT_GT(scene.ccd().getCcdCounters().m_eventLimits, 0);
}

namespace
{
/// Flies a box at a plate; true if it was stopped.
template <typename Prepare>
bool isStopped(const Prepare& prepare)
{
    Scene scene(Kind::World);
    btRigidBody* plate = scene.body(scene.boxMesh(vec(0.1, 0.1, 0.001)), 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* box =
        scene.body(scene.boxMesh(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(0, 0, 0.05)));
    prepare(scene, *plate, *box);
    box->setLinearVelocity(vec(0, 0, -10));
    scene.step(0.01);
    return box->getWorldTransform().getOrigin().z() > btScalar(0);
}
}  // namespace

TEST(Impact, PairsThatBulletDoesNotCollidePassThrough)
{
    struct Nothing : btOverlapFilterCallback
    {
        bool needBroadphaseCollision(btBroadphaseProxy*, btBroadphaseProxy*) const override
        {
            return false;
        }
    };
    Nothing nothing;
    EXPECT_TRUE(isStopped([](Scene&, btRigidBody&, btRigidBody&) {}));
    EXPECT_FALSE(isStopped([](Scene&, btRigidBody& plate, btRigidBody&)
                           { plate.getBroadphaseHandle()->m_collisionFilterMask = 0; }));
    EXPECT_FALSE(isStopped([](Scene&, btRigidBody& plate, btRigidBody& box)
                           { box.setIgnoreCollisionCheck(&plate, true); }));
    EXPECT_FALSE(isStopped(
        [](Scene&, btRigidBody& plate, btRigidBody&)
        {
            plate.setCollisionFlags(plate.getCollisionFlags() |
                                    btCollisionObject::CF_NO_CONTACT_RESPONSE);
        }));
    EXPECT_FALSE(isStopped([&](Scene& scene, btRigidBody&, btRigidBody&)
                           { scene.world().getPairCache()->setOverlapFilterCallback(&nothing); }));
}

TEST(Impact, LinksOfOneBodyMeetOnlyWithSelfCollision)
{
    for (const bool self : {true, false})
    {
        // Three links fold onto each other: the last meets the first, not its own parent.
        Scene scene(Kind::World);
        btMultiBody* body = scene.chain(
            {rod(scene), rod(scene), rod(scene)}, kHalfLength, btTransform::getIdentity());
        body->setHasSelfCollision(self);
        body->setJointPos(1, btScalar(2.0));
        body->setJointPos(2, btScalar(1.5));
        Scene::placeColliders(*body);
        body->setJointVel(2, 4);
        Recorder recorder;
        scene.ccd().setCcdImpactListener(&recorder);
        scene.step(0.3);
        ASSERT_EQ(recorder.m_impacts.size(), self ? 1U : 0U);
        if (self)
        {
            EXPECT_EQ(recorder.m_impacts[0].m_linkA + recorder.m_impacts[0].m_linkB, 0 + 2);
        }
    }
}

TEST(Impact, UnsupportedShapesAreCountedAndLeftToBullet)
{
    Scene scene(Kind::World);
    const btSphereShape* sphere = scene.keep(std::make_unique<btSphereShape>(btScalar(0.1)));
    scene.body(scene.keep(std::make_unique<btMinkowskiSumShape>(sphere, sphere)),
               0.0,
               poseAt(vec(0, 0, 0)));
    btRigidBody* box =
        scene.body(scene.boxMesh(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(0, 0, 0.5)));
    box->setLinearVelocity(vec(0, 0, -1));
    scene.step(0.01);
    EXPECT_EQ(scene.ccd().getCcdCounters().m_unsupported, 1);
    EXPECT_NEAR(double(box->getWorldTransform().getOrigin().z()), 0.49, 1e-6);
}

TEST(Impact, IntersectingBodiesAreLeftToDiscreteContacts)
{
    Scene scene(Kind::World);
    scene.body(scene.boxMesh(vec(0.1, 0.1, 0.01)), 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* box =
        scene.body(scene.boxMesh(vec(0.02, 0.02, 0.02)), 0.1, poseAt(vec(0, 0, 0.005)));
    box->setLinearVelocity(vec(0, 0, 1));
    scene.step(0.01);
    EXPECT_EQ(scene.ccd().getCcdCounters().m_overlaps, 1);
    EXPECT_EQ(scene.ccd().getCcdCounters().m_impacts, 0);
    EXPECT_GT(double(box->getWorldTransform().getOrigin().z()), 0.013);
}
}  // namespace bullet_ccd::tests
