#include "grasp/squeeze/squeeze.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/grasp_forces.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr double kLeastFirmness = 1.2;
/// Margin to slip over the largest normal force below which contacts do not press together.
constexpr double kLeastMargin = 1e-3;

std::string number(double value)
{
    std::string text = std::to_string(value);
    return text.substr(0, text.find('.') + 3);
}

/// A joint that does not close and carries all that do: of a wrist or an arm, not of a finger.
bool carriesTheFingers(const HandModel& hand, std::int32_t link)
{
    const std::vector<Link>& links = hand.robot.tree.links;
    for (std::size_t finger = 0; finger < links.size(); ++finger)
    {
        auto above = static_cast<std::int32_t>(finger);
        while (hand.closingDirections[finger] != 0 && above != link && above >= 0)
        {
            above = links[static_cast<std::size_t>(above)].parent;
        }
        if (above < 0)
        {
            return false;
        }
    }
    return hand.closingDirections[static_cast<std::size_t>(link)] == 0;
}
}  // namespace

std::vector<JointEffort> jointEfforts(const HandModel& hand)
{
    const KinematicTree& tree = hand.robot.tree;
    std::vector<JointEffort> efforts;
    for (const std::int32_t link : independentJoints(tree))
    {
        const Joint& joint = tree.links[static_cast<std::size_t>(link)].joint;
        const bool slides = joint.type == JointType::Prismatic;
        const double mostTorque = carriesTheFingers(hand, link) ? kMostArmTorque : kMostTorque;
        const double most = slides ? kMostForce : mostTorque;
        const bool isAssumed = !(joint.maxEffort > 0.0 && joint.maxEffort <= most);
        const double usual = slides ? kUsualForce : kUsualTorque;
        double limit = isAssumed ? usual : joint.maxEffort;
        // What the URDF states of a joint that follows is what that joint may bear of the motor.
        for (const Link& other : tree.links)
        {
            if (other.joint.isMovable() && other.joint.mimicOf == link && !isAssumed &&
                other.joint.maxEffort > 0.0 && std::isfinite(other.joint.maxEffort))
            {
                limit += std::abs(other.joint.mimicMultiplier) * other.joint.maxEffort;
            }
        }
        efforts.push_back({.limit = limit, .isAssumed = isAssumed});
    }
    return efforts;
}

Squeeze squeezeOf(const HandModel& hand, const Grasp& grasp, const SqueezeOptions& options)
{
    require(options.mass.has_value(),
            "squeeze: the object has no mass: give one, such as that of massOf()");
    require(std::isfinite(*options.mass) && *options.mass > 0.0,
            "squeeze: mass " + number(*options.mass) + " kg of the object: give a positive one");
    require(std::isfinite(options.friction) && options.friction > 0.0,
            "squeeze: friction " + number(options.friction) + ": give a positive one");
    const KinematicTree& tree = hand.robot.tree;
    const std::vector<std::int32_t> joints = independentJoints(tree);
    Squeeze squeeze;
    squeeze.efforts = jointEfforts(hand);
    require(options.efforts.empty() || options.efforts.size() == joints.size(),
            "squeeze: " + std::to_string(options.efforts.size()) + " efforts for " +
                std::to_string(joints.size()) + " joints: give one per independent joint");
    for (const double effort : options.efforts)
    {
        require(std::isfinite(effort) && effort > 0.0,
                "squeeze: effort " + std::to_string(effort) + ": give a positive number");
    }
    ForceProblem problem;
    for (std::size_t j = 0; j < joints.size(); ++j)
    {
        if (!options.efforts.empty())
        {
            squeeze.efforts[j] = {.limit = options.efforts[j], .isAssumed = false};
        }
        problem.torqueLimits.push_back(squeeze.efforts[j].limit);
        const Joint& joint = tree.links[static_cast<std::size_t>(joints[j])].joint;
        const bool slides = joint.type == JointType::Prismatic;
        squeeze.stiffness.push_back(squeeze.efforts[j].limit /
                                    (slides ? kFullEffortWay : kFullEffortAngle));
    }
    if (grasp.contacts.size() < 2)
    {
        squeeze.reason = "geometry: fewer than two contacts";
        return squeeze;
    }
    const double needed = *options.mass * kStandardGravity / options.friction;
    problem.contacts = grasp.contacts;
    problem.law.friction = options.friction;
    problem.jacobian = handJacobian(tree, grasp.X_WH, grasp.positions, grasp.contacts);
    problem.maxNormalForce = 0.5 * options.firmness * needed;
    const GraspForces forces = solveGraspForces(problem, {.objective = ForceObjective::Firm});
    double sum = 0.0;
    double least = std::numeric_limits<double>::infinity();
    double largest = 0.0;
    for (const ContactForce& contact : forces.contacts)
    {
        sum += contact.normal;
        largest = std::max(largest, contact.normal);
        least = std::min(least, contact.margin);
    }
    if (forces.status != ForceStatus::Balanced || !(least > kLeastMargin * largest))
    {
        squeeze.reason =
            "geometry: within friction " + number(options.friction) +
            " the contacts cannot press against each other so that each of them is loaded";
        return squeeze;
    }
    if (sum < kLeastFirmness * needed)
    {
        squeeze.reason = "limits: the efforts allow " + number(sum) + " N of normal force where " +
                         number(kLeastFirmness * needed) + " N are needed";
        return squeeze;
    }
    const double scale = std::min(1.0, options.firmness * needed / sum);
    squeeze.normalForce = scale * sum;
    for (std::size_t j = 0; j < joints.size(); ++j)
    {
        squeeze.torques.push_back(scale * forces.jointTorques[j]);
        squeeze.targets.push_back(grasp.positions[static_cast<std::size_t>(joints[j])] +
                                  squeeze.torques[j] / squeeze.stiffness[j]);
    }
    return squeeze;
}
}  // namespace bullet_ccd::grasp
