/// Rotation, alone and with translation: rods, pins, wheels, several turns.
#include "benchmarks/reference/catalogue/case_parts.h"
#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <cmath>

namespace bullet_ccd::reference
{
using Eigen::Vector3d;

RigidCase rodToWall(const std::string& id, double length, double h, double w)
{
    const double angle = std::asin(h / length);
    return {.id = id,
            .scene = {.meshA = segment({0, 0, 0}, {length, 0, 0}),
                      .meshB = wallAtY(h, 2.0 * length),
                      .motionA = {.w_W = {0, 0, w}}},
            .answer = {
                .time = angle / w, .closingSpeed = length * w * std::cos(angle), .length = length}};
}

RigidCase barToPin(const std::string& id, double w)
{
    constexpr double kHalf = 0.05;
    constexpr double kPin = 0.1;
    constexpr double kRho = 1.5;
    constexpr double kPhi = 1.2;
    const double lag = std::asin((kPin + kHalf) / kRho);
    const double angle = kPhi - lag;
    return {
        .id = id,
        .scene = {.meshA = box({0, -kHalf, -0.2}, {2, kHalf, 0.2}),
                  .meshB =
                      prism(circlePoints(kPin, circleAngles(16, angle - 0.5 * kPi)), -0.5, 0.5),
                  .motionA = {.w_W = {0, 0, w}},
                  .motionB = {.X_W0 = poseOf({kRho * std::cos(kPhi), kRho * std::sin(kPhi), 0})}},
        .answer = {.time = angle / w, .closingSpeed = w * kRho * std::cos(lag)}};
}

RigidCase rollingSpike(const std::string& id, double excess)
{
    const double w = 2.0 * kPi;
    const Vector3d tip(0, 0, 1.0 + excess);
    RigidCase spike{
        .id = id,
        .scene = {.meshA = triangle(tip, tip, tip),
                  .meshB = floorAt(0.0, 10.0),
                  .motionA = {.X_W0 = poseOf({0, 0, 1}), .v_W = {w, 0, 0}, .w_W = {0, w, 0}}},
        .answer = {.clearance = -excess}};
    if (excess >= 0.0)
    {
        const double angle = std::acos(-1.0 / (1.0 + excess));
        spike.answer = {.time = angle / w,
                        .closingSpeed = excess > 0.0 ? (1.0 + excess) * w * std::sin(angle) : 0.0,
                        .closingAcceleration = w * w};
    }
    return spike;
}

RigidCase shaftInBearing(const std::string& id, int sides, double radius, const CaseAnswer& answer)
{
    const std::vector<double> angles = circleAngles(sides, 0.0);
    return {.id = id,
            .scene = {.meshA = prism(circlePoints(radius, angles), -0.5, 0.5),
                      .meshB = tube(circlePoints(1.0 / std::cos(kPi / sides), angles), -0.4, 0.4),
                      .motionA = {.w_W = {0, 0, 2.0 * kPi}}},
            .answer = answer,
            .nested = true};
}

namespace
{

/// The reference point is the tip, which moves on a straight line.
RigidCase tipOnALine()
{
    return {.id = "B08b",
            .scene = {.meshA = segment({-2, 0, 0}, {0, 0, 0}),
                      .meshB = wallAtY(1.0, 4.0),
                      .motionA = {.X_W0 = poseOf({2, 0, 0}),
                                  .v_W = {-2, 2, 0},
                                  .w_W = {0, 0, 0.5 * kPi}}},
            .answer = {.time = 0.5, .closingSpeed = 2.0}};
}

RigidCase boxTips()
{
    const double H = 2.0;
    return {.id = "B06",
            .scene = {.meshA = box({-2, -1, -1}, {2, 1, 1}),
                      .meshB = floorAt(0.0, 10.0),
                      .motionA = {.X_W0 = poseOf({0, 0, H}), .w_W = {0, 0.5 * kPi, 0}}},
            .answer = {.time = (std::atan2(2.0, 1.0) - std::acos(H / std::sqrt(5.0))) / (0.5 * kPi),
                       .closingSpeed = 0.5 * kPi * std::sqrt(5.0 - H * H)}};
}

RigidCase closingDoors()
{
    const double angle = std::acos(3.0 / 4.0);
    return {.id = "B09",
            .scene = {.meshA = segment({0, 0, 0}, {2, 0, 0}),
                      .meshB = segment({0, 0, 0}, {-2, 0, 0}),
                      .motionA = {.X_W0 = poseOf({0, 0, 0}, 1.2), .w_W = {0, 0, -1}},
                      .motionB = {.X_W0 = poseOf({3, 0, 0}, -1.2), .w_W = {0, 0, 1}}},
            .answer = {.time = 1.2 - angle, .closingSpeed = 4.0 * std::sin(angle)}};
}

RigidCase scissors()
{
    const double r = 0.3;
    const double D = 1.2;
    const double angle = std::asin(r / D);
    return {
        .id = "B10",
        .scene = {.meshA = segment({0, 0, 0}, {2, 0, 0}),
                  .meshB = prism(circlePoints(r, circleAngles(16, angle + 0.5 * kPi)), -0.5, 0.5),
                  .motionA = {.X_W0 = poseOf({0, 0, 0}, 1.0), .w_W = {0, 0, -1}},
                  .motionB = {.X_W0 = poseOf({D, 0, 0})}},
        .answer = {.time = 1.0 - angle, .closingSpeed = std::sqrt(D * D - r * r)}};
}

RigidCase squarePeg()
{
    const double s = 1.0;
    const double S = 1.2;
    const double angle = std::asin(S / (s * std::sqrt(2.0)));
    return {.id = "B11",
            .scene = {.meshA = box({-0.5 * s, -0.5 * s, -1}, {0.5 * s, 0.5 * s, 1}),
                      .meshB = tube(square(0.5 * S), -0.5, 0.5),
                      .motionA = {.w_W = {0, 0, 1}}},
            .answer = {.time = angle - 0.25 * kPi,
                       .closingSpeed = s / std::sqrt(2.0) * std::cos(angle)},
            .nested = true};
}

/// A wheel of many corners turns over a plane just out of its reach.
RigidCase polygonWheel()
{
    return {.id = "B13",
            .scene = {.meshA = placed(prism(circlePoints(1.0, circleAngles(1024, 0.0)), -0.2, 0.2),
                                      poseOf(Vector3d::Zero(), 0.5 * kPi, Vector3d::UnitX())),
                      .meshB = floorAt(0.0, 10.0),
                      .motionA = {.X_W0 = poseOf({0, 0, 1.001}), .w_W = {0, 2.0 * kPi, 0}}},
            .answer = {.clearance = 1.001 - 1.0, .tolerances = {1e-4}}};
}

RigidCase cubeAroundSphere()
{
    return {.id = "B14",
            .scene = {.meshA = cube(1.0),
                      .meshB = sphereWithPole(0.9, Vector3d::UnitX(), 6),
                      .motionA = {.w_W = {0, 1.2 * kPi, 1.6 * kPi}}},
            .answer = {.clearance = 0.0999},
            .nested = true};
}

RigidCase flywheel()
{
    return {.id = "B16",
            .scene = {.meshA = segment({-1, 0, 0}, {1, 0, 0}),
                      .meshB = wallAtY(1.001, 4.0),
                      .motionA = {.w_W = {0, 0, 200.0 * kPi}}},
            .answer = {.clearance = 1e-3, .tolerances = {1e-4}}};
}

/// A pin on one wheel meets a radial flank of another that turns in the same sense.
RigidCase cogs()
{
    const double rho = 1.8;
    const double D = 3.0;
    const double r = 0.1;
    const double time = std::asin((rho * std::sin(1.0) - r) / D);
    const TriangleMesh pin =
        shifted(prism(circlePoints(r, circleAngles(16, -0.5 * kPi)), -0.5, 0.5),
                {-rho * std::cos(1.0), rho * std::sin(1.0), 0.0});
    return {.id = "B18",
            .scene = {.meshA = segment({0, 0, 0}, {1.8, 0, 0}),
                      .meshB = pin,
                      .motionA = {.w_W = {0, 0, 1}},
                      .motionB = {.X_W0 = poseOf({D, 0, 0}), .w_W = {0, 0, 1}}},
            .answer = {.time = time, .closingSpeed = D * std::cos(time)}};
}

RigidCase screw(const std::string& id, double height, const CaseAnswer& answer)
{
    return {.id = id,
            .scene = {.meshA = segment({0.2, 0, 0}, {1, 0, 0}),
                      .meshB = box({-2, 0, 0}, {0, 2, height}),
                      .motionA = {.X_W0 = poseOf({0, 0, 1}),
                                  .v_W = {0, 0, -0.5},
                                  .w_W = {0, 0, 2.0 * kPi}}},
            .answer = answer};
}

RigidCase tumblingRod()
{
    return {
        .id = "C03",
        .scene = {.meshA = segment({-1.5, 0, 0}, {1.5, 0, 0}),
                  .meshB = floorAt(0.0, 10.0),
                  .motionA = {.X_W0 = poseOf({0, 0, 2}), .v_W = {0, 0, -1}, .w_W = {0, kPi, 0}}},
        .answer = {.time = 0.5, .closingSpeed = 1.0}};
}

}  // namespace

std::vector<RigidCase> rotationCases()
{
    RigidCase micro = rodToWall("B05", 1.0, 5e-7, 1e-6);
    micro.answer.tolerances = {1e-10};
    const RigidCase bearing =
        shaftInBearing("B12", 256, 0.999, {.clearance = 1.0 - 0.999, .tolerances = {1e-4}});
    const TriangleMesh cone = merged({fan({0, 0, -1}, 1.0, 0.0, 16), fan({0, 0, 0}, 1.0, 0.0, 16)});
    const RigidCase bar = barToPin("B02", 0.5 * kPi);
    return {
        rodToWall("B01", 2.0, 1.0, 0.5 * kPi),
        bar,
        barToPin("B03", 6.0 * kPi),
        barToPin("B04", kPi),
        micro,
        boxTips(),
        rodToWall("B07", 100.0, 0.5, 0.01),
        rodToWall("B08a", 2.0, 1.0, 0.5 * kPi),
        tipOnALine(),
        closingDoors(),
        scissors(),
        squarePeg(),
        bearing,
        polygonWheel(),
        cubeAroundSphere(),
        {.id = "B15",
         .scene = {.meshA = cone,
                   .meshB = floorAt(0.0, 10.0),
                   .motionA = {.X_W0 = poseOf({0, 0, 5}),
                               .v_W = {0, 0, -8},
                               .w_W = {0, 0, 100.0 * kPi}}},
         .answer = {.time = (5.0 - 1.0) / 8.0, .closingSpeed = 8.0}},
        flywheel(),
        cogs(),
        screw("C01", 0.8, {.time = (1.0 - 0.8) / 0.5, .closingSpeed = 0.5}),
        screw("C02", 0.9, {.time = 0.25, .closingSpeed = 0.2 * 2.0 * kPi}),
        tumblingRod(),
        rollingSpike("C05a", 0.0),
        rollingSpike("C05b", 1e-4),
        barToPin("J06", 4.0 * kPi),
        inUnits("F06c", bar, 1e-6),
        inUnits("F06d", bar, 1e6),
    };
}
}  // namespace bullet_ccd::reference
