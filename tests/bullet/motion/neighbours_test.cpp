#include "benchmarks/reference/bullet/scene.h"
#include "bullet_ccd/bullet/motion/btCcdNeighbours.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kTimeStep = 1.0 / 240.0;

/// A ball at 10 m/s for 20 steps beside which nothing is, so that its neighbours are listed; then
/// something changes. Returns the impacts of the next 10 steps.
struct Flight
{
    Scene m_scene;
    btRigidBody* m_ball;
    btRigidBody* m_wall;
    btRigidBody* m_other;  // keeps the list in use: it flies along beside the ball

    explicit Flight(Kind kind, const btVector3& wallAt) : m_scene(kind)
    {
        btCollisionShape* sphere = m_scene.keep(std::make_unique<btSphereShape>(btScalar(0.02)));
        m_ball = m_scene.body(sphere, 1.0, poseAt(vec(0, 0, 0)));
        m_other = m_scene.body(sphere, 1.0, poseAt(vec(0, 0.05, 0)));
        m_wall = m_scene.body(m_scene.box(vec(0.001, 0.5, 0.5)), 0.0, poseAt(wallAt));
        m_ball->setLinearVelocity(vec(10, 0, 0));
        m_other->setLinearVelocity(vec(10, 0, 0));
        run(20);
    }
    void run(int steps)
    {
        for (int i = 0; i < steps; ++i)
        {
            m_scene.step(kTimeStep);
        }
    }
    std::int64_t impacts(int steps)
    {
        const std::int64_t before = m_scene.counters().m_impacts;
        run(steps);
        return m_scene.counters().m_impacts - before;
    }
    double x() const { return double(m_ball->getWorldTransform().getOrigin().x()); }
};
}  // namespace

class NeighbourList : public testing::TestWithParam<int>
{
};

TEST_P(NeighbourList, HoldsAllPairsOfBoxesThatMeetAndNoOthers)
{
    const int count = GetParam();
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::vector<btCcdBox> boxes(static_cast<std::size_t>(count));
    for (btCcdBox& box : boxes)
    {
        box.m_low = vec(uniform(random), uniform(random), uniform(random));
        box.m_high = box.m_low + vec(uniform(random), uniform(random), uniform(random)) *
                                     btScalar(18.0 / count);
    }
    boxes[5] = {};
    // Much larger than the others, in two directions, or in all.
    boxes[9] = {vec(-90, 0.4, -90), vec(90, 0.5, 90)};
    boxes[11] = {vec(-BT_LARGE_FLOAT, -BT_LARGE_FLOAT, -BT_LARGE_FLOAT),
                 vec(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT)};
    std::vector<std::pair<int, int>> expected;
    for (int a = 0; a < count; ++a)
    {
        for (int b = a + 1; b < count; ++b)
        {
            if (a != 5 && b != 5 && boxes[std::size_t(a)].meets(boxes[std::size_t(b)]))
            {
                expected.emplace_back(a, b);
            }
        }
    }
    btCcdNeighbours neighbours;
    neighbours.boxes() = boxes;
    EXPECT_FALSE(neighbours.listAmongAll(expected.size() - 1));
    EXPECT_TRUE(neighbours.listAmongAll(expected.size()));
    EXPECT_EQ(neighbours.pairs(), expected);
    EXPECT_GT(expected.size(), std::size_t(count) / 3);
    EXPECT_LT(expected.size(), std::size_t(count * count) / 3);
    // With a split, those of the first third with the others.
    const int split = count / 3;
    std::erase_if(expected,
                  [split](const auto& pair) { return pair.first >= split || pair.second < split; });
    EXPECT_TRUE(neighbours.listBetween(std::size_t(split), expected.size()));
    EXPECT_EQ(neighbours.pairs(), expected);
    EXPECT_GT(expected.size(), std::size_t(count) / 12);
    EXPECT_TRUE(neighbours.boxes()[3].contains(boxes[3].m_low, boxes[3].m_high));
    EXPECT_FALSE(neighbours.boxes()[5].contains(boxes[3].m_low, boxes[3].m_high));
}

