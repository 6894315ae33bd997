#include "benchmarks/reference/audit/world_audit.h"

#include "bullet_ccd/examples/example_support.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>

#include <cmath>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;
using examples::Engine;
using examples::meshShape;
using examples::poseAt;
using examples::World;

const Vector3d kHalfPlate(0.001, 0.5, 0.5);
const Vector3d kHalfBullet(0.005, 0.005, 0.005);
constexpr double kStep = 1.0 / 60.0;

/// A small block beside a plate that it crosses within one step.
struct Shot
{
    World world;
    WorldAudit audit;
    btRigidBody* block;

    Shot(Engine engine, int mostSamples)
        : world(engine), audit(*world, {.longestMove = 1e-3, .mostSamples = mostSamples})
    {
        world->setGravity(btVector3(0, 0, 0));
        audit.add(world.add(meshShape(makeBox(kHalfPlate)), 0.0),
                  std::make_shared<const AuditMesh>(makeBox(kHalfPlate)));
        block = world.add(meshShape(makeBox(kHalfBullet)), 0.1, poseAt(-0.1, 0.0, 0.0));
        block->setLinearVelocity(btVector3(btScalar(0.2 / kStep), 0, 0));
        audit.add(block, std::make_shared<const AuditMesh>(makeBox(kHalfBullet)));
    }
};

TEST(WorldAudit, SeesWhatGoesThroughBetweenTwoSteps)
{
    Shot shot(Engine::Bullet, 1000);
    EXPECT_TRUE(shot.audit.start().clean());
    const AuditResult result = shot.audit.step(kStep);
    EXPECT_NEAR(double(shot.block->getWorldTransform().getOrigin().x()), 0.1, 1e-9);
    // It is in the plate for 12 mm of the way, 0.2 m, that was sampled every millimetre.
    EXPECT_EQ(result.poses, 200);
    EXPECT_NEAR(double(result.intersecting), 12.0, 1.0);
    EXPECT_NEAR(result.time, 0.5 * kStep, 0.1 * kStep);
    EXPECT_EQ(result.bodyA, 0);
    EXPECT_EQ(result.bodyB, 1);
}

TEST(WorldAudit, KnotsAloneWouldNotSeeIt)
{
    Shot shot(Engine::Bullet, 1);
    EXPECT_TRUE(shot.audit.start().clean());
    EXPECT_TRUE(shot.audit.step(kStep).clean());
}

TEST(WorldAudit, NotesThePosesOfImpacts)
{
    Shot shot(Engine::Ccd, 1);
    shot.world.ccd().setCcdImpactListener(&shot.audit);
    EXPECT_TRUE(shot.audit.start().clean());
    const AuditResult result = shot.audit.step(kStep);
    EXPECT_GE(result.poses, 2);
    EXPECT_TRUE(result.clean());
    EXPECT_LT(double(shot.block->getWorldTransform().getOrigin().x()), 0.0);
    const WorldAudit::Busiest busiest = shot.audit.busiestPair();
    EXPECT_EQ(std::minmax(busiest.bodyA, busiest.bodyB), std::minmax(0, 1));
    EXPECT_GE(busiest.impacts, 1);
}

TEST(WorldAudit, LinksAreWhereTheirJointsCarryThem)
{
    // A rod on a hinge at the origin turns from below a peg to above it: the straight way from its
    // first pose to its last would miss the peg, which stands near the end of the arc.
    World world(Engine::Bullet);
    world->setGravity(btVector3(0, 0, 0));
    WorldAudit audit(*world, {.longestMove = 1e-3, .mostSamples = 1000});
    btMultiBody body(1, 0, btVector3(0, 0, 0), true, false);
    body.setupRevolute(0,
                       btScalar(0.01),
                       btVector3(1, 1, 1),
                       -1,
                       btQuaternion::getIdentity(),
                       btVector3(0, 0, 1),
                       btVector3(0, 0, 0),
                       btVector3(btScalar(0.1), 0, 0));
    body.finalizeMultiDof();
    body.setAngularDamping(0);
    body.setJointPos(0, btScalar(-0.75));
    body.setJointVel(0, btScalar(1.5 / kStep));
    btMultiBodyLinkCollider collider(&body, 0);
    const Vector3d half(0.1, 0.002, 0.002);
    const auto shape = meshShape(makeBox(half));
    collider.setCollisionShape(shape.get());
    body.getLink(0).m_collider = &collider;
    world->addMultiBody(&body);
    world->addCollisionObject(
        &collider, btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body.forwardKinematics(rotations, origins);
    body.updateCollisionObjectWorldTransforms(rotations, origins);

    audit.add(&collider, std::make_shared<const AuditMesh>(makeBox(half)));
    audit.addMultiBody(&body);
    const Vector3d peg(0.002, 0.002, 0.01);
    audit.add(world.add(meshShape(makeBox(peg)), 0.0, poseAt(0.195, 0.0, 0.0)),
              std::make_shared<const AuditMesh>(makeBox(peg)));
    EXPECT_TRUE(audit.start().clean());
    const AuditResult result = audit.step(kStep);
    EXPECT_NEAR(double(body.getJointPos(0)), 0.75, 1e-6);
    EXPECT_GT(result.intersecting, 0);
    EXPECT_NEAR(result.time, 0.5 * kStep, 0.1 * kStep);
    // The audit puts the joint back to where the step left it.
    EXPECT_NEAR(double(collider.getWorldTransform().getOrigin().y()),
                0.1 * std::sin(double(body.getJointPos(0))),
                1e-9);
    world->removeCollisionObject(&collider);
    world->removeMultiBody(&body);
}
}  // namespace
}  // namespace bullet_ccd::tests
