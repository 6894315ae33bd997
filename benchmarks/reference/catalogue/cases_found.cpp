/// Scenes that once broke something in this project, and scenes that sampling and other codes get
/// wrong which the catalogue does not have. Where each comes from is said above it.
#include "benchmarks/reference/catalogue/case_parts.h"
#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <cmath>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Vector2d;
using Eigen::Vector3d;

/// A square bar about z with an edge pointing along -x at (x, 0).
TriangleMesh wedgeAt(double x)
{
    return prism({{x, 0}, {x + 1, -1}, {x + 2, 0}, {x + 1, 1}}, -1.0, 1.0);
}

/// A square bar of half 1 turns about its axis; the edge of another, parallel to all its edges,
/// is at distance rho from that axis. In the frame of the turning bar the edge goes around a
/// circle; it is rho cos(angle) - 1 over the face that it starts in front of, and meets it there at
/// tan(angle) = sqrt(rho^2 - 1) < 1 of its half.
///
/// Seven of a million soak queries with parallel edges that turn were called hits beyond the
/// tolerance: cross products of the edges vanish, the direction of the closest points has no
/// digits, and the step stalled.
RigidCase parallelEdges()
{
    const double rho = 1.2;
    return {.id = "N01",
            .scene = {.meshA = cube(1.0), .meshB = wedgeAt(rho), .motionA = {.w_W = {0, 0, 1}}},
            .answer = {.time = std::acos(1.0 / rho), .closingSpeed = std::sqrt(rho * rho - 1.0)}};
}

/// The same from a gap within the tolerance, at rest for an instant: g' = 0, g'' = -rho w^2.
///
/// Corners of fast bodies left a Bullet world's time-of-impact event with a normal velocity of
/// zero, came back along that parabola at once, and the step ended in ever shorter events.
RigidCase curvesIn()
{
    const double rho = 1.0 + 5e-7;
    RigidCase result = parallelEdges();
    result.id = "N21";
    result.scene.meshB = wedgeAt(rho);
    result.answer = {.time = std::acos(1.0 / rho),
                     .closingSpeed = std::sqrt(rho * rho - 1.0),
                     .tolerances = {1e-6},
                     .startsTouching = true};
    return result;
}

/// Slivers of aspect 1e9 that cross: hits of slivers were reported with gap 0 while they were apart
/// (soak), as the plane of a sliver is known to rounding / height only.
RigidCase crossingSlivers()
{
    return falls("N02",
                 triangle({-0.5, 0, 1}, {0.5, 0, 1}, {0, 1e-9, 1}),
                 triangle({0, -0.5, 0}, {0, 0.5, 0}, {1e-9, 0, 0}));
}

/// A rod's tip on a circle of radius 1e5: h = R sin(w t). Poses of motions with a far axis formed
/// the axis and cancelled it again, which put the start off by 2e-7.
RigidCase farAxis()
{
    const double R = 1e5;
    const double w = 1e-5;
    const double h = 0.5;
    const double angle = std::asin(h / R);
    return {.id = "N03",
            .scene = {.meshA = segment({-1, 0, 0}, {0, 0, 0}),
                      .meshB = wallAtY(h, 4.0),
                      .motionA = {.X_W0 = poseOf({R, 0, 0}),
                                  .w_W = {0, 0, w},
                                  .reference_B = {-R, 0, 0}},
                      .motionB = {.X_W0 = poseOf({R, 0, 0})}},
            .answer = {.time = angle / w, .closingSpeed = R * w * std::cos(angle)}};
}

/// B01 with the mesh 1000 off its frame and turning about its own end. The bound of its
/// acceleration counted from the frame and cost a thousand times too many steps.
RigidCase farFromItsFrame()
{
    const double w = 0.5 * kPi;
    return {.id = "N04",
            .scene = {.meshA = segment({1000, 0, 0}, {1002, 0, 0}),
                      .meshB = wallAtY(1.0, 4.0),
                      .motionA = {.X_W0 = poseOf({-1000, 0, 0}),
                                  .w_W = {0, 0, w},
                                  .reference_B = {1000, 0, 0}}},
            .answer = {.time = std::asin(0.5) / w, .closingSpeed = 2.0 * w * std::cos(kPi / 6.0)}};
}

/// Both turn 30 times about one hub and fly together; A in addition sinks along the axis, so that
/// in the turning frame the gap is 0.5 - t. Each body's own speed once cost thousands of poses.
RigidCase turnsAndCloses()
{
    RigidCase result{.id = "N06",
                     .scene = {.meshA = cube(1.0), .meshB = cube(1.0)},
                     .answer = {.time = 2.5 - 2.0, .closingSpeed = 1.0}};
    result.scene.motionA.X_W0 = poseOf({0.2, 0.1, 2.5});
    moveAsOne(result.scene, {3, -2, 1}, {0, 0, 60.0 * kPi}, {5, 3, -4});
    result.scene.motionA.v_W.z() -= 1.0;
    return result;
}

