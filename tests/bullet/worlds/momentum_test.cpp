#include "benchmarks/reference/bullet/mechanics.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

enum class Form
{
    Sphere,
    Box,
    MeshBox,
    MeshBall,
};

btCollisionShape* shapeOf(Scene& scene, Form form, double size)
{
    const btVector3 half = vec(size, 0.7 * size, 0.5 * size);
    switch (form)
    {
        case Form::Sphere:
            return scene.keep(std::make_unique<btSphereShape>(btScalar(size)));
        case Form::Box:
            return scene.box(half);
        case Form::MeshBox:
            return scene.boxMesh(half);
        case Form::MeshBall:
            return scene.mesh(makeSphere(size, 1));
    }
    return nullptr;
}

struct Encounter
{
    bool collided = false;
    double linear = 0.0;  // change of the momentum, of the sum of the absolute values
    double angular = 0.0;
};

/// Two bodies of random size, mass and spin fly at each other.
Encounter meet(Kind kind,
               WorldClass worldClass,
               const std::array<Form, 2>& forms,
               std::uint64_t seed)
{
    constexpr double kTimeStep = 1.0 / 240.0;
    constexpr int kSteps = 60;
    Random random(seed);
    Scene scene(kind, worldClass);
    const double restitution = random.uniform(0.0, 1.0);
    const double friction = random.uniform(0.0, 1.0);
    const Vector3d way = random.direction();
    const double speed = random.logUniform(4.0, 20.0);
    btRigidBody* bodies[2];
    for (int i = 0; i < 2; ++i)
    {
        const double side = i == 0 ? -1.0 : 1.0;
        const double size = random.uniform(0.02, 0.05);
        Eigen::Isometry3d pose = random.pose(0.01);
        // They meet in the middle of the run.
        pose.translation() += 0.5 * side * kTimeStep * kSteps * speed * way;
        btRigidBody* body = scene.body(shapeOf(scene, forms[std::size_t(i)], size),
                                       random.logUniform(0.1, 10.0),
                                       btCcdToBullet(pose));
        body->setRestitution(btScalar(restitution));
        body->setFriction(btScalar(friction));
        body->setLinearVelocity(btCcdToBullet(Vector3d(-side * speed * way)));
        body->setAngularVelocity(btCcdToBullet(random.inBox(10.0)));
        bodies[i] = body;
    }
    const Momentum before = momentumOf(scene);
    const btVector3 velocity = bodies[0]->getLinearVelocity();
    for (int i = 0; i < kSteps; ++i)
    {
        scene.step(kTimeStep);
    }
    const Momentum after = momentumOf(scene);
    return {.collided = (bodies[0]->getLinearVelocity() - velocity).length() > btScalar(0.01),
            .linear = (after.linear - before.linear).norm() / before.linearScale,
            .angular = (after.angular - before.angular).norm() / before.angularScale};
}

/// A chain that floats and a box that flies at it.
Encounter meetChain(Kind kind, std::uint64_t seed)
{
    constexpr double kTimeStep = 1.0 / 240.0;
    constexpr double kHalf = 0.05;
    Random random(seed);
    Scene scene(kind);
    btCollisionShape* link = scene.box(vec(kHalf, 0.01, 0.01));
    btVector3 inertia;
    link->calculateLocalInertia(btScalar(1), inertia);
    auto chain = std::make_unique<btMultiBody>(2, btScalar(1), inertia, false, false);
    for (int i = 0; i < 2; ++i)
    {
        chain->setupRevolute(i,
                             btScalar(1),
                             inertia,
                             i - 1,
                             btQuaternion::getIdentity(),
                             vec(0, 0, 1),
                             vec(kHalf + 0.005, 0, 0),
                             vec(kHalf + 0.005, 0, 0),
                             true);
    }
    chain->finalizeMultiDof();
    btMultiBody* body = scene.addMultiBody(std::move(chain), link, {link, link});
    body->setJointPos(0, btScalar(random.uniform(-0.5, 0.5)));
    body->setJointPos(1, btScalar(random.uniform(-0.5, 0.5)));
    Scene::placeColliders(*body);
    btRigidBody* box =
        scene.body(scene.box(vec(0.03, 0.03, 0.03)),
                   random.uniform(0.5, 2.0),
                   poseAt(vec(random.uniform(0.0, 0.2), 0.3, 0), random.uniform(0.0, 1.0)));
    box->setLinearVelocity(vec(0, -random.uniform(4.0, 8.0), 0));
    const Momentum before = momentumOf(scene);
    const btVector3 velocity = box->getLinearVelocity();
    // A chain that tumbles loses momentum in Bullet's integrator: the same time for all, counted
    // from the collision.
    int left = 40;
    bool collided = false;
    for (; left > 0; --left)
    {
        scene.step(kTimeStep);
        if (!collided && (box->getLinearVelocity() - velocity).length() > btScalar(0.01))
        {
            collided = true;
            left = std::min(left, 4);
        }
    }
    const Momentum after = momentumOf(scene);
    return {.collided = collided,
            .linear = (after.linear - before.linear).norm() / before.linearScale,
            .angular = (after.angular - before.angular).norm() / before.angularScale};
}

