#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kStepOfRecovery = 1.0 / 60.0;

class Recovery : public testing::TestWithParam<Kind>
{
};

/// Of all contacts.
std::vector<double> depthsOf(Scene& scene)
{
    std::vector<double> depths;
    btDispatcher& dispatcher = *scene.world().getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        for (int k = 0; k < manifold.getNumContacts(); ++k)
        {
            depths.push_back(double(manifold.getContactPoint(k).getDistance()));
        }
    }
    return depths;
}
}  // namespace

TEST_P(Recovery, OfMeshesThatBeginInsideEachOther)
{
    enum class Floor
    {
        Box,
        StaticMesh,
        Mesh,
    };
    for (const Floor kind : {Floor::Box, Floor::StaticMesh, Floor::Mesh})
    {
        for (const double depth : {0.001, 0.003, 0.01, 0.03})
        {
            Scene scene(GetParam(), WorldClass::Rigid);
            scene.world().setGravity(vec(0, 0, -10));
            btCollisionShape* floor =
                kind == Floor::Box ? static_cast<btCollisionShape*>(scene.box(vec(5, 5, 0.5)))
                : kind == Floor::StaticMesh
                    ? scene.staticMesh(makeBox(Eigen::Vector3d(5, 5, 0.5)))
                    : static_cast<btCollisionShape*>(scene.boxMesh(vec(5, 5, 0.5)));
            scene.body(floor, 0.0, poseAt(vec(0, 0, -0.5)));
            btRigidBody* cube =
                scene.body(scene.boxMesh(vec(0.2, 0.2, 0.2)), 1.0, poseAt(vec(0, 0, 0.2 - depth)));
            double lowest = 1.0;
            double fastest = 0.0;
            for (int i = 0; i < 180; ++i)
            {
                scene.step(kStepOfRecovery);
                lowest = std::min(lowest, double(cube->getWorldTransform().getOrigin().z()));
                fastest = std::max(fastest, double(cube->getLinearVelocity().length()));
            }
            const std::string which =
                "floor " + std::to_string(int(kind)) + ", " + std::to_string(depth) + " m deep";
            // It comes to rest on the floor, at the sum of the margins.
            EXPECT_NEAR(double(cube->getWorldTransform().getOrigin().z()), 0.2005, 1.5e-3) << which;
            // Before the first contact it falls for one step, 3 mm.
            EXPECT_GT(lowest, 0.2 - depth - 0.006) << which;
            // As softly as Bullet's error reduction has it: a fifth of the depth in a step.
            EXPECT_LT(fastest, 0.2 + 0.2 * depth / kStepOfRecovery) << which;
        }
    }
}

TEST_P(Recovery, HasAContactAtEveryCornerThatIsInside)
{
    // A cube leans in a floor: the lower edge of its bottom is 2 cm deep, the upper one 1 cm.
    const double half = 0.1;
    const double lean = std::asin(0.01 / (2.0 * half));
    const double height = half * (std::cos(lean) + std::sin(lean)) - 0.02;
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.body(scene.box(vec(5, 5, 0.5)), 0.0, poseAt(vec(0, 0, -0.5)));
    btTransform pose = poseAt(vec(0, 0, height));
    pose.setRotation(btQuaternion(vec(0, 1, 0), btScalar(lean)));
    scene.body(scene.boxMesh(vec(half, half, half)), 1.0, pose);
    scene.addHooks();
    scene.world().performDiscreteCollisionDetection();
    std::vector<double> depths = depthsOf(scene);
    std::ranges::sort(depths);
    ASSERT_EQ(depths.size(), 4U);
    // Counted from where the margins touch, half a millimetre above.
    EXPECT_NEAR(depths[0], -0.0205, 1e-4);
    EXPECT_NEAR(depths[1], -0.0205, 1e-4);
    EXPECT_NEAR(depths[2], -0.0105, 1e-4);
    EXPECT_NEAR(depths[3], -0.0105, 1e-4);
}

TEST_P(Recovery, OfAConvexShapeThatIsHitMeanwhile)
{
    // A box is put 5 mm deep into a floor of mesh, 10 cm thick, and a heavy ball hits it askew.
    int through = 0;
    for (const double speed : {5.0, 10.0, 20.0, 40.0, 80.0})
    {
        for (const double askew : {0.0, 0.03, 0.06, 0.09})
        {
            Scene scene(GetParam(), WorldClass::Rigid);
            scene.world().setGravity(vec(0, 0, -10));
            scene.body(scene.boxMesh(vec(100, 100, 0.05)), 0.0, poseAt(vec(0, 0, -0.05)));
            btRigidBody* box =
                scene.body(scene.box(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0, 0.095)));
            btRigidBody* ball =
                scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.1))),
                           5.0,
                           poseAt(vec(askew, 0.5 * askew, 0.4)));
            ball->setLinearVelocity(vec(0, 0, -speed));
            for (int step = 0; step < 90; ++step)
            {
                scene.step(2.0 * kStepOfRecovery);
            }
            through += box->getWorldTransform().getOrigin().z() > 0 ? 0 : 1;
        }
    }
    EXPECT_EQ(through, 0);
}

