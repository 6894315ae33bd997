/// Soft bodies dropped onto things: stock Bullet lets them through, the solver does not.
#include "benchmarks/reference/bullet/soft_scene.h"
#include "benchmarks/reference/scenes/deforming_scenes.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/btCcdAction.h"
#include "bullet_ccd/bullet/btCcdControl.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/bullet/recording_drawer.h"
#include "tests/support/test_data.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <gmock/gmock.h>
#include <limits>
#include <memory>
#include <new>
#include <numbers>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace
{
constexpr double kRest = 1e-3;  // the separation by default

Isometry3d at(double x, double y, double z)
{
    Isometry3d X = Isometry3d::Identity();
    X.translation() = Vector3d(x, y, z);
    return X;
}

/// A square in the plane y = 0.
TriangleMesh plate(int cells, double half)
{
    TriangleMesh mesh = sheet(cells);
    for (Vector3d& v : mesh.vertices)
    {
        v = half * Vector3d(2.0 * v.x() - 1.0, 0.0, 1.0 - 2.0 * v.y());
    }
    return mesh;
}

enum class Floor
{
    Box,
    Mesh,
    StockMesh,
    Plane,
    Sphere,
};

struct StockMesh
{
    btTriangleMesh m_triangles;
    std::unique_ptr<btBvhTriangleMeshShape> m_shape;
};

void addFloor(SoftScene& scene, Floor floor)
{
    static std::vector<std::unique_ptr<btTriangleMesh>> kept;
    const TriangleMesh mesh = plate(20, 1.0);
    switch (floor)
    {
        case Floor::Box:
            scene.obstacle(std::make_unique<btBoxShape>(btVector3(1, btScalar(0.0025), 1)),
                           plate(1, 1.0));
            break;
        case Floor::Mesh:
            scene.obstacle(btCcdMeshShape::fromMesh(mesh), mesh);
            break;
        case Floor::StockMesh:
            kept.push_back(std::make_unique<btTriangleMesh>());
            for (const Triangle& t : mesh.triangles)
            {
                kept.back()->addTriangle(btCcdToBullet(mesh.vertices[std::size_t(t[0])]),
                                         btCcdToBullet(mesh.vertices[std::size_t(t[1])]),
                                         btCcdToBullet(mesh.vertices[std::size_t(t[2])]));
            }
            scene.obstacle(std::make_unique<btBvhTriangleMeshShape>(kept.back().get(), true), mesh);
            break;
        case Floor::Plane:
            scene.obstacle(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)),
                           plate(1, 50.0));
            break;
        case Floor::Sphere:
            // What is judged is inscribed.
            scene.obstacle(std::make_unique<btSphereShape>(btScalar(0.3)), makeSphere(0.3, 2));
            break;
    }
}

struct Drop
{
    Floor floor;
    double speed;  // [m/s]
    double timeStep;
    int cloths = 1;
    int cells = 9;
    double seconds = 0.3;

    [[nodiscard]] std::string text() const
    {
        return "floor " + std::to_string(int(floor)) + ", " + std::to_string(speed) + " m/s, 1/" +
               std::to_string(int(1.0 / timeStep + 0.5)) + " s, " + std::to_string(cloths) +
               " cloths";
    }
};

SoftVerdict fall(SoftWorld kind, const Drop& drop)
{
    SoftScene scene(kind);
    addFloor(scene, drop.floor);
    for (int k = 0; k < drop.cloths; ++k)
    {
        btSoftBody* cloth = scene.cloth(at(0, 0.5 + 0.05 * k, 0), 1.4, drop.cells, 5.0);
        cloth->setVelocity(btVector3(0, btScalar(-drop.speed * (k == 0 ? 1.0 : 1.5)), 0));
    }
    for (int i = 0; i < int(drop.seconds / drop.timeStep + 0.5); ++i)
    {
        scene.step(drop.timeStep);
    }
    return scene.judge();
}

double height(const btSoftBody& body, bool lowest)
{
    double y = double(body.m_nodes[0].m_x.y());
    for (int i = 1; i < body.m_nodes.size(); ++i)
    {
        const double other = double(body.m_nodes[i].m_x.y());
        y = lowest ? std::min(y, other) : std::max(y, other);
    }
    return y;
}

Vector3d middle(const btSoftBody& body)
{
    Vector3d sum = Vector3d::Zero();
    for (int i = 0; i < body.m_nodes.size(); ++i)
    {
        sum += btCcdToEigen(body.m_nodes[i].m_x);
    }
    return sum / body.m_nodes.size();
}

constexpr bool kIsSingle = sizeof(btScalar) == 4;

/// A box of 1 kg that lies on a cloth, in gravity that leans by `slope` from their normal.
struct Slide
{
    bool isPinned;  ///< all nodes of the cloth; else it lies on a rough floor
    bool isMesh;    ///< the box is; then its friction is the solver's alone
    double slope;
    double friction;
    SoftWorld kind = SoftWorld::Solver;
};

struct Slid
{
    double m_way = 0.0;  // [m], along the slope
    double m_expected = 0.0;
    double m_height = 0.0;  // above where it has been put [m]
    double m_sideways = 0.0;
    btCcdSoftCounters m_counters;
};

Slid slid(const Slide& slide, int steps)
{
    const double dt = 1.0 / 60.0;
    SoftScene scene(
        slide.kind,
        btVector3(
            btScalar(10.0 * std::sin(slide.slope)), btScalar(-10.0 * std::cos(slide.slope)), 0));
    if (!slide.isPinned)
    {
        addFloor(scene, Floor::Plane);
        scene.world().getCollisionObjectArray()[0]->setFriction(10);
    }
    const double ofCloth = slide.isPinned ? 0.0 : kRest;
    btSoftBody* cloth = scene.cloth(at(0, ofCloth, 0), 3.0, 15, 2.0);
    cloth->m_cfg.kDF = 1;
    for (int i = 0; i < cloth->m_nodes.size() && slide.isPinned; ++i)
    {
        cloth->setMass(i, 0);
    }
    const Vector3d half(0.3, 0.1, 0.3);
    std::unique_ptr<btCollisionShape> shape = std::make_unique<btBoxShape>(btCcdToBullet(half));
    if (slide.isMesh)
    {
        shape = btCcdMeshShape::fromMesh(makeBox(half));
    }
    const Vector3d start(-0.5, half.y() + ofCloth + kRest, 0.03);
    btRigidBody* box =
        scene.obstacle(std::move(shape), makeBox(half), at(-0.5, start.y(), 0.03), 1.0);
    box->setFriction(btScalar(slide.friction));
    box->setActivationState(DISABLE_DEACTIVATION);
    for (int i = 0; i < steps; ++i)
    {
        scene.step(dt);
    }
    const Vector3d way = btCcdToEigen(box->getWorldTransform().getOrigin()) - start;
    const double pull = std::sin(slide.slope) - slide.friction * std::cos(slide.slope);
    const double t = steps * dt;
    EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
    return {.m_way = way.x(),
            .m_expected = std::max(0.0, 5.0 * pull * t * (t + dt)),  // of velocities before places
            .m_height = way.y(),
            .m_sideways = way.z(),
            .m_counters = scene.solver()->getCcdSoftCounters()};
}
}  // namespace

TEST(SoftDrops, StockBulletLetsAFastClothThroughEverything)
{
    for (const Floor floor : {Floor::Box, Floor::StockMesh, Floor::Mesh})
    {
        const Drop drop{.floor = floor, .speed = 20.0, .timeStep = 1.0 / 60.0};
        EXPECT_EQ(fall(SoftWorld::Stock, drop).through, 10 * 10) << drop.text();
    }
    const Drop two{.floor = Floor::Mesh, .speed = 20.0, .timeStep = 1.0 / 60.0, .cloths = 2};
    EXPECT_EQ(fall(SoftWorld::Stock, two).through, 2 * 10 * 10);
}

TEST(SoftDrops, NothingGoesThrough)
{
    for (const Floor floor :
         {Floor::Box, Floor::Mesh, Floor::StockMesh, Floor::Plane, Floor::Sphere})
    {
        const Drop drop{.floor = floor, .speed = 20.0, .timeStep = 1.0 / 60.0};
        const SoftVerdict verdict = fall(SoftWorld::Solver, drop);
        EXPECT_TRUE(verdict.isClean()) << drop.text() << ": " << verdict;
    }
}

TEST(SoftDrops, NorClothThroughClothNorItself)
{
    for (const SoftWorld kind : {SoftWorld::Solver, SoftWorld::World})
    {
        const Drop drop{.floor = Floor::Mesh, .speed = 20.0, .timeStep = 1.0 / 60.0, .cloths = 2};
        const SoftVerdict verdict = fall(kind, drop);
        EXPECT_EQ(verdict.through, 0);
        EXPECT_EQ(verdict.crossing, 0);
        EXPECT_EQ(verdict.notFinite, 0);
    }
}

