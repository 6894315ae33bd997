#include "benchmarks/reference/bullet/scene.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btMinkowskiSumShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <LinearMath/btQuickprof.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
int countOf(const std::string& text, const std::string& word)
{
    int count = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    {
        ++count;
    }
    return count;
}

/// Heights of two bodies of a kind that is not covered over 60 steps: on a box, and on a mesh.
std::vector<btVector3> fallOfUncovered(Kind kind)
{
    Scene scene(kind);
    scene.world().setGravity(vec(0, 0, -9.81));
    const btSphereShape* sphere = scene.keep(std::make_unique<btSphereShape>(btScalar(0.05)));
    btCollisionShape* sum = scene.keep(std::make_unique<btMinkowskiSumShape>(sphere, sphere));
    scene.body(scene.box(vec(0.5, 0.5, 0.1)), 0.0, poseAt(vec(0, 0, -0.1)));
    scene.body(scene.boxMesh(vec(0.5, 0.5, 0.1)), 0.0, poseAt(vec(2, 0, -0.1)));
    std::vector<btVector3> way;
    btRigidBody* bodies[] = {scene.body(sum, 1.0, poseAt(vec(0, 0, 0.15))),
                             scene.body(sum, 1.0, poseAt(vec(2, 0, 0.15)))};
    for (int i = 0; i < 60; ++i)
    {
        scene.step(1.0 / 240.0);
        for (const btRigidBody* body : bodies)
        {
            way.push_back(body->getWorldTransform().getOrigin());
        }
    }
    EXPECT_TRUE(!isOurs(kind) || scene.counters().m_unsupported == 2);
    return way;
}

/// The zones of ours that Bullet's profiler is told of, as long as this lives.
class Zones
{
public:
    Zones()
        : m_enter(btGetCurrentEnterProfileZoneFunc()), m_leave(btGetCurrentLeaveProfileZoneFunc())
    {
        s_open.clear();
        s_seen.clear();
        btSetCustomEnterProfileZoneFunc(
            [](const char* name)
            {
                s_open.emplace_back(name);
                if (s_open.back().starts_with("btCcd"))
                {
                    s_seen.insert(s_open.back());
                }
            });
        btSetCustomLeaveProfileZoneFunc([] { s_open.pop_back(); });
    }
    ~Zones()
    {
        btSetCustomEnterProfileZoneFunc(m_enter);
        btSetCustomLeaveProfileZoneFunc(m_leave);
    }
    Zones(const Zones&) = delete;
    Zones& operator=(const Zones&) = delete;

    static inline std::vector<std::string> s_open;
    static inline std::set<std::string> s_seen;

private:
    btEnterProfileZoneFunc* m_enter;
    btLeaveProfileZoneFunc* m_leave;
};

class Reports : public testing::TestWithParam<Kind>
{
};
}  // namespace

TEST_P(Reports, WhatIsNotCoveredBehavesAsInStockBulletAndIsNamedOnce)
{
    const std::vector<btVector3> stock = fallOfUncovered(Kind::Stock);
    EXPECT_LT(stock.back().z(), btScalar(0.12)) << "still in the air";
    EXPECT_GT(stock.back().z(), btScalar(0.08)) << "no contacts";
    testing::internal::CaptureStderr();
    const std::vector<btVector3> ours = fallOfUncovered(GetParam());
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_TRUE(stock == ours);
    EXPECT_EQ(countOf(said, "\n"), 1) << said;
    EXPECT_EQ(countOf(said, "MinkowskiSum"), 1) << said;
}

