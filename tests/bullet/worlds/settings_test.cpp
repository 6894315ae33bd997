#include "benchmarks/reference/bullet/scene.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// What the exception says that `action` throws.
std::string refusalOf(const std::function<void()>& action)
{
    try
    {
        action();
    }
    catch (const std::invalid_argument& error)
    {
        return error.what();
    }
    return "";
}

class Settings : public testing::TestWithParam<Kind>
{
};

/// A rod that lies over a plate: it falls at the plate (`falls`), or turns into it about its
/// middle.
double lowestAfter(Kind kind, btCcdMode mode, bool falls)
{
    Scene scene(kind);
    scene.body(scene.boxMesh(vec(1, 1, 0.005)), 0.0, poseAt(vec(1.2, 0, 0)));
    btRigidBody* rod = scene.body(scene.boxMesh(vec(1, 0.01, 0.01)), 1.0, poseAt(vec(0, 0, 0.1)));
    scene.ccd().setCcdSettings(rod, {.m_mode = mode});
    rod->setLinearVelocity(vec(0, 0, falls ? -100 : 0));
    rod->setAngularVelocity(vec(0, falls ? 0 : 60, 0));
    scene.step(0.01);
    // Of the end over the plate.
    const double low = double((rod->getWorldTransform() * vec(1, 0, 0)).z());
    scene.ccd().resetCcdSettings(rod);
    return low;
}
}  // namespace

TEST_P(Settings, AreReadAsTheyWereSet)
{
    Scene scene(GetParam());
    btRigidBody* body = scene.body(scene.box(vec(1, 1, 1)), 1.0, poseAt(vec(0, 0, 0)));
    btCcdControl& ccd = scene.ccd();
    EXPECT_EQ(ccd.getCcdSettings().m_tolerance, btCcdSettings{}.m_tolerance);
    EXPECT_EQ(ccd.getCcdSettings(body), btCcdObjectSettings{});
    btCcdSettings settings;
    settings.m_tolerance = 1e-3;
    settings.m_budget.m_impactsPerBody = 7;
    settings.m_objects.m_mode = btCcdMode::TranslationOnly;
    settings.m_drawLevel = 3;
    ccd.setCcdSettings(settings);
    // The setters of single ones show the same, and change nothing else.
    EXPECT_EQ(ccd.getCcdTolerance(), 1e-3);
    EXPECT_EQ(ccd.getCcdBudget().m_impactsPerBody, 7);
    ccd.setCcdTolerance(2e-3);
    ccd.setCcdDrawLevel(1);
    ccd.setCcdBudget({.m_impactsPerBody = 8});
    EXPECT_EQ(ccd.getCcdSettings().m_tolerance, 2e-3);
    EXPECT_EQ(ccd.getCcdSettings().m_budget.m_impactsPerBody, 8);
    EXPECT_EQ(ccd.getCcdSettings().m_drawLevel, 1);
    EXPECT_EQ(ccd.getCcdSettings(body).m_mode, btCcdMode::TranslationOnly);

    ccd.setCcdSettings(body, {.m_tolerance = 1e-4, .m_priority = 2.0});
    ccd.setCcdEnabled(body, false);
    EXPECT_FALSE(ccd.isCcdEnabled(body));
    EXPECT_EQ(ccd.getCcdSettings(body).m_priority, 2.0);
    ccd.setCcdEnabled(body, true);
    EXPECT_EQ(ccd.getCcdSettings(body).m_mode, btCcdMode::TranslationOnly);
    EXPECT_EQ(ccd.getCcdSettings(body).m_tolerance, 1e-4);
    ccd.resetCcdSettings(body);
    EXPECT_EQ(ccd.getCcdSettings(body), settings.m_objects);
}

TEST_P(Settings, ThatAreOutOfRangeAreRefusedByNameAndChangeNothing)
{
    Scene scene(GetParam());
    btCcdControl& ccd = scene.ccd();
    const btRigidBody* body = scene.body(scene.box(vec(1, 1, 1)), 1.0, poseAt(vec(0, 0, 0)));
    const auto expectRefused =
        [&](const char* name, const std::function<void(btCcdSettings&)>& change)
    {
        btCcdSettings settings;
        settings.m_drawLevel = 5;
        change(settings);
        const std::string said = refusalOf([&] { ccd.setCcdSettings(settings); });
        EXPECT_NE(said.find(name), std::string::npos) << name << ": " << said;
        EXPECT_EQ(ccd.getCcdSettings().m_drawLevel, 0) << name;
    };
    for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    {
        expectRefused("m_tolerance", [&](btCcdSettings& s) { s.m_tolerance = bad; });
    }
    expectRefused("m_impactsPerStep", [](btCcdSettings& s) { s.m_budget.m_impactsPerStep = -3; });
    expectRefused("m_seconds is nan",
                  [](btCcdSettings& s) { s.m_budget.m_seconds = std::nan(""); });
    expectRefused("m_priority is -1", [](btCcdSettings& s) { s.m_objects.m_priority = -1; });
    expectRefused("m_drawLevel is -2", [](btCcdSettings& s) { s.m_drawLevel = -2; });
    expectRefused("m_mode is 7", [](btCcdSettings& s) { s.m_objects.m_mode = btCcdMode(7); });
    EXPECT_NE(refusalOf([&] { ccd.setCcdSettings(body, {.m_tolerance = 0.0}); })
                  .find("m_tolerance of an object is 0"),
              std::string::npos);
    EXPECT_EQ(ccd.getCcdSettings(body), btCcdObjectSettings{});
}

