#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kTolerance = 2e-4;

/// A ghost that is in the world for as long as it lives.
class Ghost
{
public:
    Ghost(Scene& scene, btCollisionShape* shape, const btTransform& pose, int mask = -1)
        : m_scene(scene)
    {
        m_ghost.setCollisionShape(shape);
        m_ghost.setWorldTransform(pose);
        m_ghost.setCollisionFlags(m_ghost.getCollisionFlags() |
                                  btCollisionObject::CF_NO_CONTACT_RESPONSE);
        scene.world().addCollisionObject(&m_ghost, btBroadphaseProxy::SensorTrigger, mask);
    }
    ~Ghost() { m_scene.world().removeCollisionObject(&m_ghost); }
    Ghost(const Ghost&) = delete;
    Ghost& operator=(const Ghost&) = delete;
    btPairCachingGhostObject* operator->() { return &m_ghost; }
    btPairCachingGhostObject* get() { return &m_ghost; }

private:
    Scene& m_scene;
    btPairCachingGhostObject m_ghost;
};

btSphereShape* ball(Scene& scene, double radius)
{
    return scene.keep(std::make_unique<btSphereShape>(btScalar(radius)));
}

/// Makes a body one that only sees.
void sense(btCollisionObject& object)
{
    object.setCollisionFlags(object.getCollisionFlags() |
                             btCollisionObject::CF_NO_CONTACT_RESPONSE);
}

struct TriggerListener : btCcdImpactListener
{
    std::function<void(const btCcdPassage&)> m_answer;
    int m_count = 0;

    btCcdAfterImpact onImpact(const btCcdImpact&) override { return btCcdAfterImpact::Solve; }
    void onPassage(const btCcdPassage& passage) override
    {
        ++m_count;
        if (m_answer)
        {
            m_answer(passage);
        }
    }
};

const btCcdPassage* passageOf(Scene& scene, const btCollisionObject* object)
{
    for (const btCcdPassage& passage : scene.ccd().getCcdPassages())
    {
        if (passage.m_object == object)
        {
            return &passage;
        }
    }
    return nullptr;
}

class Triggers : public testing::TestWithParam<Kind>
{
};
}  // namespace

TEST_P(Triggers, SeeWhatPassesThroughAThinOneInOneStep)
{
    Scene scene(GetParam());
    Ghost plate(scene, scene.box(vec(1, 1, 0.001)), poseAt(vec(0, 0, 0)));
    btRigidBody* body = scene.body(ball(scene, 0.01), 1.0, poseAt(vec(0.3, 0, 5)));
    body->setLinearVelocity(vec(0, 0, -1000));
    TriggerListener listener;
    scene.ccd().setCcdImpactListener(&listener);
    scene.step(0.01);
    EXPECT_NEAR(double(body->getWorldTransform().getOrigin().z()), -5, 1e-4) << "nothing stops it";
    ASSERT_EQ(scene.ccd().getCcdPassages().size(), 1U);
    EXPECT_EQ(listener.m_count, 1);
    const btCcdPassage& passage = scene.ccd().getCcdPassages()[0];
    EXPECT_EQ(passage.m_trigger, plate.get());
    EXPECT_EQ(passage.m_object, body);
    EXPECT_FALSE(passage.m_wasInside);
    EXPECT_FALSE(passage.m_isInside);
    EXPECT_NEAR(double(passage.m_enterTime), (5 - 0.011) / 1000, kTolerance / 1000 + 1e-8);
    EXPECT_NEAR(double(passage.m_exitTime), (5 + 0.011) / 1000, kTolerance / 1000 + 1e-7);
    EXPECT_NEAR(double(passage.m_point.z()), 0.001, kTolerance + 1e-6);
    EXPECT_NEAR(double(passage.m_normal.z()), 1, 1e-5) << "from the trigger to the body";
    scene.step(0.01);
    EXPECT_TRUE(scene.ccd().getCcdPassages().empty());
}

