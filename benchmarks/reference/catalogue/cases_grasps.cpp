/// Fingers and jaws on cylinders, blocks and each other.
#include "benchmarks/reference/catalogue/case_parts.h"
#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Two fingers of that length with their bases so far apart, mirrored, that close at the same rate.
ArticulatedCase mirrored(const std::string& id, double length, double apart)
{
    KinematicTree tree = planarChain({length});
    tree.links.push_back(planarChain({length}, {apart, 0, 0}).links[1]);
    const TriangleMesh finger = segment({0, 0, 0}, {length, 0, 0});
    return {.id = id,
            .tree = tree,
            .linkMeshes = {{}, finger, finger},
            .motion = {.root = {}, .positions = {0, 1.2, kPi - 1.2}, .rates = {0, -1, 1}}};
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

ArticulatedCase mirroredFingers()
{
    const double contact = tangentAngle() + 0.5 * kPi;
    ArticulatedCase result = mirrored("G15", 0.12, 2.0 * kD);
    result.obstacles = {cylinder({contact, kPi - contact})};
    result.answer = {
        .time = 1.2 - tangentAngle(), .closingSpeed = std::sqrt(kD * kD - kR * kR), .length = 0.1};
    result.links = {1, 2};
    return result;
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

/// A finger sweeps 100 degrees over a radial plate 1e-4 thick, a tenth of a degree at its place:
/// steps of 10 degrees are on either side of it. Contact is when the finger lies on the plate.
ArticulatedCase sweepsOverThinPlate()
{
    const double travel = 100.0 / 180.0 * kPi;
    const double place = 0.8;
    return {.id = "I13",
            .tree = planarChain({0.10}),
            .linkMeshes = rods({0.10}),
            .motion = {.root = {}, .positions = {0, 0}, .rates = {0, travel}},
            .obstacles = {placed(box({0.05, 0, -0.01}, {0.08, 1e-4, 0.01}),
                                 poseOf(Vector3d::Zero(), place))},
            .answer = {.time = place / travel, .closingSpeed = 0.05 * travel, .length = 0.1},
            .links = {1}};
}
}  // namespace

ArticulatedCase fingersMeet(const std::string& id)
{
    constexpr double kLength = 0.08;
    constexpr double kApart = 0.12;
    const double angle = std::acos(kApart / (2.0 * kLength));
    ArticulatedCase result = mirrored(id, kLength, kApart);
    result.selfPairs = {{1, 2}};
    result.obstacles = {shifted(sphereWithPole(0.005, Vector3d::UnitY()), {0.06, -0.02, 0})};
    result.answer = {
        .time = 1.2 - angle, .closingSpeed = 2.0 * kLength * std::sin(angle), .length = 0.1};
    result.links = {1};
    return result;
}

std::vector<ArticulatedCase> graspCases()
{
    return {
        wrapsCylinder("G12a", 1.0),
        tipOnCylinder(),
        secondPhalanxCloses(),
        mirroredFingers(),
        parallelJaw("I02", 0.0, false),
        parallelJaw("I03a", 0.005, false),
        parallelJaw("I03b", 0.005, true),
        boxesOverlapButMiss(),
        wrapsCylinder("I06a", 0.895),
        wrapsCylinder("I06b", 0.896),
        fingersMeet("I08"),
        sweepsOverThinPlate(),
    };
}
}  // namespace bullet_ccd::reference
