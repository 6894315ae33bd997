#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/motion/btCcdMultiBodyMotion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

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

void setUpJoint(btMultiBody& body, int link, int parent, Random& random)
{
    const btVector3 inertia = vec(1, 1, 1);
    const btScalar mass = 1;
    const btVector3 axis = btCcdToBullet(random.direction());
    const btQuaternion rotation = turn(random);
    const btVector3 pivot = point(random);
    const btVector3 center = point(random);
    switch (random.integer(0, 5))
    {
        case 0:
            body.setupFixed(link, mass, inertia, parent, rotation, pivot, center);
            break;
        case 1:
        {
            // Bullet takes the length of a prismatic axis into account.
            const btVector3 stretched = axis * btScalar(random.uniform(0.5, 2.0));
            body.setupPrismatic(
                link, mass, inertia, parent, rotation, stretched, pivot, center, false);
            break;
        }
        case 2:
            body.setupSpherical(link, mass, inertia, parent, rotation, pivot, center);
            break;
        case 3:
            body.setupPlanar(link, mass, inertia, parent, rotation, axis, pivot);
            break;
        default:
            body.setupRevolute(link, mass, inertia, parent, rotation, axis, pivot, center);
    }
}

/// Links under random parents, joints of all kinds off the centres of mass, all frames turned.
std::unique_ptr<btMultiBody> randomBody(Random& random, int links)
{
    auto body =
        std::make_unique<btMultiBody>(links, btScalar(1), vec(1, 1, 1), random.chance(0.5), false);
    for (int i = 0; i < links; ++i)
    {
        setUpJoint(*body, i, random.integer(-1, i - 1), random);
    }
    body->finalizeMultiDof();
    body->setBaseWorldTransform(btTransform(turn(random), point(random)));
    if (!body->hasFixedBase())
    {
        body->setBaseVel(point(random));
        body->setBaseOmega(point(random) * btScalar(10));
    }
    for (int i = 0; i < links; ++i)
    {
        btScalar position[4] = {};
        for (int k = 0; k < body->getLink(i).m_posVarCount; ++k)
        {
            position[k] = btScalar(random.uniform(-2.0, 2.0));
        }
        if (body->getLink(i).m_jointType == btMultibodyLink::eSpherical)
        {
            const btQuaternion q = turn(random);
            std::copy_n(&q[0], 4, position);
        }
        btScalar velocity[3] = {};
        for (int k = 0; k < body->getLink(i).m_dofCount; ++k)
        {
            velocity[k] = btScalar(random.uniform(-3.0, 3.0));
        }
        if (body->getLink(i).m_dofCount > 0)
        {
            body->setJointPosMultiDof(i, position);
            body->setJointVelMultiDof(i, velocity);
        }
    }
    return body;
}

/// Positions integrated by Bullet, link poses up to date.
void step(btMultiBody& body, btScalar seconds)
{
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    if (seconds > 0)
    {
        body.stepPositionsMultiDof(seconds);
    }
    body.forwardKinematics(rotations, origins);
}

double largestDifference(const btMultiBody& body, const btCcdMultiBodyMotion& motion, double t)
{
    double largest = 0.0;
    for (int i = -1; i < body.getNumLinks(); ++i)
    {
        const Eigen::Isometry3d ours =
            linkStateAt(motion.m_tree, motion.m_motion, kNone, motion.coreLink(i), t).X_W *
            motion.bulletFrame(body, i);
        const btTransform bullet =
            i < 0 ? body.getBaseWorldTransform() : body.getLink(i).m_cachedWorldTransform;
        largest = std::max(largest,
                           (ours.matrix() - btCcdToEigen(bullet).matrix()).cwiseAbs().maxCoeff());
    }
    return largest;
}
}  // namespace