/// As a program does that takes poses from a scene graph.
TEST_P(Reports, AScaledPoseIsTakenAsARotationAndSaidOnce)
{
    for (const double scale : {0.25, 2.0})
    {
        testing::internal::CaptureStderr();
        double place = 0.0;
        {
            Scene scene(GetParam());
            scene.body(scene.box(vec(5, 5, 0.5)), 0.0, poseAt(vec(0, 0, -0.5)));
            btRigidBody* ball =
                scene.body(scene.mesh(makeSphere(0.2, 2)), 1.0, poseAt(vec(0, 0, 1)));
            ball->setLinearVelocity(vec(0, 0, -30));
            scene.step(1.0 / 60.0);
            for (int i = 0; i < 30; ++i)
            {
                if (i < 2)
                {
                    btTransform scaled = ball->getWorldTransform();
                    scaled.getBasis() = scaled.getBasis().scaled(vec(scale, scale, scale));
                    ball->setWorldTransform(scaled);
                }
                scene.step(1.0 / 60.0);
            }
            place = double(ball->getWorldTransform().getOrigin().z());
        }
        const std::string said = testing::internal::GetCapturedStderr();
        EXPECT_NEAR(place, 0.2, 0.01) << scale;
        // Before the action looks, Bullet has made a rotation of it.
        const int times = GetParam() == Kind::World ? 1 : 0;
        EXPECT_EQ(countOf(said, "\n"), times) << said;
        EXPECT_EQ(countOf(said, "setLocalScaling"), times) << said;
    }
}

