#include "benchmarks/stability/stability_worlds.h"

#include "benchmarks/reference/bullet/missiles.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using reference::Kind;
using reference::Scene;
using reference::vec;

constexpr double kGravity = 9.81;       // [m/s^2]
constexpr double kServoForce = 2000.0;  // [N]: a joint that is to stay does
constexpr double kSettle = 0.7;         // from when the weight comes to when rest is expected [s]

enum class Surface
{
    Convex,
    Mesh,
};

btCollisionShape* meshShape(Scene& scene, Kind kind, const TriangleMesh& mesh)
{
    return reference::isOurs(kind) ? static_cast<btCollisionShape*>(scene.mesh(mesh))
                                   : reference::gimpactShape(scene, mesh);
}

btCollisionShape* boxShape(Scene& scene, Kind kind, Surface surface, const Vector3d& half)
{
    return surface == Surface::Mesh ? meshShape(scene, kind, makeBox(half))
                                    : scene.box(btCcdToBullet(half));
}

btVector3 boxInertia(double mass, const Vector3d& half)
{
    const Vector3d squares = half.cwiseAbs2();
    return btCcdToBullet(Vector3d(
        mass / 3.0 *
        Vector3d(squares.y() + squares.z(), squares.x() + squares.z(), squares.x() + squares.y())));
}

void watch(Trial& trial, const btCollisionObject* object, TriangleMesh mesh, bool isFixed)
{
    trial.meshes.push_back(std::make_unique<const reference::AuditMesh>(std::move(mesh)));
    trial.audit.parts.push_back({.mesh = trial.meshes.back().get(),
                                 .body = static_cast<std::int32_t>(trial.audited.size())});
    trial.audit.fixed.push_back(isFixed);
    trial.audited.push_back(object);
}

/// A motor on a joint of a multibody, which the scene owns.
btMultiBodyJointMotor* addMotor(Scene& scene, btMultiBody* body, int link)
{
    auto motor = std::make_unique<btMultiBodyJointMotor>(body, link, btScalar(0), btScalar(0));
    btMultiBodyJointMotor* raw = motor.get();
    scene.addConstraint(std::unique_ptr<btMultiBodyConstraint>(std::move(motor)));
    return raw;
}

/// Goes to a position at no more than that speed and stays there.
void servo(btMultiBodyJointMotor& motor, double position, double speed, double timeStep)
{
    motor.setVelocityTarget(btScalar(0), btScalar(1));
    motor.setPositionTarget(btScalar(position), btScalar(1));
    motor.setRhsClamp(btScalar(speed));
    motor.setMaxAppliedImpulse(btScalar(kServoForce * timeStep));
}

/// Closes at that speed with at most that force or torque.
void close(btMultiBodyJointMotor& motor, double velocity, double force, double timeStep)
{
    motor.setVelocityTarget(btScalar(velocity), btScalar(1));
    motor.setPositionTarget(btScalar(0), btScalar(0));
    motor.setMaxAppliedImpulse(btScalar(force * timeStep));
}

/// Presses with that force or torque. A motor that is asked for a speed would not: what it gives in
/// a step grows with the iterations of the solver.
void press(btMultiBody& body, int link, btMultiBodyJointMotor& motor, double force)
{
    motor.setMaxAppliedImpulse(btScalar(0));
    body.addJointTorque(link, btScalar(force));
}

/// By when jaws and fingers have come to the object, after the time that this takes [s].
constexpr double kReach = 0.03;

/// Two jaws that slide along x, one held in place by its servo, one that presses: so the object has
/// a place to be.
struct JawPlan
{
    Surface surface = Surface::Convex;
    Vector3d objectHalf{0.02, 0.02, 0.02};
    double objectMass = 0.1;
    double objectHeight = 0.0;  ///< above the middle of the jaws where it starts [m]
    double jawMass = 0.05;
    double gap = 0.002;  ///< between the object and each jaw at the start [m]
    double speed = 0.1;  ///< of closing [m/s]
    std::function<double(double)> force = [](double) { return 20.0; };  ///< of time [N]
    double closesAt = 0.0;                                              ///< [s]
    double weightAt = 0.3;                                              ///< [s]
};

const Vector3d kPad(0.005, 0.015, 0.02);