TEST_P(Recovery, OfThinPlatesThatAreHitMeanwhile)
{
    // A plate of 1 cm is put 3 or 6 mm deep into a floor, a mesh or the floor being one, and a
    // heavy ball hits it askew. Its core is in the floor as well, or it has none.
    int through = 0;
    for (const bool isMesh : {false, true})
    {
        for (const double speed : {2.0, 10.0, 40.0})
        {
            for (const double askew : {0.0, 0.02, 0.04})
            {
                for (const double depth : {0.003, 0.006})
                {
                    Scene scene(GetParam(), WorldClass::Rigid);
                    scene.world().setGravity(vec(0, 0, -10));
                    const auto box = [&](const btVector3& half, bool mesh) {
                        return mesh ? static_cast<btCollisionShape*>(scene.boxMesh(half))
                                    : scene.box(half);
                    };
                    scene.body(box(vec(100, 100, 0.05), !isMesh), 0.0, poseAt(vec(0, 0, -0.05)));
                    btRigidBody* plate = scene.body(
                        box(vec(0.1, 0.1, 0.005), isMesh), 1.0, poseAt(vec(0, 0, 0.005 - depth)));
                    btRigidBody* ball =
                        scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.1))),
                                   5.0,
                                   poseAt(vec(askew, 0.5 * askew, 0.15)));
                    ball->setLinearVelocity(vec(0, 0, -speed));
                    for (int step = 0; step < 90; ++step)
                    {
                        scene.step(kStepOfRecovery);
                    }
                    through += plate->getWorldTransform().getOrigin().z() > 0 ? 0 : 1;
                }
            }
        }
    }
    EXPECT_EQ(through, 0);
}

TEST_P(Recovery, OfPlatesThatTipWhollyInside)
{
    // A plate of 8 mm begins aslant, with one corner up to 25 mm deep, and falls over: then all of
    // it is below the surface of the floor.
    int left = 0;
    for (const bool isMesh : {false, true})
    {
        for (const double tilt : {0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2})
        {
            for (const double depth : {0.01, 0.015, 0.02, 0.025})
            {
                Scene scene(GetParam(), WorldClass::Rigid);
                scene.world().setGravity(vec(0, 0, -10));
                const auto box = [&](const btVector3& half, bool mesh) {
                    return mesh ? static_cast<btCollisionShape*>(scene.boxMesh(half))
                                : scene.box(half);
                };
                scene.body(box(vec(100, 100, 0.05), !isMesh), 0.0, poseAt(vec(0, 0, -0.05)));
                const double reach = 0.04 * std::sin(tilt) + 0.03 * 0.3 + 0.004 * std::cos(tilt);
                btTransform pose = poseAt(vec(0, 0, std::max(reach - depth, -0.004)));
                pose.setRotation(btQuaternion(vec(0, 1, 0), btScalar(tilt)) *
                                 btQuaternion(vec(1, 0, 0), btScalar(0.3)));
                btRigidBody* plate = scene.body(box(vec(0.04, 0.03, 0.004), isMesh), 0.3, pose);
                plate->setFriction(btScalar(0.1));
                for (int step = 0; step < 120; ++step)
                {
                    scene.step(kStepOfRecovery);
                }
                left += plate->getWorldTransform().getOrigin().z() > 0 ? 0 : 1;
            }
        }
    }
    EXPECT_EQ(left, 0);
}

TEST_P(Recovery, FromAnyDepth)
{
    // A cube of 20 cm on a floor of 50 cm, one of them a mesh. In a mesh, which may be a room as
    // well, it may be up to five eighths.
    enum class Pair
    {
        BoxInMesh,
        MeshInBox,
        MeshInMesh,
    };
    for (const Pair pair : {Pair::BoxInMesh, Pair::MeshInBox, Pair::MeshInMesh})
    {
        const double most = pair == Pair::MeshInBox ? 0.3 : 0.125;
        for (double depth = 0.005; depth <= most; depth += 0.02)
        {
            if (depth > 0.173 && depth < 0.2)
            {
                continue;  // its radius, up to where it is wholly inside
            }
            Scene scene(GetParam(), WorldClass::Rigid);
            scene.world().setGravity(vec(0, 0, -10));
            const btVector3 floor = vec(10, 10, 0.25);
            const btVector3 cube = vec(0.1, 0.1, 0.1);
            scene.body(pair == Pair::MeshInBox ? static_cast<btCollisionShape*>(scene.box(floor))
                                               : scene.boxMesh(floor),
                       0.0,
                       poseAt(vec(0, 0, -0.25)));
            btRigidBody* body =
                scene.body(pair == Pair::BoxInMesh ? static_cast<btCollisionShape*>(scene.box(cube))
                                                   : scene.boxMesh(cube),
                           1.0,
                           poseAt(vec(0, 0, 0.1 - depth)));
            double fastest = 0.0;
            for (int step = 0; step < 90; ++step)
            {
                scene.step(kStepOfRecovery);
                fastest = std::max(fastest, double(body->getLinearVelocity().length()));
            }
            const std::string which = std::to_string(int(pair)) + ", " + std::to_string(depth);
            EXPECT_NEAR(double(body->getWorldTransform().getOrigin().z()), 0.1, 2e-3) << which;
            EXPECT_LT(fastest, 1.0) << which;
        }
    }
}

