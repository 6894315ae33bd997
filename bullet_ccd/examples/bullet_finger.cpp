// A finger, one link of a btMultiBody, is flicked against a plate of half a millimetre. Its tip
// travels 15 cm a step: in a plain Bullet world the finger is found beyond the plate, in a
// btCcdMultiBodyDynamicsWorld it hits. Bullet has no continuous collision detection for links.
#include "bullet_ccd/examples/example_support.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace
{
using namespace bullet_ccd::examples;

constexpr double kHalfLength = 0.030;                   // of the finger [m]
constexpr double kHalfWidth = 0.001;                    // of the finger [m]
constexpr double kNearEdge = 0.020;                     // of the plate, from the hinge [m]
constexpr double kHalfPlate = 0.00025;                  // [m]
constexpr double kPlateAngle = std::numbers::pi / 3.0;  // from where the finger starts [rad]
constexpr double kSpeed = 150.0;                        // [rad/s]
constexpr double kTimeStep = 1.0 / 60.0;                // [s]

btVector3 vec(double x, double y, double z)
{
    return {btScalar(x), btScalar(y), btScalar(z)};
}

/// One link on a fixed base, hinged about z at the world's origin.
struct Finger
{
    btBoxShape shape{vec(kHalfLength, kHalfWidth, 0.005)};
    btMultiBody body{1, 0, vec(0, 0, 0), true, false};
    btMultiBodyLinkCollider collider{&body, 0};

    Finger()
    {
        shape.setMargin(btScalar(1e-4));
        btVector3 inertia;
        shape.calculateLocalInertia(btScalar(0.01), inertia);
        body.setupRevolute(0,
                           btScalar(0.01),
                           inertia,
                           -1,
                           btQuaternion::getIdentity(),
                           vec(0, 0, 1),
                           vec(0, 0, 0),
                           vec(kHalfLength, 0, 0));
        body.finalizeMultiDof();
        body.setAngularDamping(0);
        body.setLinearDamping(0);
        body.setMaxCoordinateVelocity(btScalar(1e4));
        body.setJointVel(0, btScalar(kSpeed));
        collider.setCollisionShape(&shape);
        body.getLink(0).m_collider = &collider;
        btAlignedObjectArray<btQuaternion> rotations;
        btAlignedObjectArray<btVector3> origins;
        body.updateCollisionObjectWorldTransforms(rotations, origins);
    }
};

/// Largest angle that the finger reaches in half a second.
double flick(Engine engine)
{
    World world(engine);
    world->setGravity(vec(0, 0, 0));
    Finger finger;
    world->addMultiBody(&finger.body);
    // Said explicitly: without filters this would count as a static object.
    world->addCollisionObject(
        &finger.collider, btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
    // Stands across the way of the outer two thirds of the finger.
    btTransform pose(btQuaternion(vec(0, 0, 1), btScalar(kPlateAngle)));
    pose.setOrigin(pose.getBasis() * vec(kNearEdge + 0.025, 0.0, 0.0));
    auto plate = std::make_unique<btBoxShape>(vec(0.025, kHalfPlate, 0.02));
    plate->setMargin(btScalar(1e-4));
    world.add(std::move(plate), 0.0, pose);

    double largest = 0.0;
    for (int step = 0; step < 30; ++step)
    {
        world->stepSimulation(btScalar(kTimeStep), 0);
        largest = std::max(largest, double(finger.body.getJointPos(0)));
    }
    world->removeCollisionObject(&finger.collider);
    world->removeMultiBody(&finger.body);
    return largest;
}
}  // namespace

int main()
{
    // The upper face of the finger meets the edge of the plate that is nearer to the hinge.
    const double reach = std::hypot(kNearEdge, kHalfPlate);
    const double atPlate =
        kPlateAngle - std::atan(kHalfPlate / kNearEdge) - std::asin(kHalfWidth / reach);
    const double plain = flick(Engine::Bullet);
    const double continuous = flick(Engine::Ccd);
    std::printf(
        "plate at %.3f rad; the finger reaches %.3f rad in a plain Bullet world, "
        "%.3f rad with continuous collision detection\n",
        atPlate,
        plain,
        continuous);
    check(plain > kPlateAngle + 0.5, "plain Bullet lets the finger through");
    check(continuous < atPlate && continuous > atPlate - 0.02, "the finger stops at the plate");
    return exitCode();
}
