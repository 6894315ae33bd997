#include "benchmarks/reference/bullet/tunnelling.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

// A link of 60 x 2 x 10 mm, hinged at its end.
const Vector3d kLinkHalf(0.03, 0.001, 0.005);
const Vector3d kPlateHalf(0.03, 0.00025, 0.03);
constexpr double kPlateAngle = -std::numbers::pi / 4;

enum class Material
{
    Box,
    Mesh,
    StaticMesh,
};

btCollisionShape* shapeOf(Scene& scene, Material material, const Vector3d& half)
{
    switch (material)
    {
        case Material::Mesh:
            return scene.boxMesh(btCcdToBullet(half));
        case Material::StaticMesh:
            return scene.staticMesh(makeBox(half));
        case Material::Box:
            break;
    }
    return scene.box(btCcdToBullet(half));
}

Isometry3d turnedZ(const Vector3d& origin, double angle)
{
    Isometry3d X = Isometry3d::Identity();
    X.linear() = Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
    X.translation() = origin;
    return X;
}

/// Of a plate whose middle is in its x-z-plane.
WatchedPoses plateAndMover(const Isometry3d& X_WP, const Isometry3d& X_WM)
{
    return {.X_WP = X_WP * Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3d::UnitX()),
            .X_WS = X_WP,
            .X_WM = X_WM};
}

/// In the way of a link that swings about the origin.
btTransform platePose()
{
    return poseAt(vec(0.06 * std::cos(kPlateAngle), 0.06 * std::sin(kPlateAngle), 0.0),
                  kPlateAngle);
}

/// Middle of link `link` of Scene::chain, in the plane of the hinges.
Isometry3d chainLink(const Isometry3d& base, std::span<const double> joints, int link)
{
    Isometry3d X = base;
    for (int i = 0; i <= link; ++i)
    {
        X = X * turnedZ(Vector3d(i == 0 ? 0.0 : kLinkHalf.x(), 0.0, 0.0), joints[std::size_t(i)]);
        X = X * Eigen::Translation3d(kLinkHalf.x(), 0.0, 0.0);
    }
    return X;
}

std::vector<double> jointsOf(const btMultiBody& body)
{
    std::vector<double> joints;
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        joints.push_back(double(body.getJointPos(i)));
    }
    return joints;
}

void launch(btMultiBody& body, int joint, double position, double speed)
{
    body.setJointPos(joint, btScalar(position));
    body.setJointVel(joint, btScalar(speed));
    Scene::placeColliders(body);
}

/// Points on the centre line of a link, from `first` on, all inside.
std::vector<Vector3d> centreLine(double first)
{
    std::vector<Vector3d> points;
    for (int i = 0; i <= 4; ++i)
    {
        points.emplace_back(first + (kLinkHalf.x() - 0.001 - first) * i / 4.0, 0.0, 0.0);
    }
    return points;
}

RunOutcome swingAtPlate(
    Kind kind, Material link, Material plate, const Setting& setting, double phase)
{
    Scene scene(kind);
    const btTransform pose = platePose();
    scene.body(shapeOf(scene, plate, kPlateHalf), 0.0, pose);
    btMultiBody* body =
        scene.chain({shapeOf(scene, link, kLinkHalf)}, kLinkHalf.x(), btTransform::getIdentity());
    const double spread = std::min(setting.speed * setting.timeStep, 0.9);
    launch(*body, 0, 0.3 - spread * phase, -setting.speed);

    Watched watched;
    watched.read = [body](double) { return Snapshot{.joints = jointsOf(*body)}; };
    watched.place = [X = btCcdToEigen(pose)](const Snapshot& now)
    { return plateAndMover(X, chainLink(Isometry3d::Identity(), now.joints, 0)); };
    watched.plateHalf = {kPlateHalf.x(), kPlateHalf.z()};
    watched.probes = centreLine(0.005);
    watched.plate = makeBox(kPlateHalf);
    watched.mover = makeBox(kLinkHalf);
    return watchRun(scene, kind, std::move(watched), {setting.timeStep, stepsFor(1.6, setting, 8)});
}