btMultiBody* makeJaws(Trial& trial, Kind kind, const JawPlan& plan)
{
    const double place = plan.objectHalf.x() + plan.gap + kPad.x();
    auto body = std::make_unique<btMultiBody>(2, btScalar(0), vec(0, 0, 0), true, false);
    for (int jaw = 0; jaw < 2; ++jaw)
    {
        body->setupPrismatic(jaw,
                             btScalar(plan.jawMass),
                             boxInertia(plan.jawMass, kPad),
                             -1,
                             btQuaternion::getIdentity(),
                             vec(1, 0, 0),
                             vec(0, 0, 0),
                             vec(0, 0, 0),
                             true);
    }
    body->finalizeMultiDof();
    body->setJointPos(0, btScalar(-place));
    body->setJointPos(1, btScalar(place));
    Scene& scene = trial.scene;
    btCollisionShape* pad = boxShape(scene, kind, plan.surface, kPad);
    // The base has a collider so that it is counted, and meets nothing.
    btMultiBody* added =
        scene.addMultiBody(std::move(body), scene.box(vec(1e-3, 1e-3, 1e-3)), {pad, pad}, 0);
    watch(trial, added->getLinkCollider(0), makeBox(kPad), false);
    watch(trial, added->getLinkCollider(1), makeBox(kPad), false);
    return added;
}

void setWeight(Trial& trial, double time, double timeStep, double from)
{
    if (time <= from && from < time + timeStep)
    {
        trial.scene.world().setGravity(vec(0, 0, -kGravity));
    }
}

std::unique_ptr<Trial> makeJawTrial(Kind kind, const JawPlan& plan)
{
    auto trial = std::make_unique<Trial>(kind);
    Scene& scene = trial->scene;
    btMultiBody* hand = makeJaws(*trial, kind, plan);
    trial->object = scene.body(boxShape(scene, kind, plan.surface, plan.objectHalf),
                               plan.objectMass,
                               reference::poseAt(vec(0, 0, plan.objectHeight)));
    watch(*trial, trial->object, makeBox(plan.objectHalf), false);
    const std::array motors{addMotor(scene, hand, 0), addMotor(scene, hand, 1)};
    trial->control = [plan, motors, hand, world = trial.get()](double time, double timeStep)
    {
        setWeight(*world, time, timeStep, plan.weightAt);
        const double place = plan.objectHalf.x() + kPad.x();
        const bool closes = time > plan.closesAt - 0.5 * timeStep;
        servo(*motors[0], -place - (closes ? 0.0 : plan.gap), plan.speed, timeStep);
        if (time >= plan.closesAt + plan.gap / plan.speed + kReach)
        {
            press(*hand, 1, *motors[1], -plan.force(time));
        }
        else if (closes)
        {
            close(*motors[1], -plan.speed, plan.force(time), timeStep);
        }
        else
        {
            servo(*motors[1], place + plan.gap, plan.speed, timeStep);
        }
    };
    trial->isThrough = [hand, object = trial->object]
    {
        // Of a plate that is no longer between the jaws nothing can be said.
        const btVector3 middle = object->getWorldTransform().getOrigin();
        const bool isBetween =
            std::abs(double(middle.y())) < kPad.y() && std::abs(double(middle.z())) < kPad.z();
        return isBetween &&
               (hand->getJointPos(0) > middle.x() || hand->getJointPos(1) < middle.x());
    };
    trial->readyAt = std::max(plan.weightAt, plan.closesAt) + kSettle;
    return trial;
}

constexpr double kCylinderRadius = 0.025;
constexpr double kCylinderHeight = 0.04;
const Vector3d kFingerHalf(0.004, 0.008, 0.03);

btMultiBody* makeThreeFingers(Trial& trial, Kind kind, Surface surface, double opening)
{
    constexpr double kMass = 0.01;
    auto body = std::make_unique<btMultiBody>(3, btScalar(0), vec(0, 0, 0), true, false);
    for (int finger = 0; finger < 3; ++finger)
    {
        const btQuaternion turn(vec(0, 0, 1), btScalar(2.0 * std::numbers::pi * finger / 3.0));
        const btVector3 hinge(
            btScalar(kCylinderRadius + kFingerHalf.x()), 0, btScalar(kFingerHalf.z() + 0.01));
        // A positive angle moves the tip, which hangs down, towards the z-axis.
        body->setupRevolute(finger,
                            btScalar(kMass),
                            boxInertia(kMass, kFingerHalf),
                            -1,
                            turn.inverse(),
                            vec(0, 1, 0),
                            quatRotate(turn, hinge),
                            vec(0, 0, -kFingerHalf.z()),
                            true);
    }
    body->finalizeMultiDof();
    for (int finger = 0; finger < 3; ++finger)
    {
        body->setJointPos(finger, btScalar(-opening));
    }
    Scene& scene = trial.scene;
    btCollisionShape* link = boxShape(scene, kind, surface, kFingerHalf);
    btMultiBody* added = scene.addMultiBody(
        std::move(body), scene.box(vec(1e-3, 1e-3, 1e-3)), {link, link, link}, 0);
    for (int finger = 0; finger < 3; ++finger)
    {
        watch(trial, added->getLinkCollider(finger), makeBox(kFingerHalf), false);
    }
    return added;
}

