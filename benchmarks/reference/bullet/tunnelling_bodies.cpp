#include "benchmarks/reference/bullet/missiles.h"
#include "benchmarks/reference/bullet/tunnelling.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kMass = 0.01;
/// What every free body moves sideways with, which no contact changes: there is no friction.
constexpr double kDrift = 1.0;

Isometry3d poseOfBody(const btRigidBody& body)
{
    return btCcdToEigen(body.getWorldTransform());
}

Snapshot snapshotOf(std::initializer_list<const btRigidBody*> bodies)
{
    Snapshot snapshot;
    for (const btRigidBody* body : bodies)
    {
        snapshot.poses.push_back(poseOfBody(*body));
        snapshot.spins.push_back(btCcdToEigen(body->getAngularVelocity()));
    }
    return snapshot;
}

/// A different orientation for every phase.
btTransform tumbled(const btVector3& origin, double phase)
{
    return btTransform(btQuaternion(vec(1, 2, 3).normalized(), btScalar(0.2 + 5.0 * phase)),
                       origin);
}

btRigidBody* throwBody(Scene& scene,
                       btCollisionShape* shape,
                       const btTransform& pose,
                       const btVector3& velocity,
                       const btVector3& spin)
{
    btRigidBody* body = scene.body(shape, kMass, pose);
    body->setFriction(0);
    body->setLinearVelocity(velocity);
    body->setAngularVelocity(spin);
    return body;
}

/// How far bodies have drifted in the mean.
UniformCoordinate driftOf(const std::vector<btRigidBody*>& bodies)
{
    const auto mean = [bodies]
    {
        double sum = 0.0;
        for (const btRigidBody* body : bodies)
        {
            sum += double(body->getWorldTransform().getOrigin().x());
        }
        return sum / static_cast<double>(bodies.size());
    };
    return {mean, kDrift};
}

RunOutcome shootAtPlate(
    Kind kind, const Missile& missile, const Target& target, const Setting& setting, double phase)
{
    Scene scene(kind);
    scene.body(target.make(scene), 0.0, btTransform::getIdentity());
    const double height = 0.1 + setting.speed * setting.timeStep * phase;
    btRigidBody* body = throwBody(scene,
                                  missile.make(scene),
                                  tumbled(vec(-0.08, 0, height), phase),
                                  vec(kDrift, 0, -setting.speed),
                                  btCcdToBullet(missile.spin));
    Watched watched;
    watched.read = [body](double) { return snapshotOf({body}); };
    watched.place = [](const Snapshot& now) { return WatchedPoses{.X_WM = now.poses[0]}; };
    watched.plateHalf = {kTargetHalf, kTargetHalf};
    watched.probes = missile.inside;
    watched.plate = target.surface;
    watched.mover = missile.surface;
    watched.moverRadius = missile.radius;
    return watchRun(scene,
                    kind,
                    std::move(watched),
                    {setting.timeStep, stepsFor(0.1, setting), driftOf({body})});
}

/// Two bodies meet head on, in the middle.
RunOutcome headOn(
    Kind kind, const Missile& upper, const Missile& lower, const Setting& setting, double phase)
{
    Scene scene(kind);
    const double height = 0.05 + setting.speed * setting.timeStep * phase;
    btRigidBody* bodies[] = {throwBody(scene,
                                       upper.make(scene),
                                       tumbled(vec(0.0005, 0, height), phase),
                                       vec(kDrift, 0, -setting.speed),
                                       vec(3, 20, 5)),
                             throwBody(scene,
                                       lower.make(scene),
                                       tumbled(vec(0, 0.0005, -0.05), 0.7 * phase),
                                       vec(kDrift, 0, setting.speed),
                                       vec(-8, 2, 15))};
    Watched watched;
    watched.read = [bodies](double) { return snapshotOf({bodies[0], bodies[1]}); };
    // Who is above whom; orientations do not matter.
    watched.place = [](const Snapshot& now)
    {
        return WatchedPoses{.X_WP = Isometry3d(Eigen::Translation3d(now.poses[1].translation())),
                            .X_WS = now.poses[1],
                            .X_WM = now.poses[0]};
    };
    watched.plateHalf = {lower.inner, lower.inner};
    watched.probes = {Vector3d::Zero()};
    watched.plate = lower.surface;
    watched.plateRadius = lower.radius;
    watched.mover = upper.surface;
    watched.moverRadius = upper.radius;
    return watchRun(scene,
                    kind,
                    std::move(watched),
                    {setting.timeStep, stepsFor(0.05, setting), driftOf({bodies[0], bodies[1]})});
}