// Its edges pierce the walls of the cup as well, but the rim is the way out.
TEST_P(Recovery, OfACylinderOnTheRimOfACup)
{
    constexpr double kCup = 0.12;
    constexpr double kWall = 0.03;
    constexpr double kHalf = 0.05;
    for (const double depth : {0.001, 0.003, 0.005})
    {
        Scene scene(GetParam(), WorldClass::Rigid);
        scene.world().setGravity(vec(0, 0, -10));
        scene.body(scene.mesh(makeRevolved({{0.0, -kCup},
                                            {kCup, -kCup},
                                            {kCup, kCup},
                                            {kCup - kWall, kCup},
                                            {kCup - kWall, -kCup + kWall},
                                            {0.0, -kCup + kWall}},
                                           16)),
                   0.0,
                   poseAt(vec(0, 0, 0)));
        btTransform pose = poseAt(vec(0.01326, 0.01578, kCup + kHalf - depth));
        pose.setRotation(btQuaternion(vec(0, 0, 1), btScalar(0.363)));
        btRigidBody* cylinder =
            scene.body(scene.mesh(makeCylinder(0.105, 2.0 * kHalf, 24)), 1.0, pose);
        for (int i = 0; i < 180; ++i)
        {
            scene.step(kStepOfRecovery);
        }
        EXPECT_NEAR(double(cylinder->getWorldTransform().getOrigin().z()), kCup + kHalf, 0.002)
            << depth;
    }
}

// All that is below a plane is inside of it.
TEST_P(Recovery, FromAnyDepthBelowAPlane)
{
    constexpr double kSize = 0.1;
    for (const double height : {0.02, 0.0, -0.04, -0.06, -0.09})
    {
        for (const int form : {0, 1, 2, 3})
        {
            Scene scene(GetParam(), WorldClass::Rigid);
            scene.world().setGravity(vec(0, 0, -10));
            scene.body(scene.keep(std::make_unique<btStaticPlaneShape>(vec(0, 0, 1), btScalar(0))),
                       0.0,
                       poseAt(vec(0, 0, 0)));
            btCollisionShape* shape =
                form == 0   ? scene.keep(std::make_unique<btSphereShape>(btScalar(kSize)))
                : form == 1 ? static_cast<btCollisionShape*>(scene.box(vec(kSize, kSize, kSize)))
                : form == 2 ? static_cast<btCollisionShape*>(scene.mesh(makeSphere(kSize, 2)))
                            : scene.boxMesh(vec(kSize, kSize, kSize));
            btRigidBody* body = scene.body(shape, 1.0, poseAt(vec(0, 0, height)));
            double fastest = 0.0;
            for (int i = 0; i < 180; ++i)
            {
                scene.step(kStepOfRecovery);
                fastest = std::max(fastest, double(body->getLinearVelocity().z()));
            }
            const double end = double(body->getWorldTransform().getOrigin().z());
            EXPECT_NEAR(end, kSize, 0.002) << "form " << form << ", from " << height;
            EXPECT_LT(fastest, 3.0) << "form " << form << ", from " << height;
        }
    }
}

TEST_P(Recovery, IntoARoomOfOneMesh)
{
    // Bodies are inside of a closed mesh, which is a room of theirs: some begin in its walls.
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, 0, -10));
    scene.body(scene.boxMesh(vec(1, 1, 1)), 0.0, poseAt(vec(0, 0, 0)));
    std::vector<btRigidBody*> bodies;
    for (int i = 0; i < 12; ++i)
    {
        const double half = 0.1;
        btCollisionShape* shape =
            i % 3 == 0 ? static_cast<btCollisionShape*>(scene.boxMesh(vec(half, half, half)))
            : i % 3 == 1
                ? scene.box(vec(half, half, half))
                : static_cast<btCollisionShape*>(scene.keep(std::make_unique<btSphereShape>(half)));
        const double depth = i < 6 ? 0.004 * i : -0.3;
        bodies.push_back(scene.body(
            shape, 1.0, poseAt(vec(-0.75 + 0.25 * (i % 6), i < 6 ? 0 : 0.5, half - depth - 1))));
        bodies.back()->setLinearVelocity(vec(0, i < 6 ? 0 : 30, -3.0 * i));
    }
    for (int step = 0; step < 180; ++step)
    {
        scene.step(kStepOfRecovery);
    }
    for (std::size_t i = 0; i < bodies.size(); ++i)
    {
        const btVector3& at = bodies[i]->getWorldTransform().getOrigin();
        EXPECT_LT(double(at.length()), 1.6) << i;
        EXPECT_GT(double(at.z()), -0.91) << i;
    }
}