constexpr std::array<std::array<Form, 2>, 6> kPairs{{{Form::Sphere, Form::Sphere},
                                                     {Form::Box, Form::Sphere},
                                                     {Form::Box, Form::Box},
                                                     {Form::MeshBox, Form::Box},
                                                     {Form::MeshBox, Form::MeshBox},
                                                     {Form::MeshBall, Form::MeshBox}}};

/// Changes in the runs in which both kinds of world had a collision.
struct Drift
{
    std::vector<double> linear;
    std::vector<double> angular;
};

void add(Drift& drift, const Encounter& encounter)
{
    drift.linear.push_back(encounter.linear);
    drift.angular.push_back(encounter.angular);
}

/// Where the momentum is small by chance its relative change is huge: a mean would tell of those
/// runs only.
double median(std::vector<double> values)
{
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

class MomentumOf : public testing::TestWithParam<Kind>
{
};
}  // namespace

TEST_P(MomentumOf, RigidBodiesThatCollideIsConserved)
{
    const double tolerance = kDouble ? 1e-6 : 1e-4;
    int collided = 0;
    int runs = 0;
    double worst = 0.0;
    for (const auto& forms : kPairs)
    {
        for (std::uint64_t seed = 1; seed <= 30; ++seed)
        {
            const WorldClass worldClass = seed % 2 == 0 ? WorldClass::Rigid : WorldClass::MultiBody;
            const Encounter encounter = meet(GetParam(), worldClass, forms, seed);
            EXPECT_LT(encounter.linear, tolerance)
                << "forms " << int(forms[0]) << ", " << int(forms[1]) << ", seed " << seed;
            worst = std::max(worst, encounter.linear);
            collided += encounter.collided ? 1 : 0;
            ++runs;
        }
    }
    std::printf("%d of %d collided, largest relative change %.1e\n", collided, runs, worst);
    EXPECT_GT(collided, 7 * runs / 10);
}

/// More bodies in touch than take part in an impact at once, some of them joined.
TEST_P(MomentumOf, WallThatIsHitIsConserved)
{
    constexpr int kWidth = 8;
    for (const WorldClass worldClass : {WorldClass::Rigid, WorldClass::MultiBody})
    {
        Scene scene(GetParam(), worldClass);
        btCollisionShape* cube = scene.box(vec(0.5, 0.5, 0.5));
        std::vector<btRigidBody*> cubes;
        for (int i = 0; i < kWidth * kWidth; ++i)
        {
            cubes.push_back(scene.body(cube, 1.0, poseAt(vec(i % kWidth, i / kWidth, 0))));
        }
        for (std::size_t i = 1; i < kWidth; ++i)
        {
            scene.addConstraint(std::make_unique<btPoint2PointConstraint>(
                *cubes[i - 1], *cubes[i], vec(0.5, 0, 0), vec(-0.5, 0, 0)));
        }
        scene.step(1.0 / 60.0);
        btRigidBody* ball = scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(1))),
                                       50.0,
                                       poseAt(vec(0.5 * kWidth, 0.4 * kWidth, 4)));
        ball->setLinearVelocity(vec(0, 0, -300));
        const Momentum before = momentumOf(scene);
        const double energy = 0.5 * 50.0 * 300.0 * 300.0;
        for (int i = 0; i < 3; ++i)
        {
            scene.step(1.0 / 60.0);
        }
        const Momentum after = momentumOf(scene);
        EXPECT_LT((after.linear - before.linear).norm() / before.linearScale,
                  kDouble ? 1e-12 : 1e-5);
        double left = 0.0;
        for (const btRigidBody* body : cubes)
        {
            left += 0.5 * double(body->getLinearVelocity().length2());
        }
        left += 25.0 * double(ball->getLinearVelocity().length2());
        EXPECT_LT(left, energy);
        EXPECT_LT(double(ball->getLinearVelocity().length()), 299.0);
        EXPECT_GT(scene.counters().m_impacts, 3);
    }
}