TEST_P(Triggers, TellEntriesAndExitsAsTheClosedFormOfBallsHasThem)
{
    Random random(11);
    Scene scene(GetParam());
    const double bigRadius = 0.5;
    const double dt = 0.01;
    Ghost trigger(scene, ball(scene, bigRadius), poseAt(vec(0.2, -0.1, 0.3)));
    struct Flying
    {
        btRigidBody* m_body;
        Eigen::Vector3d m_from;
        Eigen::Vector3d m_velocity;
        double m_radius;
        int m_entered = 0;
        int m_left = 0;
    };
    std::vector<Flying> balls;
    for (int i = 0; i < 60; ++i)
    {
        Flying one;
        one.m_radius = random.uniform(0.005, 0.05);
        one.m_from = Eigen::Vector3d(0.2, -0.1, 0.3) + random.inBox(2.0);
        const Eigen::Vector3d aim = Eigen::Vector3d(0.2, -0.1, 0.3) + random.inBox(0.6);
        one.m_velocity = (aim - one.m_from).normalized() * random.logUniform(3.0, 1000.0);
        // In a group of its own, so that balls do not meet each other.
        one.m_body = scene.body(ball(scene, one.m_radius), 1.0, poseAt(btCcdToBullet(one.m_from)));
        scene.world().removeRigidBody(one.m_body);
        scene.world().addRigidBody(one.m_body, 1, btBroadphaseProxy::SensorTrigger);
        one.m_body->setLinearVelocity(btCcdToBullet(one.m_velocity));
        balls.push_back(one);
    }
    int passed = 0;
    for (int step = 0; step < 30; ++step)
    {
        scene.step(dt);
        for (Flying& one : balls)
        {
            const btCcdPassage* passage = passageOf(scene, one.m_body);
            if (passage == nullptr)
            {
                continue;
            }
            one.m_entered += passage->m_wasInside ? 0 : 1;
            one.m_left += passage->m_isInside ? 0 : 1;
            passed += !passage->m_wasInside && !passage->m_isInside ? 1 : 0;
            const Eigen::Vector3d from = one.m_from - Eigen::Vector3d(0.2, -0.1, 0.3);
            const auto distanceAt = [&](btScalar time)
            { return (from + one.m_velocity * (step * dt + double(time))).norm(); };
            const double touching = bigRadius + one.m_radius;
            const double far = (from + one.m_velocity * (step * dt)).norm();
            const double slack = 1e-3 * std::max(1.0, 1e-3 * one.m_velocity.norm());
            if (!passage->m_wasInside && far > touching)
            {
                EXPECT_NEAR(distanceAt(passage->m_enterTime), touching, slack);
            }
            if (!passage->m_isInside)
            {
                EXPECT_NEAR(distanceAt(passage->m_exitTime), touching, slack);
            }
        }
    }
    int hits = 0;
    for (const Flying& one : balls)
    {
        const Eigen::Vector3d from = one.m_from - Eigen::Vector3d(0.2, -0.1, 0.3);
        const double nearest =
            std::clamp(-from.dot(one.m_velocity) / one.m_velocity.squaredNorm(), 0.0, 30 * dt);
        const double least = (from + nearest * one.m_velocity).norm();
        const double touching = bigRadius + one.m_radius;
        if (std::abs(least - touching) < 1e-3)
        {
            continue;
        }
        const bool isHit = least < touching;
        const bool ends = (from + 30 * dt * one.m_velocity).norm() < touching;
        hits += isHit ? 1 : 0;
        EXPECT_EQ(one.m_entered, isHit ? 1 : 0) << one.m_velocity.norm();
        EXPECT_EQ(one.m_left, isHit && !ends ? 1 : 0) << one.m_velocity.norm();
    }
    EXPECT_GT(hits, 10);
    EXPECT_LT(hits, 50);
    EXPECT_GT(passed, 3) << "some come and go in one step";
}

