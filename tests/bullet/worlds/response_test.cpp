#include "benchmarks/reference/bullet/mechanics.h"
#include "benchmarks/reference/bullet/pile.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btGeneric6DofSpring2Constraint.h>
#include <BulletDynamics/ConstraintSolver/btSliderConstraint.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kGravity = 9.81;
constexpr double kTimeStep = 1.0 / 240.0;

/// Its top is the plane z = 0.
btRigidBody* addFloor(Scene& scene, btScalar restitution, btScalar friction, double thickness = 2.0)
{
    scene.world().setGravity(vec(0, 0, -kGravity));
    const double half = 0.5 * thickness;
    btRigidBody* floor = scene.body(scene.box(vec(20, 20, half)), 0.0, poseAt(vec(0, 0, -half)));
    floor->setRestitution(restitution);
    floor->setFriction(friction);
    return floor;
}

class ResponseOf : public testing::TestWithParam<Kind>
{
protected:
    /// Worlds of both classes have the same answers to check.
    static constexpr WorldClass kClasses[] = {WorldClass::Rigid, WorldClass::MultiBody};
};

struct Drop
{
    bool mesh = false;
    double radius = 0.1;
    double thickness = 2.0;  ///< of the floor
    double restitution = 0.0;
};

/// Height over the floor that a ball reaches again after it was dropped from 1 m.
double reboundHeight(Kind kind, WorldClass worldClass, const Drop& drop)
{
    Scene scene(kind, worldClass);
    addFloor(scene, 1, 0, drop.thickness);
    btCollisionShape* shape =
        drop.mesh ? static_cast<btCollisionShape*>(scene.mesh(makeSphere(drop.radius, 2)))
                  : static_cast<btCollisionShape*>(
                        scene.keep(std::make_unique<btSphereShape>(btScalar(drop.radius))));
    btRigidBody* ball = scene.body(shape, 0.1, poseAt(vec(0, 0, 1.0 + drop.radius)));
    ball->setRestitution(btScalar(drop.restitution));
    bool fell = false;
    bool back = false;
    double highest = 0.0;
    for (int i = 0; i < 240; ++i)
    {
        scene.step(kTimeStep);
        fell = fell || ball->getLinearVelocity().z() < btScalar(-4);
        back = back || (fell && ball->getLinearVelocity().z() > btScalar(-0.5));
        if (back)
        {
            highest =
                std::max(highest, double(ball->getWorldTransform().getOrigin().z()) - drop.radius);
        }
    }
    return highest;
}
}  // namespace

TEST_P(ResponseOf, DroppedBallComesBackAsHighAsInTheStockWorld)
{
    for (const WorldClass worldClass : kClasses)
    {
        for (const double restitution : {0.0, 0.5, 1.0})
        {
            const double expected = restitution * restitution;
            const double stock =
                reboundHeight(Kind::Stock, worldClass, {.restitution = restitution});
            // Where stock Bullet is slow enough, and where it would lose the ball.
            const double ours = reboundHeight(GetParam(), worldClass, {.restitution = restitution});
            Drop thin{.radius = 0.005, .thickness = 0.001, .restitution = restitution};
            const double small = reboundHeight(GetParam(), worldClass, thin);
            thin.mesh = true;
            const double mesh = reboundHeight(GetParam(), worldClass, thin);
            std::printf(
                "restitution %.1f: stock %.3f, ours %.3f, on a thin plate %.3f, mesh %.3f m\n",
                restitution,
                stock,
                ours,
                small,
                mesh);
            const double tolerance = std::max(std::abs(stock - expected), 0.03);
            EXPECT_NEAR(ours, stock, 0.01);
            EXPECT_NEAR(small, expected, tolerance);
            EXPECT_NEAR(mesh, expected, tolerance);
        }
    }
}