TEST(MultiBodyMotion, PosesEqualBulletsStepAtEveryFractionOfIt)
{
    std::map<btMultibodyLink::eFeatherstoneJointType, int> joints;
    int floating = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed)
    {
        const auto make = [&]
        {
            Random random(1000 + seed);
            return randomBody(random, random.integer(1, 8));
        };
        const auto body = make();
        ASSERT_TRUE(btCcdIsCovered(*body));
        const btScalar dt = btScalar(0.05);
        btCcdMultiBodyMotion motion;
        btCcdReadMotion(*body, dt, motion);
        for (const double fraction : {0.0, 0.25, 0.7, 1.0})
        {
            const auto stepped = make();
            step(*stepped, btScalar(fraction) * dt);
            EXPECT_LT(largestDifference(*stepped, motion, double(btScalar(fraction))), kExact)
                << "seed " << seed << " fraction " << fraction;
        }
        floating += body->hasFixedBase() ? 0 : 1;
        for (int i = 0; i < body->getNumLinks(); ++i)
        {
            ++joints[body->getLink(i).m_jointType];
        }
    }
    EXPECT_GT(floating, 60);
    EXPECT_EQ(joints.size(), 5U);
    for (const auto& [type, count] : joints)
    {
        EXPECT_GT(count, 60) << type;
    }
}

TEST(MultiBodyMotion, TheMotionThatHasJustEndedIsReadFromItsEnd)
{
    for (std::uint64_t seed = 0; seed < 200; ++seed)
    {
        const auto make = [&]
        {
            Random random(2000 + seed);
            return randomBody(random, random.integer(1, 8));
        };
        const btScalar dt = btScalar(0.05);
        const auto after = make();
        step(*after, dt);
        btCcdMultiBodyMotion motion;
        btCcdReadMotion(*after, dt, motion, {.m_done = true});
        EXPECT_LT(largestDifference(*after, motion, 1.0), kExact) << "seed " << seed;
        for (const double fraction : {0.0, 0.5})
        {
            const auto before = make();
            step(*before, btScalar(fraction) * dt);
            EXPECT_LT(largestDifference(*before, motion, fraction), 2.0 * kExact)
                << "seed " << seed << " fraction " << fraction;
        }
    }
}

TEST(MultiBodyMotion, FastTurnsEndWhereBulletsClampedFormulaEnds)
{
    int clamped = 0;
    for (std::uint64_t seed = 0; seed < 100; ++seed)
    {
        Random random(3000 + seed);
        const auto body = randomBody(random, 3);
        for (int i = 0; i < 3; ++i)
        {
            btScalar velocity[3] = {btScalar(random.uniform(-40.0, 40.0)),
                                    btScalar(random.uniform(-40.0, 40.0)),
                                    btScalar(random.uniform(-40.0, 40.0))};
            if (body->getLink(i).m_jointType == btMultibodyLink::eSpherical)
            {
                body->setJointVelMultiDof(i, velocity);
                ++clamped;
            }
        }
        if (!body->hasFixedBase())
        {
            body->setBaseOmega(btCcdToBullet(random.inBox(40.0)));
            ++clamped;
        }
        const btScalar dt = btScalar(0.05);
        btCcdMultiBodyMotion motion;
        btCcdReadMotion(*body, dt, motion);
        step(*body, dt);
        EXPECT_LT(largestDifference(*body, motion, 1.0), kExact) << "seed " << seed;
    }
    EXPECT_GT(clamped, 50);
    EXPECT_NEAR(btCcdTurn(vec(0.6, 0, 0), 1).x(), 0.6, 1e-6);
    // Continuous where the clamp sets in, and less than the velocity beyond.
    EXPECT_NEAR(btCcdTurn(vec(0, SIMD_HALF_PI * 0.5001, 0), 1).y(), 0.25 * std::numbers::pi, 1e-3);
    EXPECT_LT(btCcdTurn(vec(0, 0, SIMD_HALF_PI), 1).z(), 1.4);
}

TEST(MultiBodyMotion, ABodyIsPlacedBackOnTheWayItCame)
{
    const btScalar dt = btScalar(0.05);
    for (std::uint64_t seed = 0; seed < 200; ++seed)
    {
        Random random(4000 + seed);
        const auto body = randomBody(random, random.integer(1, 6));
        if (!body->hasFixedBase() && seed % 2 == 0)
        {
            body->setBaseOmega(btCcdToBullet(random.inBox(40.0)));  // beyond Bullet's clamp
        }
        step(*body, dt);
        btCcdMultiBodyMotion whole;
        btCcdReadMotion(*body, dt, whole, {.m_done = true});
        const double part = random.uniform(0.1, 1.0);
        btCcdMultiBodyMotion last;
        btCcdReadMotion(*body, dt, last, {.m_part = part, .m_done = true});
        EXPECT_LT(largestDifference(*body, last, 1.0), kExact) << "seed " << seed;
        btCcdPlaceAtStart(*body, last);
        EXPECT_LT(largestDifference(*body, whole, 1.0 - part), 2.0 * kExact) << "seed " << seed;
    }
}