/// A rod whose tip is within the tolerance of a wall turns away and comes back: its height is
/// f(t) = cos(2 pi t) + v t, and v is chosen such that f = 1 + g, the wall, at t = 0.98. Before
/// that f stays below: it rises by v^2 / (8 pi^2) < g / 50 at first, falls, and is increasing from
/// the half turn on. Starts that leave were once forgotten for good, or stopped at once.
RigidCase comesBack()
{
    const double g = 5e-5;
    const double time = 0.98;
    const double w = 2.0 * kPi;
    const double v = (1.0 + g - std::cos(w * time)) / time;
    return {.id = "N07",
            .scene = {.meshA = segment({0, 0, 0}, {0, 1, 0}),
                      .meshB = wallAtY(1.0 + g, 4.0),
                      .motionA = {.v_W = {0, v, 0}, .w_W = {0, 0, w}}},
            .answer = {.time = time,
                       .closingSpeed = v - w * std::sin(w * time),
                       .tolerances = {1e-4},
                       .startsTouching = true}};
}

/// A01 with everything 1e8 off the origin: the last bit of a coordinate is 1.5e-8, and single
/// precision has none of the scene left. Volumes in the world frame would not separate anything.
RigidCase farOff()
{
    const Vector3d far(1e8, -1e8, 1e8);
    RigidCase result =
        cubeOverFloor("N08",
                      {.X_W0 = poseOf(far + Vector3d(0, 0, 5)), .v_W = {0, 0, -8}},
                      {.time = (5.0 - 1.0) / 8.0, .closingSpeed = 8.0, .tolerances = {1e-3, 1e-4}});
    result.scene.motionB = {.X_W0 = poseOf(far)};
    return result;
}

/// The soak's spikes: no face, no edge and no normal that would tell the direction.
RigidCase needlesMeet()
{
    return falls("N09", fan({0, 0, 1}, 1e-3, 2.0, 8), fan({0, 0, 0}, 1e-3, -1.0, 8));
}

/// Sizes that differ by a million. Absolute thresholds fit one of them.
RigidCase unequalSizes()
{
    RigidCase result = falls("N10", shifted(cube(1e-3), {0, 0, 1.001}), floorAt(0.0, 1e3));
    result.answer.length = 1e-3;
    return result;
}

/// Two feet above two plates, of which one is 2e-9 lower: the second contact comes 1e-9 later.
RigidCase twoContacts()
{
    const auto plate = [](double x, double z) {
        return quad({x - 1, -1, z}, {x + 1, -1, z}, {x + 1, 1, z}, {x - 1, 1, z});
    };
    return falls("N12",
                 merged({box({-2, -0.3, 1}, {-1, 0.3, 2}), box({1, -0.3, 1}, {2, 0.3, 2})}),
                 merged({plate(-1.5, -2e-9), plate(1.5, 0.0)}));
}

/// A blade spins 50 times and drifts to a wall. Its reach is f(t) = v t + |cos(w t)|; the wall is
/// put at f(T), w T = 50 pi - 0.05, which is the first time: the peak before is lower, as a half
/// turn advances by v pi / w = 0.01 > 1 - cos(0.05) + v^2 / (2 w^2), and f rises from the half turn
/// before T on until T. Sampling sees the blade where the wall is not.
RigidCase spinningBlade()
{
    const double w = 100.0 * kPi;
    const double back = 0.05;
    const double time = (50.0 * kPi - back) / w;
    const double h = time + std::cos(back);
    return {.id = "N14",
            .scene = {.meshA = quad({-1, 0, -0.1}, {1, 0, -0.1}, {1, 0, 0.1}, {-1, 0, 0.1}),
                      .meshB = wallAtX(h, 4.0),
                      .motionA = {.v_W = {1, 0, 0}, .w_W = {0, 0, w}}},
            .answer = {.time = time, .closingSpeed = 1.0 + w * std::sin(back)}};
}

/// Seven rectangles that share one edge; one of them points straight down.
RigidCase fins()
{
    TriangleMesh mesh;
    for (const double angle : circleAngles(7, -0.5 * kPi))
    {
        const Vector3d out(0, std::cos(angle), std::sin(angle));
        const Vector3d axis(1, 0, 0);
        mesh = merged({mesh, quad(-axis, axis, axis + out, -axis + out)});
    }
    return falls("N16", shifted(mesh, {0, 0, 2}), floorAt(0.0, 10.0));
}