// Of impacts alone: Bullet's own gyroscopic terms blow up what spins by more than a radian a step.
TEST_P(MomentumOf, FastFlocksOfBoxesGainNoEnergy)
{
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
    {
        Random random(seed);
        Scene scene(GetParam());
        for (int i = 0; i < 27; ++i)
        {
            Eigen::Isometry3d pose = random.pose(0.0);
            pose.translation() = Vector3d(i % 3, (i / 3) % 3, i / 9);
            btRigidBody* body = scene.body(scene.box(vec(random.uniform(0.05, 0.2),
                                                         random.uniform(0.05, 0.2),
                                                         random.uniform(0.05, 0.2))),
                                           random.uniform(0.5, 4.5),
                                           btCcdToBullet(pose));
            const Vector3d way = Vector3d(1, 1, 1) - pose.translation() + random.direction();
            body->setLinearVelocity(btCcdToBullet(Vector3d(random.uniform(20, 286) * way)));
            body->setRestitution(btScalar(seed % 2 == 0 ? 0.73 : 0.0));
            body->setDamping(0, 0);
            body->setFlags(0);
        }
        double energy = energyOf(scene, 0.0);
        for (int i = 0; i < 30; ++i)
        {
            scene.step(1.0 / 60.0);
            const double now = energyOf(scene, 0.0);
            EXPECT_LT(now, energy * (1.0 + 1e-3)) << "seed " << seed << ", step " << i;
            energy = now;
        }
        EXPECT_GT(scene.counters().m_impacts, 0) << seed;
    }
}

TEST_P(MomentumOf, RotationIsKeptNoWorseThanInTheStockWorld)
{
    Drift stock;
    Drift ours;
    for (std::size_t pair = 0; pair < 3; ++pair)
    {
        for (std::uint64_t seed = 1; seed <= 60; ++seed)
        {
            const Encounter theirs = meet(Kind::Stock, WorldClass::Rigid, kPairs[pair], seed);
            const Encounter mine = meet(GetParam(), WorldClass::Rigid, kPairs[pair], seed);
            if (theirs.collided && mine.collided)
            {
                add(stock, theirs);
                add(ours, mine);
            }
        }
    }
    ASSERT_GT(ours.angular.size(), 30U);
    std::printf("median relative change of angular momentum in %zu runs: stock %.2e, ours %.2e\n",
                ours.angular.size(),
                median(stock.angular),
                median(ours.angular));
    EXPECT_LE(median(ours.angular), 1.05 * median(stock.angular));
}

TEST_P(MomentumOf, FloatingChainIsKeptNoWorseThanInTheStockWorld)
{
    Drift stock;
    Drift ours;
    for (std::uint64_t seed = 1; seed <= 400; ++seed)
    {
        const Encounter theirs = meetChain(Kind::Stock, seed);
        const Encounter mine = meetChain(GetParam(), seed);
        if (theirs.collided && mine.collided)
        {
            add(stock, theirs);
            add(ours, mine);
        }
    }
    ASSERT_GT(ours.linear.size(), 100U);
    std::printf(
        "median relative change in %zu runs: linear stock %.2e, ours %.2e; angular stock %.2e, "
        "ours %.2e\n",
        ours.linear.size(),
        median(stock.linear),
        median(ours.linear),
        median(stock.angular),
        median(ours.angular));
    EXPECT_LE(median(ours.linear), 1.05 * median(stock.linear) + 1e-6);
    EXPECT_LE(median(ours.angular), 1.05 * median(stock.angular) + 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Ours,
                         MomentumOf,
                         testing::ValuesIn(kOurKinds),
                         [](const testing::TestParamInfo<Kind>& test)
                         { return std::string(codeOf(test.param)); });
}  // namespace bullet_ccd::tests
