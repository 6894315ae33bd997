// A ball falls on the ground, in a world of Bullet's own class: an action adds continuous collision
// detection to it. Only the two marked lines differ from what a plain Bullet program would say.
#include "bullet_ccd/bullet/btCcdAction.h"

#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>

int main()
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity(btVector3(0, -10, 0));
    btCcdAction ccd(&world);  // added; it registers the algorithm itself
    world.addAction(&ccd);    // added

    btBoxShape groundShape(btVector3(50, 50, 50));
    btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &groundShape));
    ground.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, -56, 0)));
    world.addRigidBody(&ground);

    btSphereShape ballShape(1);
    btVector3 inertia;
    ballShape.calculateLocalInertia(1, inertia);
    btRigidBody ball(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &ballShape, inertia));
    ball.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(2, 10, 0)));
    world.addRigidBody(&ball);

    for (int step = 1; step <= 150; ++step)
    {
        world.stepSimulation(btScalar(1.0 / 60.0), 10);
        if (step % 15 == 0)
        {
            const btVector3& at = ball.getWorldTransform().getOrigin();
            std::printf("%.2f s: ball at (%6.3f, %6.3f, %6.3f)\n",
                        step / 60.0,
                        double(at.x()),
                        double(at.y()),
                        double(at.z()));
        }
    }

    const double height = double(ball.getWorldTransform().getOrigin().y());
    world.removeAction(&ccd);
    world.removeRigidBody(&ball);
    world.removeRigidBody(&ground);
    const bool rests = std::abs(height + 5.0) < 0.02;  // on the ground, whose top is at -6
    std::printf("%s\n", rests ? "the ball rests on the ground" : "FAILED: the ball is not at rest");
    return rests ? 0 : 1;
}