TEST_P(Settings, SayWhatIsSweptOfAMotion)
{
    // Falling ends on the plate in both modes; turning is seen in one only.
    for (const bool falls : {true, false})
    {
        EXPECT_LT(lowestAfter(GetParam(), btCcdMode::Off, falls), -0.1) << falls;
        EXPECT_GT(lowestAfter(GetParam(), btCcdMode::Full, falls), 0.0) << falls;
    }
    EXPECT_GT(lowestAfter(GetParam(), btCcdMode::TranslationOnly, true), 0.0);
    EXPECT_LT(lowestAfter(GetParam(), btCcdMode::TranslationOnly, false), -0.1);
}

TEST_P(Settings, TakeWhatDoesNotTurnAsItIsWhenTheStepBegins)
{
    // The rod turns about the vertical, and away from the plate before it is down there.
    for (const btCcdMode mode : {btCcdMode::TranslationOnly, btCcdMode::Full})
    {
        Scene scene(GetParam());
        scene.body(scene.boxMesh(vec(1, 1, 0.005)), 0.0, poseAt(vec(1.9, 0, 0)));
        btRigidBody* rod =
            scene.body(scene.boxMesh(vec(1, 0.01, 0.01)), 1.0, poseAt(vec(0, 0, 0.9)));
        scene.ccd().setCcdSettings(rod, {.m_mode = mode});
        rod->setLinearVelocity(vec(0, 0, -100));
        rod->setAngularVelocity(vec(0, 0, 60));
        scene.step(0.01);
        EXPECT_EQ(scene.counters().m_impacts > 0, mode == btCcdMode::TranslationOnly);
        scene.ccd().resetCcdSettings(rod);
    }
}

TEST_P(Settings, SayWhatIsSweptOfAKinematicMotion)
{
    // A rod is turned through a ball, or put beyond it.
    for (const bool turns : {true, false})
    {
        for (const btCcdMode mode : {btCcdMode::TranslationOnly, btCcdMode::Full})
        {
            Scene scene(GetParam(), WorldClass::Rigid);
            btRigidBody* rod = scene.body(scene.box(vec(1, 0.01, 0.01)), 0.0, poseAt(vec(0, 0, 0)));
            rod->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
            rod->setActivationState(DISABLE_DEACTIVATION);
            const btRigidBody* ball =
                scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.05))),
                           1.0,
                           poseAt(vec(0.8, 0, -0.2)));
            scene.ccd().setCcdSettings(rod, {.m_mode = mode});
            scene.step(0.01);
            btTransform pose = poseAt(vec(0, 0, turns ? 0 : -0.5));
            pose.setRotation(btQuaternion(vec(0, 1, 0), btScalar(turns ? 0.6 : 0)));
            rod->setWorldTransform(pose);
            scene.step(0.01);
            const bool isSeen = mode == btCcdMode::Full || !turns;
            EXPECT_EQ(scene.counters().m_impacts > 0, isSeen) << turns;
            EXPECT_EQ(double(ball->getWorldTransform().getOrigin().z()) < -0.25, isSeen) << turns;
            scene.ccd().resetCcdSettings(rod);
        }
    }
}

