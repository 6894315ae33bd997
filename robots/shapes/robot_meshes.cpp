#include "robots/shapes/robot_meshes.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "robots/shapes/polygonize.h"

#include <cmath>
#include <numbers>

namespace bullet_ccd::shapes
{
namespace
{
/// A finger bone: round ends about (0, 0, 0) and (0, 0, length), slimmer between them.
struct Bone
{
    double length = 0.0;  ///< between the centres of the ends [m]
    double startRadius = 0.0;
    double endRadius = 0.0;
    double endHeight = 0.0;  ///< of the cap beyond the end's centre; endRadius makes it a ball
    double waist = 0.0;      ///< taken off the radius half way [m]
    double flatness = 0.12;  ///< share that the palmar side is flattened by
    int capRings = 6;
    int shaftRings = 10;
    int segments = 20;
};

TriangleMesh makeBone(const Bone& bone)
{
    Profile stations;
    const auto addCap = [&](double center, double radius, double height, double from, double to)
    {
        for (int i = 0; i <= bone.capRings; ++i)
        {
            const double angle = from + (to - from) * i / bone.capRings;
            const bool isPole = std::abs(angle) > 0.5 * std::numbers::pi - 1e-9;
            stations.emplace_back(isPole ? 0.0 : radius * std::cos(angle),
                                  center + height * std::sin(angle));
        }
    };
    addCap(0.0, bone.startRadius, bone.startRadius, -0.5 * std::numbers::pi, 0.0);
    for (int i = 1; i < bone.shaftRings; ++i)
    {
        const double t = static_cast<double>(i) / bone.shaftRings;
        const double slim = std::sin(std::numbers::pi * t);
        stations.emplace_back(
            bone.startRadius + t * (bone.endRadius - bone.startRadius) - bone.waist * slim * slim,
            t * bone.length);
    }
    addCap(bone.length, bone.endRadius, bone.endHeight, 0.0, 0.5 * std::numbers::pi);
    const auto section = [&](int station)
    {
        const Eigen::Vector2d& ring = stations[static_cast<std::size_t>(station)];
        std::vector<Eigen::Vector3d> points;
        for (int i = 0; i < bone.segments; ++i)
        {
            const double angle = 2.0 * std::numbers::pi * i / bone.segments;
            const double palmar = std::max(0.0, std::cos(angle));
            const double x = ring.x() * std::cos(angle) * (1.0 - bone.flatness * palmar);
            points.emplace_back(x + 0.0, ring.x() * std::sin(angle) + 0.0, ring.y());
        }
        return points;
    };
    return makeLofted(section, static_cast<int>(stations.size()));
}

/// Half space on the side that `normal` points away from.
Solid halfSpace(const Eigen::Vector3d& normal, double offset)
{
    const Eigen::Vector3d unit = normal.normalized();
    return [=](const Eigen::Vector3d& p) { return unit.dot(p) - offset; };
}

Eigen::AlignedBox3d box(double x0, double x1, double y0, double y1, double z0, double z1)
{
    return {Eigen::Vector3d(x0, y0, z0), Eigen::Vector3d(x1, y1, z1)};
}

Solid boxBetween(const Eigen::AlignedBox3d& extent, double rounding)
{
    return moved(roundedBox(0.5 * extent.sizes(), rounding), extent.center());
}

/// Palm: wrist flange, plate that widens towards the fingers, a socket under every finger and the
/// post that the thumb base turns on.
TriangleMesh makeHandPalm()
{
    Solid plate = boxBetween(box(-0.014, 0.014, -0.051, 0.051, 0.004, 0.090), 0.010);
    for (const double side : {-1.0, 1.0})
    {
        const Eigen::Vector3d normal(0.0, side, -0.17);
        plate = blendIntersect(plate, halfSpace(normal, 0.036 / normal.norm()), 0.006);
    }
    Solid palm = blend(plate, roundedCylinder(0.031, 0.0, 0.014, 0.003), 0.006);
    palm = blend(palm, moved(roundedCylinder(0.0145, 0.0, 0.022, 0.002), {0.030, 0, 0}), 0.004);
    for (const double y : {-0.036, 0.0, 0.036})
    {
        palm = blend(palm, moved(roundedCylinder(0.0115, 0.080, 0.0935, 0.003), {0, y, 0}), 0.003);
    }
    return polygonize(
        palm,
        box(-0.035, 0.050, -0.055, 0.055, -0.002, 0.097),
        {.cell = 1.5e-3, .chordError = 2.2e-4, .shortestEdge = 2.6e-3, .longestEdge = 9e-3});
}

/// Thumb base: hub about its joint, arm along +x and a socket that leans out under the thumb.
TriangleMesh makeThumbBase()
{
    const Eigen::Vector3d thumb(0.058, 0.0, 0.057);  // origin of the thumb's first joint
    const double lean = 20.0 * std::numbers::pi / 180.0;
    const Eigen::Vector3d bone(std::sin(lean), 0.0, std::cos(lean));
    Solid base = roundedCylinder(0.0145, 0.002, 0.022, 0.002);
    base = blend(base, boxBetween(box(-0.004, 0.050, -0.0105, 0.0105, 0.002, 0.021), 0.006), 0.004);
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translate(thumb - 0.050 * bone);
    X.rotate(Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitY()));
    base = blend(base, placed(roundedCylinder(0.0115, 0.0, 0.0385, 0.002), X), 0.004);
    return polygonize(
        base,
        box(-0.018, 0.075, -0.018, 0.018, -0.002, 0.057),
        {.cell = 1.5e-3, .chordError = 2.2e-4, .shortestEdge = 2.6e-3, .longestEdge = 9e-3});
}

/// Rounded block of a gripper: small fillets, flat faces.
TriangleMesh polygonizeBlock(const Solid& solid, const Eigen::AlignedBox3d& extent)
{
    return polygonize(
        solid, extent, {.chordError = 2.0e-4, .shortestEdge = 2.4e-3, .longestEdge = 1.5e-2});
}
}  // namespace