TEST_P(Recovery, OfHullsWithSharpEdgesIsOutTheWayTheyCame)
{
    // Where the nearest point is on an edge or at a corner, some triangle there faces away from
    // what is outside. Of 4,000 such hulls, which begin in the floor with their margin of 4 cm,
    // these two were taken for inside of it.
    for (const std::uint64_t seed : {633, 2323})
    {
        Random random(seed);
        Scene scene(GetParam(), WorldClass::Rigid);
        scene.world().setGravity(vec(0, 0, 0));
        scene.body(scene.boxMesh(vec(2, 2, 0.05)), 0.0, poseAt(vec(0, 0, -0.05)));
        auto hull = std::make_unique<btConvexHullShape>();
        const double size = random.logUniform(0.03, 0.25);
        const int points = 4 + int(random.uniform(0, 12));
        for (int k = 0; k < points; ++k)
        {
            hull->addPoint(btCcdToBullet(Eigen::Vector3d(size * random.direction())));
        }
        Eigen::Isometry3d X = random.pose(1.0);
        X.translation() = Eigen::Vector3d(0, 0, size + 0.002);
        btRigidBody* body = scene.body(scene.keep(std::move(hull)), 1.0, btCcdToBullet(X));
        const double x = random.uniform(-8, 8);
        const double y = random.uniform(-8, 8);
        body->setLinearVelocity(vec(x, y, -random.logUniform(0.1, 5.0)));
        body->setAngularVelocity(btCcdToBullet(random.inBox(60.0)));
        for (int step = 0; step < 60; ++step)
        {
            scene.step(1.0 / 240.0);
            for (const double depth : depthsOf(scene))
            {
                EXPECT_GT(depth, -0.041) << seed << ", step " << step;
            }
        }
    }
}

TEST_P(Recovery, OfAHeapThatBeginsOnTheFloorToTheLastBit)
{
    // A hundred cubes in each other push the lowest, which touch the floor without a gap, down.
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, 0, -10));
    scene.body(scene.box(vec(20, 20, 0.5)), 0.0, poseAt(vec(0, 0, -0.5)));
    const double half = 0.1;
    btCollisionShape* cube = scene.boxMesh(vec(half, half, half));
    std::vector<btRigidBody*> cubes;
    for (int i = 0; i < 100; ++i)
    {
        const btVector3 place = vec(0.18 * (i % 5), 0.18 * (i / 5 % 5), half + 0.18 * (i / 25));
        cubes.push_back(scene.body(cube, 1.0, poseAt(place)));
    }
    double lowest = 0.0;
    for (int step = 0; step < 12; ++step)
    {
        scene.step(kStepOfRecovery);
        for (const btRigidBody* body : cubes)
        {
            const Eigen::Isometry3d X_WB = btCcdToEigen(body->getWorldTransform());
            const double reach = half * X_WB.linear().row(2).cwiseAbs().sum();
            lowest = std::min(lowest, X_WB.translation().z() - reach);
        }
    }
    EXPECT_GT(lowest, -0.01);
}

TEST_P(Recovery, BySplitImpulsesLeadsThroughNothing)
{
    // Boxes that fall on each other at up to 780 m/s are pushed out of each other, and must not be
    // pushed through the slab below: Bullet's default, a push is not a velocity.
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, 0, -10));
    ASSERT_NE(scene.world().getSolverInfo().m_splitImpulse, 0);
    scene.body(scene.boxMesh(vec(20, 20, 0.05)), 0.0, poseAt(vec(0, 0, -0.05)));
    std::vector<btRigidBody*> boxes;
    for (int i = 0; i < 40; ++i)
    {
        boxes.push_back(scene.body(
            scene.box(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0.5 * (i % 8) - 2.5, 0, 3 + 0.3 * i))));
        boxes.back()->setLinearVelocity(vec(0, 0, -20.0 * i));
    }
    for (int step = 0; step < 40; ++step)
    {
        scene.step(kStepOfRecovery);
        for (const btRigidBody* box : boxes)
        {
            const btVector3& at = box->getWorldTransform().getOrigin();
            const bool isOver = std::max(std::abs(at.x()), std::abs(at.y())) < btScalar(19.9);
            EXPECT_TRUE(!isOver || at.z() > btScalar(-0.03)) << "step " << step;
        }
    }
}

TEST_P(Recovery, OfColumnsOfMeshesThatFellOnEachOther)
{
    for (const double speed : {0.0, 5.0, 30.0})
    {
        Scene scene(GetParam(), WorldClass::Rigid);
        scene.world().setGravity(vec(0, 0, -10));
        scene.body(scene.box(vec(20, 20, 0.05)), 0.0, poseAt(vec(0, 0, -0.05)));
        std::vector<btRigidBody*> cubes;
        for (int i = 0; i < 4; ++i)
        {
            cubes.push_back(
                scene.body(scene.boxMesh(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0, 3 + 1.2 * i))));
            cubes.back()->setLinearVelocity(vec(0, 0, -speed * (i + 1)));
        }
        const auto isOverFloor = [](const btRigidBody& cube)
        {
            const btVector3& at = cube.getWorldTransform().getOrigin();
            return std::max(std::abs(at.x()), std::abs(at.y())) < btScalar(19.8);
        };
        std::vector<bool> isOver(cubes.size(), true);  // has never left
        for (int step = 0; step < 300; ++step)
        {
            scene.step(kStepOfRecovery);
            for (std::size_t i = 0; i < cubes.size(); ++i)
            {
                isOver[i] = isOver[i] && isOverFloor(*cubes[i]);
                EXPECT_TRUE(!isOver[i] ||
                            cubes[i]->getWorldTransform().getOrigin().z() > btScalar(0.09))
                    << speed << ", step " << step;
            }
        }
        // What is held does not gather speed (5 s of gravity are 50 m/s): all lie, on the floor or
        // on each other, or topple just then, but for what the fall at 120 m/s has thrown off.
        int lying = 0;
        for (std::size_t i = 0; i < cubes.size(); ++i)
        {
            lying += isOver[i] ? 1 : 0;
            EXPECT_TRUE(!isOver[i] || cubes[i]->getLinearVelocity().length() < btScalar(4))
                << speed << ", cube " << i;
        }
        EXPECT_GE(lying, speed < 30.0 ? 4 : 2) << speed;
    }
}