// Few boxes are compared each with each, many by cells.
INSTANTIATE_TEST_SUITE_P(FewAndMany, NeighbourList, testing::Values(20, 60, 300));

TEST(Neighbours, WhatIsPutElsewhereBetweenTwoStepsIsMetThere)
{
    for (const Kind kind : kOurKinds)
    {
        Flight ball(kind, vec(100, 0, 0));
        EXPECT_EQ(ball.impacts(1), 0);
        ball.m_ball->setWorldTransform(poseAt(vec(99.9, 0, 0)));
        EXPECT_GT(ball.impacts(10), 0);
        EXPECT_LT(ball.x(), 100.0);

        Flight wall(kind, vec(100, 0, 0));
        EXPECT_EQ(wall.impacts(1), 0);
        wall.m_wall->setWorldTransform(poseAt(vec(wall.x() + 0.1, 0, 0)));
        EXPECT_GT(wall.impacts(10), 0);
    }
}

/// A crowd that moves along together has no neighbours to list until one of it does not: then both
/// those that go on and those that have fallen asleep on the way are in its list.
TEST(Neighbours, WhatLeavesACrowdMeetsTheOthers)
{
    for (const Kind kind : kOurKinds)
    {
        Scene scene(kind);
        btCollisionShape* sphere = scene.keep(std::make_unique<btSphereShape>(btScalar(0.02)));
        std::vector<btRigidBody*> crowd;
        for (int i = 0; i < 64; ++i)
        {
            crowd.push_back(scene.body(sphere, 1.0, poseAt(vec(0, 0.5 * (i % 8), 0.5 * (i / 8)))));
            crowd.back()->setLinearVelocity(vec(60, 0, 0));
        }
        const auto run = [&](int steps)
        {
            for (int i = 0; i < steps; ++i)
            {
                scene.step(kTimeStep);
            }
        };
        const auto isBefore = [](const btRigidBody& a, const btRigidBody& b)
        { return a.getWorldTransform().getOrigin().y() < b.getWorldTransform().getOrigin().y(); };
        run(30);
        EXPECT_EQ(scene.counters().m_impacts, 0);
        // It crosses the row of eight in less than a step.
        crowd[0]->setLinearVelocity(vec(60, 1000, 0));
        run(2);
        EXPECT_GT(scene.counters().m_impacts, 0);
        EXPECT_TRUE(isBefore(*crowd[0], *crowd[1]));

        const std::int64_t before = scene.counters().m_impacts;
        for (int i = 56; i < 64; ++i)
        {
            crowd[std::size_t(i)]->setLinearVelocity(vec(0, 0, 0));
            crowd[std::size_t(i)]->setActivationState(ISLAND_SLEEPING);
        }
        const btVector3& last = crowd[63]->getWorldTransform().getOrigin();
        crowd[20]->setWorldTransform(poseAt(vec(double(last.x()), -1.0, double(last.z()))));
        crowd[20]->setLinearVelocity(vec(0, 1000, 0));
        run(2);
        EXPECT_GT(scene.counters().m_impacts, before);
        EXPECT_TRUE(isBefore(*crowd[20], *crowd[56]));
    }
}