TEST_P(Reports, SayNothingOfACompoundWithoutChildren)
{
    testing::internal::CaptureStderr();
    {
        Scene scene(GetParam());
        btCompoundShape* nothing = scene.keep(std::make_unique<btCompoundShape>());
        scene.body(nothing, 1.0, poseAt(vec(0, 0, 0)));
        scene.body(scene.box(vec(0.5, 0.5, 0.1)), 1.0, poseAt(vec(0, 0, 0)));
        scene.step(1.0 / 240.0);
        EXPECT_EQ(scene.counters().m_unsupported, 0);
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_P(Reports, AListenerMayLeaveAPairToBullet)
{
    struct Veto : btCcdImpactListener
    {
        const btCollisionObject* m_free = nullptr;

        btCcdAfterImpact onImpact(const btCcdImpact&) override { return btCcdAfterImpact::Solve; }
        bool isSwept(const btCollisionObject& a, const btCollisionObject& b) override
        {
            return &a != m_free && &b != m_free;
        }
    };
    Scene scene(GetParam());
    btRigidBody* plate = scene.body(scene.boxMesh(vec(1, 1, 0.001)), 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* bodies[2];
    for (int i = 0; i < 2; ++i)
    {
        bodies[i] =
            scene.body(scene.box(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(i - 0.5, 0, 0.061)));
        bodies[i]->setLinearVelocity(vec(0, 0, -100));
    }
    Veto veto;
    veto.m_free = bodies[1];
    scene.ccd().setCcdImpactListener(&veto);
    scene.step(0.01);
    EXPECT_GT(double(bodies[0]->getWorldTransform().getOrigin().z()), 0.01);
    EXPECT_LT(double(bodies[1]->getWorldTransform().getOrigin().z()), -0.5);

    const btCcdImpact* impact = scene.ccd().findCcdImpact(bodies[0], plate);
    ASSERT_NE(impact, nullptr);
    EXPECT_EQ(impact, scene.ccd().findCcdImpact(plate, bodies[0]));
    EXPECT_EQ(scene.ccd().findCcdImpact(plate, bodies[1]), nullptr);
    // 50 mm to go, 0.5 mm of which are the margin of the mesh.
    EXPECT_NEAR(double(impact->m_time), 0.0495 / 100.0, 1e-6);
    EXPECT_NEAR(std::abs(double(impact->m_normal.z())), 1.0, 1e-6);
    scene.step(0.01);
    EXPECT_EQ(scene.ccd().findCcdImpact(plate, bodies[1]), nullptr);
}

TEST_P(Reports, AskNothingOfWhatIsPressedButAtRest)
{
    Scene scene(GetParam());
    scene.world().getSolverInfo().m_linearSlop = btScalar(1e-3);  // nothing is pushed out
    // No plane lies between a floor with a wall and what stands on it.
    TriangleMesh yard = makeBox(Eigen::Vector3d(0.1, 0.1, 0.05));
    TriangleMesh wall = makeBox(Eigen::Vector3d(0.01, 0.1, 0.05));
    transformMesh(wall, Eigen::Affine3d(Eigen::Translation3d(0.08, 0.0, 0.1)));
    appendMesh(yard, wall);
    scene.body(scene.mesh(yard), 0.0, poseAt(vec(0, 0, 0)));
    // Two margins of 0.5 mm, of which 0.4 mm are used up, and 0.28 mm are left.
    btRigidBody* box = scene.body(
        scene.boxMesh(vec(0.02, 0.02, 0.02)), 0.1, poseAt(vec(0, 0, 0.07 + 1e-3 - 4e-4)));
    for (int i = 0; i < 10; ++i)
    {
        box->setLinearVelocity(vec(0.01, 0, 0));
        scene.step(0.01);
    }
    EXPECT_EQ(scene.counters().m_queries, 0);
    box->setLinearVelocity(vec(0, 0, -1));
    scene.step(0.01);
    EXPECT_GE(scene.counters().m_queries, 1);
    EXPECT_GT(double(box->getWorldTransform().getOrigin().z()), 0.07);
}

TEST_P(Reports, CountWhatTheyDidUntilTheyAreReset)
{
    Scene scene(GetParam());
    EXPECT_EQ(scene.counters().m_queries, 0);
    scene.body(scene.boxMesh(vec(0.1, 0.1, 0.001)), 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* box = scene.body(scene.box(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(0, 0, 0.061)));
    box->setLinearVelocity(vec(0, 0, -10));
    scene.step(0.01);
    const btCcdCounters counters = scene.counters();
    EXPECT_GE(counters.m_queries, 1);
    EXPECT_EQ(counters.m_impacts, 1);
    EXPECT_EQ(counters.m_eventLimits, 0);
    EXPECT_EQ(counters.m_iterationLimits, 0);
    EXPECT_EQ(counters.m_overlaps, 0);
    EXPECT_EQ(counters.m_unsupported, 0);
    if (GetParam() == Kind::World)
    {
        EXPECT_EQ(counters.m_subSteps, 1);
        EXPECT_EQ(counters.m_clamps, 0);
        EXPECT_EQ(counters.m_lostTime, 0.0);
    }
    else
    {
        // 50 mm to go, 0.5 mm of which are the margin of the mesh: 5 ms.
        EXPECT_EQ(counters.m_subSteps, 0);
        EXPECT_EQ(counters.m_clamps, 1);
        EXPECT_NEAR(counters.m_lostTime, 0.005, 2e-4);
    }
    EXPECT_EQ(scene.ccd().getCcdLostTime(box), counters.m_lostTime);

    scene.ccd().resetCcdCounters();
    EXPECT_EQ(scene.counters().m_queries, 0);
    EXPECT_EQ(scene.counters().m_impacts, 0);
    EXPECT_EQ(scene.counters().m_clamps, 0);
    EXPECT_EQ(scene.counters().m_lostTime, 0.0);
    EXPECT_EQ(scene.ccd().getCcdLostTime(box), 0.0);
}

TEST_P(Reports, TellBulletsProfilerWhatTheyDo)
{
    Scene scene(GetParam());
    scene.body(scene.boxMesh(vec(0.1, 0.1, 0.001)), 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* box = scene.body(scene.box(vec(0.01, 0.01, 0.01)), 0.1, poseAt(vec(0, 0, 0.061)));
    const Zones zones;
    scene.step(0.001);
    const std::set<std::string> quiet = Zones::s_seen;
    box->setLinearVelocity(vec(0, 0, -10));
    scene.step(0.01);
    EXPECT_TRUE(Zones::s_open.empty()) << Zones::s_open.back();
    const bool isWorld = GetParam() == Kind::World;
    // The world looks ahead, and the action back.
    const std::string looks = isWorld ? "btCcdStep::begin" : "btCcdStep::rollBack";
    EXPECT_EQ(quiet, std::set{looks});
    std::set<std::string> all{looks, "btCcdStepper::getReady", "btCcdStepper::next"};
    if (isWorld)
    {
        all.insert({"btCcdStep::respond", "btCcdImpactSolver::solve"});
    }
    all.insert("btCcdStepper::refresh");
    EXPECT_EQ(Zones::s_seen, all);
}

TEST_P(Reports, LoseTimeOnlyUntilSomethingElseComes)
{
    // A ball of 10 mm meets the wall 2 ms after the begin of the step and another one meets it
    // 4 ms later: from then on neither is held.
    Scene scene(GetParam(), WorldClass::Rigid);
    btCollisionShape* shape = scene.keep(std::make_unique<btSphereShape>(btScalar(0.01)));
    scene.body(scene.box(vec(0.1, 0.1, 0.001)), 0.0, poseAt(vec(0, 0, -0.001)));
    btRigidBody* first = scene.body(shape, 0.1, poseAt(vec(0, 0, 0.03)));
    btRigidBody* second = scene.body(shape, 0.1, poseAt(vec(0, 0, 0.09)));
    first->setLinearVelocity(vec(0, 0, -10));
    second->setLinearVelocity(vec(0, 0, -10));
    scene.step(0.01);
    EXPECT_GT(double(first->getWorldTransform().getOrigin().z()), 0.0099);
    EXPECT_GT(double(second->getWorldTransform().getOrigin().z()), 0.0299);
    EXPECT_NEAR(scene.ccd().getCcdLostTime(first), GetParam() == Kind::World ? 0.0 : 0.004, 1e-4);
    EXPECT_NEAR(scene.ccd().getCcdLostTime(second), 0.0, 1e-4);
}

TEST(WorldsOfOurs, SettleABodyThatMeetsItsLimitOfImpacts)
{
    // A ball that bounces between two plates, 20 mm apart, at 100 m/s: 50 times in a step.
    for (const int most : {1, 4})
    {
        Scene scene(Kind::World);
        scene.ccd().setCcdBudget({.m_impactsPerBody = most});
        btRigidBody* plates[] = {
            scene.body(scene.box(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, -0.02))),
            scene.body(scene.box(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, 0.02)))};
        btRigidBody* ball = scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.005))),
                                       0.1,
                                       poseAt(vec(0, 0, 0)));
        for (btRigidBody* body : {plates[0], plates[1], ball})
        {
            body->setRestitution(1);
            body->setFriction(0);
        }
        ball->setLinearVelocity(vec(0, 0, 100));
        scene.step(0.01);
        const btCcdCounters counters = scene.counters();
        EXPECT_EQ(counters.m_impacts, most + 1);
        EXPECT_EQ(counters.m_subSteps, most);
        EXPECT_EQ(counters.m_eventLimits, 1);
        // It has lost its approach, and need not be held.
        EXPECT_EQ(counters.m_clamps, 0);
        EXPECT_EQ(counters.m_lostTime, 0.0);
        // In single precision 100 m/s are rounded to 8e-6 m/s.
        EXPECT_NEAR(double(ball->getLinearVelocity().z()), 0.0, 1e-4);
        EXPECT_LE(std::abs(double(ball->getWorldTransform().getOrigin().z())), 0.005 + 1e-4);
    }
}

TEST(WorldsOfOurs, RefuseAToleranceThatIsNoLength)
{
    Scene scene(Kind::World);
    for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL})
    {
        EXPECT_THROW(scene.ccd().setCcdTolerance(bad), std::invalid_argument);
    }
    scene.ccd().setCcdTolerance(1e-3);
    EXPECT_EQ(scene.ccd().getCcdTolerance(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Ours,
                         Reports,
                         testing::ValuesIn(kOurKinds),
                         [](const testing::TestParamInfo<Kind>& test)
                         { return std::string(codeOf(test.param)); });
}  // namespace bullet_ccd::tests
