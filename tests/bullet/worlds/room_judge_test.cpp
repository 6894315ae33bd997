#include "benchmarks/reference/audit/room_judge.h"

#include "benchmarks/reference/bullet/scene.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kStepInRoom = 1.0 / 60.0;
constexpr int kFloor = 2;  // its axis

class JudgeOfRooms : public testing::TestWithParam<Kind>
{
};

/// Takes bodies back to where they were once they are this low, and leaves them their velocity:
/// what the action did to meshes that were held at the first instant of every step.
class Jam : public btActionInterface
{
public:
    explicit Jam(std::vector<btRigidBody*> bodies) : m_bodies(std::move(bodies)) {}
    void updateAction(btCollisionWorld*, btScalar timeStep) override
    {
        for (btRigidBody* body : m_bodies)
        {
            if (body->getWorldTransform().getOrigin().z() < -1.7)
            {
                body->translate(-timeStep * body->getLinearVelocity());
            }
        }
    }
    void debugDraw(btIDebugDraw*) override {}

private:
    std::vector<btRigidBody*> m_bodies;
};

Room roomWithFloor()
{
    return {.half = 2.0, .walls = {{{0.05, 0.05}, {0.05, 0.05}, {0.05, 0.05}}}};
}

btRigidBody* addFloorOf(Scene& scene, bool mesh)
{
    const btVector3 half = vec(2, 2, 0.05);
    btCollisionShape* floor =
        mesh ? static_cast<btCollisionShape*>(scene.boxMesh(half)) : scene.box(half);
    scene.world().setGravity(vec(0, 0, -10));
    return scene.body(floor, 0.0, poseAt(vec(0, 0, -2.05)));
}

/// The last finding of the first step with one.
RoomFinding judgeSteps(Scene& scene,
                       RoomJudge& judge,
                       const std::vector<btRigidBody*>& bodies,
                       int steps)
{
    RoomFinding found = RoomFinding::Nothing;
    for (int i = 0; i < steps && found == RoomFinding::Nothing; ++i)
    {
        scene.step(kStepInRoom);
        for (const btRigidBody* body : bodies)
        {
            const RoomFinding now = judge.look(*body);
            found = now == RoomFinding::Nothing ? found : now;
        }
    }
    return found;
}

/// Of cubes of mesh that fall on each other in a column.
RoomFinding judgeColumn(Kind kind, bool jammed)
{
    Scene scene(kind, WorldClass::Rigid);
    addFloorOf(scene, true);
    std::vector<btRigidBody*> cubes;
    for (int i = 0; i < 4; ++i)
    {
        cubes.push_back(
            scene.body(scene.boxMesh(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0, -1.8 + 0.25 * i))));
    }
    RoomJudge judge(roomWithFloor(), kStepInRoom);
    Jam jam(jammed ? cubes : std::vector<btRigidBody*>());
    scene.world().addAction(&jam);
    const RoomFinding found = judgeSteps(scene, judge, cubes, 300);
    scene.world().removeAction(&jam);
    return found;
}
}  // namespace

TEST_P(JudgeOfRooms, SeesWhatIsHeldForEverWhileItGathersSpeed)
{
    EXPECT_EQ(judgeColumn(Kind::Stock, true), RoomFinding::GathersSpeed);
    EXPECT_EQ(judgeColumn(GetParam(), false), RoomFinding::Nothing);
}

TEST_P(JudgeOfRooms, CountsWhatDoesNotComeOutOfAWall)
{
    for (const bool ignoresFloor : {true, false})
    {
        for (const bool falls : {true, false})
        {
            for (const bool mesh : {true, false})
            {
                Scene scene(GetParam(), WorldClass::Rigid);
                btRigidBody* floor = addFloorOf(scene, mesh);
                scene.world().setGravity(vec(0, 0, falls ? -10 : 0));
                RoomJudge judge(roomWithFloor(), kStepInRoom);
                std::vector<btRigidBody*> cubes;
                for (const double depth : {0.003, 0.01, 0.03})
                {
                    cubes.push_back(scene.body(scene.boxMesh(vec(0.1, 0.1, 0.1)),
                                               1.0,
                                               poseAt(vec(20 * depth, 0, -1.9 - depth))));
                    cubes.back()->setIgnoreCollisionCheck(floor, ignoresFloor);
                    judge.beginsInWall(*cubes.back(), kFloor, 0);
                }
                // What sinks through or sticks is counted, and is not wrong in itself.
                for (int step = 0; step < 70; ++step)
                {
                    const RoomFinding found = judgeSteps(scene, judge, cubes, 1);
                    EXPECT_TRUE(found == RoomFinding::Nothing || (ignoresFloor && falls));
                }
                EXPECT_EQ(judge.begunInWalls(), 3);
                EXPECT_EQ(judge.notComeOut(), ignoresFloor ? 3 : 0) << falls << mesh;
                EXPECT_FALSE(judge.isComingOut(*cubes[0]));
            }
        }
    }
}

TEST_P(JudgeOfRooms, SeesWhatIsInTheMiddleOfAWall)
{
    Scene scene(GetParam(), WorldClass::Rigid);
    btRigidBody* ball = scene.body(
        scene.keep(std::make_unique<btSphereShape>(btScalar(0.1))), 1.0, poseAt(vec(0, 0, 2)));
    RoomJudge judge(roomWithFloor(), kStepInRoom);
    EXPECT_EQ(judge.look(*ball), RoomFinding::Nothing);
    ball->translate(vec(0, 0, 0.06));
    EXPECT_EQ(judge.look(*ball), RoomFinding::Out);
    judge.beginsInWall(*ball, 2, 1);
    EXPECT_EQ(judge.look(*ball), RoomFinding::OutFromAWall);
    ball->setLinearVelocity(vec(0, 0, NAN));
    EXPECT_EQ(judge.look(*ball), RoomFinding::NotFinite);
    // A body that is put elsewhere, or given a speed, was not held.
    ball->setWorldTransform(poseAt(vec(0, 0, 0)));
    for (int i = 0; i < 20; ++i)
    {
        ball->setLinearVelocity(vec(i, 0, 0));
        judge.forget(*ball);
        EXPECT_EQ(judge.look(*ball), RoomFinding::Nothing);
    }
}

TEST(ReachOfBodies, IsThatOfTheirShapes)
{
    Scene scene(Kind::Stock);
    btCollisionShape* box = scene.boxMesh(vec(0.1, 0.2, 0.3));
    auto both = std::make_unique<btCompoundShape>();
    both->addChildShape(poseAt(vec(1, 0, 0)), box);
    both->addChildShape(poseAt(vec(0, -1, 0)),
                        scene.keep(std::make_unique<btSphereShape>(btScalar(0.25))));
    const btRigidBody* body =
        scene.body(scene.keep(std::move(both)), 1.0, poseAt(vec(0, 0, 5), SIMD_HALF_PI));
    EXPECT_NEAR(reachOf(*body, vec(1, 0, 0)), 1.25, 1e-6);
    EXPECT_NEAR(reachOf(*body, vec(0, 1, 0)), 1.1, 1e-6);
    EXPECT_NEAR(reachOf(*body, vec(0, 0, 1)), 5.3, 1e-6);
    EXPECT_NEAR(reachOf(*body, vec(0, 0, -1)), -4.7, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Ours,
                         JudgeOfRooms,
                         testing::ValuesIn(kOurKinds),
                         [](const auto& test) { return codeOf(test.param); });
}  // namespace bullet_ccd::tests