TEST_P(Triggers, AreLeftWhenTheirLastPartIs)
{
    // Boxes in a row, passed in one step.
    Scene scene(GetParam());
    auto* row = scene.keep(std::make_unique<btCompoundShape>());
    for (const double x : {0.0, 3.0, 5.0})
    {
        row->addChildShape(poseAt(vec(x, 0, 0)), scene.box(vec(0.5, 0.5, 0.5)));
    }
    Ghost trigger(scene, row, poseAt(vec(0, 0, 0)));
    btRigidBody* body = scene.body(ball(scene, 0.1), 1.0, poseAt(vec(-2, 0, 0)));
    body->setLinearVelocity(vec(100, 0, 0));
    scene.step(0.1);
    const btCcdPassage* passage = passageOf(scene, body);
    ASSERT_NE(passage, nullptr);
    EXPECT_FALSE(passage->m_isInside);
    EXPECT_NEAR(double(passage->m_enterTime), (2.0 - 0.6) / 100, kTolerance / 100 + 1e-7);
    EXPECT_NEAR(double(passage->m_exitTime), (2.0 + 5.6) / 100, kTolerance / 100 + 1e-7);
    // It ends in the second box, and is inside.
    body->setWorldTransform(poseAt(vec(-2, 0, 0)));
    scene.ccd().teleported(body);
    body->setLinearVelocity(vec(49, 0, 0));
    scene.step(0.1);
    passage = passageOf(scene, body);
    ASSERT_NE(passage, nullptr);
    EXPECT_TRUE(passage->m_isInside);
    EXPECT_NEAR(double(passage->m_enterTime), (2.0 - 0.6) / 49, kTolerance / 49 + 1e-7);
}

TEST_P(Triggers, AreLeftByBallsOfAnySizeThatStopBesideThem)
{
    // A distance that is only known to be beyond a bound is not below it, however the radius
    // rounds.
    Scene scene(GetParam());
    auto* cylinder = scene.keep(std::make_unique<btCylinderShapeZ>(vec(0.955, 0.955, 0.601)));
    Ghost trigger(scene, cylinder, poseAt(vec(0, 0, 0)));
    for (int i = 0; i < 20; ++i)
    {
        const double radius = 0.0216 + 1e-6 * i;
        btRigidBody* body = scene.body(ball(scene, radius), 1.0, poseAt(vec(2.117, -0.5, -1.408)));
        body->setLinearVelocity(vec(-186.26, 32.157, 95.3245));
        scene.step(1.0 / 60);  // to 11 mm beside it
        const btCcdPassage* passage = passageOf(scene, body);
        ASSERT_NE(passage, nullptr);
        EXPECT_FALSE(passage->m_isInside) << radius;
        EXPECT_LT(double(passage->m_exitTime), 0.01665) << radius;
        body->setWorldTransform(poseAt(vec(100 + i, 0, 0)));
        scene.ccd().teleported(body);
        body->setLinearVelocity(vec(0, 0, 0));
    }
}

TEST_P(Triggers, FollowThePathThatIsTakenNotTheOneThatWasMeant)
{
    Scene scene(GetParam());
    // Down to the plate, and up again in the same step if the world answers at once.
    btRigidBody* plate = scene.body(scene.boxMesh(vec(1, 1, 0.01)), 0.0, poseAt(vec(0, 0, 0)));
    Ghost below(scene, scene.box(vec(1, 1, 0.01)), poseAt(vec(0, 0, -0.5)));
    Ghost above(scene, scene.box(vec(1, 1, 0.01)), poseAt(vec(0, 0, 2)));
    btRigidBody* body = scene.body(ball(scene, 0.05), 1.0, poseAt(vec(0, 0, 1)));
    plate->setRestitution(1);
    body->setRestitution(1);
    body->setLinearVelocity(vec(0, 0, -1000));
    scene.step(0.01);
    const bool bounces = GetParam() == Kind::World;
    ASSERT_EQ(scene.ccd().getCcdPassages().size(), bounces ? 1U : 0U);
    if (bounces)
    {
        const btCcdPassage& passage = scene.ccd().getCcdPassages()[0];
        EXPECT_EQ(passage.m_trigger, above.get());
        const double way = (1 - 0.06) + (2 - 0.01 - 0.05 - 0.06);
        EXPECT_NEAR(double(passage.m_enterTime), way / 1000, 5e-6);
    }
}