TEST_P(Recovery, OfAColumnOfFiveMeshesTakesNoTimeFromThemForever)
{
    // Contacts closed by what the solver leaves undone, in which each cube was held by the next.
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, -10, 0));
    scene.body(scene.box(vec(20, 0.05, 20)), 0.0, poseAt(vec(0, -0.05, 0)));
    btCollisionShape* cube = scene.boxMesh(vec(0.1, 0.1, 0.1));
    for (int i = 0; i < 5; ++i)
    {
        scene.body(cube, 1.0, poseAt(vec(0, 3 + 1.2 * i, 0)))
            ->setLinearVelocity(vec(0, -5.0 * (i + 1), 0));
    }
    for (int i = 0; i < 150; ++i)
    {
        scene.step(kStepOfRecovery);
    }
    const double before = scene.counters().m_lostTime;
    for (int i = 0; i < 60; ++i)
    {
        scene.step(kStepOfRecovery);
    }
    EXPECT_LT(scene.counters().m_lostTime - before, 0.5);  // of five body-seconds
}

TEST_P(Recovery, OfAStackOfMeshesThatRests)
{
    // Ten iterations of the solver leave a stack a little approach in every step, which closes the
    // margins: that must cost neither time nor sleep.
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, 0, -10));
    scene.body(scene.box(vec(20, 20, 0.05)), 0.0, poseAt(vec(0, 0, -0.05)));
    std::vector<btRigidBody*> cubes;
    for (int i = 0; i < 4; ++i)
    {
        cubes.push_back(scene.body(
            scene.boxMesh(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0.03 * i, 0, 0.1005 + 0.201 * i))));
        cubes.back()->forceActivationState(ACTIVE_TAG);
    }
    for (int i = 0; i < 240; ++i)
    {
        scene.step(kStepOfRecovery);
    }
    EXPECT_GT(scene.counters().m_impacts, 20);
    EXPECT_LT(scene.counters().m_lostTime, 0.2);  // of 16 body-seconds
    for (std::size_t i = 0; i < cubes.size(); ++i)
    {
        EXPECT_EQ(cubes[i]->getActivationState(), ISLAND_SLEEPING) << i;
        const btVector3& at = cubes[i]->getWorldTransform().getOrigin();
        EXPECT_NEAR(double(at.z()), 0.1005 + 0.201 * double(i), 0.002) << i;
        EXPECT_NEAR(double(at.x()), 0.03 * double(i), 0.03) << i;
    }
}

TEST_P(Recovery, OfALightMeshUnderAHeavyOne)
{
    // Pressed until their surfaces touch to the last bit, in which no query finds a direction.
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, -10, 0));
    scene.body(scene.boxMesh(vec(5, 0.05, 5)), 0.0, poseAt(vec(0, -0.05, 0)));
    scene.body(scene.boxMesh(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0.1, 0)));
    btRigidBody* heavy = scene.body(scene.boxMesh(vec(0.3, 0.3, 0.3)), 100.0, poseAt(vec(0, 6, 0)));
    heavy->setLinearVelocity(vec(0, -60, 0));
    for (int i = 0; i < 120; ++i)
    {
        scene.step(kStepOfRecovery);
        EXPECT_GT(double(heavy->getWorldTransform().getOrigin().y()), 0.299) << i;
    }
    EXPECT_LT(scene.counters().m_iterationLimits, 5);
}

TEST_P(Recovery, OfWhatAPlatformLiftsIsNone)
{
    // It starts under what lies on it, and goes up and down: Bullet puts it into them at once.
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, 0, -10));
    btRigidBody* platform = scene.body(scene.boxMesh(vec(2, 2, 0.1)), 0.0, poseAt(vec(0, 0, -0.1)));
    platform->setCollisionFlags(platform->getCollisionFlags() |
                                btCollisionObject::CF_KINEMATIC_OBJECT);
    platform->setActivationState(DISABLE_DEACTIVATION);
    btCollisionShape* mesh = scene.boxMesh(vec(0.2, 0.2, 0.2));
    btCollisionShape* box = scene.box(vec(0.2, 0.2, 0.2));
    std::vector<btRigidBody*> cargo;
    for (int i = 0; i < 6; ++i)
    {
        const double x = -1.2 + 0.5 * i;
        cargo.push_back(scene.body(i % 2 == 0 ? box : mesh, 1.0, poseAt(vec(x, 0, 0.201))));
    }
    for (int step = 0; step < 300; ++step)
    {
        const double height = 2.0 * std::sin(1.5 * step * kStepOfRecovery);
        platform->setWorldTransform(poseAt(vec(0, 0, height - 0.1)));
        scene.step(kStepOfRecovery);
        for (std::size_t i = 0; i < cargo.size(); ++i)
        {
            const btVector3& at = cargo[i]->getWorldTransform().getOrigin();
            // Shapes of Bullet sink in as deep as in the stock world.
            EXPECT_GT(double(at.z()) - height, i % 2 == 0 ? 0.14 : 0.199) << step << ", " << i;
            EXPECT_NEAR(double(at.x()), -1.2 + 0.5 * double(i), 0.1) << step << ", " << i;
        }
    }
    EXPECT_LT(scene.counters().m_lostTime, 0.5);
}

