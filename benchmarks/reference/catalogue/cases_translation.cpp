/// Pure translation: faces, edges and vertices that meet, tunnelling, tight passages.
#include "benchmarks/reference/catalogue/case_parts.h"
#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <cmath>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Vector3d;

RigidCase cubeOntoFloor(const std::string& id, const Eigen::Isometry3d& X, double lowest)
{
    return {.id = id,
            .scene = {.meshA = cube(1.0),
                      .meshB = floorAt(0.0, 10.0),
                      .motionA = {.X_W0 = X, .v_W = {0, 0, -8}}},
            .answer = {.time = (5.0 - lowest) / 8.0, .closingSpeed = 8.0}};
}

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

/// The same in units of which `factor` make up one.
RigidCase spheresInUnits(const std::string& id, double factor)
{
    RigidCase result = spheres(id, Vector3d::Zero());
    result.scene = scaled(result.scene, factor);
    result.answer.length *= factor;
    result.answer.closingSpeed *= factor;
    return result;
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

/// Four walls around a square passage along z.
TriangleMesh slot(double half, double low, double high)
{
    const auto wall = [&](double x0, double y0, double x1, double y1) {
        return quad({x0, y0, low}, {x1, y1, low}, {x1, y1, high}, {x0, y0, high});
    };
    return merged({wall(-half, -half, half, -half),
                   wall(half, -half, half, half),
                   wall(half, half, -half, half),
                   wall(-half, half, -half, -half)});
}

RigidCase throughSlot(const std::string& id, double drift)
{
    RigidCase result{.id = id,
                     .scene = {.meshA = cube(1.0),
                               .meshB = slot(1.001, -7.0, 7.0),
                               .motionA = {.X_W0 = poseOf({0, 0, -5}), .v_W = {0, drift, 10}}},
                     .answer = {.clearance = 1.001 - 1.0, .tolerances = {1e-4, 1e-6}}};
    if (drift > 0.0)
    {
        result.answer.time = (1.001 - 1.0) / drift;
        result.answer.closingSpeed = drift;
    }
    return result;
}

RigidCase bulletThroughPaper()
{
    return {.id = "A10",
            .scene = {.meshA = cube(0.5),
                      .meshB = quad({0, -2, -2}, {0, 2, -2}, {0, 2, 2}, {0, -2, 2}),
                      .motionA = {.X_W0 = poseOf({5, 0, 0}), .v_W = {-1000, 0, 0}}},
            .answer = {.time = (5.0 - 0.5) / 1000.0, .closingSpeed = 1000.0}};
}

RigidCase pegInBlindHole()
{
    const TriangleMesh hole = merged({slot(1.001, -1.0, 1.0), floorAt(-1.0, 1.001)});
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
    const TriangleMesh cavity = merged({slot(1.0, -1.0, 1.0), floorAt(-1.0, 1.0)});
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
            const double end = 0.2;
            plates = merged(
                {plates, quad({x, y, 0}, {x + end, y, 0}, {x + end, y + end, 0}, {x, y + end, 0})});
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

/// A fingertip 0.02 below the palm is over the same sphere.
RigidCase fingertipBeforePalm()
{
    return {.id = "I10",
            .scene = {.meshA = merged({floorAt(0.0, 0.05), segment({0, 0, 0}, {0, 0, -0.02})}),
                      .meshB = sphereWithPole(0.03, Vector3d::UnitZ()),
                      .motionA = {.X_W0 = poseOf({0, 0, 0.25}), .v_W = {0, 0, -0.30}}},
            .answer = {.time = (0.25 - 0.02 - 0.03) / 0.30, .closingSpeed = 0.30, .length = 0.1}};
}

RigidCase palmToSphere()
{
    return {.id = "I01",
            .scene = {.meshA = floorAt(0.0, 0.05),
                      .meshB = sphereWithPole(0.03, Vector3d::UnitZ()),
                      .motionA = {.X_W0 = poseOf({0, 0, 0.25}), .v_W = {0, 0, -0.30}}},
            .answer = {.time = (0.25 - 0.03) / 0.30, .closingSpeed = 0.30, .length = 0.1}};
}
}  // namespace

std::vector<RigidCase> translationCases()
{
    const Eigen::Isometry3d X = poseOf({0, 0, 5});
    Eigen::Isometry3d onVertex = X;
    onVertex.linear() =
        Eigen::Quaterniond::FromTwoVectors(Vector3d(1, 1, 1), Vector3d::UnitZ()).toRotationMatrix();
    const auto twoCubes = [](double offset, double vy) -> RigidScene
    {
        return {.meshA = cube(1.0),
                .meshB = cube(1.0),
                .motionA = {.X_W0 = poseOf({5, offset, 0}), .v_W = {-4, vy, 0}}};
    };
    return {
        cubeOntoFloor("A01", X, 1.0),
        cubeOntoFloor("A02", onVertex, std::sqrt(3.0)),
        cubeOntoFloor("A03", poseOf({0, 0, 5}, 0.25 * kPi, Vector3d::UnitX()), std::sqrt(2.0)),
        crossedRods("A04", 0.5 * kPi),
        crossedRods("A05", 1e-6),
        crossedRods("A06", 0.0),
        {.id = "A07",
         .scene = {.meshA = octahedron(),
                   .meshB = octahedron(),
                   .motionA = {.X_W0 = poseOf({0, 0, 5}), .v_W = {0, 0, -4}}},
         .answer = {.time = (5.0 - 2.0) / 4.0, .closingSpeed = 4.0}},
        spheres("A08", Vector3d::Zero()),
        spheres("A09", {1e3, -2e3, 5e2}),
        spheresInUnits("F06a", 1e-6),
        spheresInUnits("F06b", 1e6),
        bulletThroughPaper(),
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
        palmToSphere(),
        fingertipBeforePalm(),
        jaw("I02", 0.0, (0.08 - 0.05) / 2.0 / 0.04),
        jaw("I03a", 0.005, (0.015 - 0.005) / 0.04),
        jaw("I03b", -0.005, (0.015 + 0.005) / 0.04),
    };
}
}  // namespace bullet_ccd::reference
