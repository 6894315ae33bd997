#include "benchmarks/reference/bullet/programs.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <tuple>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
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

using ProgramRun = std::tuple<ProgramEntry, Kind>;

std::string nameOfRun(const testing::TestParamInfo<ProgramRun>& run)
{
    const auto& [entry, kind] = run.param;
    return std::string(entry.name) + "_" + codeOf(kind);
}

class EveryProgram : public testing::TestWithParam<ProgramRun>
{
};

TEST_P(EveryProgram, IsBitwiseAsInTheStockWorldUntilTheFirstTimeOfImpact)
{
    const auto& [entry, kind] = GetParam();
    const Trace stock = runProgram(entry, Kind::Stock);
    const Trace ours = runProgram(entry, kind);
    const int differs = firstDifference(stock, ours);
    std::printf("%s, %s: first time of impact in step %d, first difference in step %d of %d\n",
                entry.name,
                nameOf(kind),
                ours.firstEvent,
                differs,
                entry.steps);
    if (entry.calm)
    {
        EXPECT_EQ(ours.firstEvent, -1);
    }
    if (ours.firstEvent < 0)
    {
        EXPECT_EQ(differs, -1);
    }
    else
    {
        EXPECT_TRUE(differs == -1 || differs >= ours.firstEvent);
    }
    // Something does move.
    EXPECT_NE(stock.states.front(), stock.states.back());
}

INSTANTIATE_TEST_SUITE_P(Transparency,
                         EveryProgram,
                         testing::Combine(testing::ValuesIn(programs()),
                                          testing::ValuesIn(kOurKinds)),
                         nameOfRun);

TEST(Transparency, BoxComesToRestOnTheFloorAsInTheStockWorld)
{
    double lost = 0.0;
    const double stock = restHeight(Kind::Stock, plane, false, nullptr);
    EXPECT_NEAR(restHeight(Kind::World, plane, false, &lost), stock, 1e-3);
    // One impact, then the solver has it: the box does not freeze in the air.
    EXPECT_LT(lost, 0.05);
}

/// Queries while two spheres fly side by side at these speeds, a tenth of a millimetre apart, for
/// 10 steps.
std::int64_t queriesOfFlight(Kind kind, double speedA, double speedB)
{
    Scene scene(kind);
    btCollisionShape* shape = scene.keep(std::make_unique<btSphereShape>(btScalar(0.01)));
    scene.body(shape, 1.0, poseAt(vec(0, 0, 0)))->setLinearVelocity(vec(0, speedA, 0));
    scene.body(shape, 1.0, poseAt(vec(0.0201, 0, 0)))->setLinearVelocity(vec(0, speedB, 0));
    for (int i = 0; i < 10; ++i)
    {
        scene.step(1.0 / 240.0);
    }
    return scene.counters().m_queries;
}

TEST(Transparency, OnlyRelativeMotionIsWorthAQuery)
{
    for (const Kind kind : kOurKinds)
    {
        EXPECT_EQ(queriesOfFlight(kind, 50.0, 50.0), 0);
        EXPECT_GT(queriesOfFlight(kind, 50.0, 40.0), 0);
        EXPECT_GT(queriesOfFlight(kind, 50.0, 0.0), 0);
    }
}

/// Balls that hit a plate one after the other, in the middle of steps, and a box that turns far
/// from them: it goes all of its way at once.
TEST(Transparency, OfWhatNoImpactConcernsIsBitwise)
{
    const auto posesOfBox = [](Kind kind, std::int64_t& impacts)
    {
        Scene scene(kind, WorldClass::Rigid);
        scene.world().setGravity(vec(0, 0, -9.81));
        scene.body(scene.box(vec(5, 5, 0.01)), 0.0, btTransform::getIdentity());
        for (int i = 0; i < 5; ++i)
        {
            btCollisionShape* ball = scene.keep(std::make_unique<btSphereShape>(btScalar(0.1)));
            scene.body(ball, 1.0, poseAt(vec(i, 0, 1 + 0.3 * i)))
                ->setLinearVelocity(vec(0, 0, -60));
        }
        btRigidBody* box = scene.body(scene.box(vec(0.1, 0.2, 0.3)), 1.0, poseAt(vec(90, 0, 9)));
        box->setLinearVelocity(vec(3, 20, 5));
        box->setAngularVelocity(vec(2, 7, 1));
        std::vector<btTransform> poses;
        for (int step = 0; step < 20; ++step)
        {
            scene.step(1.0 / 60.0);
            poses.push_back(box->getWorldTransform());
        }
        impacts = scene.counters().m_impacts;
        return poses;
    };
    std::int64_t impacts = 0;
    const std::vector<btTransform> stock = posesOfBox(Kind::Stock, impacts);
    const std::vector<btTransform> ours = posesOfBox(Kind::World, impacts);
    EXPECT_GE(impacts, 5);
    for (std::size_t step = 0; step < stock.size(); ++step)
    {
        EXPECT_TRUE(ours[step] == stock[step]) << step;
    }
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