TEST_P(Triggers, MayMoveAndTurnThemselves)
{
    Scene scene(GetParam());
    // A body that falls through a plate, a ghost that is put on the other side of it, and a link
    // that swings through a pin: everything in one step.
    btRigidBody* plate = scene.body(scene.boxMesh(vec(1, 1, 0.001)), 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* falling = scene.body(scene.box(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0.5, 0, 1)));
    sense(*falling);
    falling->setLinearVelocity(vec(0, 0, -200));
    btRigidBody* pin = scene.body(ball(scene, 0.001), 0.0, poseAt(vec(10, 0.2, 0)));
    btMultiBody* arm = scene.chain({scene.box(vec(0.2, 0.001, 0.001))}, 0.2, poseAt(vec(10, 0, 0)));
    btMultiBodyLinkCollider* link = arm->getLink(0).m_collider;
    sense(*link);
    arm->setJointVel(0, btScalar(3.0 / 0.01));  // 3 rad in the step
    Ghost hand(scene, scene.box(vec(0.5, 0.1, 0.1)), poseAt(vec(-0.5, 0, 1)));
    scene.step(0.01);
    const auto sawOnce = [&](const btCollisionObject* trigger, const btCollisionObject* object)
    {
        int count = 0;
        for (const btCcdPassage& passage : scene.ccd().getCcdPassages())
        {
            count += passage.m_trigger == trigger && passage.m_object == object ? 1 : 0;
        }
        return count == 1;
    };
    EXPECT_TRUE(sawOnce(falling, plate));
    EXPECT_TRUE(sawOnce(link, pin));
    EXPECT_EQ(passageOf(scene, pin)->m_triggerLink, 0);
    EXPECT_EQ(passageOf(scene, pin)->m_objectLink, btCcdImpact::kNoLink);
    // It starts along x, so the pin at y is met after a quarter turn.
    EXPECT_NEAR(
        double(passageOf(scene, pin)->m_enterTime), 0.01 * (0.5 * SIMD_PI - 0.01) / 3.0, 1e-4);
    EXPECT_FALSE(sawOnce(hand.get(), plate));
    hand->setWorldTransform(poseAt(vec(-0.5, 0, -1)));
    scene.step(0.01);
    EXPECT_TRUE(sawOnce(hand.get(), plate)) << "it has passed through";
    scene.step(0.01);
    EXPECT_FALSE(sawOnce(hand.get(), plate));
    hand->setWorldTransform(poseAt(vec(-0.5, 0, 1)));
    scene.ccd().teleported(hand.get());
    scene.step(0.01);
    EXPECT_FALSE(sawOnce(hand.get(), plate)) << "it has been put there";
}