/// A square ring about z of bars 0.2 thick around a hole of half 1.
TriangleMesh ring()
{
    return merged({box({-1.2, -1.2, -0.1}, {1.2, -1, 0.1}),
                   box({-1.2, 1, -0.1}, {1.2, 1.2, 0.1}),
                   box({-1.2, -1, -0.1}, {-1, 1, 0.1}),
                   box({1, -1, -0.1}, {1.2, 1, 0.1})});
}

/// Two rings through each other; the bar of one moves from 0 to the other's bar at 1.
RigidCase chainLinks()
{
    return {.id = "N17",
            .scene = {.meshA = placed(ring(), poseOf({1, 0, 0}, 0.5 * kPi, Vector3d::UnitX())),
                      .meshB = ring(),
                      .motionA = {.v_W = {2, 0, 0}}},
            .answer = {.time = (1.0 - 0.0) / 2.0, .closingSpeed = 2.0},
            .nested = true};
}

/// Two floors a unit in the last place apart: ties that a strict order may never resolve.
RigidCase doubledFloor()
{
    const TriangleMesh ground =
        merged({floorAt(1.0, 10.0), floorAt(std::nextafter(1.0, 0.0), 10.0)});
    return falls("N18", shifted(cube(0.5), {0, 0, 2.5}), ground);
}

/// A rod of 60 x 4 x 4 mm, pinned at its centre, turns at 60 rad/s for 1/240 s; the lower corners
/// of a blade are at (23, 5.5) and (27, 5.5) mm. A corner at (rho, phi) is rho sin(phi - angle)
/// above the rod's middle, and the farther one is met first: angle = phi - asin(2 mm / rho). Worlds
/// of Bullet, with this library's impacts solved by one contact point, turned it through.
RigidCase pinnedRod()
{
    const double w = 60.0 / 240.0;
    const double x = 0.027;
    const double y = 0.0055;
    const double rho = std::hypot(x, y);
    const double lag = std::asin(0.002 / rho);
    return {.id = "N20",
            .scene = {.meshA = box({-0.03, -0.002, -0.002}, {0.03, 0.002, 0.002}),
                      .meshB = box({0.023, y, -0.02}, {x, y + 0.0005, 0.02}),
                      .motionA = {.w_W = {0, 0, w}}},
            .answer = {.time = (std::atan2(y, x) - lag) / w,
                       .closingSpeed = w * rho * std::cos(lag),
                       .length = 0.01}};
}

/// Barycentric coordinates on such a triangle cancel.
RigidCase onRibbon()
{
    const TriangleMesh ribbon =
        quad({-5e3, -5e-5, 0}, {5e3, -5e-5, 0}, {5e3, 5e-5, 0}, {-5e3, 5e-5, 0});
    const TriangleMesh needle = fan({0, 0, 0}, 1e-2, 1.0, 8);
    return falls("N22", shifted(needle, {1234.5, 4e-5, 1}), ribbon);
}
}  // namespace

std::vector<RigidCase> foundCases()
{
    const double justBefore = 1.0 - 1e-9;
    return {
        parallelEdges(),
        crossingSlivers(),
        farAxis(),
        farFromItsFrame(),
        // A spin about the contact normal brings nothing nearer; it once cost thousands of poses.
        cubeOverFloor("N05",
                      {.X_W0 = poseOf({0, 0, 1.01}), .w_W = {0, 0, 400}},
                      {.clearance = 1.01 - 1.0, .tolerances = {1e-3}},
                      1.0,
                      20.0),
        turnsAndCloses(),
        comesBack(),
        farOff(),
        needlesMeet(),
        unequalSizes(),
        // Contact 1e-9 before the end: codes that take the last thousandth for the end say
        // "none".
        cubeOverFloor("N11",
                      {.X_W0 = poseOf({0, 0, 5}), .v_W = {0, 0, -4.0 / justBefore}},
                      {.time = justBefore, .closingSpeed = 4.0 / justBefore}),
        twoContacts(),
        // B02 with 6000 turns: a whole number of them between samples at 1/60, 1/240, 1/100 and
        // 1/1000.
        barToPin("N13", 12000.0 * kPi),
        spinningBlade(),
        // A10 where the sheet is met and left again between samples 999 and 1000 of 1000.
        throughSheet("N15", 0.25, 999.5),
        fins(),
        chainLinks(),
        doubledFloor(),
        // B12 with fewer sides and more room, where one of the strategies gave up.
        shaftInBearing("N19", 64, 0.99, {.clearance = 0.0099, .tolerances = {1e-3}}),
        pinnedRod(),
        curvesIn(),
        onRibbon()};
}
}  // namespace bullet_ccd::reference