TEST(SoftDrops, TheWorldDoesNotCallItsSoftBodiesUncovered)
{
    testing::internal::CaptureStderr();
    SoftScene scene(SoftWorld::World);
    addFloor(scene, Floor::Box);
    btRigidBody* bar = scene.obstacle(std::make_unique<btBoxShape>(btVector3(2, 1, 2) / 20),
                                      makeBox({0.1, 0.05, 0.1}),
                                      at(0, 0.3, 0),
                                      1.0);
    bar->setAngularVelocity(btVector3(0, 20, 0));
    scene.cloth(at(0.01, 0.02, 0.1), 1.0, 4, 1.0)->appendDeformableAnchor(12, bar);
    RecordingDrawer drawer;
    scene.world().setDebugDrawer(&drawer);
    for (int i = 0; i < 10; ++i)
    {
        scene.step(1.0 / 60.0);
        scene.world().debugDrawWorld();
    }
    scene.world().setDebugDrawer(nullptr);
    const auto& control = dynamic_cast<btCcdControl&>(scene.world());
    EXPECT_EQ(control.getCcdCounters().m_unsupported, 0);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(SoftDrops, AnActionSaysThatItLeavesSoftBodiesToBullet)
{
    testing::internal::CaptureStderr();
    SoftScene scene(SoftWorld::Stock);
    scene.cloth(at(0, 1, 0), 1.0, 4, 1.0);
    btCcdAction action(&scene.world());
    scene.world().addAction(&action);
    scene.step(1.0 / 60.0);
    scene.world().removeAction(&action);
    EXPECT_EQ(action.getCcdCounters().m_unsupported, 1);
    EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("is not covered"));

    // Beside the solver of the library it has nothing to say.
    testing::internal::CaptureStderr();
    SoftScene covered(SoftWorld::Solver);
    covered.cloth(at(0, 1, 0), 1.0, 4, 1.0);
    btCcdAction other(&covered.world());
    covered.world().addAction(&other);
    covered.step(1.0 / 60.0);
    covered.world().removeAction(&other);
    EXPECT_EQ(other.getCcdCounters().m_unsupported, 0);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(SoftDrops, LongNothingGoesThroughAtAnySpeed)
{
    if (!longTests())
    {
        GTEST_SKIP() << "long";
    }
    for (const Floor floor :
         {Floor::Box, Floor::Mesh, Floor::StockMesh, Floor::Plane, Floor::Sphere})
    {
        for (const double speed : {5.0, 20.0, 50.0})
        {
            for (const double rate : {30.0, 60.0, 240.0})
            {
                for (const int cloths : {1, 2})
                {
                    const Drop drop{.floor = floor,
                                    .speed = speed,
                                    .timeStep = 1.0 / rate,
                                    .cloths = cloths,
                                    .cells = 15,
                                    .seconds = 0.5};
                    const SoftVerdict verdict = fall(SoftWorld::Solver, drop);
                    EXPECT_EQ(verdict.through, 0) << drop.text();
                    EXPECT_EQ(verdict.crossing, 0) << drop.text();
                    EXPECT_EQ(verdict.notFinite, 0) << drop.text();
                }
            }
        }
    }
}

TEST(SoftDrops, AClothRestsAtTheSeparation)
{
    for (const Floor floor : {Floor::Mesh, Floor::Plane})
    {
        SoftScene scene(SoftWorld::Solver);
        addFloor(scene, floor);
        btSoftBody* cloth = scene.cloth(at(0.01, 0.02, 0), 1.0, 8, 1.0);
        for (int i = 0; i < 60; ++i)
        {
            scene.step(1.0 / 60.0);
        }
        const Vector3d before = middle(*cloth);
        scene.solver()->resetCcdSoftCounters();
        for (int i = 0; i < 60; ++i)
        {
            scene.step(1.0 / 60.0);
        }
        EXPECT_NEAR(height(*cloth, true), kRest, 0.02 * kRest);
        EXPECT_NEAR(height(*cloth, false), kRest, 0.02 * kRest);
        EXPECT_LT((middle(*cloth) - before).norm(), 1e-5);
        // One question for what is near and one for the answer in each step.
        EXPECT_EQ(scene.solver()->getCcdSoftCounters().m_queries, 120);
        EXPECT_EQ(scene.solver()->getCcdSoftCounters().m_held, 0);
    }
}

TEST(SoftDrops, FrictionHoldsOnASlopeUpToItsCoefficient)
{
    // Gravity leans by `slope` from the normal of the plane.
    const auto slide = [](double slope)
    {
        SoftScene scene(
            SoftWorld::Solver,
            btVector3(btScalar(10 * std::sin(slope)), btScalar(-10 * std::cos(slope)), 0));
        addFloor(scene, Floor::Plane);
        btSoftBody* cloth = scene.cloth(at(0, kRest, 0), 0.5, 4, 1.0);
        scene.world().getCollisionObjectArray()[0]->setFriction(1);
        cloth->m_cfg.kDF = btScalar(0.5);
        for (int i = 0; i < 60; ++i)
        {
            scene.step(1.0 / 60.0);
        }
        return middle(*cloth).x();
    };
    EXPECT_LT(slide(std::atan(0.45)), 2e-3);
    // x = (sin - mu cos) g t^2 / 2 after a second, less or more by what a step adds.
    const double steep = std::atan(1.0);
    EXPECT_NEAR(slide(steep), 5.0 * (std::sin(steep) - 0.5 * std::cos(steep)), 0.1);
}

// What is held must neither stick nor creep: paths that are only shortened lose their slide, too.
// The pinned cloth has nothing that could give way: once a box fell through it.
TEST(SoftDrops, ABoxOnAClothSlidesOnlyBeyondItsFriction)
{
    for (const SoftWorld kind : {SoftWorld::Solver, SoftWorld::World})
    {
        for (const bool isPinned : {true, false})
        {
            for (const bool isMesh : {true, false})
            {
                const auto tell = [&](const Slid& result)
                {
                    return testing::Message()
                           << "world " << int(kind) << (isPinned ? ", pinned" : ", on a floor")
                           << (isMesh ? ", mesh: " : ", box: ") << result.m_way << " m, expected "
                           << result.m_expected;
                };
                const Slid rests = slid({isPinned, isMesh, std::atan(0.3), 0.4, kind}, 60);
                EXPECT_LT(std::abs(rests.m_way), 2e-3) << tell(rests);
                EXPECT_LT(std::abs(rests.m_height), 2e-4) << tell(rests);
                const Slid slides = slid({isPinned, isMesh, std::atan(0.7), 0.4, kind}, 30);
                // On a floor Bullet's contacts with it hold the box in the first steps.
                EXPECT_NEAR(slides.m_way, slides.m_expected, isPinned ? 2e-3 : 5e-2)
                    << tell(slides);
                EXPECT_LT(std::abs(slides.m_height), 4e-4) << tell(slides);
                EXPECT_LT(std::abs(slides.m_sideways), 3e-3) << tell(slides);
                for (const Slid& result : {rests, slides})
                {
                    EXPECT_EQ(result.m_counters.m_held, 0) << tell(result);
                    EXPECT_EQ(result.m_counters.m_heldBodies, 0) << tell(result);
                }
                EXPECT_LE(rests.m_counters.m_queries, 60 * 2 + 6) << tell(rests);
            }
        }
    }
}

// Nodes that are pinned move as they are told; so does what lies on them, as fast as friction has
// it.
TEST(SoftDrops, APinnedClothThatMovesIsABelt)
{
    SoftScene scene(SoftWorld::Solver);
    btSoftBody* cloth = scene.cloth(at(0, 0, 0), 4.0, 20, 1.0);
    cloth->m_cfg.kDF = 1;
    btRigidBody* box = scene.obstacle(std::make_unique<btBoxShape>(btVector3(2, 1, 2) / 10),
                                      makeBox({0.2, 0.1, 0.2}),
                                      at(-1, 0.1 + kRest, 0),
                                      1.0);
    box->setFriction(btScalar(0.3));
    for (int i = 0; i < 30; ++i)
    {
        for (int k = 0; k < cloth->m_nodes.size(); ++k)
        {
            cloth->setMass(k, 0);
            cloth->m_nodes[k].m_v = btVector3(btScalar(0.5), 0, 0);
        }
        scene.step(1.0 / 60.0);
        const double speed = std::min(3.0 * (i + 1) / 60.0, 0.5);  // mu g t
        EXPECT_NEAR(double(box->getLinearVelocity().x()), speed, 0.01) << i;
    }
    EXPECT_NEAR(double(box->getWorldTransform().getOrigin().y()), 0.1 + kRest, 1e-4);
}

// A cloth under a box slides with it where the floor is smoother than the box.
TEST(SoftDrops, ABoxAndTheClothBelowItSlideOnAFloor)
{
    const double slope = 0.3;
    for (const double friction : {0.0, 0.2})
    {
        SoftScene scene(
            SoftWorld::Solver,
            btVector3(btScalar(10.0 * std::sin(slope)), btScalar(-10.0 * std::cos(slope)), 0));
        addFloor(scene, Floor::Plane);
        scene.world().getCollisionObjectArray()[0]->setFriction(btScalar(friction));
        btSoftBody* cloth = scene.cloth(at(0, kRest, 0), 0.6, 8, 0.4);
        cloth->m_cfg.kDF = 1;
        const Vector3d half(0.15, 0.1, 0.15);
        btRigidBody* box = scene.obstacle(std::make_unique<btBoxShape>(btCcdToBullet(half)),
                                          makeBox(half),
                                          at(0, 0.1 + 2 * kRest, 0),
                                          5.0);
        box->setFriction(btScalar(0.8));
        for (int i = 0; i < 60; ++i)
        {
            scene.step(1.0 / 60.0);
        }
        const double expected =
            5.0 * (std::sin(slope) - friction * std::cos(slope)) * (1.0 + 1.0 / 60.0);
        EXPECT_NEAR(double(box->getWorldTransform().getOrigin().x()), expected, 0.04 * expected);
        EXPECT_NEAR(middle(*cloth).x(), expected, 0.04 * expected);
    }
}

// Between a heavy body and a floor, light nodes pass on what presses them, through layers as well.
TEST(SoftDrops, AHeavyBoxOnLightClothsComesToRest)
{
    for (const int cloths : {1, 3})
    {
        SoftScene scene(SoftWorld::Solver);
        addFloor(scene, Floor::Box);
        const btSoftBody* lowest = scene.cloth(at(0, 0.01, 0), 0.8, 10, 0.5);
        for (int k = 1; k < cloths; ++k)
        {
            scene.cloth(at(0, 0.01 + 0.005 * k, 0), 0.8, 10, 0.5);
        }
        const Vector3d half(0.15, 0.1, 0.15);
        btRigidBody* box = scene.obstacle(std::make_unique<btBoxShape>(btCcdToBullet(half)),
                                          makeBox(half),
                                          at(0.02, 0.15, 0.01),
                                          200.0);
        box->setActivationState(DISABLE_DEACTIVATION);
        for (int i = 0; i < 60; ++i)
        {
            scene.step(1.0 / 60.0);
        }
        const btVector3 before = box->getWorldTransform().getOrigin();
        scene.solver()->resetCcdSoftCounters();
        for (int i = 0; i < 60; ++i)
        {
            scene.step(1.0 / 60.0);
        }
        EXPECT_LT(double((box->getWorldTransform().getOrigin() - before).length()), 5e-4) << cloths;
        EXPECT_LT(double(box->getLinearVelocity().length()), 0.01) << cloths;
        EXPECT_EQ(scene.solver()->getCcdSoftCounters().m_heldBodies, 0) << cloths;
        EXPECT_LE(scene.solver()->getCcdSoftCounters().m_queries, 60 * 3) << cloths;
        EXPECT_TRUE(scene.judge().isClean()) << scene.judge() << ", " << cloths;
        EXPECT_GT(height(*lowest, true), 0.0025) << cloths;
    }
}

// A body on layers slips a little while it comes to rest, less and less: sweeps end when none
// changes a distance by more than a thousandth of the separation. It is the response alone that
// holds it: Bullet's own contacts of soft bodies with each other once pushed a box on five cloths
// by 2 mm/s.
TEST(SoftDrops, ABoxOnClothsDoesNotCreep)
{
    for (const int cloths : longTests() ? std::vector{1, 3, 5, 10} : std::vector{5})
    {
        SoftScene scene(SoftWorld::Solver);
        addFloor(scene, Floor::Plane);
        for (int k = 0; k < cloths; ++k)
        {
            scene.cloth(at(0.004 * k, 0.01 + 0.005 * k, 0.003 * k), 0.8, 10, 0.5);
        }
        const Vector3d half(0.15, 0.1, 0.15);
        btRigidBody* box = scene.obstacle(std::make_unique<btBoxShape>(btCcdToBullet(half)),
                                          makeBox(half),
                                          at(0.02, 0.4, 0.01),
                                          0.5);
        box->setActivationState(DISABLE_DEACTIVATION);
        std::vector<Vector3d> places;  // after each second
        for (int second = 0; second < 4; ++second)
        {
            for (int i = 0; i < 60; ++i)
            {
                scene.step(1.0 / 60.0);
            }
            places.push_back(btCcdToEigen(box->getWorldTransform().getOrigin()));
        }
        const auto way = [&](std::size_t from, std::size_t to)
        { return (places[to] - places[from]).norm(); };
        EXPECT_LT(way(1, 3), 0.2 * kRest) << cloths;
        EXPECT_LT(way(2, 3), std::max(way(1, 2), 1e-5)) << cloths << ": it drifts";
        EXPECT_TRUE(scene.judge().isClean()) << scene.judge() << ", " << cloths;
        EXPECT_TRUE(scene.world().getSoftBodyArray()[0]->isActive()) << "it slept within the step";
    }
}

// Bullet's solver is told what the cloth carries: the upper box has its weight on the lower one.
TEST(SoftDrops, ABoxSlidesOnABoxThatAClothCarries)
{
    const double slope = 0.5;
    SoftScene scene(
        SoftWorld::World,
        btVector3(btScalar(10.0 * std::sin(slope)), btScalar(-10.0 * std::cos(slope)), 0));
    btSoftBody* cloth = scene.cloth(at(0, 0, 0), 3.0, 15, 3.0);
    cloth->m_cfg.kDF = 1;
    for (int i = 0; i < cloth->m_nodes.size(); ++i)
    {
        cloth->setMass(i, 0);
    }
    const Vector3d lowerHalf(0.4, 0.1, 0.3);
    const Vector3d upperHalf(0.1, 0.1, 0.1);
    btRigidBody* lower = scene.obstacle(std::make_unique<btBoxShape>(btCcdToBullet(lowerHalf)),
                                        makeBox(lowerHalf),
                                        at(0, 0.1 + kRest, 0),
                                        4.0);
    btRigidBody* upper = scene.obstacle(std::make_unique<btBoxShape>(btCcdToBullet(upperHalf)),
                                        makeBox(upperHalf),
                                        at(-0.2, 0.3 + 2 * kRest, 0),
                                        1.0);
    lower->setFriction(3);
    upper->setFriction(0);
    lower->setActivationState(DISABLE_DEACTIVATION);
    upper->setActivationState(DISABLE_DEACTIVATION);
    for (int i = 0; i < 24; ++i)
    {
        scene.step(1.0 / 60.0);
    }
    const double slides = double(upper->getWorldTransform().getOrigin().x()) + 0.2;
    EXPECT_NEAR(slides / (5.0 * std::sin(slope) * 0.4 * (0.4 + 1.0 / 60.0)), 1.0, 0.12);
    EXPECT_LT(std::abs(double(lower->getWorldTransform().getOrigin().x())), 1e-3);
    EXPECT_NEAR(double(upper->getWorldTransform().getOrigin().y() -
                       lower->getWorldTransform().getOrigin().y()),
                0.2,
                5e-3);
}

TEST(SoftDrops, HingedBoxesOnAClothComeToRest)
{
    SoftScene scene(SoftWorld::World);
    addFloor(scene, Floor::Plane);
    scene.cloth(at(0, 0.02, 0), 1.5, 12, 0.5);
    const Vector3d half(0.1, 0.05, 0.1);
    std::vector<btRigidBody*> boxes;
    std::vector<std::unique_ptr<btHingeConstraint>> hinges;
    for (int i = 0; i < 4; ++i)
    {
        boxes.push_back(scene.obstacle(std::make_unique<btBoxShape>(btCcdToBullet(half)),
                                       makeBox(half),
                                       at(-0.36 + 0.24 * i, 0.15, 0),
                                       1.0));
        if (i > 0)
        {
            hinges.push_back(std::make_unique<btHingeConstraint>(*boxes[std::size_t(i - 1)],
                                                                 *boxes[std::size_t(i)],
                                                                 btVector3(btScalar(0.12), 0, 0),
                                                                 btVector3(btScalar(-0.12), 0, 0),
                                                                 btVector3(0, 0, 1),
                                                                 btVector3(0, 0, 1)));
            scene.world().addConstraint(hinges.back().get(), true);
        }
    }
    double fastest = 0.0;
    for (int i = 0; i < 90; ++i)
    {
        scene.step(1.0 / 60.0);
        for (const btRigidBody* box : boxes)
        {
            const double speed = double(box->getLinearVelocity().length());
            fastest = i < 60 ? 0.0 : std::max(fastest, speed);
        }
    }
    EXPECT_LT(fastest, 0.05);  // [m/s]
    EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
    for (const std::unique_ptr<btHingeConstraint>& hinge : hinges)
    {
        scene.world().removeConstraint(hinge.get());
    }
}

TEST(SoftDrops, BouncesAsFastAsRestitutionSays)
{
    SoftScene scene(SoftWorld::Solver, btVector3(0, 0, 0));
    addFloor(scene, Floor::Plane);
    btSoftBody* cloth = scene.cloth(at(0, 0.1, 0), 0.5, 2, 1.0);
    scene.world().getCollisionObjectArray()[0]->setRestitution(btScalar(0.8));
    cloth->setRestitution(btScalar(0.5));
    cloth->setVelocity(btVector3(0, -10, 0));
    for (int i = 0; i < 3; ++i)
    {
        scene.step(1.0 / 60.0);
    }
    for (int i = 0; i < cloth->m_nodes.size(); ++i)
    {
        EXPECT_NEAR(double(cloth->m_nodes[i].m_v.y()), 4.0, 0.02);
    }
}

TEST(SoftDrops, TheMomentumOfAPairIsConserved)
{
    // In no gravity: what is left of the momentum of both is rounding.
    const auto change = [](const auto& addOther, SoftWorld kind)
    {
        SoftScene scene(kind, btVector3(0, 0, 0));
        addOther(scene);
        btSoftBody* cloth = scene.cloth(at(0.03, 0.4, 0.02), 1.0, 8, 2.0);
        cloth->setVelocity(btVector3(1, -15, btScalar(0.5)));
        const Vector3d before = scene.momentum();
        // Also where the cloth is crumpled: Bullet's own test of soft bodies does not conserve it.
        for (int i = 0; i < 30; ++i)
        {
            scene.step(1.0 / 60.0);
        }
        EXPECT_GT(scene.solver()->getCcdSoftCounters().m_contacts, 100);
        EXPECT_EQ(scene.judge().through, 0);
        return (scene.momentum() - before).norm() / before.norm();
    };
    const double rounding = kIsSingle ? 2e-5 : 1e-12;
    for (const SoftWorld kind : {SoftWorld::Solver, SoftWorld::World})
    {
        EXPECT_LT(change([](SoftScene& scene) { scene.cloth(at(0, 0, 0), 1.0, 7, 3.0); }, kind),
                  rounding);
        EXPECT_LT(change(
                      [](SoftScene& scene)
                      {
                          const TriangleMesh ball = makeSphere(0.2, 2);
                          scene.obstacle(btCcdMeshShape::fromMesh(ball), ball, at(0, 0, 0), 1.0);
                      },
                      kind),
                  rounding);
        EXPECT_LT(change([](SoftScene& scene) { scene.block(at(0, 0, 0), 0.3, 3, 4.0); }, kind),
                  rounding);
    }
}

// Also where a step has to hold the body back: it is slowed by what it pushes, and by nothing else.
TEST(SoftDrops, TheMomentumOfABodyThatIsHeldBackIsConserved)
{
    struct Throw
    {
        double speed;  // [m/s]
        double timeStep;
    };
    std::int64_t heldBodies = 0;
    const auto meet = [&](bool isCloth, double mass, const Throw& thrown, double spin, int boxes)
    {
        SoftScene scene(isCloth ? SoftWorld::Solver : SoftWorld::World, btVector3(0, 0, 0));
        isCloth ? scene.cloth(at(0, 0, 0), 1.0, 12, 1.0) : scene.block(at(0, 0, 0), 0.4, 3, 1.0);
        const Vector3d half(0.15, 0.1, 0.12);
        for (int i = 0; i < boxes;
             ++i)  // Meshes, with which soft bodies have no contacts of Bullet's.
        {
            btRigidBody* box = scene.obstacle(btCcdMeshShape::fromMesh(makeBox(half)),
                                              makeBox(half),
                                              at(0.02, 0.45 + 0.21 * i, 0.01),
                                              mass);
            box->setActivationState(DISABLE_DEACTIVATION);
            box->setLinearVelocity(
                btVector3(btScalar(0.3), btScalar(-thrown.speed), btScalar(0.2)));
            box->setAngularVelocity(btScalar(spin) *
                                    btVector3(1, btScalar(1.0 / 3.0), btScalar(-0.5)));
        }
        const Vector3d before = scene.momentum();
        double most = 0.0;
        for (int i = 0; i < int(0.2 / thrown.timeStep); ++i)
        {
            scene.step(thrown.timeStep);
            most = std::max(most, (scene.momentum() - before).norm() / before.norm());
        }
        heldBodies += scene.solver()->getCcdSoftCounters().m_heldBodies;
        EXPECT_GT(scene.solver()->getCcdSoftCounters().m_contacts, 0);
        EXPECT_EQ(scene.judge().through, 0);
        EXPECT_LT(most, kIsSingle ? 5e-6 : 1e-12)
            << (isCloth ? "cloth" : "volume") << ", " << mass << " kg, " << thrown.speed
            << " m/s, steps of 1/" << 1.0 / thrown.timeStep << " s, spin " << spin << ", " << boxes
            << " boxes";
    };
    // (Slow enough that Bullet's springs do not throw nodes, which does not conserve it either.)
    for (const Throw& thrown :
         {Throw{3.0, 1.0 / 60.0}, Throw{8.0, 1.0 / 60.0}, Throw{20.0, 1.0 / 240.0}})
    {
        for (const double mass : {0.5, 2.0, 10.0})
        {
            for (const bool isCloth : {true, false})
            {
                meet(isCloth, mass, thrown, 0.0, 1);
                meet(isCloth, mass, thrown, 15.0, 1);
            }
        }
    }
    meet(true, 2.0, {3.0, 1.0 / 30.0}, 15.0, 1);
    meet(true, 10.0, {8.0, 1.0 / 30.0}, 0.0, 1);
    meet(true, 2.0, {8.0, 1.0 / 60.0}, 0.0, 3);
    EXPECT_GT(heldBodies, 100);
}

TEST(SoftDrops, ALinkIsPushedAlongItsJoint)
{
    SoftScene scene(SoftWorld::Solver, btVector3(0, 0, 0));
    const TriangleMesh box = makeBox({0.4, 0.05, 0.4});
    btMultiBody* slider = scene.slider(btCcdMeshShape::fromMesh(box), box, 1.0);
    slider->setLinearDamping(0);
    btSoftBody* cloth = scene.cloth(at(0.03, 0.3, 0.02), 0.6, 6, 2.0);
    cloth->setVelocity(btVector3(0, -10, 0));
    const Vector3d before = scene.momentum();
    for (int i = 0; i < 10; ++i)
    {
        scene.step(1.0 / 60.0);
    }
    EXPECT_LT(double(slider->getJointVel(0)), -1.0);
    EXPECT_LT(std::abs(scene.momentum().y() - before.y()), (kIsSingle ? 1e-4 : 1e-9) * 20.0);
    EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
}

TEST(SoftDrops, RopesAndVolumesStayOutside)
{
    for (const double speed : {5.0, 20.0})
    {
        SoftScene scene(SoftWorld::Solver);
        addFloor(scene, Floor::Sphere);
        addFloor(scene, Floor::Plane);
        btSoftBody* rope = scene.rope(at(0.01, 0.8, 0.03), 1.5, 20, 0.5);
        btSoftBody* block = scene.block(at(0.05, 1.2, 0.02), 0.2, 3, 1.0);
        rope->setVelocity(btVector3(0, btScalar(-speed), 0));
        block->setVelocity(btVector3(0, btScalar(-speed), 0));
        for (int i = 0; i < 30; ++i)
        {
            scene.step(1.0 / 60.0);
            // The rope has no face; a link must not come nearer to the centre than the sphere
            // allows. (The floor cuts the sphere in half.)
            for (int k = 0; k < rope->m_links.size(); ++k)
            {
                const Vector3d a = btCcdToEigen(rope->m_links[k].m_n[0]->m_x);
                const Vector3d b = btCcdToEigen(rope->m_links[k].m_n[1]->m_x);
                const double t = std::clamp(-a.dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
                ASSERT_GT((a + t * (b - a)).norm(), 0.3) << "step " << i << ", link " << k;
            }
        }
        EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
    }
}

TEST(SoftDrops, WhatMovesThroughAHangingClothTakesItAlong)
{
    for (const bool isKinematic : {false, true})
    {
        SoftScene scene(SoftWorld::Solver);
        Isometry3d X = at(0, 1, 0);
        X.linear() =
            Eigen::AngleAxisd(std::numbers::pi / 2.0, Vector3d::UnitX()).toRotationMatrix();
        btSoftBody* cloth = scene.cloth(X, 1.0, 10, 1.0);
        cloth->setMass(0, 0);
        cloth->setMass(10, 0);
        const TriangleMesh ball = makeSphere(0.1, 2);
        btRigidBody* body =
            scene.obstacle(btCcdMeshShape::fromMesh(ball), ball, at(0.02, 1, 2), 1.0);
        if (isKinematic)
        {
            body->setCollisionFlags(body->getCollisionFlags() |
                                    btCollisionObject::CF_KINEMATIC_OBJECT);
            body->setActivationState(DISABLE_DEACTIVATION);
        }
        body->setLinearVelocity(btVector3(0, 0, -30));
        for (int i = 0; i < 6; ++i)
        {
            if (isKinematic)
            {
                btTransform pose = body->getWorldTransform();
                pose.getOrigin().setZ(pose.getOrigin().z() - btScalar(0.5));
                body->setWorldTransform(pose);
            }
            scene.step(1.0 / 60.0);
        }
        const SoftVerdict verdict = scene.judge();
        EXPECT_EQ(verdict.through, 0) << isKinematic;
        EXPECT_EQ(verdict.crossing, 0) << isKinematic;
        EXPECT_EQ(scene.solver()->getCcdSoftCounters().m_squeezed, 0);
        EXPECT_LT(height(*cloth, true), 1.0);
        EXPECT_LT(middle(*cloth).z(), -0.05) << isKinematic;
    }
}

TEST(SoftDrops, AnchoredNodesStayOnTheirBody)
{
    // A cloth swings down from a bar that is carried on.
    SoftScene scene(SoftWorld::Solver);
    const btVector3 half(btScalar(0.6), btScalar(0.05), btScalar(0.05));
    btRigidBody* bar = scene.obstacle(
        std::make_unique<btBoxShape>(half), makeBox({0.59, 0.04, 0.04}), at(0, 0.4, 0), 1.0);
    bar->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    bar->setActivationState(DISABLE_DEACTIVATION);
    btSoftBody* cloth = scene.cloth(at(0, 0.4, 0.55), 1.0, 8, 0.5);
    for (int i = 0; i < cloth->m_nodes.size(); ++i)
    {
        if (cloth->m_nodes[i].m_x.z() < btScalar(0.06))
        {
            cloth->appendDeformableAnchor(i, bar);
        }
    }
    ASSERT_EQ(cloth->m_deformableAnchors.size(), 9);
    for (int i = 0; i < 60; ++i)
    {
        btTransform pose = bar->getWorldTransform();
        pose.getOrigin() += btVector3(btScalar(0.01), 0, btScalar(0.02));
        bar->setWorldTransform(pose);
        scene.step(1.0 / 60.0);
    }
    EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
    for (int i = 0; i < cloth->m_deformableAnchors.size(); ++i)
    {
        const btSoftBody::DeformableNodeRigidAnchor& anchor = cloth->m_deformableAnchors[i];
        EXPECT_LT((bar->getWorldTransform() * anchor.m_local - anchor.m_node->m_x).length(),
                  btScalar(1e-5));
    }
}

/// A bar that turns and carries a cloth by a few nodes.
struct Carried
{
    Vector3d half;
    double mass;  ///< 0: the bar is kinematic
    int cells;
    double side;
    double ofCloth;  ///< [kg]
    Vector3d velocity;
    Vector3d turn;
    std::vector<int> anchors;
};

// An anchored node cannot evade, but its body can be held back, or takes along what the node meets.
// Once such a node pulled an edge of its cloth through another one.
TEST(SoftDrops, AnAnchoredNodeGoesThroughNothing)
{
    const Carried dynamic{.half = {0.1737, 0.1087, 0.1839},
                          .mass = 3.191,
                          .cells = 10,
                          .side = 0.9002,
                          .ofCloth = 2.488,
                          .velocity = {-3.806, 0.1827, 3.831},
                          .turn = {1.748, 5.992, -3.340},
                          .anchors = {37, 49, 60, 61, 70}};
    const Carried kinematic{.half = {0.3344, 0.05093, 0.1809},
                            .mass = 0.0,
                            .cells = 11,
                            .side = 1.175,
                            .ofCloth = 0.6452,
                            .velocity = {0.468, -0.3674, 0.8298},
                            .turn = {-1.756, 0.447, 0.8205},
                            .anchors = {52, 55}};
    for (const Carried& c : {dynamic, kinematic})
    {
        SoftScene scene(SoftWorld::World);
        btRigidBody* bar = scene.obstacle(std::make_unique<btBoxShape>(btCcdToBullet(c.half)),
                                          makeBox(c.half),
                                          at(0, 0.4, 0),
                                          std::max(c.mass, 1.0));
        bar->setActivationState(DISABLE_DEACTIVATION);
        btSoftBody* cloth =
            scene.cloth(at(0, 0.4 + c.half.y() + kRest, 0), c.side, c.cells, c.ofCloth);
        for (const int node : c.anchors)
        {
            cloth->appendDeformableAnchor(node, bar);
        }
        if (c.mass > 0.0)
        {
            bar->setLinearVelocity(btCcdToBullet(c.velocity));
            bar->setAngularVelocity(btCcdToBullet(c.turn));
        }
        else
        {
            bar->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        }
        for (int i = 0; i < 30; ++i)
        {
            if (c.mass == 0.0 && i > 0)
            {
                btTransform pose = bar->getWorldTransform();
                pose.getOrigin() += btCcdToBullet(Vector3d(c.velocity / 30.0));
                const btQuaternion turn(btCcdToBullet(Vector3d(c.turn.normalized())),
                                        btScalar(c.turn.norm() / 30.0));
                pose.setRotation((turn * pose.getRotation()).normalized());
                bar->setWorldTransform(pose);
            }
            scene.step(1.0 / 30.0);
            ASSERT_EQ(scene.judge().crossing, 0) << "mass " << c.mass << ", step " << i;
        }
        EXPECT_GT(scene.solver()->getCcdSoftCounters().m_contacts, 0);
    }
}

// A body pushes what it stands on with the nodes that hang on it, too. Once only the free nodes
// beside them could answer, by ways a hundred times as long: the body got 20 m/s.
TEST(SoftDrops, ABodyStandsOnTheNodesThatHangOnIt)
{
    for (const SoftWorld kind : {SoftWorld::Solver, SoftWorld::World})
    {
        SoftScene scene(kind);
        addFloor(scene, Floor::Box);
        btSoftBody* cloth = scene.cloth(at(0, 0.01, 0), 0.8, 10, 0.5);
        const Vector3d half(0.1, 0.1, 0.1);
        btRigidBody* box = scene.obstacle(
            std::make_unique<btBoxShape>(btCcdToBullet(half)), makeBox(half), at(0, 0.15, 0), 1.0);
        box->setActivationState(DISABLE_DEACTIVATION);
        for (int i = 0; i < 90; ++i)
        {
            if (i == 45)
            {
                cloth->appendDeformableAnchor(60, box);  // in the middle
            }
            scene.step(1.0 / 60.0);
            if (i >= 44)
            {
                const btVector3 place = box->getWorldTransform().getOrigin();
                EXPECT_NEAR(double(place.y()), 0.1025 + 2 * kRest, 1e-3) << i;
                EXPECT_LT(std::hypot(double(place.x()), double(place.z())), 2e-3) << i;
                EXPECT_LT(double(box->getLinearVelocity().length()), 0.05) << i;
                ASSERT_FALSE(HasFailure()) << int(kind);
            }
        }
        EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
    }
}

// The same of a link: once it was held back in every step, and its speed grew on.
TEST(SoftDrops, ALinkStandsOnTheNodesThatHangOnIt)
{
    SoftScene scene(SoftWorld::Solver);
    addFloor(scene, Floor::Box);
    const TriangleMesh box = makeBox({0.1, 0.1, 0.1});
    btMultiBody* press = scene.slider(btCcdMeshShape::fromMesh(box), box, 1.0);
    press->setJointPos(0, btScalar(0.4));
    scene.step(1e-3);  // The link is where it has been put before there is a cloth.
    btSoftBody* cloth = scene.cloth(at(0, 0.298, 0), 0.15, 4, 0.1);
    for (int i = 0; i < cloth->m_nodes.size(); ++i)
    {
        cloth->appendDeformableAnchor(i, press->getLink(0).m_collider);
    }
    for (int i = 0; i < 90; ++i)
    {
        scene.step(1.0 / 60.0);
        EXPECT_LT(std::abs(double(press->getJointVel(0))), i < 45 ? 3.0 : 0.05) << i;
    }
    EXPECT_NEAR(double(press->getJointPos(0)), 0.1045 + kRest, kRest);
    EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
}

TEST(SoftDrops, ABallOnAClothOnAFloorSqueezesNothingThrough)
{
    for (const SoftWorld kind : {SoftWorld::Solver, SoftWorld::World})
    {
        SoftScene scene(kind);
        addFloor(scene, Floor::Box);
        scene.cloth(at(0, 0.01, 0), 0.8, 10, 0.5);
        btRigidBody* body = scene.obstacle(std::make_unique<btSphereShape>(btScalar(0.1)),
                                           makeSphere(0.1, 2),
                                           at(0.02, 0.3, 0.01),
                                           2.0);
        body->setLinearVelocity(btVector3(0, -20, 0));
        for (int i = 0; i < 40; ++i)
        {
            scene.step(1.0 / 60.0);
        }
        EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
        EXPECT_EQ(scene.solver()->getCcdSoftCounters().m_squeezed, 0);
        EXPECT_NEAR(double(body->getWorldTransform().getOrigin().y()), 0.106, 0.005);
        // What it meets first stops it: nothing beside that throws it aside.
        EXPECT_NEAR(double(body->getWorldTransform().getOrigin().x()), 0.02, 0.05);
        EXPECT_NEAR(double(body->getWorldTransform().getOrigin().z()), 0.01, 0.05);
    }
}

// A press that outweighs the cloth by far: as a link it has to be held back as a body is.
TEST(SoftDrops, ALinkThatPressesAClothOnAFloorSqueezesNothingThrough)
{
    SoftScene scene(SoftWorld::Solver);
    const TriangleMesh floor = plate(20, 1.0);
    scene.obstacle(btCcdMeshShape::fromMesh(floor), floor);
    const TriangleMesh box = makeBox({0.2, 0.02, 0.2});
    btMultiBody* press = scene.slider(btCcdMeshShape::fromMesh(box), box, 50.0);
    press->setJointPos(0, btScalar(0.4));
    scene.step(1e-3);  // The link is where it has been put before there is a cloth.
    scene.cloth(at(0.01, 0.1, 0.02), 0.6, 8, 0.1);
    press->setJointVel(0, btScalar(-20));
    for (int i = 0; i < 40; ++i)
    {
        scene.step(1.0 / 60.0);
    }
    EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
    EXPECT_EQ(scene.solver()->getCcdSoftCounters().m_squeezed, 0);
    EXPECT_GT(double(press->getJointPos(0)), 0.021);
    EXPECT_LT(double(press->getJointPos(0)), 0.05);  // the cloth has folds
}

// Once the link fell through: none of the nodes could give way, so nothing was answered.
TEST(SoftDrops, ALinkStopsAtAPinnedCloth)
{
    SoftScene scene(SoftWorld::Solver);
    const TriangleMesh box = makeBox({0.1, 0.05, 0.1});
    btMultiBody* press = scene.slider(btCcdMeshShape::fromMesh(box), box, 1.0);
    press->setJointPos(0, btScalar(0.2));
    scene.step(1e-3);  // The link is where it has been put before there is a cloth.
    btSoftBody* cloth = scene.cloth(at(0, 0, 0), 1.0, 6, 1.0);
    for (int i = 0; i < cloth->m_nodes.size(); ++i)
    {
        cloth->setMass(i, 0);
    }
    for (int i = 0; i < 60; ++i)
    {
        scene.step(1.0 / 60.0);
    }
    EXPECT_NEAR(double(press->getJointPos(0)), 0.05 + kRest, kRest);
    EXPECT_NEAR(double(press->getJointVel(0)), 0.0, 0.05);
    EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
}

/// A plate of 60 cm, 4 cm thick, that goes where it is put.
btRigidBody* addLift(SoftScene& scene)
{
    const btVector3 half(btScalar(0.3), btScalar(0.02), btScalar(0.3));
    btRigidBody* lift =
        scene.obstacle(std::make_unique<btBoxShape>(half), makeBox(btCcdToEigen(half)));
    lift->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    lift->setActivationState(DISABLE_DEACTIVATION);
    return lift;
}

// Between the lift and a box that is free nothing has to be squeezed: the box gives way.
TEST(SoftDrops, ALiftTakesAlongWhatLiesOnTheClothThatLiesOnIt)
{
    for (const SoftWorld kind : {SoftWorld::Solver, SoftWorld::World})
    {
        SoftScene scene(kind);
        btRigidBody* lift = addLift(scene);
        btSoftBody* cloth = scene.cloth(at(0, 0.04, 0), 0.5, 8, 0.2);
        btRigidBody* box =
            scene.obstacle(std::make_unique<btBoxShape>(btVector3(1, 1, 1) * btScalar(0.1)),
                           makeBox({0.1, 0.1, 0.1}),
                           at(0, 0.15, 0),
                           1.0);
        for (int i = 0; i < 90; ++i)
        {
            const double y = 0.3 * std::sin(std::max(0.0, 2.0 * (i - 30) / 60.0));
            lift->setWorldTransform(btCcdToBullet(at(0, y, 0)));
            scene.step(1.0 / 60.0);
            const double top = y + 0.02;
            EXPECT_GT(height(*cloth, true), top) << i;
            EXPECT_GT(double(box->getWorldTransform().getOrigin().y()) - 0.1, top) << i;
            ASSERT_FALSE(HasFailure()) << int(kind);
        }
        EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
        EXPECT_EQ(scene.solver()->getCcdSoftCounters().m_squeezed, 0);
    }
}

// A cloth holds back the lower box, of which Bullet's solver knows nothing: the upper one must not
// sink into it, nor be lost when a lift takes both along.
TEST(SoftDrops, ABoxOnABoxOnAClothDoesNotSinkIn)
{
    for (const SoftWorld kind : {SoftWorld::Solver, SoftWorld::World})
    {
        SoftScene scene(kind);
        btRigidBody* lift = addLift(scene);
        scene.cloth(at(0, 0.04, 0), 0.5, 8, 0.2);
        std::vector<btRigidBody*> boxes;
        for (const double y : {0.15, 0.36})
        {
            boxes.push_back(
                scene.obstacle(std::make_unique<btBoxShape>(btVector3(1, 1, 1) * btScalar(0.1)),
                               makeBox({0.1, 0.1, 0.1}),
                               at(0, y, 0),
                               5.0));
        }
        for (int i = 0; i < 120; ++i)
        {
            const double y = 0.2 * std::sin(std::max(0.0, 2.0 * (i - 60) / 60.0));
            lift->setWorldTransform(btCcdToBullet(at(0, y, 0)));
            scene.step(1.0 / 60.0);
            const btVector3 between = boxes[1]->getWorldTransform().getOrigin() -
                                      boxes[0]->getWorldTransform().getOrigin();
            // Bullet's own contacts see what moves slowly a step late: an approach of 1 m/s.
            EXPECT_GT(double(between.y()), i == 59 || i == 119 ? 0.198 : 0.183) << i;
            ASSERT_FALSE(HasFailure()) << int(kind);
        }
        EXPECT_TRUE(scene.judge().isClean()) << scene.judge();
        EXPECT_EQ(scene.solver()->getCcdSoftCounters().m_squeezed, 0);
        for (const btRigidBody* box : boxes)  // Of the lift's 0.4 m/s at most, nothing is gathered.
        {
            EXPECT_LT(double(box->getLinearVelocity().length()), 0.7) << int(kind);
        }
    }
}

// Where a node meets a rim, no contact has the normal of a surface.
TEST(SoftDrops, ANodeStopsAtARim)
{
    // A cloth flies against the rim of another in the same plane with one corner.
    SoftScene scene(SoftWorld::Solver, btVector3(0, 0, 0));
    btSoftBody* wall = scene.cloth(at(0, 0, 0), 1.0, 2, 1.0);
    Isometry3d X = at(-1.3, 0, 0.2);
    X.linear() = Eigen::AngleAxisd(0.25 * std::numbers::pi, Vector3d::UnitY()).toRotationMatrix();
    btSoftBody* cloth = scene.cloth(X, 1.0, 2, 1.0);
    for (const btSoftBody* body : {wall, cloth})
    {
        ASSERT_EQ(body->m_nodes.size(), 9);
    }
    for (int i = 0; i < wall->m_nodes.size(); ++i)
    {
        wall->setMass(i, 0);
    }
    cloth->setVelocity(btVector3(10, 0, 0));
    for (int i = 0; i < 3; ++i)
    {
        scene.step(1.0 / 60.0);
        for (int k = 0; k < cloth->m_nodes.size(); ++k)
        {
            EXPECT_LT(cloth->m_nodes[k].m_x.x(), btScalar(-0.5)) << i;
        }
    }
    EXPECT_GT(scene.solver()->getCcdSoftCounters().m_rounds, 0);
}

TEST(SoftDrops, TwoRopesMeetHeadOn)
{
    SoftScene scene(SoftWorld::Solver, btVector3(0, 0, 0));
    const btSoftBody* wall = scene.rope(at(0.6, 0, 0), 1.0, 5, 1.0);
    btSoftBody* rope = scene.rope(at(-0.6, 0, 0), 1.0, 5, 1.0);
    rope->setVelocity(btVector3(20, 0, 0));
    scene.step(1.0 / 60.0);
    for (int i = 0; i < wall->m_nodes.size(); ++i)
    {
        for (int k = 0; k < rope->m_nodes.size(); ++k)
        {
            EXPECT_LT(rope->m_nodes[k].m_x.x(), wall->m_nodes[i].m_x.x()) << i << " " << k;
        }
    }
}

TEST(SoftDrops, AFlatClothDoesNotFoldWithinItsPlane)
{
    SoftScene scene(SoftWorld::Solver, btVector3(0, 0, 0));
    btSoftBody* cloth = scene.cloth(at(0, 0, 0), 1.0, 4, 1.0);
    cloth->setSelfCollision(true);
    // A node of the rim, across the row behind it in one step.
    cloth->m_nodes[2].m_v = btVector3(0, 0, 18);
    const auto doubleArea = [&](int i)
    {
        const btSoftBody::Face& face = cloth->m_faces[i];
        return (face.m_n[1]->m_x - face.m_n[0]->m_x).cross(face.m_n[2]->m_x - face.m_n[0]->m_x).y();
    };
    const btScalar side = doubleArea(0);
    scene.step(1.0 / 60.0);
    for (int i = 0; i < cloth->m_faces.size(); ++i)
    {
        EXPECT_GT(doubleArea(i) * side, btScalar(0)) << i;
    }
    EXPECT_GT(cloth->m_nodes[2].m_x.z(), btScalar(-0.45));
}

TEST(SoftDrops, AStepWithoutContactIsBulletsOwn)
{
    SoftScene stock(SoftWorld::Stock);
    SoftScene solver(SoftWorld::Solver);
    for (SoftScene* scene : {&stock, &solver})
    {
        addFloor(*scene, Floor::Mesh);
        scene->cloth(at(0, 5, 0), 1.0, 6, 1.0)->setMass(0, 0);
        for (int i = 0; i < 20; ++i)
        {
            scene->step(1.0 / 60.0);
        }
    }
    const btSoftBody& a = *stock.world().getSoftBodyArray()[0];
    const btSoftBody& b = *solver.world().getSoftBodyArray()[0];
    for (int i = 0; i < a.m_nodes.size(); ++i)
    {
        EXPECT_EQ(a.m_nodes[i].m_x, b.m_nodes[i].m_x);
        EXPECT_EQ(a.m_nodes[i].m_v, b.m_nodes[i].m_v);
    }
}

/// A cloth that hits a ball: later an edge of it comes over the rim of one of its faces. All that
/// is near then has a normal that leans, which is of no use as an answer, but it is there.
TEST(SoftDrops, WhatComesOverTheRimOfAFaceIsSeen)
{
    Random random(241 * 7919);
    Isometry3d X = Isometry3d::Identity();
    X.linear() =
        Eigen::AngleAxisd(random.uniform(-0.3, 0.3), random.direction()).toRotationMatrix();
    const double size = random.uniform(0.2, 0.4);
    SoftScene scene(SoftWorld::World);
    scene.obstacle(std::make_unique<btSphereShape>(btScalar(size)), makeSphere(size, 2), X);
    static_cast<void>(random.integer(1, 3));
    X.linear() =
        Eigen::AngleAxisd(random.uniform(-0.2, 0.2), random.direction()).toRotationMatrix();
    X.translation() = Vector3d(random.uniform(-0.1, 0.1), 0.5, random.uniform(-0.1, 0.1));
    btSoftBody* body = scene.cloth(
        X, random.uniform(0.5, 1.2), random.integer(3, 16), random.logUniform(0.2, 5.0));
    body->m_cfg.kDF = btScalar(random.uniform(0.0, 0.8));
    body->setVelocity(btVector3(btScalar(random.uniform(-3.0, 3.0)),
                                btScalar(-random.uniform(0.0, 50.0)),
                                btScalar(random.uniform(-3.0, 3.0))));
    for (int i = 0; i < 15; ++i)
    {
        scene.step(1.0 / 30.0);
        EXPECT_EQ(scene.judge().crossing, 0) << "step " << i;
    }
    EXPECT_GT(scene.solver()->getCcdSoftCounters().m_contacts, 0);
}

TEST(SoftDrops, ContactsAndBentPathsAreDrawn)
{
    for (const SoftWorld kind : {SoftWorld::Solver, SoftWorld::World})
    {
        SoftScene scene(kind);
        addFloor(scene, Floor::Mesh);
        scene.cloth(at(0.01, 0.1, 0), 1.0, 4, 1.0)->setVelocity(btVector3(0, -20, 0));
        RecordingDrawer drawer;
        scene.solver()->debugDraw(&drawer);
        EXPECT_TRUE(drawer.m_lines.empty()) << "no step yet";
        scene.step(1.0 / 60.0);
        scene.world().setDebugDrawer(&drawer);
        kind == SoftWorld::World ? scene.world().debugDrawWorld()
                                 : scene.solver()->debugDraw(&drawer);
        const std::vector<std::pair<Vector3d, Vector3d>> red = drawer.linesOf({1, 0, 0});
        const std::vector<std::pair<Vector3d, Vector3d>> yellow = drawer.linesOf({1, 1, 0});
        scene.world().setDebugDrawer(nullptr);
        ASSERT_GE(red.size(), 2U * 25U);
        for (std::size_t i = 0; i < red.size(); i += 2)
        {
            // From the closest point on one to that on the other, and the normal.
            EXPECT_NEAR(std::abs(red[i].first.y() - red[i].second.y()), kRest, 0.5 * kRest);
            const Vector3d normal = red[i + 1].second - red[i + 1].first;
            EXPECT_NEAR(std::abs(normal.normalized().y()), 1.0, 1e-3);
        }
        ASSERT_EQ(yellow.size(), 25U);
        for (const auto& [from, to] : yellow)
        {
            EXPECT_NEAR(from.y(), 0.1, 1e-3);
            EXPECT_NEAR(to.y(), kRest, 0.2 * kRest);
        }
    }
}

/// While it lives, Bullet's objects come from one block of memory, upwards or downwards.
class Addresses
{
public:
    explicit Addresses(bool areFalling) : m_block(kBytes), m_areFalling(areFalling)
    {
        s_used = this;
        btAlignedAllocSetCustomAligned([](std::size_t size, int alignment) -> void*
                                       { return s_used->take(size, std::size_t(alignment)); },
                                       [](void*) {});
    }
    ~Addresses() { btAlignedAllocSetCustomAligned(nullptr, nullptr); }
    Addresses(const Addresses&) = delete;
    Addresses& operator=(const Addresses&) = delete;

private:
    static constexpr std::size_t kBytes = std::size_t(64) << 20U;
    inline static Addresses* s_used = nullptr;
    std::vector<std::byte> m_block;
    std::size_t m_taken = 0;
    bool m_areFalling;

    void* take(std::size_t size, std::size_t alignment)
    {
        m_taken += size + 2 * alignment;
        if (m_taken > kBytes)
        {
            throw std::bad_alloc();
        }
        std::byte* const begin =
            m_block.data() + (m_areFalling ? kBytes - m_taken : m_taken - size - alignment);
        std::size_t space = size + alignment;
        void* aligned = begin;
        return std::align(alignment, size, aligned, space);
    }
};

/// A cloth on many boxes, of which some move: every order of contacts and bodies plays a part. The
/// boxes are meshes and the cloth does not meet itself, because stock contacts depend on addresses.
std::vector<btVector3> placesOfClothOnBoxes(int threads = 1)
{
    SoftScene scene(SoftWorld::Solver);
    scene.solver()->setCcdThreads(threads);
    const TriangleMesh mesh = makeBox({0.08, 0.05, 0.08});
    for (int i = 0; i < 16; ++i)
    {
        scene.obstacle(btCcdMeshShape::fromMesh(mesh),
                       mesh,
                       at(0.25 * (i % 4) - 0.375, 0, 0.25 * (i / 4) - 0.375),
                       i % 3 == 1 ? 1.0 : 0.0);
    }
    btSoftBody* cloth = scene.cloth(at(0, 0.06, 0), 1.0, 9, 1.0);
    cloth->setVelocity(btVector3(0, -5, 0));
    cloth->setSelfCollision(false);
    for (int i = 0; i < 60; ++i)
    {
        scene.step(1.0 / 60.0);
    }
    EXPECT_GT(scene.solver()->getCcdSoftCounters().m_contacts, 1000);
    const btCollisionObjectArray& objects = scene.world().getCollisionObjectArray();
    std::vector<btVector3> places;
    for (int i = 0; i < objects.size(); ++i)
    {
        places.push_back(objects[i]->getWorldTransform().getOrigin());
    }
    for (int i = 0; i < cloth->m_nodes.size(); ++i)
    {
        places.push_back(cloth->m_nodes[i].m_x);
    }
    return places;
}

TEST(SoftDrops, TheOutcomeDoesNotDependOnAddresses)
{
    std::array<std::vector<btVector3>, 2> places;
    for (const bool areFalling : {false, true})
    {
        const Addresses addresses(areFalling);
        places[areFalling ? 1 : 0] = placesOfClothOnBoxes();
    }
    EXPECT_EQ(places[0], places[1]);
}

TEST(SoftDrops, TheOutcomeDoesNotDependOnThreads)
{
    EXPECT_EQ(placesOfClothOnBoxes(1), placesOfClothOnBoxes(2));
}

// Programs put things back where they began, at rest or thrown: nothing is swept on the way there.
TEST(SoftDrops, ResetsAreNoMotion)
{
    SoftScene scene(SoftWorld::World);
    addFloor(scene, Floor::Box);
    btSoftBody* cloth = scene.cloth(at(0, 0.1, 0), 0.8, 10, 0.5);
    std::vector<btVector3> places;
    for (int k = 0; k < cloth->m_nodes.size(); ++k)
    {
        places.push_back(cloth->m_nodes[k].m_x);
    }
    btRigidBody* ball = scene.obstacle(
        std::make_unique<btSphereShape>(btScalar(0.1)), makeSphere(0.1, 2), at(0, 0.5, 0), 1.0);
    ball->setActivationState(DISABLE_DEACTIVATION);
    for (int round = 0; round < 4; ++round)
    {
        for (int i = 0; i < 40; ++i)
        {
            scene.step(1.0 / 60.0);
            EXPECT_GT(height(*cloth, true), 0.0025) << round;
            EXPECT_GT(double(ball->getWorldTransform().getOrigin().y()), 0.1025) << round;
            ASSERT_FALSE(HasFailure()) << i;
        }
        // By turns where it began, below the ball, and above where the ball has been.
        const btVector3 up(0, btScalar(round % 2 == 0 ? 0.4 : 0.0), 0);
        for (int k = 0; k < cloth->m_nodes.size(); ++k)
        {
            btSoftBody::Node& node = cloth->m_nodes[k];
            node.m_x = node.m_q = places[std::size_t(k)] + up;
            node.m_v.setZero();
            node.m_vn.setZero();
        }
        ball->setWorldTransform(btCcdToBullet(at(0, 0.9, 0)));
        ball->setInterpolationWorldTransform(ball->getWorldTransform());
        ball->setLinearVelocity(btVector3(0, btScalar(round % 2 == 0 ? -30 : 0), 0));
        ball->setAngularVelocity(btVector3(0, 0, 0));
        scene.solver()->resetCcdSoftCounters();
    }
    EXPECT_EQ(scene.judge().crossing, 0);
}

// What carries a body is remembered from step to step. Another one at the same address once got it.
TEST(SoftDrops, ABodyInThePlaceOfARemovedOneIsNotCarried)
{
    SoftScene scene(SoftWorld::Solver);
    btSoftBody* cloth = scene.cloth(at(0, 0, 0), 1.0, 8, 1.0);
    for (int i = 0; i < cloth->m_nodes.size(); ++i)
    {
        cloth->setMass(i, 0);
    }
    const btVector3 half(btScalar(0.1), btScalar(0.1), btScalar(0.1));
    btRigidBody* box = scene.obstacle(
        std::make_unique<btBoxShape>(half), makeBox({0.1, 0.1, 0.1}), at(0, 0.105, 0), 1.0);
    for (int i = 0; i < 60; ++i)
    {
        scene.step(1.0 / 60.0);
    }
    EXPECT_NEAR(double(box->getLinearVelocity().y()), 0.0, 0.05);
    scene.world().removeRigidBody(box);
    btCollisionShape* shape = box->getCollisionShape();
    box->~btRigidBody();
    new (box) btRigidBody(btScalar(1), nullptr, shape);
    box->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 5, 0)));
    scene.world().addRigidBody(box);
    scene.step(1.0 / 60.0);
    EXPECT_NEAR(double(box->getWorldTransform().getOrigin().y()), 5.0 - 10.0 / 3600.0, 1e-6);
}