std::unique_ptr<Trial> makeThreeFingerTrial(Kind kind, Surface surface)
{
    constexpr double kOpening = 0.1;  // [rad]
    constexpr double kSpeed = 2.0;    // [rad/s]
    constexpr double kTorque = 0.4;   // [N m]
    constexpr double kWeightAt = 0.3;
    constexpr int kSegments = 36;  // a multiple of three: the same faces every finger
    auto trial = std::make_unique<Trial>(kind);
    Scene& scene = trial->scene;
    btMultiBody* hand = makeThreeFingers(*trial, kind, surface, kOpening);
    // Of the cylinder a corner, which is on it, faces the fingers; of the prism a side, on which it
    // can rest.
    TriangleMesh cylinder = makeCylinder(kCylinderRadius, kCylinderHeight, kSegments);
    if (surface == Surface::Mesh)
    {
        transformMesh(
            cylinder,
            Eigen::Affine3d(Eigen::AngleAxisd(std::numbers::pi / kSegments, Vector3d::UnitZ())));
    }
    btCollisionShape* shape = surface == Surface::Mesh
                                  ? meshShape(scene, kind, cylinder)
                                  : scene.keep(std::make_unique<btCylinderShapeZ>(vec(
                                        kCylinderRadius, kCylinderRadius, kCylinderHeight / 2.0)));
    trial->object = scene.body(shape, 0.1, reference::poseAt(vec(0, 0, 0)));
    watch(*trial, trial->object, cylinder, false);
    const std::array motors{
        addMotor(scene, hand, 0), addMotor(scene, hand, 1), addMotor(scene, hand, 2)};
    trial->control = [motors, hand, world = trial.get()](double time, double timeStep)
    {
        setWeight(*world, time, timeStep, kWeightAt);
        servo(*motors[0], 0.0, kSpeed, timeStep);
        servo(*motors[1], 0.0, kSpeed, timeStep);
        if (time >= kOpening / kSpeed + kReach)
        {
            press(*hand, 2, *motors[2], kTorque);
        }
        else
        {
            close(*motors[2], kSpeed, kTorque, timeStep);
        }
    };
    trial->readyAt = kWeightAt + kSettle;
    return trial;
}

/// A chain of three links of 10 g swings at a wall that stands along its way.
std::unique_ptr<Trial> makeImpactTrial(Kind kind, Surface surface, double speed)
{
    const Vector3d link(0.03, 0.002, 0.005);
    const Vector3d wall(0.1, 0.0025, 0.02);
    constexpr double kFirst = 0.05;  // where the wall begins [m]
    auto trial = std::make_unique<Trial>(kind);
    Scene& scene = trial->scene;
    btRigidBody* target = scene.body(
        boxShape(scene, kind, surface, wall), 0.0, reference::poseAt(vec(kFirst + wall.x(), 0, 0)));
    watch(*trial, target, makeBox(wall), true);
    btCollisionShape* shape = boxShape(scene, kind, surface, link);
    btMultiBody* chain = scene.chain({shape, shape, shape}, link.x(), btTransform::getIdentity());
    chain->setJointPos(0, btScalar(0.8));
    chain->setJointVel(0, btScalar(-speed));
    Scene::placeColliders(*chain);
    for (int i = 0; i < 3; ++i)
    {
        watch(*trial, chain->getLinkCollider(i), makeBox(link), false);
    }
    trial->audit.ignored = {{1, 2}, {2, 3}};
    trial->isThrough = [chain]
    {
        bool isThrough = chain->getJointPos(0) < btScalar(-0.1);
        for (int i = 1; i < 3; ++i)
        {
            const btVector3 middle = chain->getLinkCollider(i)->getWorldTransform().getOrigin();
            isThrough |= middle.y() < btScalar(-0.0025) && middle.x() > btScalar(kFirst);
        }
        return isThrough;
    };
    return trial;
}

std::string of(Surface surface)
{
    return surface == Surface::Mesh ? "meshes" : "convex shapes";
}

