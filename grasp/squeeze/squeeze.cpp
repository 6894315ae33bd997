#include "grasp/squeeze/squeeze.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/elastic_hold.h"
#include "grasp/force/force_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr double kLeastFirmness = 1.2;
/// Fewer weights than this are none.
constexpr double kLeastWeights = 1e-3;
/// Contacts that hold nothing of a load that is so small a part of what the joints bear do not fail
/// for the efforts.
constexpr double kLeastLoad = 1e-9;

std::string number(double value)
{
    std::string text = std::to_string(value);
    return text.substr(0, text.find('.') + 3);
}

Eigen::Vector3d middleOf(const std::vector<GraspContact>& contacts)
{
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const GraspContact& contact : contacts)
    {
        sum += contact.point;
    }
    return sum / static_cast<double>(contacts.size());
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

/// The largest force at a contact that every joint could bear alone [N]; infinite without one that
/// moves a contact.
double bearableForce(const ForceProblem& problem)
{
    const Eigen::Map<const Eigen::MatrixXd> jacobian = jacobianOf(problem);
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index row = 0; row < jacobian.rows(); row += 6)
    {
        for (Eigen::Index j = 0; j < jacobian.cols(); ++j)
        {
            least = std::min(least,
                             problem.torqueLimits[static_cast<std::size_t>(j)] /
                                 jacobian.col(j).segment<3>(row).norm());
        }
    }
    return least;
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
        JointEffort effort{.isAssumed = !(joint.maxEffort > 0.0 && joint.maxEffort <= most)};
        const auto add = [&](const Joint& moved, double multiplier)
        {
            const bool turns = moved.type != JointType::Prismatic;
            const double usual = turns ? kUsualTorque : kUsualForce;
            const double own = effort.isAssumed ? usual : moved.maxEffort;
            effort.limit += std::abs(multiplier) * own;
            effort.stiffness +=
                multiplier * multiplier * own / (turns ? kFullEffortAngle : kFullEffortWay);
        };
        add(joint, 1.0);
        for (const Link& other : tree.links)
        {
            const bool isStated =
                other.joint.maxEffort > 0.0 && std::isfinite(other.joint.maxEffort);
            if (other.joint.isMovable() && other.joint.mimicOf == link &&
                (effort.isAssumed || isStated))
            {
                add(other.joint, other.joint.mimicMultiplier);
            }
        }
        efforts.push_back(effort);
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
            squeeze.efforts[j].stiffness *= options.efforts[j] / squeeze.efforts[j].limit;
            squeeze.efforts[j].limit = options.efforts[j];
            squeeze.efforts[j].isAssumed = false;
        }
        problem.torqueLimits.push_back(squeeze.efforts[j].limit);
        squeeze.stiffness.push_back(squeeze.efforts[j].stiffness);
    }
    if (grasp.contacts.size() < 2)
    {
        squeeze.reason = "geometry: fewer than two contacts";
        return squeeze;
    }
    problem.contacts = grasp.contacts;
    problem.law.friction = options.friction;
    problem.jacobian = handJacobian(tree, grasp.X_WH, grasp.positions, grasp.contacts);
    problem.reference = options.centerOfMass.value_or(middleOf(grasp.contacts));
    const double weight = *options.mass * kStandardGravity;
    const double needed = weight / options.friction;
    const auto holdOf = [&](double load)
    {
        return holdElastically(
            problem, squeeze.stiffness, 1.0 / kSkinStiffness, load, 0.5 * options.firmness);
    };
    ElasticHold hold = holdOf(weight);
    // Efforts that are far too small for the weight say nothing of the geometry: ask again with
    // weights that they bear.
    const double bearable = bearableForce(problem);
    double share = 1.0;
    for (double light = std::min(weight, bearable);
         !(hold.weights > kLeastWeights) && light > kLeastLoad * bearable;
         light *= 0.01)
    {
        hold = holdOf(light);
        share = light / weight;
    }
    double sum = 0.0;
    for (std::size_t i = 0; i < hold.forces.size(); ++i)
    {
        sum += hold.forces[i].dot(grasp.contacts[i].normal);
    }
    if (!(hold.weights > kLeastWeights))
    {
        squeeze.reason =
            "geometry: within friction " + number(options.friction) +
            " the contacts cannot press against each other so that each of them is loaded";
        return squeeze;
    }
    double scale = std::max(1.0, options.firmness * needed / sum);
    for (std::size_t j = 0; j < joints.size(); ++j)
    {
        scale = std::min(scale, squeeze.efforts[j].limit / std::abs(hold.torques[j]));
    }
    if (scale * sum < kLeastFirmness * needed)
    {
        squeeze.reason = "limits: the efforts allow " + number(scale * sum) +
                         " N of normal force where " + number(kLeastFirmness * needed) +
                         " N are needed";
        return squeeze;
    }
    squeeze.normalForce = scale * sum;
    for (const Eigen::Vector3d& force : hold.forces)
    {
        squeeze.forces.emplace_back(scale * force);
    }
    squeeze.weights = share * hold.weights;
    for (std::size_t j = 0; j < joints.size(); ++j)
    {
        squeeze.torques.push_back(scale * hold.torques[j]);
        squeeze.targets.push_back(grasp.positions[static_cast<std::size_t>(joints[j])] +
                                  squeeze.torques[j] / squeeze.stiffness[j]);
    }
    return squeeze;
}
}  // namespace bullet_ccd::grasp
