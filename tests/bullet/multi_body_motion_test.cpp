#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMultiBodyMotion.h"
#include "tests/bullet/scene.h"
#include "tests/support/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace bullet_ccd::tests
{
namespace
{
constexpr double kExact = kDouble ? 1e-12 : 1e-5;

btQuaternion turn(Random& random)
{
    return btCcdToBullet(Eigen::Quaterniond(random.rotation()));
}

btVector3 point(Random& random)
{
    return btCcdToBullet(random.inBox(0.3));
}

/// Links under random parents, joints off the centres of mass, all frames turned.
std::unique_ptr<btMultiBody> randomBody(Random& random, int links)
{
    auto body =
        std::make_unique<btMultiBody>(links, btScalar(1), vec(1, 1, 1), random.chance(0.5), false);
    for (int i = 0; i < links; ++i)
    {
        const int parent = random.integer(-1, i - 1);
        const btVector3 inertia = vec(1, 1, 1);
        const btVector3 axis = btCcdToBullet(random.direction());
        switch (random.integer(0, 3))
        {
            case 0:
                body->setupFixed(
                    i, btScalar(1), inertia, parent, turn(random), point(random), point(random));
                break;
            case 1:
                // Bullet takes the length of a prismatic axis into account.
                body->setupPrismatic(i,
                                     btScalar(1),
                                     inertia,
                                     parent,
                                     turn(random),
                                     axis * btScalar(random.uniform(0.5, 2.0)),
                                     point(random),
                                     point(random),
                                     false);
                break;
            default:
                body->setupRevolute(i,
                                    btScalar(1),
                                    inertia,
                                    parent,
                                    turn(random),
                                    axis,
                                    point(random),
                                    point(random));
        }
    }
    body->finalizeMultiDof();
    body->setBaseWorldTransform(btTransform(turn(random), point(random)));
    if (!body->hasFixedBase())
    {
        body->setBaseVel(point(random));
        body->setBaseOmega(point(random));
    }
    for (int i = 0; i < links; ++i)
    {
        if (body->getLink(i).m_dofCount > 0)
        {
            body->setJointPos(i, btScalar(random.uniform(-2.0, 2.0)));
            body->setJointVel(i, btScalar(random.uniform(-3.0, 3.0)));
        }
    }
    return body;
}

double largestDifference(const btMultiBody& body, const btCcdMultiBodyMotion& motion, double t)
{
    double largest = 0.0;
    for (int i = -1; i < body.getNumLinks(); ++i)
    {
        const Eigen::Isometry3d ours =
            linkStateAt(motion.m_tree, motion.m_motion, kNone, i + 1, t).X_W *
            motion.bulletFrame(body, i);
        const btTransform bullet =
            i < 0 ? body.getBaseWorldTransform() : body.getLink(i).m_cachedWorldTransform;
        largest = std::max(largest,
                           (ours.matrix() - btCcdToEigen(bullet).matrix()).cwiseAbs().maxCoeff());
    }
    return largest;
}
}  // namespace

TEST(MultiBodyMotion, PosesEqualBulletsForwardKinematicsAndItsIntegration)
{
    Random random(11);
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    for (int trial = 0; trial < 100; ++trial)
    {
        const auto body = randomBody(random, random.integer(1, 8));
        ASSERT_TRUE(btCcdIsCovered(*body));
        const btScalar dt = btScalar(0.05);
        btCcdMultiBodyMotion motion;
        btCcdReadMotion(*body, dt, motion);
        body->forwardKinematics(rotations, origins);
        EXPECT_LT(largestDifference(*body, motion, 0.0), kExact);

        body->stepPositionsMultiDof(dt);
        body->forwardKinematics(rotations, origins);
        EXPECT_LT(largestDifference(*body, motion, 1.0), kExact);
    }
}

TEST(MultiBodyMotion, KinematicLinksStandStillAsInBullet)
{
    Random random(12);
    int stopped = 0;
    for (int trial = 0; trial < 30; ++trial)
    {
        const auto body = randomBody(random, 5);
        btMultiBodyLinkCollider collider(body.get(), 2);
        body->getLink(2).m_collider = &collider;
        body->setLinkDynamicType(2, btCollisionObject::CF_KINEMATIC_OBJECT);
        btCcdMultiBodyMotion motion;
        btCcdReadMotion(*body, btScalar(0.05), motion);
        body->stepPositionsMultiDof(btScalar(0.05));
        btAlignedObjectArray<btQuaternion> rotations;
        btAlignedObjectArray<btVector3> origins;
        body->forwardKinematics(rotations, origins);
        EXPECT_LT(largestDifference(*body, motion, 1.0), kExact);
        EXPECT_EQ(motion.m_motion.rates[3], 0.0);
        stopped += body->getLink(2).m_dofCount > 0 ? 1 : 0;
    }
    EXPECT_GT(stopped, 10) << "the test is vacuous";
}

TEST(MultiBodyMotion, OtherJointsAndIntegratorsAreNotCovered)
{
    btMultiBody ball(1, btScalar(1), vec(1, 1, 1), true, false);
    ball.setupSpherical(
        0, btScalar(1), vec(1, 1, 1), -1, btQuaternion::getIdentity(), vec(0, 0, 0), vec(0, 0, 0));
    ball.finalizeMultiDof();
    EXPECT_FALSE(btCcdIsCovered(ball));

    Random random(13);
    const auto body = randomBody(random, 2);
    EXPECT_TRUE(btCcdIsCovered(*body));
    body->useRK4Integration(true);
    EXPECT_FALSE(btCcdIsCovered(*body));
}
}  // namespace bullet_ccd::tests