/// Two thin tiles, both free, flat against each other or edge on, spinning.
RunOutcome tileAtTile(Kind kind, const Setting& setting, double phase)
{
    Scene scene(kind);
    const Vector3d half(0.02, 0.02, 0.00025);
    const auto shape = [&] { return scene.boxMesh(btCcdToBullet(half)); };
    const double height = 0.05 + setting.speed * setting.timeStep * phase;
    btRigidBody* bodies[] = {
        throwBody(scene,
                  shape(),
                  btTransform(btQuaternion(vec(1, 0.3, 0).normalized(), btScalar(3.0 * phase)),
                              vec(0.001, 0, height)),
                  vec(kDrift, 0, -setting.speed),
                  vec(2, 1, 10)),
        throwBody(scene,
                  shape(),
                  poseAt(vec(0, 0.002, -0.05), 0.3),
                  vec(kDrift, 0, setting.speed),
                  vec(0, 0, -5))};
    Watched watched;
    watched.read = [bodies](double) { return snapshotOf({bodies[0], bodies[1]}); };
    watched.place = [](const Snapshot& now)
    { return WatchedPoses{.X_WP = now.poses[1], .X_WS = now.poses[1], .X_WM = now.poses[0]}; };
    watched.plateHalf = {half.x(), half.y()};
    for (int i = -3; i <= 3; ++i)
    {
        for (int k = -3; k <= 3; ++k)
        {
            watched.probes.emplace_back(0.0064 * i, 0.0064 * k, 0.0);
        }
    }
    watched.plate = watched.mover = makeBox(half);
    return watchRun(scene,
                    kind,
                    std::move(watched),
                    {setting.timeStep, stepsFor(0.05, setting), driftOf({bodies[0], bodies[1]})});
}

const Vector3d kRodHalf(0.03, 0.002, 0.002);
const Vector3d kBladeHalf(0.002, 0.00025, 0.02);
const Vector3d kBladeAt(0.025, 0.0, 0.0);

/// The blade goes through the rod: seen from the rod, whose middle plane is its x-z-plane.
Watched rodAndBlade(btRigidBody* rod)
{
    Watched watched;
    watched.read = [rod](double) { return snapshotOf({rod}); };
    watched.place = [](const Snapshot& now)
    {
        return WatchedPoses{
            .X_WP = now.poses[0] * Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3d::UnitX()),
            .X_WS = now.poses[0],
            .X_WM = Isometry3d(Eigen::Translation3d(kBladeAt))};
    };
    watched.plateHalf = {kRodHalf.x(), kRodHalf.z()};
    watched.probes = {Vector3d::Zero()};
    watched.plate = makeBox(kRodHalf);
    watched.mover = makeBox(kBladeHalf);
    return watched;
}

btCollisionShape* boxOf(Scene& scene, bool mesh, const Vector3d& half)
{
    return mesh ? static_cast<btCollisionShape*>(scene.boxMesh(btCcdToBullet(half)))
                : static_cast<btCollisionShape*>(scene.box(btCcdToBullet(half)));
}

/// The rod turns about its fixed middle; its end meets the blade.
RunOutcome turnAtBlade(Kind kind, bool mesh, const Setting& setting, double phase)
{
    Scene scene(kind);
    scene.body(boxOf(scene, mesh, kBladeHalf), 0.0, poseAt(btCcdToBullet(kBladeAt)));
    const double start = 0.6 + setting.speed * setting.timeStep * phase;
    btRigidBody* rod = throwBody(scene,
                                 boxOf(scene, mesh, kRodHalf),
                                 poseAt(vec(0, 0, 0), start),
                                 vec(0, 0, 0),
                                 vec(0, 0, -setting.speed));
    // Not 0: the solver takes a body that cannot shift for a static one and lets it spin on.
    rod->setLinearFactor(vec(1e-3, 1e-3, 1e-3));
    rod->setAngularFactor(vec(0, 0, 1));
    return watchRun(scene, kind, rodAndBlade(rod), {setting.timeStep, stepsFor(1.2, setting, 8)});
}

/// The rod flies broadside; its end meets the blade.
RunOutcome flyAtBlade(Kind kind, bool mesh, const Setting& setting, double phase)
{
    Scene scene(kind);
    scene.body(boxOf(scene, mesh, kBladeHalf), 0.0, poseAt(btCcdToBullet(kBladeAt)));
    btRigidBody* rod = throwBody(scene,
                                 boxOf(scene, mesh, kRodHalf),
                                 poseAt(vec(0, 0.1 + setting.speed * setting.timeStep * phase, 0)),
                                 vec(0, -setting.speed, 0),
                                 vec(0, 0, 0));
    return watchRun(scene, kind, rodAndBlade(rod), {setting.timeStep, stepsFor(0.1, setting)});
}