// Where Bullet's solver diverges it throws nodes; when it integrates, it cuts their velocity to
// what m_maxDisplacement allows. What they hit once got the impulse of all of it.
TEST(SoftDrops, AThrownNodePushesWithTheSpeedThatBulletLeavesIt)
{
    SoftScene scene(SoftWorld::Solver, btVector3(0, 0, 0));
    const double dt = 1.0 / 60.0;
    scene.world().getWorldInfo().m_maxDisplacement = btScalar(0.5);
    btRigidBody* ball = scene.obstacle(
        std::make_unique<btSphereShape>(btScalar(0.2)), makeSphere(0.2, 2), at(0, -0.25, 0), 1.0);
    btSoftBody* cloth = scene.cloth(at(0, 0, 0), 0.1, 1, 0.1);
    scene.step(dt);
    scene.solver()->predictMotion(btScalar(dt));
    cloth->setVelocity(btVector3(0, btScalar(-1e7), 0));  // as the solver might
    scene.solver()->applyTransforms(btScalar(dt));
    const double momentum = 0.1 * 0.5 / dt;
    EXPECT_LT(double(ball->getLinearVelocity().length()), 1.0001 * momentum);
    EXPECT_GT(double(ball->getLinearVelocity().length()), 0.1 * momentum);
}