namespace
{
/// Of 72 bodies in a closed room of walls of 2 mm, how many are outside after 30 steps. Some spin
/// faster than Bullet's boxes have room for; a push changes all velocities after Bullet has made
/// its boxes.
int countOutside(Kind kind, double push)
{
    Scene scene(kind, WorldClass::Rigid);
    for (int i = 0; i < 6; ++i)
    {
        btVector3 half = vec(2.1, 2.1, 2.1);
        half[i / 2] = btScalar(0.001);
        btVector3 place = vec(0, 0, 0);
        place[i / 2] = btScalar(i % 2 == 0 ? -2.0 : 2.0);
        scene.body(scene.box(half), 0.0, poseAt(place));
    }
    btCollisionShape* brick = scene.box(vec(0.08, 0.05, 0.02));
    btCollisionShape* ball = scene.keep(std::make_unique<btSphereShape>(btScalar(0.04)));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    std::vector<btRigidBody*> bodies;
    for (int i = 0; i < 72; ++i)
    {
        const btVector3 place = vec(0.6 * (i % 6) - 1.5, 0.6 * (i / 6 % 4) - 0.9, i / 24 - 1.0);
        btRigidBody* body = scene.body(i % 2 == 0 ? brick : ball, 1.0, poseAt(place));
        body->setLinearVelocity(btScalar(30) * vec(any(random), any(random), any(random)));
        body->setAngularVelocity(btScalar(40) * vec(any(random), any(random), any(random)));
        body->setRestitution(btScalar(0.8));
        bodies.push_back(body);
    }
    for (int step = 0; step < 30; ++step)
    {
        for (btRigidBody* body : bodies)
        {
            body->applyCentralForce(vec(step % 2 == 0 ? push : -push, 0, 0.5 * push));
        }
        scene.step(1.0 / 60.0);
    }
    return int(std::ranges::count_if(bodies,
                                     [](const btRigidBody* body)
                                     {
                                         const btVector3 place =
                                             body->getWorldTransform().getOrigin().absolute();
                                         return !(place[place.maxAxis()] < btScalar(2.0));
                                     }));
}
}  // namespace

TEST(Neighbours, ACrowdStaysInARoomOfThinWalls)
{
    // Without a push nearly everything stays in Bullet's boxes; with a weak one they have to be
    // left by some, with a strong one by all.
    for (const double push : {0.0, 40.0, 400.0})
    {
        EXPECT_GT(countOutside(Kind::Stock, push), 20);  // the control
        EXPECT_EQ(countOutside(Kind::World, push), 0) << "push " << push;
        EXPECT_EQ(countOutside(Kind::Action, push), 0) << "push " << push;
    }
}

TEST(Neighbours, WhatIsAddedOrTakesAnotherShapeBetweenTwoStepsIsMet)
{
    for (const Kind kind : kOurKinds)
    {
        Flight added(kind, vec(100, 0, 0));
        EXPECT_EQ(added.impacts(1), 0);
        added.m_scene.body(
            added.m_scene.box(vec(0.001, 0.5, 0.5)), 0.0, poseAt(vec(added.x() + 0.1, 0, 0)));
        EXPECT_GT(added.impacts(10), 0);

        // A small plate beside the way grows into it.
        Flight grown(kind, vec(1.1, 2, 0));
        EXPECT_EQ(grown.impacts(1), 0);
        grown.m_wall->setCollisionShape(grown.m_scene.box(vec(0.001, 3, 3)));
        EXPECT_GT(grown.impacts(10), 0);

        Flight scaled(kind, vec(1.1, 2, 0));
        EXPECT_EQ(scaled.impacts(1), 0);
        scaled.m_wall->getCollisionShape()->setLocalScaling(vec(1, 6, 1));
        EXPECT_GT(scaled.impacts(10), 0);
    }
}

TEST(Neighbours, FiltersAreAskedInEveryStep)
{
    for (const Kind kind : kOurKinds)
    {
        Flight flight(kind, vec(1.1, 0, 0));
        flight.m_wall->setCollisionFlags(flight.m_wall->getCollisionFlags() |
                                         btCollisionObject::CF_NO_CONTACT_RESPONSE);
        EXPECT_EQ(flight.impacts(4), 0);
        EXPECT_LT(flight.x(), 1.05);
        flight.m_wall->setCollisionFlags(flight.m_wall->getCollisionFlags() &
                                         ~btCollisionObject::CF_NO_CONTACT_RESPONSE);
        EXPECT_GT(flight.impacts(10), 0);
        EXPECT_LT(flight.x(), 1.1);
    }
}
}  // namespace bullet_ccd::tests