TEST_P(Recovery, OfAKinematicObjectThatJumpsIsNoSweep)
{
    for (const bool told : {false, true})
    {
        // A platform is put 40 m (told: 3 m) farther on, a ball lies as far beyond.
        const double jump = told ? 3.0 : 40.0;
        Scene scene(GetParam(), WorldClass::Rigid);
        btRigidBody* platform =
            scene.body(scene.boxMesh(vec(1, 1, 0.2)), 0.0, poseAt(vec(0, 0, 0)));
        platform->setCollisionFlags(platform->getCollisionFlags() |
                                    btCollisionObject::CF_KINEMATIC_OBJECT);
        platform->setActivationState(DISABLE_DEACTIVATION);
        btRigidBody* ball = scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.5))),
                                       1.0,
                                       poseAt(vec(1.75 * jump, 0, 0)));
        scene.step(kStepOfRecovery);
        platform->setWorldTransform(poseAt(vec(jump, 0, 0)));
        if (told)
        {
            scene.ccd().teleported(platform);
        }
        for (int i = 0; i < 10; ++i)
        {
            scene.step(kStepOfRecovery);
        }
        EXPECT_EQ(double(ball->getLinearVelocity().length()), 0.0) << told;
        EXPECT_EQ(scene.counters().m_impacts, 0) << told;
    }
}

TEST_P(Recovery, OfTheGroundThatIsReplacedAtTheSameAddress)
{
    constexpr int kSide = 65;
    std::vector<btScalar> heights(std::size_t(kSide) * kSide);
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, 0, -10));
    alignas(16) static unsigned char place[sizeof(btHeightfieldTerrainShape)];
    const auto makeTerrain = [&](btScalar level)
    {
        std::fill(heights.begin(), heights.end(), level);
        return new (place) btHeightfieldTerrainShape(
            kSide, kSide, heights.data(), 1, -50, 50, 2, PHY_FLOAT, false);
    };
    btHeightfieldTerrainShape* terrain = makeTerrain(0);
    btRigidBody* ground = scene.body(terrain, 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* box = scene.body(scene.box(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0.3, 0.2, 5)));
    for (const btScalar level : {btScalar(0), btScalar(19), btScalar(-2), btScalar(17)})
    {
        if (level != btScalar(0))
        {
            scene.world().removeRigidBody(ground);
            terrain->~btHeightfieldTerrainShape();
            terrain = makeTerrain(level);
            ground->setCollisionShape(terrain);
            scene.world().addRigidBody(ground);
        }
        box->setWorldTransform(poseAt(vec(0.3, 0.2, double(level) + 20)));
        box->setLinearVelocity(vec(0, 0, -300));
        box->setAngularVelocity(vec(0, 0, 0));
        box->activate();
        double lowest = 100.0;
        for (int i = 0; i < 20; ++i)
        {
            scene.step(kStepOfRecovery);
            lowest = std::min(lowest, double(box->getWorldTransform().getOrigin().z()));
        }
        // It may bounce, but comes down to the new ground and no deeper.
        EXPECT_GT(lowest, double(level) + 0.05);
        EXPECT_LT(lowest, double(level) + 1.0);
    }
    scene.world().removeRigidBody(ground);
    terrain->~btHeightfieldTerrainShape();
}

/// Columns of mesh cubes of which each falls faster than the one below, up to 780 m/s: what a piece
/// of such a column does for itself throws it off the floor.
TEST_P(Recovery, OfMeshesThatAreJammedAtHighSpeed)
{
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, -10, 0));
    scene.body(scene.box(vec(20, 0.05, 20)), 0.0, poseAt(vec(0, -0.05, 0)));
    btCollisionShape* cube = scene.boxMesh(vec(0.1, 0.1, 0.1));
    constexpr int kCubes = 40;
    std::vector<btRigidBody*> cubes;
    for (int i = 0; i < kCubes; ++i)
    {
        cubes.push_back(scene.body(cube, 1.0, poseAt(vec(0.5 * (i % 8) - 2.5, 3 + 0.3 * i, 0))));
        cubes.back()->setLinearVelocity(vec(0, -20 * i, 0));
    }
    for (int i = 0; i < 60; ++i)
    {
        scene.step(kStepOfRecovery);
    }
    for (const btRigidBody* body : cubes)
    {
        const btVector3& at = body->getWorldTransform().getOrigin();
        EXPECT_TRUE(std::max(std::abs(at.x()), std::abs(at.z())) < btScalar(19) &&
                    at.y() > btScalar(0.09))
            << at.x() << " " << at.y() << " " << at.z();
        // Whoever falls off a column of five has 4 m/s.
        EXPECT_LT(double(body->getLinearVelocity().length()), 8.0);
    }
}