// As many faces as before, of other nodes: once the surface was still the old one.
TEST(SoftDrops, FacesThatAreReplacedInPlaceAreSeen)
{
    SoftScene scene(SoftWorld::Solver, btVector3(0, 0, 0));
    btSoftBody* cloth = scene.cloth(at(0, 0, 0), 1.0, 8, 1.0);
    btSoftBody::tFaceArray left;
    btSoftBody::tFaceArray right;
    for (int i = 0; i < cloth->m_nodes.size(); ++i)
    {
        cloth->setMass(i, 0);
    }
    for (int i = 0; i < cloth->m_faces.size(); ++i)
    {
        const btSoftBody::Face& face = cloth->m_faces[i];
        const btScalar x = face.m_n[0]->m_x.x() + face.m_n[1]->m_x.x() + face.m_n[2]->m_x.x();
        (x < btScalar(0) ? left : right).push_back(face);
    }
    ASSERT_EQ(left.size(), right.size());
    btVector3 middleOfFace(0, btScalar(0.1), 0);
    for (const btSoftBody::Node* node : right[0].m_n)
    {
        middleOfFace += node->m_x / btScalar(3);
    }
    cloth->m_faces = left;
    btRigidBody* ball = scene.obstacle(std::make_unique<btSphereShape>(btScalar(0.02)),
                                       makeSphere(0.02, 1),
                                       Isometry3d(Eigen::Translation3d(btCcdToEigen(middleOfFace))),
                                       1.0);
    scene.step(1.0 / 60.0);
    cloth->m_faces = right;
    ball->setLinearVelocity(btVector3(0, -20, 0));
    scene.step(1.0 / 60.0);
    EXPECT_GT(double(ball->getWorldTransform().getOrigin().y()), 0.02);
}