TEST_P(Triggers, KnowWhatStaysInside)
{
    Scene scene(GetParam());
    scene.world().setGravity(vec(0, 0, -10));
    scene.body(scene.box(vec(5, 5, 0.1)), 0.0, poseAt(vec(0, 0, -0.1)));
    Ghost zone(scene, scene.box(vec(1, 1, 1)), poseAt(vec(0, 0, 0.5)));
    btRigidBody* box = scene.body(scene.box(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0, 0.3)));
    btRigidBody* still =
        scene.body(scene.boxMesh(vec(0.1, 0.1, 0.1)), 0.0, poseAt(vec(0.5, 0, 0.2)));
    for (int steps = 0; steps < 30; ++steps)
    {
        scene.step(0.01);
        ASSERT_EQ(scene.ccd().getCcdPassages().size(), 1U) << "not the floor, not what is static";
        const btCcdPassage& passage = scene.ccd().getCcdPassages()[0];
        EXPECT_EQ(passage.m_object, box);
        EXPECT_EQ(passage.m_wasInside, steps > 0);
        EXPECT_TRUE(passage.m_isInside);
        EXPECT_EQ(passage.m_enterTime, btScalar(0));
        EXPECT_EQ(passage.m_exitTime, btScalar(0.01));
    }
    box->forceActivationState(ISLAND_SLEEPING);
    scene.step(0.01);
    ASSERT_FALSE(box->isActive());
    ASSERT_NE(passageOf(scene, box), nullptr) << "it is there as it sleeps";
    EXPECT_TRUE(passageOf(scene, box)->m_isInside);
    box->setWorldTransform(poseAt(vec(4, 0, 0.1)));
    box->forceActivationState(DISABLE_DEACTIVATION);
    scene.ccd().teleported(box);
    scene.step(0.01);
    ASSERT_NE(passageOf(scene, box), nullptr);
    EXPECT_TRUE(passageOf(scene, box)->m_wasInside);
    EXPECT_FALSE(passageOf(scene, box)->m_isInside);
    EXPECT_EQ(passageOf(scene, box)->m_exitTime, btScalar(0));
    scene.step(0.01);
    EXPECT_EQ(passageOf(scene, box), nullptr);
    EXPECT_EQ(passageOf(scene, still), nullptr);
}

TEST_P(Triggers, KeepToBulletsFilters)
{
    Scene scene(GetParam());
    Ghost plate(scene, scene.box(vec(5, 1, 0.001)), poseAt(vec(0, 0, 0)), 2);
    btRigidBody* bodies[4];
    for (int i = 0; i < 4; ++i)
    {
        bodies[i] = scene.body(ball(scene, 0.01), 1.0, poseAt(vec(i, 0, 1)));
        bodies[i]->setLinearVelocity(vec(0, 0, -200));
        scene.world().removeRigidBody(bodies[i]);
        scene.world().addRigidBody(bodies[i], i == 1 ? 4 : 2, -1);
    }
    plate->setIgnoreCollisionCheck(bodies[2], true);
    scene.ccd().setCcdEnabled(bodies[3], false);
    scene.step(0.01);
    ASSERT_EQ(scene.ccd().getCcdPassages().size(), 1U);
    EXPECT_EQ(scene.ccd().getCcdPassages()[0].m_object, bodies[0]);
    scene.ccd().setCcdEnabled(bodies[3], true);
}

TEST_P(Triggers, OfManyKindsSeeManyKinds)
{
    const TriangleMesh knot = makeTorus(0.2, 0.05, 24, 12);
    for (int kind = 0; kind < 4; ++kind)
    {
        Scene scene(GetParam());
        auto* compound = scene.keep(std::make_unique<btCompoundShape>());
        compound->addChildShape(poseAt(vec(0.2, 0, 0)), ball(scene, 0.05));
        compound->addChildShape(poseAt(vec(-0.2, 0, 0)), scene.box(vec(0.05, 0.05, 0.05)));
        btCollisionShape* shapes[] = {
            scene.mesh(knot), compound, scene.staticMesh(knot), scene.box(vec(0.25, 0.25, 0.05))};
        Ghost trigger(scene, shapes[kind], poseAt(vec(0, 0, 0)));
        btRigidBody* onRim =
            scene.body(scene.mesh(makeBox({0.01, 0.01, 0.01})), 1.0, poseAt(vec(0.2, 0, 1)));
        btRigidBody* throughHole = scene.body(compound, 1.0, poseAt(vec(0, 0, -3)));
        throughHole->getCollisionShape();
        throughHole->setCollisionShape(ball(scene, 0.05));
        onRim->setLinearVelocity(vec(0, 0, -200));
        throughHole->setLinearVelocity(vec(0, 0, 500));
        scene.step(0.01);
        EXPECT_NE(passageOf(scene, onRim), nullptr) << kind;
        EXPECT_EQ(passageOf(scene, throughHole) != nullptr, kind == 3) << kind;
    }
}