TEST_P(Settings, MayCoverNothingButWhatIsNamed)
{
    Scene scene(GetParam());
    btRigidBody* plate = scene.body(scene.boxMesh(vec(2, 1, 0.001)), 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* bodies[2];
    for (int i = 0; i < 2; ++i)
    {
        bodies[i] = scene.body(scene.box(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(i, 0, 1)));
        bodies[i]->setLinearVelocity(vec(0, 0, -300));
    }
    btCcdSettings settings;
    settings.m_objects.m_mode = btCcdMode::Off;
    scene.ccd().setCcdSettings(settings);
    scene.ccd().setCcdEnabled(plate, true);
    scene.ccd().setCcdEnabled(bodies[1], true);
    scene.step(0.01);
    EXPECT_LT(double(bodies[0]->getWorldTransform().getOrigin().z()), -1.5);
    EXPECT_GT(double(bodies[1]->getWorldTransform().getOrigin().z()), 0.0);
}

TEST_P(Settings, TakeTheFinestToleranceOfAPair)
{
    // Where a ball is stopped above a box says which tolerance held.
    const auto gapWith = [&](double ofWorld, double ofBall, double ofBox)
    {
        Scene scene(GetParam());
        btRigidBody* floor = scene.body(scene.box(vec(1, 1, 0.1)), 0.0, poseAt(vec(0, 0, -0.1)));
        btRigidBody* ball = scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.1))),
                                       1.0,
                                       poseAt(vec(0, 0, 0.5)));
        ball->setLinearVelocity(vec(0, 0, -100));
        scene.ccd().setCcdTolerance(ofWorld);
        scene.ccd().setCcdSettings(ball, {.m_tolerance = ofBall});
        scene.ccd().setCcdSettings(floor, {.m_tolerance = ofBox});
        struct Hold : btCcdImpactListener
        {
            btCcdAfterImpact onImpact(const btCcdImpact&) override
            {
                return btCcdAfterImpact::Hold;
            }
        } hold;
        scene.ccd().setCcdImpactListener(&hold);
        scene.step(0.01);
        return double(ball->getWorldTransform().getOrigin().z()) - 0.1;
    };
    const double none = std::numeric_limits<double>::infinity();
    // Half of the tolerance is left as gap.
    EXPECT_NEAR(gapWith(1e-2, none, none), 5e-3, 1e-3);
    EXPECT_NEAR(gapWith(1e-2, 1e-3, none), 5e-4, 1e-4);
    EXPECT_NEAR(gapWith(1e-2, 1e-3, 4e-4), 2e-4, 4e-5);
    EXPECT_NEAR(gapWith(1e-3, 1.0, none), 5e-4, 1e-4) << "an object may only be finer";
}

TEST(Priority, DecidesWhoIsAnsweredWhenTheBudgetIsUsedUp)
{
    // Three balls between two plates, 20 mm apart, at 100 m/s.
    Scene scene(Kind::World, WorldClass::Rigid);
    scene.ccd().setCcdBudget({.m_impactsPerBody = 2, .m_impactsPerStep = 1000});
    for (const double z : {-0.02, 0.02})
    {
        scene.body(scene.box(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, z)))->setRestitution(1);
    }
    btRigidBody* balls[3];
    const double priorities[] = {0.0, 1.0, 100.0};
    for (int i = 0; i < 3; ++i)
    {
        balls[i] = scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.005))),
                              0.1,
                              poseAt(vec(0.1 * i, 0, 0)));
        balls[i]->setRestitution(1);
        balls[i]->setFriction(0);
        balls[i]->setLinearVelocity(vec(1, 0, 100));
        scene.ccd().setCcdSettings(balls[i], {.m_priority = priorities[i]});
    }
    struct Count : btCcdImpactListener
    {
        std::map<const btCollisionObject*, int> m_impacts;
        std::map<const btCollisionObject*, int> m_yields;
        btCcdAfterImpact onImpact(const btCcdImpact& impact) override
        {
            ++m_impacts[impact.m_objectA];
            ++m_impacts[impact.m_objectB];
            return btCcdAfterImpact::Solve;
        }
        void onYield(const btCollisionObject& object, btCcdYield, const btCcdImpact&) override
        {
            ++m_yields[&object];
        }
    } count;
    scene.ccd().setCcdImpactListener(&count);
    scene.step(0.005);
    EXPECT_GE(count.m_yields[balls[0]], 1) << "it gives way at once";
    EXPECT_NEAR(double(balls[0]->getLinearVelocity().z()), 0.0, 1e-3);
    EXPECT_EQ(count.m_impacts[balls[1]], 3);
    EXPECT_GE(count.m_yields[balls[1]], 1);
    EXPECT_EQ(count.m_yields[balls[2]], 0) << "its impacts are answered";
    EXPECT_GT(count.m_impacts[balls[2]], 3);
}

