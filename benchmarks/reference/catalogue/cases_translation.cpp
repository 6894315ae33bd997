/// Pure translation: faces, edges and vertices that meet, tunnelling, tight passages.
#include "benchmarks/reference/catalogue/case_parts.h"
#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/math/pose.h"

#include <cmath>

namespace bullet_ccd::reference
{
using Eigen::Vector3d;

RigidCase throughSheet(const std::string& id, double half, double from)
{
    return {.id = id,
            .scene = {.meshA = cube(half),
                      .meshB = wallAtX(0.0, 2.0),
                      .motionA = {.X_W0 = poseOf({from, 0, 0}), .v_W = {-1000, 0, 0}}},
            .answer = {.time = (from - half) / 1000.0, .closingSpeed = 1000.0}};
}

namespace
{
/// Square bars of half diagonal r with ridges up and down, crossed at `angle`.
RigidCase crossedRods(const std::string& id, double angle)
{
    constexpr double kRadius = 0.1;
    const TriangleMesh rod = placed(prism(circlePoints(kRadius, circleAngles(4, 0.0)), -1.0, 1.0),
                                    poseOf(Vector3d::Zero(), 0.5 * kPi, Vector3d::UnitY()));
    return {.id = id,
            .scene = {.meshA = rod,
                      .meshB = rod,
                      .motionB = {.X_W0 = poseOf({0, 0, 1}, angle), .v_W = {0, 0, -2}}},
            .answer = {.time = (1.0 - 2.0 * kRadius) / 2.0, .closingSpeed = 2.0}};
}

/// Time at which two balls of total radius R meet, centres p apart and approaching with v.
double ballsMeet(const Vector3d& p, const Vector3d& v, double R)
{
    const double pv = p.dot(v);
    return (-pv - std::sqrt(pv * pv - v.squaredNorm() * (p.squaredNorm() - R * R))) /
           v.squaredNorm();
}

RigidCase spheres(const std::string& id, const Vector3d& drift)
{
    constexpr double kA = 0.7;
    constexpr double kB = 0.5;
    const Vector3d p(3, 1, -0.5);
    const Vector3d v(-6, -1.5, 1);
    const double time = ballsMeet(p, v, kA + kB);
    const Vector3d towardsA = (p + time * v).normalized();
    return {.id = id,
            .scene = {.meshA = sphereWithPole(kA, -towardsA),
                      .meshB = sphereWithPole(kB, towardsA),
                      .motionA = {.X_W0 = poseOf(p), .v_W = v + drift},
                      .motionB = {.v_W = drift}},
            .answer = {.time = time, .closingSpeed = -v.dot(towardsA)}};
}

RigidCase parallelCylinders()
{
    constexpr double kA = 0.7;
    constexpr double kB = 0.5;
    const Vector3d p(3, 1, 0);
    const Vector3d v(-6, -1.5, 0);
    const double time = ballsMeet(p, v, kA + kB);
    const Vector3d towardsA = (p + time * v).normalized();
    const double angle = std::atan2(towardsA.y(), towardsA.x());
    return {.id = "A13",
            .scene = {.meshA = prism(circlePoints(kA, circleAngles(24, angle + kPi)), -1, 1),
                      .meshB = prism(circlePoints(kB, circleAngles(24, angle)), -1, 1),
                      .motionA = {.X_W0 = poseOf(p), .v_W = v}},
            .answer = {.time = time, .closingSpeed = -v.dot(towardsA)}};
}

RigidCase throughSlot(const std::string& id, double drift)
{
    RigidCase result{.id = id,
                     .scene = {.meshA = cube(1.0),
                               .meshB = tube(square(1.001), -7.0, 7.0),
                               .motionA = {.X_W0 = poseOf({0, 0, -5}), .v_W = {0, drift, 10}}},
                     .answer = {.clearance = 1.001 - 1.0, .tolerances = {1e-4, 1e-6}}};
    if (drift > 0.0)
    {
        result.answer.time = (1.001 - 1.0) / drift;
        result.answer.closingSpeed = drift;
    }
    return result;
}

RigidCase pegInBlindHole()
{
    const TriangleMesh hole = merged({tube(square(1.001), -1.0, 1.0), floorAt(-1.0, 1.001)});
    return {.id = "J04",
            .scene = {.meshA = box({-1, -1, 0}, {1, 1, 3}),
                      .meshB = hole,
                      .motionA = {.v_W = {0, 0, -2}}},
            .answer = {.time = 0.5, .closingSpeed = 2.0, .tolerances = {1e-4, 1e-6}}};
}

RigidCase combs()
{
    // Teeth along y with a pitch of 2 and a clearance of 1e-3 on both sides.
    TriangleMesh a;
    TriangleMesh b;
    for (int k = 0; k < 8; ++k)
    {
        const double x = 2.0 * k;
        a = merged({a, box({x, 0, 0}, {x + 0.999, 4, 1})});
        b = merged({b, box({x + 1.0, -4, 0}, {x + 1.999, 1, 1})});
    }
    return {.id = "J05",
            .scene = {.meshA = a, .meshB = b, .motionA = {.v_W = {0, -0.8, 0}}},
            .answer = {.clearance = 1e-3, .tolerances = {1e-4, 1e-6}}};
}

RigidCase intoCavity()
{
    const TriangleMesh cavity = merged({tube(square(1.0), -1.0, 1.0), floorAt(-1.0, 1.0)});
    return {.id = "J07",
            .scene = {.meshA = cube(0.4),
                      .meshB = cavity,
                      .motionA = {.X_W0 = poseOf({0, 0, 0.4}), .v_W = {0, 0, -2}}},
            .answer = {.time = (0.4 - 0.4 + 1.0) / 2.0, .closingSpeed = 2.0}};
}

/// A hundred plates in one plane, all met at once.
RigidCase ontoPlates()
{
    TriangleMesh plates;
    for (int i = 0; i < 10; ++i)
    {
        for (int j = 0; j < 10; ++j)
        {
            const double x = -1.0 + 0.2 * i;
            const double y = -1.0 + 0.2 * j;
            plates = merged({plates, shifted(floorAt(0.0, 0.1), {x + 0.1, y + 0.1, 0})});
        }
    }
    return {.id = "J03",
            .scene = {.meshA = cube(1.0),
                      .meshB = plates,
                      .motionA = {.X_W0 = poseOf({0, 0, 5}), .v_W = {0, 0, -8}}},
            .answer = {.time = (5.0 - 1.0) / 8.0, .closingSpeed = 8.0}};
}

/// A jaw that closes on an object of half width 0.025, which stands that far off the middle.
RigidCase jaw(const std::string& id, double offset, double time)
{
    constexpr double kTravel = 0.04;
    return {.id = id,
            .scene = {.meshA = box({0, -0.02, -0.02}, {0.01, 0.02, 0.02}),
                      .meshB =
                          shifted(box({-0.025, -0.03, -0.03}, {0.025, 0.03, 0.03}), {offset, 0, 0}),
                      .motionA = {.X_W0 = poseOf({0.04, 0, 0}), .v_W = {-kTravel, 0, 0}}},
            .answer = {.time = time, .closingSpeed = kTravel, .length = 0.1}};
}

/// Down onto a ball of radius 0.03, which something `reach` below the palm meets first.
RigidCase palmToBall(const std::string& id, const TriangleMesh& palm, double reach)
{
    return {.id = id,
            .scene = {.meshA = palm,
                      .meshB = sphereWithPole(0.03, Vector3d::UnitZ()),
                      .motionA = {.X_W0 = poseOf({0, 0, 0.25}), .v_W = {0, 0, -0.30}}},
            .answer = {.time = (0.25 - reach - 0.03) / 0.30, .closingSpeed = 0.30, .length = 0.1}};
}
}  // namespace

std::vector<RigidCase> translationCases()
{
    // From a height of 5 at speed 8, turned so that the lowest point is so far below the middle.
    const auto dropped = [](const std::string& id, const Eigen::Isometry3d& turn, double lowest)
    {
        return cubeOverFloor(id,
                             {.X_W0 = poseOf({0, 0, 5}) * turn, .v_W = {0, 0, -8}},
                             {.time = (5.0 - lowest) / 8.0, .closingSpeed = 8.0});
    };
    const RigidCase faceOn = dropped("A01", Eigen::Isometry3d::Identity(), 1.0);
    const Eigen::Isometry3d onVertex(rotationBetween(Vector3d(1, 1, 1), Vector3d::UnitZ()));
    const RigidCase balls = spheres("A08", Vector3d::Zero());
    const TriangleMesh palm = floorAt(0.0, 0.05);
    const auto twoCubes = [](double offset, double vy) -> RigidScene
    {
        return {.meshA = cube(1.0),
                .meshB = cube(1.0),
                .motionA = {.X_W0 = poseOf({5, offset, 0}), .v_W = {-4, vy, 0}}};
    };
    return {
        faceOn,
        dropped("A02", onVertex, std::sqrt(3.0)),
        dropped("A03", poseOf({0, 0, 0}, 0.25 * kPi, Vector3d::UnitX()), std::sqrt(2.0)),
        crossedRods("A04", 0.5 * kPi),
        crossedRods("A05", 1e-6),
        crossedRods("A06", 0.0),
        {.id = "A07",
         .scene = {.meshA = octahedron(),
                   .meshB = octahedron(),
                   .motionA = {.X_W0 = poseOf({0, 0, 5}), .v_W = {0, 0, -4}}},
         .answer = {.time = (5.0 - 2.0) / 4.0, .closingSpeed = 4.0}},
        balls,
        spheres("A09", {1e3, -2e3, 5e2}),
        inUnits("F06a", balls, 1e-6),
        inUnits("F06b", balls, 1e6),
        // Near the edges of what single-precision volumes can hold.
        inUnits("F17a", faceOn, 1e-8),
        inUnits("F17b", faceOn, 1e+10),
        throughSheet("A10", 0.5, 5.0),
        throughSlot("A11", 0.0),
        throughSlot("A12", 0.01),
        parallelCylinders(),
        {.id = "A14",
         .scene = twoCubes(5.0, -4.0),
         .answer = {.time = (5.0 - 2.0) / 4.0, .closingSpeed = 4.0 * std::sqrt(2.0)}},
        {.id = "D09a",
         .scene = twoCubes(2.0, 0.0),
         .answer = {.time = (5.0 - 2.0) / 4.0, .closingSpeed = 4.0}},
        {.id = "D09b", .scene = twoCubes(2.0 + 1e-12, 0.0), .answer = {.clearance = 1e-12}},
        {.id = "D09c",
         .scene = twoCubes(2.0 - 1e-12, 0.0),
         .answer = {.time = (5.0 - 2.0) / 4.0, .closingSpeed = 4.0}},
        pegInBlindHole(),
        combs(),
        intoCavity(),
        ontoPlates(),
        palmToBall("I01", palm, 0.0),
        palmToBall("I10", merged({palm, segment({0, 0, 0}, {0, 0, -0.02})}), 0.02),
        jaw("I02", 0.0, (0.08 - 0.05) / 2.0 / 0.04),
        jaw("I03a", 0.005, (0.015 - 0.005) / 0.04),
        jaw("I03b", -0.005, (0.015 + 0.005) / 0.04),
    };
}
}  // namespace bullet_ccd::reference