namespace
{
/// How far a box gets that slides at 3 m/s, or lands on the floor before.
double slidingDistance(Kind kind, WorldClass worldClass, bool mesh, double fall)
{
    Scene scene(kind, worldClass);
    addFloor(scene, 0, btScalar(1));
    const btVector3 half = vec(0.05, 0.05, 0.005);
    btCollisionShape* shape = mesh ? static_cast<btCollisionShape*>(scene.boxMesh(half))
                                   : static_cast<btCollisionShape*>(scene.box(half));
    btRigidBody* box = scene.body(shape, 0.1, poseAt(vec(0, 0, 0.0055 + fall)));
    box->setFriction(btScalar(0.5));
    box->setLinearVelocity(vec(3, 0, 0));
    for (int i = 0; i < 480; ++i)
    {
        scene.step(kTimeStep);
    }
    EXPECT_LT(double(box->getLinearVelocity().length()), 0.02);
    return double(box->getWorldTransform().getOrigin().x());
}
}  // namespace

TEST_P(ResponseOf, SlidingBoxStopsAfterTheWayOfItsFriction)
{
    const double expected = 3.0 * 3.0 / (2.0 * 0.5 * kGravity);
    for (const WorldClass worldClass : kClasses)
    {
        const double stock = slidingDistance(Kind::Stock, worldClass, false, 0.0);
        const double ours = slidingDistance(GetParam(), worldClass, false, 0.0);
        const double mesh = slidingDistance(GetParam(), worldClass, true, 0.0);
        std::printf("slides: stock %.4f, ours %.4f, mesh %.4f m, expected %.4f\n",
                    stock,
                    ours,
                    mesh,
                    expected);
        EXPECT_NEAR(ours, stock, 0.01 * expected);
        EXPECT_NEAR(mesh, expected, 0.03 * expected);
    }
}

TEST_P(ResponseOf, BoxThatLandsFastSlidesAsFarAsInTheStockWorld)
{
    for (const WorldClass worldClass : kClasses)
    {
        const double stock = slidingDistance(Kind::Stock, worldClass, false, 0.3);
        const double ours = slidingDistance(GetParam(), worldClass, false, 0.3);
        std::printf("lands and slides: stock %.4f, ours %.4f m\n", stock, ours);
        EXPECT_NEAR(ours, stock, 0.05 * stock);
    }
}

namespace
{
/// Boxes on top of each other, dropped by a millimetre each.
void addStack(Scene& scene, bool mesh, double size)
{
    const btVector3 half = vec(size, size, size);
    for (int i = 0; i < 5; ++i)
    {
        btCollisionShape* shape = mesh ? static_cast<btCollisionShape*>(scene.boxMesh(half))
                                       : static_cast<btCollisionShape*>(scene.box(half));
        scene.body(shape, 1.0, poseAt(vec(0, 0, (2.0 * i + 1.0) * size + 0.002 * (i + 1))));
    }
}
}  // namespace

TEST_P(ResponseOf, RestingStackGainsNoEnergy)
{
    for (const WorldClass worldClass : kClasses)
    {
        for (const bool mesh : {false, true})
        {
            Scene scene(GetParam(), worldClass);
            addFloor(scene, 0, btScalar(0.5));
            constexpr double kSize = 0.05;
            addStack(scene, mesh, kSize);
            for (int i = 0; i < 240; ++i)
            {
                scene.step(kTimeStep);
            }
            const double settled = energyOf(scene, kGravity);
            double highest = settled;
            for (int i = 0; i < 960; ++i)
            {
                scene.step(kTimeStep);
                highest = std::max(highest, energyOf(scene, kGravity));
            }
            // Of what it takes to lift all five boxes by a thousandth of their size.
            const double gain = (highest - settled) / (5.0 * kGravity * 2.0 * kSize);
            std::printf(
                "%s stack: energy gained %.1e of weight times size\n", mesh ? "mesh" : "box", gain);
            EXPECT_LT(gain, 1e-3) << (mesh ? "meshes" : "boxes");
            const btRigidBody* top = btRigidBody::upcast(
                scene.world()
                    .getCollisionObjectArray()[scene.world().getNumCollisionObjects() - 1]);
            EXPECT_NEAR(double(top->getWorldTransform().getOrigin().z()), 9.0 * kSize, 0.007);
        }
    }
}

