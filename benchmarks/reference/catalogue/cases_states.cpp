/// Initial and final states: overlapping, touching, at rest, moving as one, contact at either end.
///
/// A query of this library tells them apart by its status: surfaces that meet at t = 0 are
/// Overlapping however they move on; bodies within the tolerance that do not close in are
/// TouchingLeaving, which is no contact. So the rows that start at distance 0 have a second form
/// (b) at half the tolerance: what a query sees that goes on from a contact that was reported.
#include "benchmarks/reference/catalogue/case_parts.h"

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Vector3d;
constexpr double kTolerance = 1e-6;

RigidCase cubeAt(const std::string& id,
                 double height,
                 const Vector3d& v,
                 const Vector3d& w,
                 const CaseAnswer& answer)
{
    return cubeOverFloor(
        id, {.X_W0 = poseOf({0, 0, height}), .v_W = v, .w_W = w}, answer, 1.0, 20.0);
}

/// Starts at distance 0.
RigidCase touches(const std::string& id, const Vector3d& v, const Vector3d& w)
{
    return cubeAt(id,
                  1.0,
                  v,
                  w,
                  {.time = 0.0,
                   .closingSpeed = 8.0,
                   .status = ToiStatus::Overlapping,
                   .hangsOnRounding = true});
}

/// Starts at half the tolerance and does not close in.
RigidCase leaves(const std::string& id, const Vector3d& v, const Vector3d& w, double tolerance)
{
    return cubeAt(id,
                  1.0 + 0.5 * tolerance,
                  v,
                  w,
                  {.clearance = 0.5 * tolerance,
                   .tolerances = {tolerance},
                   .status = ToiStatus::TouchingLeaving,
                   .startsTouching = true});
}

/// Two cubes at a gap of 1e-3 that turn and fly as one.
RigidCase coMoving()
{
    RigidCase result{.id = "E06",
                     .scene = {.meshA = cube(1.0), .meshB = cube(1.0)},
                     .answer = {.clearance = 2.001 - 2.0, .tolerances = {1e-4, 1e-6}}};
    result.scene.motionA.X_W0 = poseOf({0.2, 0.1, 2.001});
    moveAsOne(result.scene, {3, -2, 1}, {0, 0, 2}, {0.3, -0.2, 1.0});
    return result;
}
}  // namespace

std::vector<RigidCase> stateCases()
{
    const Vector3d none = Vector3d::Zero();
    const double justTooSlow = 4.0 * (1.0 - 1e-9);
    return {
        cubeAt("E01",
               0.9,
               {0, 0, -1},
               none,
               {.time = 0.0, .closingSpeed = 1.0, .status = ToiStatus::Overlapping}),
        touches("E02", {0, 0, 8}, none),
        leaves("E02b", {0, 0, 8}, none, kTolerance),
        touches("E03", {8, 0, 0}, none),
        leaves("E03b", {8, 0, 0}, none, kTolerance),
        leaves("E04", {3, -2, 0.1}, none, kTolerance),
        cubeAt("E05", 2.0, none, none, {.clearance = 1.0}),
        coMoving(),
        {.id = "E07",
         .scene = {.meshA = cube(0.5), .meshB = cube(2.0), .motionA = {.v_W = {4, 0, 0}}},
         .answer = {.time = (2.0 - 0.5) / 4.0, .closingSpeed = 4.0},
         .nested = true},
        cubeAt("E08", 5.0, {0, 0, -4}, none, {.time = 1.0, .closingSpeed = 4.0}),
        cubeAt("E09",
               5.0,
               {0, 0, -justTooSlow},
               none,
               {.clearance = 4.0 - justTooSlow, .tolerances = {1e-10}}),
        cubeAt(
            "E10",
            1.0 + 4e-9,
            {0, 0, -4},
            none,
            {.time = ((1.0 + 4e-9) - 1.0) / 4.0, .closingSpeed = 4.0, .tolerances = {1e-6, 1e-10}}),
        touches("E11", none, {0, 0, 10}),
        leaves("E11b", none, {0, 0, 10}, 1e-4),
    };
}
}  // namespace bullet_ccd::reference
