#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/make_mesh.h"
#include "tests/bullet/mechanics.h"
#include "tests/support/random.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace bullet_ccd::tests
{
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
    double linear = 0.0;   // change of the momentum, of the sum of the absolute values
    double angular = 0.0;
};

/// Two bodies of random size, mass and spin fly at each other.
Encounter meet(Kind kind, WorldClass worldClass, const std::array<Form, 2>& forms, std::uint64_t seed)
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

constexpr std::array<std::array<Form, 2>, 6> kPairs{{{Form::Sphere, Form::Sphere},
                                                     {Form::Box, Form::Sphere},
                                                     {Form::Box, Form::Box},
                                                     {Form::MeshBox, Form::Box},
                                                     {Form::MeshBox, Form::MeshBox},
                                                     {Form::MeshBall, Form::MeshBox}}};

std::string nameOfKind(const testing::TestParamInfo<Kind>& test)
{
    return codeOf(test.param);
}

class Momentum : public testing::TestWithParam<Kind>
{
};
}  // namespace

using MomentumOf = Momentum;

TEST_P(MomentumOf, LinearIsConservedWhenRigidBodiesCollide)
{
    const double tolerance = kDouble ? 1e-6 : 1e-4;
    int collided = 0;
    int runs = 0;
    for (const auto& forms : kPairs)
    {
        for (std::uint64_t seed = 1; seed <= 30; ++seed)
        {
            const WorldClass worldClass = seed % 2 == 0 ? WorldClass::Rigid : WorldClass::MultiBody;
            const Encounter encounter = meet(GetParam(), worldClass, forms, seed);
            EXPECT_LT(encounter.linear, tolerance)
                << "forms " << int(forms[0]) << ", " << int(forms[1]) << ", seed " << seed;
            collided += encounter.collided ? 1 : 0;
            ++runs;
        }
    }
    EXPECT_GT(collided, 7 * runs / 10);
}
}  // namespace bullet_ccd::tests
