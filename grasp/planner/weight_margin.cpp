#include "grasp/planner/weight_margin.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/contact_models.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/force/linear_program.h"
#include "grasp/squeeze/squeeze.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kGravity = 9.80665;  // [m/s^2]
constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// The corners of an icosahedron.
std::array<Eigen::Vector3d, 12> icosahedron()
{
    std::array<Eigen::Vector3d, 12> corners;
    std::size_t next = 0;
    for (int axis = 0; axis < 3; ++axis)
    {
        for (const double a : {-1.0, 1.0})
        {
            for (const double b : {-std::numbers::phi, std::numbers::phi})
            {
                Eigen::Vector3d corner = Eigen::Vector3d::Zero();
                corner[(axis + 1) % 3] = a;
                corner[(axis + 2) % 3] = b;
                corners[next++] = corner.normalized();
            }
        }
    }
    return corners;
}

/// The program without a direction: unknowns are the amplitudes of the pyramids' edges and, last,
/// the weight; rows are the balance of the object, with moments over its radius, and the torques of
/// limited joints over their limits.
LinearProgram balance(const HandModel& hand,
                      const GraspObject& object,
                      const Grasp& grasp,
                      const ContactLaw& law,
                      int edges,
                      std::span<const double> efforts)
{
    const KinematicTree& tree = hand.robot.tree;
    std::vector<double> limits(efforts.begin(), efforts.end());
    if (limits.empty())
    {
        for (const JointEffort& effort : jointEfforts(hand))
        {
            limits.push_back(effort.limit);
        }
    }
    require(limits.size() == independentJoints(tree).size(),
            "largestMassHeld: " + std::to_string(limits.size()) + " efforts for " +
                std::to_string(independentJoints(tree).size()) +
                " joints: give one per independent joint");
    const std::vector<Twist> twists =
        handJacobian(tree, grasp.X_WH, grasp.positions, grasp.contacts);
    const auto contacts = static_cast<Eigen::Index>(grasp.contacts.size());
    const auto joints = static_cast<Eigen::Index>(limits.size());
    const Eigen::Map<const Eigen::MatrixXd> jacobian(
        twists.empty() ? nullptr : twists.front().data(), 6 * contacts, joints);
    const Eigen::MatrixXd pyramid = coneEdges(law, edges);
    LinearProgram program(6 + joints, contacts * pyramid.cols() + 1);
    for (Eigen::Index i = 0; i < contacts; ++i)
    {
        const GraspContact& contact = grasp.contacts[static_cast<std::size_t>(i)];
        auto columns = program.rows.middleCols(i * pyramid.cols(), pyramid.cols());
        columns.topRows<6>() =
            contactBasis(contact, law, object.centerOfMass, object.radius) * pyramid;
        // Torques are worth what the contact's own force does at the contact.
        columns.bottomRows(joints) = jacobian.middleRows(6 * i, 6).transpose() *
                                     contactBasis(contact, law, contact.point, 1.0) * pyramid;
    }
    program.rowLower.head<6>().setZero();
    program.rowUpper.head<6>().setZero();
    for (Eigen::Index j = 0; j < joints; ++j)
    {
        const double limit = limits[static_cast<std::size_t>(j)];
        if (std::isfinite(limit) && limit > 0.0)
        {
            program.rows.row(6 + j) /= limit;
            program.rowLower[6 + j] = -1.0;
            program.rowUpper[6 + j] = 1.0;
        }
        else
        {
            program.rows.row(6 + j).setZero();
        }
    }
    program.cost[program.cost.size() - 1] = -1.0;
    return program;
}
}  // namespace

double largestMassHeld(const HandModel& hand,
                       const GraspObject& object,
                       const Grasp& grasp,
                       double friction,
                       int coneEdges,
                       std::span<const double> efforts)
{
    if (grasp.contacts.empty())
    {
        return 0.0;
    }
    const ContactLaw law = simplified({.friction = friction});
    LinearProgram program = balance(hand, object, grasp, law, coneEdges, efforts);
    const Eigen::Index last = program.cost.size() - 1;
    const std::array<Eigen::Vector3d, 12> directions = icosahedron();
    std::array<double, 12> weights{};
    for (std::size_t k = 0; k < directions.size(); ++k)
    {
        program.rows.block<3, 1>(0, last) = directions[k];
        const LinearSolution solution = solve(program);
        if (solution.status == LinearStatus::Optimal)
        {
            weights[k] = solution.x[last];
        }
        else if (solution.status == LinearStatus::Unbounded)
        {
            weights[k] = kUnlimited;
        }
    }
    const double least = *std::ranges::min_element(weights);
    if (!(least > 0.0) || std::isinf(least))
    {
        return least;
    }
    // What is unlimited counts as very much, so that faces have a place.
    double radius = kUnlimited;
    for (double& weight : weights)
    {
        weight = std::min(weight, 1e3 * least);
    }
    const double edge = 1.0 / std::sqrt(5.0);  // cosine between neighbours
    const auto areNeighbours = [&](std::size_t a, std::size_t b)
    { return std::abs(directions[a].dot(directions[b]) - edge) < 1e-6; };
    for (std::size_t a = 0; a < 12; ++a)
    {
        for (std::size_t b = a + 1; b < 12; ++b)
        {
            for (std::size_t c = b + 1; c < 12; ++c)
            {
                if (areNeighbours(a, b) && areNeighbours(b, c) && areNeighbours(a, c))
                {
                    const Eigen::Vector3d corner = weights[a] * directions[a];
                    const Eigen::Vector3d normal = (weights[b] * directions[b] - corner)
                                                       .cross(weights[c] * directions[c] - corner)
                                                       .normalized();
                    radius = std::min(radius, std::abs(normal.dot(corner)));
                }
            }
        }
    }
    return radius / kGravity;
}
}  // namespace bullet_ccd::grasp