TEST_P(Recovery, IsNotNeededByThinBoxesOnALargeStockMesh)
{
    // Bullet's contacts of these are off by more than what is thin may lose, or missing: the boxes
    // creep in, slower than anything is fast.
    TriangleMesh floor;
    floor.vertices = {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}};
    floor.triangles = {{0, 1, 2}, {0, 2, 3}};
    TriangleMesh tiles;
    constexpr int kTiles = 20;
    const double width = 4.0 / kTiles;
    for (int i = 0; i <= kTiles; ++i)
    {
        for (int j = 0; j <= kTiles; ++j)
        {
            tiles.vertices.emplace_back(width * i - 2.0, width * j - 2.0, 0.0);
        }
    }
    for (int i = 0; i < kTiles * kTiles; ++i)
    {
        const int corner = i / kTiles * (kTiles + 1) + i % kTiles;
        tiles.triangles.push_back({corner, corner + kTiles + 1, corner + kTiles + 2});
        tiles.triangles.push_back({corner, corner + kTiles + 2, corner + 1});
    }
    for (const double half : {0.0005, 0.004})
    {
        for (int seed = 0; seed < 16; ++seed)
        {
            Random random(seed);
            Scene scene(GetParam(), WorldClass::Rigid);
            scene.world().setGravity(vec(0, 0, -9.81));
            scene.body(scene.staticMesh(seed % 2 == 0 ? floor : tiles), 0.0, poseAt(vec(0, 0, 0)));
            const Eigen::Vector3d extents(0.034, 0.032, half);
            Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
            pose.linear() = random.rotation();
            pose.translation() << random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 0.1;
            const btRigidBody* box =
                scene.body(scene.box(btCcdToBullet(extents)), 0.2, btCcdToBullet(pose));
            double lowest = 1.0;  // of the core
            for (int step = 0; step < 400; ++step)
            {
                scene.step(kStepOfRecovery);
                const Eigen::Isometry3d X_WB = btCcdToEigen(box->getWorldTransform());
                const Eigen::Vector3d core = extents.array() - 0.5 * half;
                const double reach = (X_WB.linear().row(2).cwiseAbs() * core).value();
                lowest = std::min(lowest, X_WB.translation().z() - reach);
            }
            const std::string which =
                std::to_string(2.0 * half) + " m thick, seed " + std::to_string(seed);
            EXPECT_GT(double(box->getWorldTransform().getOrigin().z()), 0.0) << which;
            EXPECT_GT(lowest, 0.0) << which;
            EXPECT_EQ(scene.counters().m_overlaps, 0) << which;
        }
    }
}

/// What touches is near, and one ring is around the other, but nothing is inside.
TEST_P(Recovery, LinkedRingsAreNotInsideEachOther)
{
    for (int seed = 0; seed < 8; ++seed)
    {
        Random random(seed);
        Scene scene(GetParam(), WorldClass::Rigid);
        btCcdMeshShape* ring = scene.mesh(makeTorus(0.6, random.uniform(0.05, 0.15), 24, 8));
        const btTransform across(btQuaternion(vec(1, 0, 0), SIMD_HALF_PI), vec(0.6, 0, 0));
        btRigidBody* first = scene.body(ring, 1.0, poseAt(vec(0, 0, 0)));
        btRigidBody* second = scene.body(ring, 1.0, across);
        for (btRigidBody* body : {first, second})
        {
            const auto vector = [&] {
                return vec(
                    random.uniform(-20, 20), random.uniform(-20, 20), random.uniform(-20, 20));
            };
            body->setLinearVelocity(vector());
            body->setAngularVelocity(vector());
        }
        // Pressed together, they come nearer and nearer; in the end poses are rounded by more.
        constexpr double kRounding = 16.0 * double(std::numeric_limits<btScalar>::epsilon());
        double distance = 1.0;
        for (int step = 0; step < 60 && distance > kRounding; ++step)
        {
            scene.step(1.0 / 120.0);
            const Eigen::Isometry3d X_BA = btCcdToEigen(second->getWorldTransform()).inverse() *
                                           btCcdToEigen(first->getWorldTransform());
            distance = treeDistance(ring->tree(), ring->tree(), X_BA, 1.0).distance;
            ASSERT_GT(distance, 0.0) << "seed " << seed << ", step " << step;
        }
    }
}

/// A way that is tried in long steps leads past the gap between two walls, and through one of them.
TEST_P(Recovery, OfABarThatBeginsInOneWallOfASlot)
{
    struct Case
    {
        double clearance;
        double depth;
    };
    for (const auto& [clearance, depth] :
         {Case{1e-4, 1e-5}, Case{1e-3, 4e-4}, Case{1e-3, 3e-3}, Case{1e-2, 3e-3}})
    {
        Scene scene(GetParam(), WorldClass::Rigid);
        TriangleMesh slot;
        for (const double side : {-1.0, 1.0})
        {
            TriangleMesh wall = makeBox({0.2, 0.05, 0.1});
            const Eigen::Translation3d place(0.0, side * (0.075 + clearance), 0.0);
            transformMesh(wall, Eigen::Affine3d(place));
            appendMesh(slot, wall);
        }
        scene.body(scene.mesh(slot), 0.0, poseAt(vec(0, 0, 0)));
        btRigidBody* bar = scene.body(
            scene.boxMesh(vec(0.05, 0.025, 0.015)), 1.0, poseAt(vec(0, clearance + depth, 0)));
        double deepest = depth;
        for (int step = 0; step < 90; ++step)
        {
            scene.step(kStepOfRecovery);
            const double y = std::abs(double(bar->getWorldTransform().getOrigin().y()));
            deepest = std::max(deepest, y - clearance);
        }
        const std::string which =
            std::to_string(clearance) + " m of room, " + std::to_string(depth) + " m deep";
        EXPECT_LT(deepest, depth + 1e-4) << which;
        EXPECT_LT(std::abs(double(bar->getWorldTransform().getOrigin().y())), clearance + 1e-4)
            << which;
    }
}

