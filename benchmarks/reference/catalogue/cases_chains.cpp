/// Chains whose joints turn at constant rates: pendulums, fingers, jaws.
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

ArticulatedCase cancellingJoints()
{
    KinematicTree tree = planarChain({1.0, 1.0});
    tree.links[2].X_PL0 = Eigen::Isometry3d::Identity();
    return {.id = "G14",
            .tree = tree,
            .linkMeshes = {{}, {}, segment({0, 0, 0}, {1, 0, 0})},
            .motion = {.root = {}, .positions = {0, 0, 0}, .rates = {0, kPi, -kPi}},
            .obstacles = {wallAtY(1e-3, 4.0)},
            .answer = {.clearance = 1e-3, .tolerances = {1e-4, 1e-6}}};
}

/// Six links of length 1 around a pole; all joints but the first turn alike from 0 to 60 degrees,
/// where the links are the sides of a hexagon.
///
/// At turn q all links are tangent to a circle of radius r(q) = 1 / (2 tan(q / 2)), which touches
/// the first, resting link at its middle: its centre is r(q) above. The pole's axis is c = r(60
/// degrees) above that middle, inside the circle and r(q) - c off its centre, so that every link is
/// at least r(q) - (r(q) - c) = c from the axis, at any time; all are that near at the end.
ArticulatedCase loopAroundPole()
{
    constexpr double kClearance = 1e-3;
    const double c = 0.5 * std::sqrt(3.0);
    const double rate = kPi / 3.0;
    return {.id = "G17",
            .tree = planarChain(std::vector<double>(6, 1.0)),
            .linkMeshes = rods(std::vector<double>(6, 1.0)),
            .motion = {.root = {},
                       .positions = std::vector<double>(7, 0.0),
                       .rates = {0, 0, rate, rate, rate, rate, rate}},
            .obstacles = {shifted(
                prism(circlePoints(c - kClearance, circleAngles(48, -0.5 * kPi)), -0.5, 0.5),
                {0.5, c, 0})},
            .answer = {.clearance = kClearance, .tolerances = {1e-4}}};
}
}  // namespace

std::vector<ArticulatedCase> chainCases()
{
    return {
        asJoint("G01", rodToWall("B01", 2.0, 1.0, 0.5 * kPi)),
        straightLineTip(),
        parallelogram(),
        curlsIntoItself(),
        pendulums("G05", {1, 1.2, 0.8, 1.5}, {0.5, 0.9, 0.5, 0.4}, {1, 1.3, 0.9, 0.7}),
        pendulums("G06", {1, 1, 1, 1}, {0.5, 0.5, 0.5, 0.5}, {1, 1, 1, 1}),
        coupledFinger(),
        asJoint("G10", barToPin("B02", 3.0 * kPi)),
        cancellingJoints(),
        loopAroundPole(),
    };
}
}  // namespace bullet_ccd::reference