/// A plate that is moved by the program (kinematic) hits a ball that rests.
RunOutcome kinematicPlateAtBall(Kind kind,
                                const Missile& ball,
                                const Setting& setting,
                                double phase)
{
    Scene scene(kind);
    btRigidBody* body = throwBody(
        scene, ball.make(scene), tumbled(vec(0, 0, 0), phase), vec(0, 0, 0), vec(0, 0, 0));
    const Vector3d half(0.1, 0.1, 0.00025);
    // Two steps of way: its velocity is known from the second on.
    const double way = setting.speed * setting.timeStep;
    const double height = 0.1 + way * (2.0 + phase);
    btRigidBody* plate = scene.body(scene.box(btCcdToBullet(half)), 0.0, poseAt(vec(0, 0, height)));
    plate->setCollisionFlags(plate->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    struct Mover : btMotionState
    {
        btTransform m_pose;
        void getWorldTransform(btTransform& pose) const override { pose = m_pose; }
        void setWorldTransform(const btTransform&) override {}
    };
    Mover mover;
    mover.m_pose = plate->getWorldTransform();
    plate->setMotionState(&mover);

    Watched watched;
    // Bullet puts the plate where the program says before the step begins; in the step it comes
    // there from where it was before.
    watched.read = [&mover, body, setting](double sinceStep)
    {
        Isometry3d X_WP = btCcdToEigen(mover.m_pose);
        X_WP.translation().z() += setting.speed * (setting.timeStep - sinceStep);
        return Snapshot{.poses = {X_WP, poseOfBody(*body)}};
    };
    watched.place = [](const Snapshot& now)
    { return WatchedPoses{.X_WP = now.poses[0], .X_WS = now.poses[0], .X_WM = now.poses[1]}; };
    watched.plateHalf = {half.x(), half.y()};
    watched.probes = ball.inside;
    watched.plate = makeBox(half);
    watched.mover = ball.surface;
    watched.moverRadius = ball.radius;
    const RunOutcome outcome =
        watchRun(scene,
                 kind,
                 std::move(watched),
                 {setting.timeStep, stepsFor(0.1 + 2.0 * way, setting), std::nullopt, [&] {
                      mover.m_pose.getOrigin() -= vec(0, 0, way);
                  }});
    plate->setMotionState(nullptr);
    return outcome;
}
}  // namespace

std::vector<TunnellingRow> bodyRows()
{
    std::vector<TunnellingRow> rows;
    const std::vector<Setting> shots = {
        {1.0 / 240, 2.0}, {1.0 / 240, 5.0}, {1.0 / 240, 10.0}, {1.0 / 60, 10.0}, {1.0 / 240, 40.0}};
    for (const Shot& shot : shotsAtTargets())
    {
        rows.push_back({.name = std::string(shot.missile.name) + " x " + shot.target.name,
                        .settings = shots,
                        .run = [=](Kind kind, const Setting& setting, double phase)
                        { return shootAtPlate(kind, shot.missile, shot.target, setting, phase); }});
    }
    for (const auto& [upper, lower] : headOnPairs())
    {
        rows.push_back({.name = std::string(upper.name) + " head on " + lower.name,
                        .settings = {{1.0 / 240, 5.0}, {1.0 / 240, 10.0}, {1.0 / 60, 20.0}},
                        .run = [=](Kind kind, const Setting& setting, double phase)
                        { return headOn(kind, upper, lower, setting, phase); }});
    }
    rows.push_back({.name = "mesh tile head on mesh tile",
                    .settings = {{1.0 / 240, 2.0}, {1.0 / 240, 5.0}, {1.0 / 60, 20.0}},
                    .run = tileAtTile});
    // Bullet turns no free body by more than 0.785 rad a step.
    const std::vector<Setting> turning = {{1.0 / 240, 60.0}, {1.0 / 240, 150.0}, {1.0 / 60, 40.0}};
    const std::vector<Setting> flying = {{1.0 / 240, 5.0}, {1.0 / 240, 10.0}, {1.0 / 60, 20.0}};
    for (const bool mesh : {false, true})
    {
        const std::string suffix = mesh ? ", meshes" : ", boxes";
        rows.push_back({.name = "centre-fixed rod x blade" + suffix,
                        .settings = turning,
                        .run = [=](Kind kind, const Setting& setting, double phase)
                        { return turnAtBlade(kind, mesh, setting, phase); }});
        rows.push_back({.name = "free rod x blade" + suffix,
                        .settings = flying,
                        .run = [=](Kind kind, const Setting& setting, double phase)
                        { return flyAtBlade(kind, mesh, setting, phase); }});
    }
    rows.push_back({.name = "kinematic plate x resting box",
                    .settings = {{1.0 / 240, 2.0}, {1.0 / 240, 10.0}, {1.0 / 60, 10.0}},
                    .run = [](Kind kind, const Setting& setting, double phase)
                    { return kinematicPlateAtBall(kind, boxMissile(), setting, phase); }});
    return rows;
}
}  // namespace bullet_ccd::reference