TEST_P(Triggers, LetTheListenerRemoveAndAddObjects)
{
    Scene scene(GetParam());
    auto first = std::make_unique<Ghost>(scene, scene.box(vec(5, 1, 0.001)), poseAt(vec(0, 0, 0)));
    std::optional<Ghost> second;
    std::vector<std::unique_ptr<btRigidBody>> own;
    btSphereShape* shape = ball(scene, 0.01);
    for (int i = 0; i < 3; ++i)
    {
        own.push_back(std::make_unique<btRigidBody>(btScalar(1), nullptr, shape, vec(1, 1, 1)));
        own.back()->setWorldTransform(poseAt(vec(i, 0, 1)));
        own.back()->setLinearVelocity(vec(0, 0, -100 - 50 * i));  // the last comes first
        scene.world().addRigidBody(own.back().get());
    }
    scene.addHooks();
    TriggerListener listener;
    listener.m_answer = [&](const btCcdPassage& passage)
    {
        ASSERT_EQ(passage.m_object, own[2].get());
        // The one that is told of and another are gone for good; a trigger comes, one goes.
        for (const std::size_t i : {std::size_t(2), std::size_t(0)})
        {
            scene.world().removeRigidBody(own[i].get());
            own[i].reset();
        }
        second.emplace(scene, scene.box(vec(5, 1, 0.001)), poseAt(vec(0, 0, -1)));
        first.reset();
    };
    scene.ccd().setCcdImpactListener(&listener);
    scene.step(0.02);
    EXPECT_EQ(listener.m_count, 1);
    EXPECT_TRUE(scene.ccd().getCcdPassages().empty());
    listener.m_answer = nullptr;
    scene.step(0.02);
    for (int i = 0; i < 5; ++i)
    {
        scene.step(0.02);
    }
    scene.ccd().setCcdImpactListener(nullptr);
    scene.world().removeRigidBody(own[1].get());
}

TEST_P(Triggers, ChangeNothing)
{
    const auto run = [&](bool withTriggers)
    {
        Scene scene(GetParam());
        scene.world().setGravity(vec(0, 0, -10));
        scene.body(scene.boxMesh(vec(3, 3, 0.01)), 0.0, poseAt(vec(0, 0, 0)));
        std::vector<btRigidBody*> bodies;
        Random random(3);
        for (int i = 0; i < 20; ++i)
        {
            bodies.push_back(scene.body(
                i % 2 == 0 ? scene.box(vec(0.1, 0.1, 0.1))
                           : static_cast<btCollisionShape*>(scene.boxMesh(vec(0.1, 0.1, 0.1))),
                1.0,
                btCcdToBullet(random.pose(1.0))));
            bodies.back()->getWorldTransform().getOrigin() += vec(0, 0, 2);
            bodies.back()->setLinearVelocity(btCcdToBullet(Eigen::Vector3d(random.inBox(50.0))));
        }
        std::vector<std::unique_ptr<Ghost>> triggers;
        for (int i = 0; i < 3; ++i)
        {
            triggers.push_back(
                std::make_unique<Ghost>(scene, scene.box(vec(1, 1, 0.3)), poseAt(vec(0, 0, i))));
            scene.ccd().setCcdEnabled(triggers.back()->get(), withTriggers);
        }
        std::vector<btTransform> poses;
        std::size_t seen = 0;
        for (int step = 0; step < 20; ++step)
        {
            scene.step(0.01);
            seen += scene.ccd().getCcdPassages().size();
            for (const btRigidBody* body : bodies)
            {
                poses.push_back(body->getWorldTransform());
            }
        }
        EXPECT_EQ(seen > 20, withTriggers);
        EXPECT_GT(scene.counters().m_impacts, 10);
        return poses;
    };
    const std::vector<btTransform> without = run(false);
    const std::vector<btTransform> with = run(true);
    EXPECT_TRUE(without == with);
}

INSTANTIATE_TEST_SUITE_P(Ours,
                         Triggers,
                         testing::ValuesIn(kOurKinds),
                         [](const auto& test) { return std::string(codeOf(test.param)); });
}  // namespace bullet_ccd::tests