TEST(MultiBodyMotion, ASleepingBodyStandsStill)
{
    Random random(14);
    const auto body = randomBody(random, 5);
    btMultiBodyLinkCollider collider(body.get(), 2);
    body->getLink(2).m_collider = &collider;
    btCcdMultiBodyMotion motion;
    btCcdReadMotion(*body, btScalar(0.05), motion);
    EXPECT_TRUE(moves(motion.m_tree, motion.m_motion, kNone, motion.coreLink(4)));
    collider.setActivationState(ISLAND_SLEEPING);
    btCcdReadMotion(*body, btScalar(0.05), motion);
    for (int i = -1; i < 5; ++i)
    {
        EXPECT_FALSE(moves(motion.m_tree, motion.m_motion, kNone, motion.coreLink(i)));
    }
}

TEST(MultiBodyMotion, KinematicLinksOfAMovingBodyStandStillAsInBullet)
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
        step(*body, btScalar(0.05));
        EXPECT_LT(largestDifference(*body, motion, 1.0), kExact);
        EXPECT_EQ(motion.m_motion.rates[std::size_t(motion.coreLink(2))], 0.0);
        stopped += body->getLink(2).m_dofCount > 0 ? 1 : 0;
    }
    EXPECT_GT(stopped, 10) << "the test is vacuous";
}

TEST(MultiBodyMotion, KinematicBodiesMoveOnAtTheirVelocity)
{
    btMultiBody body(2, btScalar(1), vec(1, 1, 1), false, false);
    const btVector3 inertia = vec(1, 1, 1);
    const btQuaternion straight = btQuaternion::getIdentity();
    for (int i = 0; i < 2; ++i)
    {
        body.setupRevolute(
            i, btScalar(1), inertia, i - 1, straight, vec(0, 0, 1), vec(0, 0, 0), vec(1, 0, 0));
    }
    body.finalizeMultiDof();
    btMultiBodyLinkCollider base(&body, -1);
    btMultiBodyLinkCollider first(&body, 0);
    btMultiBodyLinkCollider second(&body, 1);
    body.setBaseCollider(&base);
    body.getLink(0).m_collider = &first;
    body.getLink(1).m_collider = &second;
    body.setBaseVel(vec(1, 2, 3));
    body.setJointVel(0, btScalar(4));
    body.setJointVel(1, btScalar(5));
    body.setBaseDynamicType(btCollisionObject::CF_KINEMATIC_OBJECT);
    body.setLinkDynamicType(0, btCollisionObject::CF_KINEMATIC_OBJECT);
    body.setLinkDynamicType(1, btCollisionObject::CF_STATIC_OBJECT);
    btCcdMultiBodyMotion motion;
    btCcdReadMotion(body, btScalar(0.5), motion);
    EXPECT_EQ(motion.m_motion.root.v_W, Eigen::Vector3d(0.5, 1, 1.5));
    EXPECT_EQ(motion.m_motion.rates[1], 2.0);
    EXPECT_EQ(motion.m_motion.rates[2], 0.0);
    body.setBaseVel(vec(0, 0, 0));
    body.setJointVel(0, btScalar(0));
    btCcdReadMotion(body, btScalar(0.5), motion);
    EXPECT_FALSE(moves(motion.m_tree, motion.m_motion, kNone, 2));
}

TEST(MultiBodyMotion, OtherIntegratorsAreNotCovered)
{
    Random random(13);
    const auto body = randomBody(random, 2);
    EXPECT_TRUE(btCcdIsCovered(*body));
    body->useRK4Integration(true);
    EXPECT_FALSE(btCcdIsCovered(*body));
}
}  // namespace bullet_ccd::tests