TEST_P(Recovery, OfACubeInThreeWallsOfARoom)
{
    for (const double depth : {1e-4, 1.5e-3})
    {
        Scene scene(GetParam(), WorldClass::Rigid);
        TriangleMesh room;
        for (int axis = 0; axis < 3; ++axis)
        {
            TriangleMesh wall = makeBox({0.3, 0.3, 0.3});
            const Eigen::Vector3d place =
                Eigen::Vector3d::Constant(0.3) - 0.6 * Eigen::Vector3d::Unit(axis);
            transformMesh(wall, Eigen::Affine3d(Eigen::Translation3d(place)));
            appendMesh(room, wall);
        }
        scene.body(scene.mesh(room), 0.0, poseAt(vec(0, 0, 0)));
        const double place = 0.05 - depth;
        btRigidBody* cube =
            scene.body(scene.boxMesh(vec(0.05, 0.05, 0.05)), 1.0, poseAt(vec(place, place, place)));
        for (int step = 0; step < 60; ++step)
        {
            scene.step(kStepOfRecovery);
        }
        const btVector3 end = cube->getWorldTransform().getOrigin();
        EXPECT_GT(double(end[end.minAxis()]), 0.05 - 1e-5) << depth;
    }
}

TEST_P(Recovery, OfTheOthersFromAPoseThatIsNone)
{
    Scene scene(GetParam(), WorldClass::Rigid);
    scene.world().setGravity(vec(0, 0, -10));
    scene.body(scene.boxMesh(vec(1, 1, 0.1)), 0.0, poseAt(vec(0, 0, -0.1)));
    btCcdMeshShape* cube = scene.boxMesh(vec(0.1, 0.1, 0.1));
    btRigidBody* lost = scene.body(cube, 1.0, poseAt(vec(0.5, 0, 0.101)));
    btRigidBody* other = scene.body(cube, 1.0, poseAt(vec(-0.5, 0, 0.101)));
    scene.step(kStepOfRecovery);
    lost->getWorldTransform().getBasis()[1][1] = btScalar(std::nan(""));
    for (int step = 0; step < 30; ++step)
    {
        EXPECT_NO_THROW(scene.step(kStepOfRecovery));
    }
    EXPECT_NEAR(double(other->getWorldTransform().getOrigin().z()), 0.101, 1e-3);
}

/// Rings that meet on both sides come apart where they meet, and do not freeze.
TEST_P(Recovery, AChainOfRingsHangsFreely)
{
    for (int seed = 0; seed < 6; ++seed)
    {
        Random random(seed);
        const double radius = random.uniform(0.1, 0.4);
        Scene scene(GetParam(), WorldClass::Rigid);
        scene.world().setGravity(vec(0, 0, -10));
        btCcdMeshShape* ring =
            scene.mesh(makeTorus(radius, radius * random.uniform(0.1, 0.2), 20, 8));
        std::vector<btRigidBody*> rings;
        for (int i = 0; i < 4; ++i)
        {
            btTransform pose = poseAt(vec(1.3 * radius * i, 0, 0));
            pose.setRotation(btQuaternion(vec(1, 0, 0), i % 2 != 0 ? SIMD_HALF_PI : 0));
            rings.push_back(scene.body(ring, i == 0 ? 0.0 : 1.0, pose));
            if (i > 0)
            {
                const auto any = [&] { return random.uniform(-3, 3); };
                rings.back()->setLinearVelocity(vec(any(), any(), any()));
                rings.back()->setAngularVelocity(vec(5 * any(), 5 * any(), 5 * any()));
            }
        }
        int frozen = 0;
        int longest = 0;
        for (int step = 0; step < 180; ++step)
        {
            const btTransform before = rings.back()->getWorldTransform();
            scene.step(1.0 / 120.0);
            const std::string which =
                "seed " + std::to_string(seed) + ", step " + std::to_string(step);
            for (std::size_t i = 1; i < rings.size(); ++i)
            {
                const Eigen::Isometry3d X_BA =
                    btCcdToEigen(rings[i]->getWorldTransform()).inverse() *
                    btCcdToEigen(rings[i - 1]->getWorldTransform());
                ASSERT_GT(treeDistance(ring->tree(), ring->tree(), X_BA, 1.0).distance, 0.0)
                    << which << ", ring " << i;
            }
            const double moved = double(
                (rings.back()->getWorldTransform().getOrigin() - before.getOrigin()).length());
            frozen = moved < 1e-7 && rings.back()->isActive() ? frozen + 1 : 0;
            longest = std::max(longest, frozen);
        }
        EXPECT_LT(longest, 20) << "seed " << seed;
    }
}

INSTANTIATE_TEST_SUITE_P(Ours,
                         Recovery,
                         testing::ValuesIn(kOurKinds),
                         [](const testing::TestParamInfo<Kind>& test)
                         { return std::string(codeOf(test.param)); });
}  // namespace bullet_ccd::tests