RobotMeshes anthropomorphicHandMeshes()
{
    RobotMeshes meshes{"anthropomorphic_hand", {}};
    meshes.links.push_back({"palm", makeHandPalm()});
    meshes.links.push_back({"thumb_base", makeThumbBase()});
    // The ball of the knuckle sits inside the proximal phalanx; its foot reaches into the socket.
    TriangleMesh knuckle = makeBone({.length = 0.0150,
                                     .startRadius = 0.0080,
                                     .endRadius = 0.0080,
                                     .endHeight = 0.0080,
                                     .waist = 0.0008,
                                     .flatness = 0.0,
                                     .shaftRings = 6});
    transformMesh(knuckle, Eigen::Affine3d(Eigen::Translation3d(0.0, 0.0, -0.0150)));
    meshes.links.push_back({"finger_knuckle", knuckle});
    meshes.links.push_back({"finger_proximal",
                            makeBone({.length = 0.067816,
                                      .startRadius = 0.0090,
                                      .endRadius = 0.0083,
                                      .endHeight = 0.0083,
                                      .waist = 0.0012,
                                      .shaftRings = 18})});
    meshes.links.push_back({"finger_medial",
                            makeBone({.length = 0.029980,
                                      .startRadius = 0.0080,
                                      .endRadius = 0.0078,
                                      .endHeight = 0.0078,
                                      .waist = 0.0006})});
    meshes.links.push_back({"finger_distal",
                            makeBone({.length = 0.0195,
                                      .startRadius = 0.0075,
                                      .endRadius = 0.0072,
                                      .endHeight = 0.0095,
                                      .waist = -0.0004,
                                      .flatness = 0.18,
                                      .capRings = 7})});
    return meshes;
}

RobotMeshes threeFingerGripperMeshes()
{
    RobotMeshes meshes{"three_finger_gripper", {}};
    Solid palm = roundedCylinder(0.045, 0.0, 0.068, 0.004);
    palm = blend(palm, boxBetween(box(-0.064, -0.030, -0.011, 0.011, 0.040, 0.088), 0.005), 0.004);
    meshes.links.push_back(
        {"palm", polygonizeBlock(palm, box(-0.066, 0.046, -0.046, 0.046, -0.001, 0.096))});
    Solid spread = roundedCylinder(0.0135, 0.001, 0.019, 0.003);
    spread =
        blend(spread, boxBetween(box(-0.004, 0.060, -0.011, 0.011, 0.001, 0.018), 0.005), 0.004);
    meshes.links.push_back(
        {"finger_spread", polygonizeBlock(spread, box(-0.015, 0.062, -0.015, 0.015, 0.0, 0.026))});
    meshes.links.push_back({"finger_proximal",
                            makeBone({.length = 0.070,
                                      .startRadius = 0.0105,
                                      .endRadius = 0.0095,
                                      .endHeight = 0.0095,
                                      .waist = 0.0008,
                                      .flatness = 0.2,
                                      .shaftRings = 18})});
    meshes.links.push_back({"finger_distal",
                            makeBone({.length = 0.047,
                                      .startRadius = 0.0090,
                                      .endRadius = 0.0070,
                                      .endHeight = 0.0090,
                                      .flatness = 0.2,
                                      .capRings = 7,
                                      .shaftRings = 14})});
    return meshes;
}

RobotMeshes parallelGripperMeshes()
{
    RobotMeshes meshes{"parallel_gripper", {}};
    Solid base = boxBetween(box(-0.085, 0.085, -0.030, 0.030, 0.010, 0.068), 0.006);
    base = blend(base, roundedCylinder(0.0315, 0.0, 0.02, 0.002), 0.004);
    meshes.links.push_back(
        {"base", polygonizeBlock(base, box(-0.086, 0.086, -0.033, 0.033, -0.001, 0.070))});
    // Pad face in the plane x = 0; carriage and finger stand 4 mm behind it.
    Solid jaw = boxBetween(box(0.004, 0.034, -0.018, 0.018, 0.001, 0.018), 0.004);
    jaw = blend(jaw, boxBetween(box(0.004, 0.018, -0.0105, 0.0105, 0.004, 0.082), 0.004), 0.003);
    jaw = blend(jaw, boxBetween(box(0.0, 0.011, -0.0135, 0.0135, 0.034, 0.086), 0.003), 0.0015);
    meshes.links.push_back(
        {"jaw",
         polygonize(jaw,
                    box(-0.001, 0.036, -0.020, 0.020, 0.0, 0.088),
                    {.cell = 1.5e-3, .chordError = 1.2e-4, .shortestEdge = 1.7e-3})});
    return meshes;
}
}  // namespace bullet_ccd::shapes