TEST_P(ResponseOf, FallBesideABusyPileIsFree)
{
    const PileFall fall = fallBesidePile(GetParam());
    EXPECT_GT(fall.impacts, 100) << "the pile was not busy";
    EXPECT_NEAR(fall.way / fall.expected, 1.0, 0.01);
}

/// A ball of 0.1 g flies at 60 m/s between a wall and a block of 1 kg that slides towards the wall
/// at 0.3 m/s, and hits the block once in a step. How fast the block is then; the joint holds it to
/// the direction of its way.
template <typename MakeJoint>
double blockAfterOneHit(const MakeJoint& makeJoint)
{
    Scene scene(Kind::World, WorldClass::Rigid);
    btRigidBody* block = scene.body(scene.box(vec(0.2, 0.2, 0.2)), 1.0, poseAt(vec(1, 0, 0)));
    block->setRestitution(1);
    block->setLinearVelocity(vec(0.3, 0, 0));
    // Beside the way of everything.
    btRigidBody* post = scene.body(scene.box(vec(0.1, 0.1, 0.1)), 0.0, poseAt(vec(0, 0, 5)));
    scene.body(scene.box(vec(0.1, 1, 1)), 0.0, poseAt(vec(1.65, 0, 0)))->setRestitution(1);
    btRigidBody* ball = scene.body(
        scene.keep(std::make_unique<btSphereShape>(btScalar(0.02))), 1e-4, poseAt(vec(1.25, 0, 0)));
    ball->setRestitution(1);
    ball->setLinearVelocity(vec(60, 0, 0));
    if (auto joint = makeJoint(*post, *block))
    {
        scene.addConstraint(std::move(joint));
    }
    scene.step(1.0 / 60.0);
    EXPECT_EQ(scene.counters().m_subSteps, 3);
    return double(block->getLinearVelocity().x());
}

TEST(ImpactOfAnIsland, LeavesMotorsSpringsAndStopsAsTheyWere)
{
    // An elastic hit takes twice the ball's mass times its speed relative to the block.
    constexpr double kHit = 2.0 * 1e-4 * 60.3;
    const btTransform inPost = poseAt(vec(1, 0, -5));
    const btTransform inBlock = poseAt(vec(0, 0, 0));
    using Joint = std::unique_ptr<btTypedConstraint>;
    EXPECT_NEAR(
        blockAfterOneHit([](btRigidBody&, btRigidBody&) { return Joint(); }), 0.3 - kHit, 2e-5);

    const auto slider = [&](bool motor)
    {
        return [&inPost, &inBlock, motor](btRigidBody& post, btRigidBody& block) -> Joint
        {
            auto joint = std::make_unique<btSliderConstraint>(post, block, inPost, inBlock, true);
            joint->setLowerLinLimit(-1);
            joint->setUpperLinLimit(1);
            joint->setLowerAngLimit(0);
            joint->setUpperAngLimit(0);
            joint->setPoweredLinMotor(motor);
            joint->setTargetLinMotorVelocity(5);
            joint->setMaxLinMotorForce(5);
            return joint;
        };
    };
    EXPECT_NEAR(blockAfterOneHit(slider(false)), 0.3 - kHit, 2e-5);
    // 5 N for a step.
    EXPECT_NEAR(blockAfterOneHit(slider(true)), 0.3 + 5.0 / 60.0 - kHit, 1e-4);

    const auto spring = [&](btScalar stiffness)
    {
        return [&inPost, &inBlock, stiffness](btRigidBody& post, btRigidBody& block) -> Joint
        {
            auto joint =
                std::make_unique<btGeneric6DofSpring2Constraint>(post, block, inPost, inBlock);
            joint->setLinearLowerLimit(vec(-1, 0, 0));
            joint->setLinearUpperLimit(vec(1, 0, 0));
            joint->setAngularLowerLimit(vec(0, 0, 0));
            joint->setAngularUpperLimit(vec(0, 0, 0));
            joint->enableSpring(0, stiffness > btScalar(0));
            joint->setStiffness(0, stiffness, false);
            joint->setEquilibriumPoint(0, btScalar(-0.1));
            return joint;
        };
    };
    EXPECT_NEAR(blockAfterOneHit(spring(0)), 0.3 - kHit, 2e-5);
    // 10 N for a step, from 0.1 m.
    EXPECT_NEAR(blockAfterOneHit(spring(100)), 0.3 - 10.0 / 60.0 - kHit, 1e-3);
}