/// Where nothing is fast, Bullet's own continuous collision detection has nothing to do.
std::vector<Kind> kindsFor(const std::string& group, Surface surface)
{
    if (group == "thin")
    {
        return {Kind::Stock, Kind::StockCcd, Kind::Action, Kind::World};
    }
    return surface == Surface::Mesh ? std::vector{Kind::Stock, Kind::Action, Kind::World}
                                    : std::vector{Kind::Stock, Kind::World};
}

StabilityWorld jawWorld(std::string name,
                        const std::string& group,
                        std::string title,
                        double seconds,
                        const JawPlan& plan)
{
    return {.name = std::move(name) + (plan.surface == Surface::Mesh ? "_mesh" : ""),
            .group = group,
            .title = std::move(title) + ", " + of(plan.surface),
            .seconds = seconds,
            .kinds = kindsFor(group, plan.surface),
            .make = [plan](Kind kind) { return makeJawTrial(kind, plan); }};
}

/// Rises evenly from 1 N to 400 N in 3 s.
double risingForce(double time)
{
    return 1.0 + 399.0 * std::min(time / 3.0, 1.0);
}

void addHolds(std::vector<StabilityWorld>& worlds, Surface surface)
{
    constexpr double kLong = 60.0;
    worlds.push_back(jawWorld(
        "hold_jaws", "hold", "two jaws hold 100 g with 20 N", kLong, {.surface = surface}));
    worlds.push_back(
        {.name = surface == Surface::Mesh ? "hold_fingers_mesh" : "hold_fingers",
         .group = "hold",
         .title = (surface == Surface::Mesh ? "three fingers hold a prism of 100 g, "
                                            : "three fingers hold a cylinder of 100 g, ") +
                  of(surface),
         .seconds = kLong,
         .kinds = kindsFor("hold", surface),
         .make = [surface](Kind kind) { return makeThreeFingerTrial(kind, surface); }});
}

void addThin(std::vector<StabilityWorld>& worlds, Surface surface)
{
    for (const auto& [name, title, thickness] :
         {std::tuple{"pinch_1mm", "a plate of 1 mm is pinched at 1 m/s", 1e-3},
          std::tuple{"pinch_02mm", "a plate of 0.2 mm is pinched at 1 m/s", 2e-4}})
    {
        worlds.push_back(jawWorld(name,
                                  "thin",
                                  title,
                                  2.0,
                                  {.surface = surface,
                                   .objectHalf = {thickness / 2.0, 0.02, 0.02},
                                   .objectMass = 0.005,
                                   .gap = 0.02,
                                   .speed = 1.0}));
    }
    // It falls 96 mm in the 0.14 s after which the jaws are there.
    worlds.push_back(jawWorld("drop_05mm",
                              "thin",
                              "a falling plate of 0.5 mm is caught at 0.5 m/s",
                              2.0,
                              {.surface = surface,
                               .objectHalf = {2.5e-4, 0.02, 0.02},
                               .objectMass = 0.005,
                               .objectHeight = 0.096,
                               .gap = 0.02,
                               .speed = 0.5,
                               .closesAt = 0.1,
                               .weightAt = 0.0}));
}

void addLight(std::vector<StabilityWorld>& worlds, Surface surface)
{
    worlds.push_back(
        jawWorld("light_jaws",
                 "light",
                 "jaws of 10 g hold 1 kg with 100 N",
                 10.0,
                 {.surface = surface, .objectMass = 1.0, .jawMass = 0.01, .force = [](double) {
                      return 100.0;
                  }}));
    worlds.push_back(
        {.name = surface == Surface::Mesh ? "light_hit_mesh" : "light_hit",
         .group = "light",
         .title = "links of 10 g hit a wall at 5 m/s, " + of(surface),
         .seconds = 1.0,
         .isPassive = true,
         .make = [surface](Kind kind) { return makeImpactTrial(kind, surface, 30.0); }});
}
}  // namespace

const std::vector<StabilityWorld>& stabilityWorlds()
{
    static const std::vector<StabilityWorld> kWorlds = []
    {
        std::vector<StabilityWorld> worlds;
        for (const Surface surface : {Surface::Convex, Surface::Mesh})
        {
            addHolds(worlds, surface);
            worlds.push_back(jawWorld(
                "squeeze",
                "squeeze",
                "50 g squeezed by jaws of 10 g with 1 to 400 N",
                4.0,
                {.surface = surface, .objectMass = 0.05, .jawMass = 0.01, .force = risingForce}));
            addThin(worlds, surface);
            addLight(worlds, surface);
        }
        return worlds;
    }();
    return kWorlds;
}
}  // namespace bullet_ccd::benchmarks