/// Two links on bases 90 mm apart swing at each other and meet with their ends.
RunOutcome linkAtLink(Kind kind, Material material, const Setting& setting, double phase)
{
    Scene scene(kind);
    const btTransform bases[] = {btTransform::getIdentity(),
                                 poseAt(vec(0.09, 0, 0), std::numbers::pi)};
    btMultiBody* bodies[2];
    for (int i = 0; i < 2; ++i)
    {
        bodies[i] = scene.chain({shapeOf(scene, material, kLinkHalf)}, kLinkHalf.x(), bases[i]);
        launch(*bodies[i],
               0,
               0.4 + (i == 0 ? setting.speed * setting.timeStep * phase : 0.0),
               -setting.speed);
    }
    Watched watched;
    watched.read = [bodies](double)
    {
        return Snapshot{
            .joints = {double(bodies[0]->getJointPos(0)), double(bodies[1]->getJointPos(0))}};
    };
    watched.place = [X_WB = btCcdToEigen(bases[1])](const Snapshot& now)
    {
        const Isometry3d X_WL = chainLink(X_WB, std::span(now.joints).subspan(1, 1), 0);
        return plateAndMover(X_WL, chainLink(Isometry3d::Identity(), now.joints, 0));
    };
    watched.plateHalf = {kLinkHalf.x(), kLinkHalf.z()};
    watched.probes = centreLine(0.015);
    watched.plate = watched.mover = makeBox(kLinkHalf);
    return watchRun(scene, kind, std::move(watched), {setting.timeStep, stepsFor(1.0, setting, 8)});
}

/// Three links fold back: the end of the last swings at the first.
RunOutcome linkAtItsOwnChain(Kind kind, Material material, const Setting& setting, double phase)
{
    Scene scene(kind);
    btCollisionShape* shape = shapeOf(scene, material, kLinkHalf);
    // The first two are so heavy that they hardly move.
    btMultiBody* body = scene.chain(
        {shape, shape, shape}, kLinkHalf.x(), btTransform::getIdentity(), {100.0, 10.0, 0.01});
    body->setJointPos(1, btScalar(2.0));
    launch(*body, 2, 1.7 - setting.speed * setting.timeStep * phase, setting.speed);
    Watched watched;
    watched.read = [body](double) { return Snapshot{.joints = jointsOf(*body)}; };
    watched.place = [](const Snapshot& now)
    {
        return plateAndMover(chainLink(Isometry3d::Identity(), now.joints, 0),
                             chainLink(Isometry3d::Identity(), now.joints, 2));
    };
    watched.plateHalf = {kLinkHalf.x(), kLinkHalf.z()};
    watched.probes = centreLine(0.025);
    watched.plate = watched.mover = makeBox(kLinkHalf);
    // It meets the first link after about half a turn of 1 rad and must not come out behind.
    return watchRun(scene, kind, std::move(watched), {setting.timeStep, stepsFor(1.0, setting, 8)});
}

/// A box on a rail.
RunOutcome sliderAtPlate(Kind kind, Material material, const Setting& setting, double phase)
{
    Scene scene(kind);
    const Vector3d plateHalf(0.1, 0.1, 0.00025);
    const Vector3d half(0.005, 0.005, 0.005);
    scene.body(shapeOf(scene, material, plateHalf), 0.0, btTransform::getIdentity());
    btCollisionShape* shape = shapeOf(scene, material, half);
    auto rail = std::make_unique<btMultiBody>(1, btScalar(0), vec(1, 1, 1), true, false);
    btVector3 inertia;
    btBoxShape(btCcdToBullet(half)).calculateLocalInertia(btScalar(0.01), inertia);
    rail->setupPrismatic(0,
                         btScalar(0.01),
                         inertia,
                         -1,
                         btQuaternion::getIdentity(),
                         vec(0, 0, 1),
                         vec(0, 0, 0),
                         vec(0, 0, 0),
                         true);
    rail->finalizeMultiDof();
    btMultiBody* body = scene.addMultiBody(std::move(rail), nullptr, {shape});
    launch(*body, 0, 0.1 + setting.speed * setting.timeStep * phase, -setting.speed);

    Watched watched;
    watched.read = [body](double) { return Snapshot{.joints = jointsOf(*body)}; };
    watched.place = [](const Snapshot& now)
    { return WatchedPoses{.X_WM = Isometry3d(Eigen::Translation3d(0.0, 0.0, now.joints[0]))}; };
    watched.plateHalf = {plateHalf.x(), plateHalf.y()};
    watched.probes = {Vector3d::Zero()};
    watched.plate = makeBox(plateHalf);
    watched.mover = makeBox(half);
    return watchRun(scene, kind, std::move(watched), {setting.timeStep, stepsFor(0.2, setting, 8)});
}

