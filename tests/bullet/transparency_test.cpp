#include "tests/bullet/scene.h"

#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <gtest/gtest.h>

#include <vector>

namespace bullet_ccd::tests
{
namespace
{
/// Where everything is, bit for bit, after each step of a scene without impacts.
std::vector<btScalar> flight(Kind kind)
{
    Scene scene(kind);
    scene.world().setGravity(vec(0, -9.81, 0));
    btCollisionShape* link = scene.box(vec(0.02, 0.002, 0.004));
    btMultiBody* chain = scene.chain({link, link, link}, 0.02, btTransform::getIdentity());
    btRigidBody* stone =
        scene.body(scene.box(vec(0.01, 0.02, 0.03)), 0.2, poseAt(vec(1, 0, 0), 0.3));
    stone->setLinearVelocity(vec(0.1, 3, -0.2));
    stone->setAngularVelocity(vec(5, -3, 8));
    std::vector<btScalar> trace;
    for (int i = 0; i < 100; ++i)
    {
        scene.step(1.0 / 240.0);
        for (int joint = 0; joint < 3; ++joint)
        {
            trace.push_back(chain->getJointPos(joint));
            trace.push_back(chain->getJointVel(joint));
        }
        for (int k = 0; k < 3; ++k)
        {
            trace.push_back(stone->getWorldTransform().getOrigin()[k]);
            trace.push_back(stone->getWorldTransform().getBasis()[k][k]);
            trace.push_back(stone->getAngularVelocity()[k]);
        }
    }
    return trace;
}

/// Height at which a box of 2 cm comes to rest.
double restHeight(Kind kind, btCollisionShape* (*floorShape)(Scene&), bool mesh, double* lostTime)
{
    Scene scene(kind);
    scene.world().setGravity(vec(0, 0, -9.81));
    scene.body(floorShape(scene), 0.0, btTransform::getIdentity());
    const btVector3 half = vec(0.01, 0.01, 0.01);
    btCollisionShape* shape = mesh ? static_cast<btCollisionShape*>(scene.boxMesh(half))
                                   : static_cast<btCollisionShape*>(scene.box(half));
    btRigidBody* box = scene.body(shape, 0.1, poseAt(vec(0, 0, 0.1)));
    for (int i = 0; i < 480; ++i)
    {
        scene.step(1.0 / 240.0);
    }
    if (lostTime != nullptr)
    {
        *lostTime = scene.ccd().getCcdCounters().m_lostTime;
    }
    EXPECT_LT(double(box->getLinearVelocity().length()), 0.01);
    return double(box->getWorldTransform().getOrigin().z());
}

btCollisionShape* plane(Scene& scene)
{
    return scene.keep(std::make_unique<btStaticPlaneShape>(vec(0, 0, 1), btScalar(0)));
}
}  // namespace

TEST(Transparency, WithoutImpactsEveryBitIsAsInTheStockWorld)
{
    EXPECT_EQ(flight(Kind::Stock), flight(Kind::World));
}

TEST(Transparency, BoxComesToRestOnTheFloorAsInTheStockWorld)
{
    double lost = 0.0;
    const double stock = restHeight(Kind::Stock, plane, false, nullptr);
    EXPECT_NEAR(restHeight(Kind::World, plane, false, &lost), stock, 1e-3);
    // One impact, then the solver has it: the box does not freeze in the air.
    EXPECT_LT(lost, 0.05);
}

TEST(Transparency, MeshRestsAtItsMarginOutOfReachOfTheTimeOfImpact)
{
    double lost = 0.0;
    const double height = restHeight(
        Kind::World,
        [](Scene& scene) -> btCollisionShape* { return scene.box(vec(0.5, 0.5, 0.01)); },
        true,
        &lost);
    EXPECT_GT(height, 0.02);
    EXPECT_LT(height, 0.02 + 2.0 * btCcdMeshShape::kDefaultMargin);
    EXPECT_LT(lost, 0.05);
}
}  // namespace bullet_ccd::tests