TEST_P(Settings, AnAccuracyHoldsAtImpactsAndIsNeverBelowMarginsAndRounding)
{
    Scene scene(GetParam());
    btRigidBody* plate = scene.body(scene.boxMesh(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* cube = scene.body(scene.boxMesh(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0, 0.4)));
    btRigidBody* ball = scene.body(
        scene.keep(std::make_unique<btSphereShape>(btScalar(0.1))), 1.0, poseAt(vec(0.5, 0, 0.4)));
    btCcdControl& ccd = scene.ccd();
    const double margins =
        double(plate->getCollisionShape()->getMargin() + cube->getCollisionShape()->getMargin());
    const double smallest = ccd.smallestCcdAccuracy();
    EXPECT_GE(smallest, margins);
    EXPECT_LE(smallest, 2.0 * margins);
    const double before = ccd.getCcdTolerance();
    for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL, 0.99 * smallest})
    {
        const std::string said = refusalOf([&] { ccd.setCcdAccuracy(bad); });
        std::ostringstream named;
        named << "the smallest in this world is " << smallest;
        EXPECT_NE(said.find(named.str()), std::string::npos) << said;
        EXPECT_EQ(ccd.getCcdTolerance(), before);
    }
    const double accuracy = 5e-3;
    ccd.setCcdAccuracy(accuracy);
    EXPECT_EQ(ccd.getCcdTolerance(), accuracy);
    cube->setLinearVelocity(vec(0, 0, -60));
    ball->setLinearVelocity(vec(0, 0, -60));
    scene.step(0.01);
    for (btRigidBody* body : {cube, ball})
    {
        const btCcdImpact* impact = ccd.findCcdImpact(body, plate);
        ASSERT_NE(impact, nullptr);
        const double gap = double(impact->m_pointA.distance(impact->m_pointB));
        EXPECT_GT(gap, 0.0);
        EXPECT_LE(gap, accuracy * 1.001);
    }
    // What is far away has coarse coordinates, and a plane without end has none.
    scene.body(scene.keep(std::make_unique<btStaticPlaneShape>(vec(0, 0, 1), btScalar(-5))),
               0.0,
               poseAt(vec(0, 0, 0)));
    EXPECT_EQ(ccd.smallestCcdAccuracy(), smallest);
    scene.body(scene.box(vec(1, 1, 1)), 0.0, poseAt(vec(0, 999, 0)));
    EXPECT_NEAR(ccd.smallestCcdAccuracy() / (1e6 * double(SIMD_EPSILON)),
                kDouble ? smallest / (1e6 * double(SIMD_EPSILON)) : 1.0,
                1e-3);
}

TEST_P(Settings, AnAccuracyStopsMeshesAtAnyGapOfTheirMargins)
{
    int within = 0;
    for (const bool isAccuracy : {false, true})
    {
        for (int k = 0; k < 20; ++k)
        {
            Scene scene(GetParam());
            btRigidBody* plate =
                scene.body(scene.boxMesh(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, 0)));
            btRigidBody* cube =
                scene.body(scene.boxMesh(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0, 0.4)));
            const double margins = double(plate->getCollisionShape()->getMargin() +
                                          cube->getCollisionShape()->getMargin());
            if (isAccuracy)
            {
                scene.ccd().setCcdAccuracy(1.001 * scene.ccd().smallestCcdAccuracy());
            }
            cube->setLinearVelocity(vec(0.3 * k, 0, -40 - k));
            cube->setAngularVelocity(vec(k, 0.5 * k, 0));
            scene.step(0.01);
            const btCcdImpact* impact = scene.ccd().findCcdImpact(cube, plate);
            ASSERT_NE(impact, nullptr);
            const double gap = double(impact->m_pointA.distance(impact->m_pointB)) / margins;
            EXPECT_GT(gap, isAccuracy ? 0.375 : 0.999);
            EXPECT_LT(gap, 1.063);
            within += isAccuracy && gap < 0.95 ? 1 : 0;
        }
    }
    EXPECT_GT(within, 5);
}

TEST_P(Settings, AnAccuracyLetsContactsFollowWhatRestsAndSlides)
{
    Scene scene(GetParam());
    scene.body(scene.boxMesh(vec(0.5, 0.5, 0.01)), 0.0, poseAt(vec(0, 0, -0.01)));
    btRigidBody* cube =
        scene.body(scene.boxMesh(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0, 0.102)));
    cube->setActivationState(DISABLE_DEACTIVATION);
    scene.world().setGravity(vec(0, 0, -10));
    scene.ccd().setCcdAccuracy(2.0 * scene.ccd().smallestCcdAccuracy());
    const auto after = [&](double seconds)
    {
        for (int i = 0; i < int(240.0 * seconds); ++i)
        {
            scene.step(1.0 / 240.0);
        }
        return cube->getWorldTransform().getOrigin();
    };
    const btVector3 rests = after(1.0);
    EXPECT_NEAR(double(rests.z()), 0.101, 1e-4);
    EXPECT_LT(double(after(1.0).distance(rests)), 1e-5);
    cube->setFriction(0);
    cube->setLinearVelocity(vec(0.4, 0, 0));
    const btVector3 slid = after(1.0);
    EXPECT_NEAR(double(slid.x()), 0.4, 0.01);
    EXPECT_NEAR(double(slid.z()), double(rests.z()), 1e-4);
    EXPECT_LT(double(after(1.0).z()), -1.0) << "over the edge";
}

INSTANTIATE_TEST_SUITE_P(Ours,
                         Settings,
                         testing::ValuesIn(kOurKinds),
                         [](const auto& test) { return std::string(codeOf(test.param)); });
}  // namespace bullet_ccd::tests