/// A link on a ball joint, as swingAtPlate(), but turning about an axis that is not the hinge's.
RunOutcome ballJointAtPlate(Kind kind, Material material, const Setting& setting, double phase)
{
    Scene scene(kind);
    const btTransform pose = platePose();
    scene.body(shapeOf(scene, material, kPlateHalf), 0.0, pose);
    auto joint = std::make_unique<btMultiBody>(1, btScalar(0), vec(1, 1, 1), true, false);
    joint->setupSpherical(0,
                          btScalar(0.01),
                          vec(1e-5, 1e-5, 1e-5),
                          -1,
                          btQuaternion::getIdentity(),
                          vec(0, 0, 0),
                          vec(kLinkHalf.x(), 0, 0),
                          true);
    joint->finalizeMultiDof();
    btMultiBody* body =
        scene.addMultiBody(std::move(joint), nullptr, {shapeOf(scene, material, kLinkHalf)});
    const double spread = std::min(setting.speed * setting.timeStep, 0.9);
    const btQuaternion turn(vec(0, 0, 1), btScalar(0.3 - spread * phase));
    const btScalar position[] = {turn.x(), turn.y(), turn.z(), turn.w()};
    const btScalar velocity[] = {0, 0, btScalar(-setting.speed)};
    body->setJointPosMultiDof(0, position);
    body->setJointVelMultiDof(0, velocity);
    Scene::placeColliders(*body);

    // About the pivot: there the link does nothing but turn.
    Watched watched;
    watched.read = [collider = body->getLink(0).m_collider](double)
    {
        Isometry3d turned = btCcdToEigen(collider->getWorldTransform());
        turned.translation().setZero();
        return Snapshot{.poses = {turned}};
    };
    watched.place = [X = btCcdToEigen(pose)](const Snapshot& now)
    { return plateAndMover(X, now.poses[0] * Eigen::Translation3d(kLinkHalf.x(), 0.0, 0.0)); };
    watched.plateHalf = {kPlateHalf.x(), kPlateHalf.z()};
    watched.probes = centreLine(0.005);
    watched.plate = makeBox(kPlateHalf);
    watched.mover = makeBox(kLinkHalf);
    return watchRun(scene, kind, std::move(watched), {setting.timeStep, stepsFor(1.6, setting, 8)});
}

