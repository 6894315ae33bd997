#include "benchmarks/reference/bullet/scene.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// Lowest height above the plane of the corners of a small box mesh that is shot at it at 100 m/s,
/// `far` from the plane's origin.
double lowest(Kind kind, double far)
{
    Scene scene(kind);
    const btVector3 normal = vec(0.6, 0, 0.8);
    scene.body(scene.keep(std::make_unique<btStaticPlaneShape>(normal, btScalar(0.25))),
               0.0,
               poseAt(vec(0, 0, 0)));
    const btVector3 start = normal * btScalar(0.55) + vec(-0.8, 0, 0.6) * btScalar(far);
    btRigidBody* body = scene.body(scene.boxMesh(vec(0.01, 0.02, 0.03)), 1.0, poseAt(start, 0.4));
    body->setDamping(0, 0);
    body->setLinearVelocity(normal * btScalar(-100));
    body->setAngularVelocity(vec(3, 5, 7));
    double height = 1e30;
    for (int i = 0; i < 10; ++i)
    {
        scene.step(1.0 / 240.0);
        for (int corner = 0; corner < 8; ++corner)
        {
            const btVector3 local((corner & 1) != 0 ? btScalar(0.01) : btScalar(-0.01),
                                  (corner & 2) != 0 ? btScalar(0.02) : btScalar(-0.02),
                                  (corner & 4) != 0 ? btScalar(0.03) : btScalar(-0.03));
            const btVector3 point = body->getWorldTransform() * local;
            height = std::min(height, double(normal.dot(point)) - 0.25);
        }
    }
    return height;
}
}  // namespace

TEST(Plane, StopsAFastMeshHoweverFarFromItsOrigin)
{
    for (const double far : {0.0, 30.0, 500.0, kDouble ? 1e5 : 500.0})
    {
        EXPECT_LT(lowest(Kind::Stock, far), -1.0) << "stock Bullet stops it too";
        EXPECT_GT(lowest(Kind::World, far), 0.0) << far;
    }
}
/// In a step it goes 300 m along the plane, and 2 m through it.
TEST(Plane, StopsWhatGoesFarAlongIt)
{
    for (const Kind kind : {Kind::Stock, Kind::Action, Kind::World})
    {
        Scene scene(kind);
        scene.body(scene.keep(std::make_unique<btStaticPlaneShape>(vec(0, 0, 1), btScalar(0.25))),
                   0.0,
                   poseAt(vec(0, 0, 0)));
        btRigidBody* ball = scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.2))),
                                       1.0,
                                       poseAt(vec(0, 0, 1.25)));
        ball->setLinearVelocity(vec(18000, 0, -120));
        scene.step(1.0 / 60.0);
        const double height = double(ball->getWorldTransform().getOrigin().z()) - 0.25;
        EXPECT_EQ(height > 0.0, isOurs(kind)) << nameOf(kind) << ": " << height;
    }
}
}  // namespace bullet_ccd::tests
