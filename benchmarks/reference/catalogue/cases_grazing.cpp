/// Tangencies, near misses, degenerate triangles, extreme scales, traps of known implementations.
#include "benchmarks/reference/catalogue/case_parts.h"
#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::reference
{
using Eigen::Vector3d;

RigidCase passingSpheres(const std::string& id, double offset)
{
    RigidCase result{.id = id,
                     .scene = {.motionA = {.X_W0 = poseOf({3, offset, 0}), .v_W = {-6, 0, 0}}},
                     .answer = {.clearance = offset - 2.0}};
    Vector3d towardsA = Vector3d::UnitY();
    if (offset <= 2.0)
    {
        const double x = std::sqrt(4.0 - offset * offset);
        towardsA = Vector3d(x, offset, 0).normalized();
        result.answer.time = (3.0 - x) / 6.0;
        result.answer.closingSpeed = 6.0 * towardsA.x();
        result.answer.closingAcceleration = 36.0 / 2.0 * towardsA.y() * towardsA.y();
    }
    else
    {
        result.answer.tolerances = {1e-3, 1e-6, 1e-7};
    }
    result.scene.meshA = sphereWithPole(1.0, -towardsA);
    result.scene.meshB = sphereWithPole(1.0, towardsA);
    return result;
}

RigidCase grazingRod(const std::string& id, double excess)
{
    const double length = 1.0 + excess;
    RigidCase result{.id = id,
                     .scene = {.meshA = segment({0, 0, 0}, {length, 0, 0}),
                               .meshB = wallAtY(1.0, 4.0),
                               .motionA = {.w_W = {0, 0, kPi}}},
                     .answer = {.clearance = -excess, .tolerances = {1e-3, 1e-6, 1e-7}}};
    if (excess >= 0.0)
    {
        const double angle = std::asin(1.0 / length);
        result.answer.time = angle / kPi;
        result.answer.closingSpeed = excess > 0.0 ? length * kPi * std::cos(angle) : 0.0;
        result.answer.closingAcceleration = kPi * kPi;
    }
    return result;
}

namespace
{
RigidCase onSlivers()
{
    // Strips of length 20 and width 2e-7.
    TriangleMesh plate;
    for (int k = -20; k < 20; ++k)
    {
        const double y = 2e-7 * k;
        const double next = 2e-7 * (k + 1);
        plate = merged({plate, quad({-10, y, 0}, {10, y, 0}, {10, next, 0}, {-10, next, 0})});
    }
    return falls("F03", box({-0.5, -0.5, 1}, {0.5, 0.5, 2}), plate);
}

RigidCase farFromOrigin()
{
    const Vector3d far = Vector3d::Constant(1e6);
    return {.id = "F05",
            .scene = {.meshA = cube(1.0),
                      .meshB = floorAt(0.0, 10.0),
                      .motionA = {.X_W0 = poseOf(
                                      far + Vector3d(0, 0, 5), 0.25 * kPi, Vector3d::UnitX()),
                                  .v_W = {0, 0, -8}},
                      .motionB = {.X_W0 = poseOf(far)}},
            .answer = {.time = (5.0 - std::sqrt(2.0)) / 8.0, .closingSpeed = 8.0}};
}

RigidCase polygonSoup()
{
    TriangleMesh body = shifted(cube(1.0), {0, 0, 2});
    const std::vector<Triangle> once = body.triangles;
    for (const Triangle& t : once)
    {
        body.triangles.push_back({t[1], t[0], t[2]});  // again, flipped
    }
    body.vertices.push_back({7, 7, -7});  // not used by any triangle
    TriangleMesh ground = floorAt(0.0, 10.0);
    ground = merged({ground, quad({-10, -10, 0}, {3, -10, 0}, {3, 2, 0}, {-10, 2, 0})});
    return falls("F07", body, ground);
}

RigidCase throughWindow()
{
    constexpr double kIn = 1.001;
    return {.id = "F08",
            .scene = {.meshA = cube(1.0),
                      .meshB = band(square(3.0), 0.0, square(kIn), 0.0),
                      .motionA = {.X_W0 = poseOf({0, 0, 5}), .v_W = {0, 0, -10}}},
            .answer = {.clearance = kIn - 1.0, .tolerances = {1e-4, 1e-6}}};
}

RigidCase concentricTriangles()
{
    Random random(9);
    TriangleMesh mesh;
    double lowest = 0.0;
    for (std::int32_t i = 0; i < 1000; ++i)
    {
        const Vector3d a = random.inBox(1.0);
        const Vector3d b = random.inBox(1.0);
        for (const Vector3d& corner : {a, b, Vector3d(-a - b)})
        {
            mesh.vertices.push_back(corner);
            lowest = std::min(lowest, corner.z());
        }
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return falls("F09", shifted(mesh, {0, 0, 1.0 - lowest}), floorAt(0.0, 10.0));
}

RigidCase needleInRing()
{
    const std::vector<double> angles = circleAngles(24, 0.0);
    return {
        .id = "F11",
        .scene = {.meshA = prism(circlePoints(1e-6, circleAngles(6, 0.0)), -0.01, 0.01),
                  .meshB = band(circlePoints(1e-3, angles), 0.0, circlePoints(2e-3, angles), 0.0),
                  .motionA = {.X_W0 = poseOf({0, 0, 0.02}), .v_W = {0, 0, -0.04}}},
        .answer = {.clearance = 1e-3 * std::cos(kPi / 24) - 1.1e-6, .length = 1e-3}};
}

RigidCase swingingBar()
{
    const double reach = std::hypot(2.0, 0.05);
    const double angle = std::asin(1.0 / reach);
    return {.id = "F12",
            .scene = {.meshA = box({0, -0.05, -0.05}, {2, 0.05, 0.05}),
                      .meshB = wallAtY(1.0, 4.0),
                      .motionA = {.w_W = {0, 0, 1.5}}},
            .answer = {.time = (angle - std::atan(0.05 / 2.0)) / 1.5,
                       .closingSpeed = 1.5 * reach * std::cos(angle)}};
}

/// A slow pair that is nearer must not hide the fast pair that hits first.
RigidCase nearerButSlower()
{
    const TriangleMesh body = merged({triangle({10, 0, 0}, {12, 0, 0}, {10, 2, 0}),
                                      triangle({0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0})});
    const TriangleMesh other = merged({segment({11, -0.9, -1}, {11, -0.9, 1}),
                                       triangle({0, 0.6, 0}, {0.1, 0.7, 0}, {-0.1, 0.7, 0})});
    return {.id = "F14",
            .scene = {.meshA = body, .meshB = other, .motionA = {.w_W = {0, 0, -0.2}}},
            .answer = {.time = std::atan2(0.9, 11.0) / 0.2,
                       .closingSpeed = 0.2 * std::hypot(0.9, 11.0)}};
}

/// Past a sphere at a gap of 1e-6, then into a wall.
RigidCase nearMissThenWall()
{
    const TriangleMesh obstacles = merged(
        {shifted(sphereWithPole(0.5, -Vector3d::UnitY()), {0, 1.0 + 1e-6, 0}), wallAtX(5.0, 5.0)});
    return {
        .id = "J01",
        .scene = {.meshA = sphereWithPole(0.5, Vector3d::UnitX()),
                  .meshB = obstacles,
                  .motionA = {.X_W0 = poseOf({-3, 0, 0}), .v_W = {10, 0, 0}}},
        .answer = {.time = (5.0 - 0.5 + 3.0) / 10.0, .closingSpeed = 10.0, .tolerances = {1e-7}}};
}
}  // namespace

std::vector<RigidCase> grazingCases()
{
    return {
        passingSpheres("D01", 2.0),
        passingSpheres("D02a", 2.0 - 1e-3),
        passingSpheres("D02b", 2.0 - 1e-6),
        passingSpheres("D02c", 2.0 - 1e-9),
        passingSpheres("D03", 2.0 + 1e-6),
        grazingRod("D04", 1e-6),
        grazingRod("D05", 0.0),
        grazingRod("D06", -1e-6),
        cubeOverFloor("D07",
                      {.X_W0 = poseOf({0, 0, 1.001}), .v_W = {1000, 0, 0}},
                      {.clearance = 1.001 - 1.0, .tolerances = {1e-4, 1e-6}},
                      1.0,
                      2000.0),
        nearMissThenWall(),
    };
}

std::vector<RigidCase> degenerateCases()
{
    const TriangleMesh ground = floorAt(0.0, 10.0);
    const Vector3d point(0.3, 0.2, 1);
    return {
        falls(
            "D10", triangle({0, 0, 1}, {0.3, 0, 2}, {-0.1, 0.2, 2}), fan({0, 0, 0}, 1.0, -0.3, 32)),
        falls("F01", triangle({0, 0, 1}, {1, 0, 1}, {2, 0, 1}), ground),
        falls("F02", triangle(point, point, point), ground),
        onSlivers(),
        cubeOverFloor("F04",
                      {.X_W0 = poseOf({0, 0, 5e-3}), .v_W = {0, 0, -8e-3}},
                      {.time = (5e-3 - 5e-4) / 8e-3, .closingSpeed = 8e-3, .length = 1e-3},
                      5e-4,
                      5e-3),
        farFromOrigin(),
        polygonSoup(),
        throughWindow(),
        concentricTriangles(),
        falls("F10",
              triangle({0, 0, 1}, {1, 0, 1}, {0, 1, 1}),
              triangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})),
        needleInRing(),
        swingingBar(),
        nearerButSlower(),
        {.id = "F15",
         .scene = {.meshA = cube(0.5),
                   .meshB = cube(0.5),
                   .motionA = {.X_W0 = poseOf({-1, 0, 0}), .v_W = {1, 0, 0}},
                   .motionB = {.X_W0 = poseOf({1, 0, 0}), .v_W = {-1, 0, 0}}},
         .answer = {.time = 0.5, .closingSpeed = 2.0}},
    };
}
}  // namespace bullet_ccd::reference