TEST(SoftDrops, BadInputIsRefusedOrLeftToBullet)
{
    SoftScene scene(SoftWorld::Solver);
    EXPECT_THROW(scene.solver()->setCcdSeparation(0.0), std::invalid_argument);
    EXPECT_THROW(scene.solver()->setCcdSeparation(std::nan("")), std::invalid_argument);
    EXPECT_THROW(scene.solver()->setCcdThreads(0), std::invalid_argument);
    {
        SoftScene sick(SoftWorld::Solver);
        addFloor(sick, Floor::Mesh);
        sick.cloth(at(0, 0.1, 0), 0.5, 3, 1.0)
            ->m_nodes[0]
            .m_v.setX(std::numeric_limits<btScalar>::quiet_NaN());
        testing::internal::CaptureStderr();
        sick.step(1.0 / 60.0);
        EXPECT_THAT(testing::internal::GetCapturedStderr(),
                    testing::HasSubstr("a soft body of 16 nodes has places or velocities that are "
                                       "not finite"));
    }
    addFloor(scene, Floor::Mesh);
    btSoftBody* well = scene.cloth(at(0, 0.1, 0), 0.5, 3, 1.0);
    well->setVelocity(btVector3(0, -20, 0));
    for (int i = 0; i < 5; ++i)
    {
        scene.step(1.0 / 60.0);
    }
    EXPECT_NEAR(height(*well, true), kRest, 0.2 * kRest);
    // A link and a face more: another surface.
    well->appendNode(btVector3(0, btScalar(0.2), 0), btScalar(0.01));
    well->appendLink(0, well->m_nodes.size() - 1);
    for (int i = 0; i < 30; ++i)
    {
        scene.step(1.0 / 60.0);
    }
    EXPECT_GT(height(*well, true), 0.4 * kRest);
}
}  // namespace bullet_ccd::tests
