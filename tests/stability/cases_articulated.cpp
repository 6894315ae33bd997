/// Chains whose joints turn at constant rates: pendulums, fingers, jaws.
#include "tests/stability/cases.h"
#include "tests/support/random_trees.h"
#include "tests/support/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bullet_ccd::tests
{
namespace
{
using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

TriangleMesh rod(double length)
{
    return segment({0, 0, 0}, {length, 0, 0});
}

/// Rods for a chain of those lengths; the base has no geometry.
std::vector<TriangleMesh> rods(const std::vector<double>& lengths)
{
    std::vector<TriangleMesh> meshes(1);
    for (const double length : lengths)
    {
        meshes.push_back(rod(length));
    }
    return meshes;
}

TriangleMesh wallAtX(double x, double half)
{
    return quad({x, -half, -half}, {x, half, -half}, {x, half, half}, {x, -half, half});
}

ArticulatedCase pendulum()
{
    const double w = 0.5 * kPi;
    const double angle = std::asin(1.0 / 2.0);
    return {.id = "G01",
            .tree = planarChain({2.0}),
            .linkMeshes = rods({2.0}),
            .motion = {.root = {}, .positions = {0, 0}, .rates = {0, w}},
            .obstacles = {wallAtY(1.0, 4.0)},
            .answer = {.time = angle / w, .closingSpeed = 2.0 * w * std::cos(angle)},
            .links = {1}};
}

ArticulatedCase straightLineTip()
{
    const double angle = std::acos(1.5 / 2.0);
    return {.id = "G02",
            .tree = planarChain({1.0, 1.0}),
            .linkMeshes = rods({1.0, 1.0}),
            .motion = {.root = {}, .positions = {0, 1.2, -2.4}, .rates = {0, -1, 2}},
            .obstacles = {wallAtX(1.5, 4.0)},
            .answer = {.time = 1.2 - angle, .closingSpeed = 2.0 * std::sin(angle)},
            .links = {2}};
}

ArticulatedCase parallelogram()
{
    const double angle = std::asin(0.9);
    return {.id = "G03",
            .tree = planarChain({1.0, 0.5}),
            .linkMeshes = rods({1.0, 0.5}),
            .motion = {.root = {}, .positions = {0, 0, 0}, .rates = {0, kPi, -kPi}},
            .obstacles = {wallAtY(0.9, 4.0)},
            .answer = {.time = angle / kPi, .closingSpeed = kPi * std::cos(angle)},
            .links = {1, 2}};
}

ArticulatedCase curlsIntoItself()
{
    const double angle = std::acos(-0.5);
    return {.id = "G04",
            .tree = planarChain({1.5, 1.0, 1.0}),
            .linkMeshes = rods({1.5, 1.0, 1.0}),
            .motion = {.root = {}, .positions = {0, 0, 0, 0}, .rates = {0, 0, 2.5, 2.5}},
            .selfPairs = {{1, 3}},
            .answer = {.time = angle / 2.5,
                       .closingSpeed = -2.5 * (std::cos(angle) + 2.0 * std::cos(2.0 * angle)),
                       .tolerances = {1e-3, 1e-6}},
            .links = {1}};
}

/// Pendulums one above the other, each with a wall of its own.
ArticulatedCase pendulums(const std::string& id,
                          const std::vector<double>& lengths,
                          const std::vector<double>& heights,
                          const std::vector<double>& rates)
{
    ArticulatedCase result{.id = id, .tree = {}, .linkMeshes = rods(lengths), .motion = {}};
    result.tree.links.resize(1);
    result.motion.positions.assign(lengths.size() + 1, 0.0);
    result.motion.rates = {0.0};
    std::vector<double> times;
    for (std::size_t k = 0; k < lengths.size(); ++k)
    {
        const double z = 3.0 * static_cast<double>(k);
        result.tree.links.push_back(planarChain({1.0}, {0, 0, z}).links[1]);
        result.motion.rates.push_back(rates[k]);
        const double y = heights[k];
        result.obstacles.push_back(
            quad({-2, y, z - 1}, {-2, y, z + 1}, {2, y, z + 1}, {2, y, z - 1}));
        times.push_back(std::asin(heights[k] / lengths[k]) / rates[k]);
    }
    const double first = *std::min_element(times.begin(), times.end());
    result.answer.time = first;
    for (std::size_t k = 0; k < lengths.size(); ++k)
    {
        if (times[k] == first)
        {
            result.links.push_back(static_cast<std::int32_t>(k) + 1);
            result.answer.closingSpeed =
                std::sqrt(lengths[k] * lengths[k] - heights[k] * heights[k]) * rates[k];
        }
    }
    return result;
}

ArticulatedCase coupledFinger()
{
    const std::vector<double> L{0.067816, 0.029980, 0.029};
    const double q2 = 0.3;
    const double rate = 1.2;
    const double time = 0.4;
    const double q3 = rate * time;
    const double depth =
        L[0] * std::sin(q2) + L[1] * std::sin(q2 + q3) + L[2] * std::sin(q2 + 2.0 * q3);
    const double speed = rate * (L[1] * std::cos(q2 + q3) + 2.0 * L[2] * std::cos(q2 + 2.0 * q3));
    return {.id = "G09",
            .tree = planarChain(L),
            .linkMeshes = rods(L),
            .motion = {.root = {}, .positions = {0, q2, 0, 0}, .rates = {0, 0, rate, rate}},
            .obstacles = {wallAtY(depth, 0.3)},
            .answer = {.time = time, .closingSpeed = speed, .length = 0.1},
            .links = {3}};
}

ArticulatedCase continuousJoint()
{
    const double rho = 1.5;
    const double phi = 1.2;
    const double lag = std::asin((0.1 + 0.05) / rho);
    const double w = 3.0 * kPi;
    const TriangleMesh pin =
        shifted(prism(circlePoints(0.1, circleAngles(16, phi - lag - 0.5 * kPi)), -0.5, 0.5),
                {rho * std::cos(phi), rho * std::sin(phi), 0});
    return {.id = "G10",
            .tree = planarChain({2.0}),
            .linkMeshes = {{}, box({0, -0.05, -0.2}, {2, 0.05, 0.2})},
            .motion = {.root = {}, .positions = {0, 0}, .rates = {0, w}},
            .obstacles = {pin},
            .answer = {.time = (phi - lag) / w, .closingSpeed = w * rho * std::cos(lag)},
            .links = {1}};
}

constexpr double kD = 0.10;  // base of the finger to the axis of the cylinder
constexpr double kR = 0.03;  // radius of the cylinder

/// The cylinder with vertices in the given directions from its axis.
TriangleMesh cylinder(std::initializer_list<double> contacts)
{
    return shifted(prism(circlePoints(kR, circleAngles(24, 0.0, contacts)), -0.05, 0.05),
                   {kD, 0, 0});
}

double tangentAngle()
{
    return std::asin(kR / kD);
}

/// The second phalanx, from the stretched finger on, meets the cylinder on its other side.
struct SecondPhalanx
{
    double angle = 0.0;         ///< that it turns through
    double tangent = 0.0;       ///< from the joint to the contact
    double contactAngle = 0.0;  ///< direction of the contact from the cylinder's axis
};

SecondPhalanx secondPhalanx(double L1)
{
    SecondPhalanx result;
    result.tangent = L1 - std::sqrt(kD * kD - kR * kR);
    result.angle = kPi - 2.0 * std::atan(kR / result.tangent);
    const double first = tangentAngle();
    const double second = first - result.angle;
    const Vector2d joint = L1 * Vector2d(std::cos(first), std::sin(first));
    const Vector2d contact =
        joint + result.tangent * Vector2d(std::cos(second), std::sin(second)) - Vector2d(kD, 0);
    result.contactAngle = std::atan2(contact.y(), contact.x());
    return result;
}

ArticulatedCase wrapsCylinder(const std::string& id, double travel)
{
    const double time = (1.2 - tangentAngle()) / travel;
    ArticulatedCase result{.id = id,
                           .tree = planarChain({0.12}),
                           .linkMeshes = rods({0.12}),
                           .motion = {.root = {}, .positions = {0, 1.2}, .rates = {0, -travel}},
                           .obstacles = {cylinder({tangentAngle() + 0.5 * kPi})},
                           .answer = {.time = time,
                                      .closingSpeed = travel * std::sqrt(kD * kD - kR * kR),
                                      .length = 0.1},
                           .links = {1}};
    if (time > 1.0)
    {
        result.answer.clearance = kD * std::sin(1.2 - travel) - kR;
        result.answer.time.reset();
    }
    return result;
}

ArticulatedCase tipOnCylinder()
{
    const double L = 0.08;
    const double angle = std::acos((L * L + kD * kD - kR * kR) / (2.0 * L * kD));
    const Vector2d contact(L * std::cos(angle) - kD, L * std::sin(angle));
    return {.id = "G12b",
            .tree = planarChain({L}),
            .linkMeshes = rods({L}),
            .motion = {.root = {}, .positions = {0, 1.2}, .rates = {0, -1}},
            .obstacles = {cylinder({std::atan2(contact.y(), contact.x())})},
            .answer = {.time = 1.2 - angle,
                       .closingSpeed = L * kD * std::sin(angle) / kR,
                       .length = 0.1},
            .links = {1}};
}

/// The proximal phalanx touches already and rests.
ArticulatedCase secondPhalanxCloses()
{
    const SecondPhalanx distal = secondPhalanx(0.12);
    return {
        .id = "G13",
        .tree = planarChain({0.12, 0.06}),
        .linkMeshes = rods({0.12, 0.06}),
        .motion = {.root = {}, .positions = {0, tangentAngle(), 0}, .rates = {0, 0, -3}},
        .obstacles = {cylinder({tangentAngle() + 0.5 * kPi, distal.contactAngle})},
        .answer = {.time = distal.angle / 3.0, .closingSpeed = 3.0 * distal.tangent, .length = 0.1},
        .links = {2}};
}

ArticulatedCase cancellingJoints()
{
    KinematicTree tree = planarChain({1.0, 1.0});
    tree.links[2].X_PL0 = Eigen::Isometry3d::Identity();
    return {.id = "G14",
            .tree = tree,
            .linkMeshes = {{}, {}, rod(1.0)},
            .motion = {.root = {}, .positions = {0, 0, 0}, .rates = {0, kPi, -kPi}},
            .obstacles = {wallAtY(1e-3, 4.0)},
            .answer = {.clearance = 1e-3, .tolerances = {1e-4, 1e-6}}};
}

ArticulatedCase mirroredFingers()
{
    KinematicTree tree = planarChain({0.12});
    tree.links.push_back(planarChain({0.12}, {2.0 * kD, 0, 0}).links[1]);
    const double contact = tangentAngle() + 0.5 * kPi;
    return {.id = "G15",
            .tree = tree,
            .linkMeshes = {{}, rod(0.12), rod(0.12)},
            .motion = {.root = {}, .positions = {0, 1.2, kPi - 1.2}, .rates = {0, -1, 1}},
            .obstacles = {cylinder({contact, kPi - contact})},
            .answer = {.time = 1.2 - tangentAngle(),
                       .closingSpeed = std::sqrt(kD * kD - kR * kR),
                       .length = 0.1},
            .links = {1, 2}};
}

/// Jaws 0.08 apart travel 0.04 each; an object of width 0.05 stands `offset` off the middle.
ArticulatedCase parallelJaw(const std::string& id, double offset, bool firstStopped)
{
    KinematicTree tree;
    tree.links.resize(3);
    for (std::size_t i = 1; i < 3; ++i)
    {
        tree.links[i].parent = 0;
        tree.links[i].joint.type = JointType::Prismatic;
        tree.links[i].joint.axis = i == 1 ? Vector3d::UnitX() : Vector3d(-Vector3d::UnitX());
        tree.links[i].X_PL0.translation() = Vector3d(i == 1 ? -0.04 : 0.04, 0, 0);
    }
    const double touch1 = 0.04 - 0.025 + offset;
    const double touch2 = 0.04 - 0.025 - offset;
    // The jaw that the object is nearer to stops where it touches.
    const double first = firstStopped ? std::min(touch1, touch2) : 0.0;
    ArticulatedCase result{
        .id = id,
        .tree = tree,
        .linkMeshes = {{},
                       box({-0.01, -0.02, -0.02}, {0, 0.02, 0.02}),
                       box({0, -0.02, -0.02}, {0.01, 0.02, 0.02})},
        .motion = {.root = {}, .positions = {0, 0, first}, .rates = {0, 0.04, 0.04}},
        .obstacles = {shifted(box({-0.025, -0.01, -0.01}, {0.025, 0.01, 0.01}), {offset, 0, 0})},
        .answer = {.time = std::min(touch1, touch2) / 0.04, .closingSpeed = 0.04, .length = 0.1},
        .links = {2}};
    if (firstStopped)
    {
        result.motion.rates[2] = 0.0;
        result.answer.time = touch1 / 0.04;
        result.links = {1};
    }
    else if (offset == 0.0)
    {
        result.links = {1, 2};
    }
    return result;
}

ArticulatedCase boxesOverlapButMiss()
{
    const double toCenter = std::hypot(0.075, 0.075);
    return {.id = "I05",
            .tree = planarChain({0.08}),
            .linkMeshes = rods({0.08}),
            .motion = {.root = {}, .positions = {0, 0.5 * kPi}, .rates = {0, -0.5 * kPi}},
            .obstacles = {shifted(sphereWithPole(0.01, {-1, -1, 0}), {0.075, 0.075, 0})},
            .answer = {.clearance = toCenter - 0.08 - 0.01, .length = 0.1}};
}

ArticulatedCase fingersMeet()
{
    const double L = 0.08;
    const double base = 0.12;
    KinematicTree tree = planarChain({L});
    tree.links.push_back(planarChain({L}, {base, 0, 0}).links[1]);
    const double angle = std::acos(base / (2.0 * L));
    return {
        .id = "I08",
        .tree = tree,
        .linkMeshes = {{}, rod(L), rod(L)},
        .motion = {.root = {}, .positions = {0, 1.2, kPi - 1.2}, .rates = {0, -1, 1}},
        .selfPairs = {{1, 2}},
        .obstacles = {shifted(sphereWithPole(0.005, Vector3d::UnitY()), {0.06, -0.02, 0})},
        .answer = {.time = 1.2 - angle, .closingSpeed = 2.0 * L * std::sin(angle), .length = 0.1},
        .links = {1}};
}
}  // namespace

std::vector<ArticulatedCase> articulatedCases()
{
    return {
        pendulum(),
        straightLineTip(),
        parallelogram(),
        curlsIntoItself(),
        pendulums("G05", {1, 1.2, 0.8, 1.5}, {0.5, 0.9, 0.5, 0.4}, {1, 1.3, 0.9, 0.7}),
        pendulums("G06", {1, 1, 1, 1}, {0.5, 0.5, 0.5, 0.5}, {1, 1, 1, 1}),
        coupledFinger(),
        continuousJoint(),
        wrapsCylinder("G12a", 1.0),
        tipOnCylinder(),
        secondPhalanxCloses(),
        cancellingJoints(),
        mirroredFingers(),
        parallelJaw("I02", 0.0, false),
        parallelJaw("I03a", 0.005, false),
        parallelJaw("I03b", 0.005, true),
        boxesOverlapButMiss(),
        wrapsCylinder("I06a", 0.895),
        wrapsCylinder("I06b", 0.896),
        fingersMeet(),
    };
}
}  // namespace bullet_ccd::tests