/// Two boxes on a hinge, without a fixed base, fly at a plate; one of them is watched.
RunOutcome floatingChainAtPlate(Kind kind, Material material, const Setting& setting, double phase)
{
    Scene scene(kind);
    const Vector3d plateHalf(0.2, 0.2, 0.00025);
    const Vector3d half(0.006, 0.004, 0.005);
    scene.body(shapeOf(scene, material, plateHalf), 0.0, btTransform::getIdentity());
    btCollisionShape* shape = shapeOf(scene, material, half);
    btVector3 inertia;
    btBoxShape(btCcdToBullet(half)).calculateLocalInertia(btScalar(0.01), inertia);
    auto chain = std::make_unique<btMultiBody>(1, btScalar(0.01), inertia, false, false);
    chain->setBaseWorldTransform(
        btTransform(btQuaternion(vec(1, 2, 3).normalized(), btScalar(0.3 + 5.0 * phase)),
                    vec(0, 0, 0.1 + setting.speed * setting.timeStep * phase)));
    chain->setupRevolute(0,
                         btScalar(0.01),
                         inertia,
                         -1,
                         btQuaternion::getIdentity(),
                         vec(0, 0, 1),
                         vec(0.007, 0, 0),
                         vec(0.007, 0, 0),
                         true);
    chain->finalizeMultiDof();
    chain->setBaseVel(vec(0, 0, -setting.speed));
    btMultiBody* body = scene.addMultiBody(std::move(chain), shape, {shape});
    const bool watchLink = int(50.0 * phase) % 2 == 1;
    const btCollisionObject* watchedBox =
        watchLink ? body->getLink(0).m_collider : body->getBaseCollider();
    Watched watched;
    watched.read = [watchedBox](double)
    { return Snapshot{.poses = {btCcdToEigen(watchedBox->getWorldTransform())}}; };
    watched.place = [](const Snapshot& now) { return WatchedPoses{.X_WM = now.poses[0]}; };
    watched.plateHalf = {plateHalf.x(), plateHalf.y()};
    watched.probes = {Vector3d::Zero()};
    watched.plate = makeBox(plateHalf);
    // Only one of the two need come to the plate: near is where the other may be in between.
    watched.mover = makeBox(Vector3d::Constant(0.02));
    return watchRun(scene, kind, std::move(watched), {setting.timeStep, stepsFor(0.1, setting)});
}

TunnellingRow swingRow(const char* name, Material link, Material plate)
{
    // Tip travel per step: 1.25, 5, 5, 15, 20, 37.5, 60, 150 mm.
    return {.name = name,
            .settings = {{1.0 / 240, 5.0},
                         {1.0 / 240, 20.0},
                         {1.0 / 60, 5.0},
                         {1.0 / 240, 60.0},
                         {1.0 / 60, 20.0},
                         {1.0 / 240, 150.0},
                         {1.0 / 60, 60.0},
                         {1.0 / 60, 150.0}},
            .run = [=](Kind kind, const Setting& setting, double phase)
            { return swingAtPlate(kind, link, plate, setting, phase); }};
}
}  // namespace

std::vector<TunnellingRow> linkRows()
{
    std::vector<TunnellingRow> rows = {
        swingRow("link x plate, boxes", Material::Box, Material::Box),
        swingRow("link x plate, mesh x box", Material::Mesh, Material::Box),
        swingRow("link x plate, meshes", Material::Mesh, Material::Mesh),
        swingRow("link x plate, mesh x static mesh", Material::Mesh, Material::StaticMesh),
    };
    const std::vector<Setting> turning = {
        {1.0 / 240, 20.0}, {1.0 / 60, 20.0}, {1.0 / 240, 150.0}, {1.0 / 60, 60.0}};
    const std::vector<Setting> sliding = {
        {1.0 / 240, 5.0}, {1.0 / 240, 10.0}, {1.0 / 60, 10.0}, {1.0 / 240, 40.0}};
    for (const Material material : {Material::Box, Material::Mesh})
    {
        const std::string suffix = material == Material::Box ? ", boxes" : ", meshes";
        rows.push_back({.name = "link x link" + suffix,
                        .settings = turning,
                        .run = [=](Kind kind, const Setting& setting, double phase)
                        { return linkAtLink(kind, material, setting, phase); }});
        rows.push_back({.name = "self-collision" + suffix,
                        .settings = turning,
                        .run = [=](Kind kind, const Setting& setting, double phase)
                        { return linkAtItsOwnChain(kind, material, setting, phase); }});
        rows.push_back({.name = "ball joint x plate" + suffix,
                        .settings = turning,
                        .run = [=](Kind kind, const Setting& setting, double phase)
                        { return ballJointAtPlate(kind, material, setting, phase); }});
        rows.push_back({.name = "floating chain x plate" + suffix,
                        .settings = sliding,
                        .run = [=](Kind kind, const Setting& setting, double phase)
                        { return floatingChainAtPlate(kind, material, setting, phase); }});
        rows.push_back({.name = "slider x plate" + suffix,
                        .settings = sliding,
                        .run = [=](Kind kind, const Setting& setting, double phase)
                        { return sliderAtPlate(kind, material, setting, phase); }});
    }
    return rows;
}
}  // namespace bullet_ccd::reference