TEST(ImpactOfAnIsland, DoesNotLetSoftContactsPushOnceMore)
{
    // A block sinks into its floor until springs of 5,000 N/m carry it, and is hit from the side.
    Scene scene(Kind::World);
    btRigidBody* floor = addFloor(scene, 0, 0);
    floor->setContactStiffnessAndDamping(5000, 100);
    btRigidBody* block = scene.body(scene.box(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0, 0.1)));
    block->setFriction(0);
    block->setActivationState(DISABLE_DEACTIVATION);
    for (int i = 0; i < 480; ++i)
    {
        scene.step(kTimeStep);
    }
    ASSERT_LT(double(block->getWorldTransform().getOrigin().z()), 0.1 - 1e-4);
    const btVector3 center = block->getWorldTransform().getOrigin();
    btCollisionShape* sphere = scene.keep(std::make_unique<btSphereShape>(btScalar(0.02)));
    btRigidBody* ball = scene.body(sphere, 1e-3, poseAt(center - vec(0.2, 0, 0)));
    ball->setLinearVelocity(vec(60, 0, 0));
    scene.step(kTimeStep);
    EXPECT_EQ(scene.counters().m_impacts, 1);
    EXPECT_GT(double(block->getLinearVelocity().x()), 0.05);
    // Another push would be one of gravity over a step, 0.04 m/s.
    EXPECT_NEAR(double(block->getLinearVelocity().z()), 0.0, 2e-3);
}

TEST(ImpactOfAnIsland, ReachesWhatTouchesCompoundsWithoutTrees)
{
    Scene scene(Kind::World);
    addFloor(scene, 0, 0);
    std::vector<btRigidBody*> blocks;
    for (const double z : {0.1, 0.3})
    {
        auto compound = std::make_unique<btCompoundShape>(false);
        compound->addChildShape(btTransform::getIdentity(), scene.box(vec(0.1, 0.1, 0.1)));
        blocks.push_back(scene.body(scene.keep(std::move(compound)), 1.0, poseAt(vec(0, 0, z))));
    }
    for (int i = 0; i < 10; ++i)
    {
        scene.step(kTimeStep);
    }
    btBroadphasePair* pair = scene.world().getPairCache()->findPair(
        blocks[0]->getBroadphaseHandle(), blocks[1]->getBroadphaseHandle());
    ASSERT_NE(pair, nullptr);
    ASSERT_NE(pair->m_algorithm, nullptr);
    btManifoldArray manifolds;
    pair->m_algorithm->getAllContactManifolds(manifolds);
    ASSERT_EQ(manifolds.size(), 1);
    EXPECT_GE(manifolds[0]->getNumContacts(), 3);
}

INSTANTIATE_TEST_SUITE_P(Ours,
                         ResponseOf,
                         testing::ValuesIn(kOurKinds),
                         [](const testing::TestParamInfo<Kind>& test)
                         { return std::string(codeOf(test.param)); });
}  // namespace bullet_ccd::tests
