#include "bullet_ccd/math/check.h"
#include "grasp/force/grasp_forces.h"

#include <algorithm>

namespace bullet_ccd::grasp
{
namespace
{
/// Motion of a point of the moved body when the joint above `link` moves at 1 rad/s or 1 m/s.
Twist jointTwist(const Link& link, const Eigen::Isometry3d& X_WL, const Eigen::Vector3d& point_W)
{
    const Eigen::Vector3d axis_W = X_WL.linear() * link.joint.axis;
    Twist twist;
    if (link.joint.type == JointType::Prismatic)
    {
        twist << axis_W, Eigen::Vector3d::Zero();
    }
    else
    {
        twist << axis_W.cross(point_W - X_WL.translation()), axis_W;
    }
    return twist;
}
}  // namespace

std::vector<std::int32_t> independentJoints(const KinematicTree& tree)
{
    std::vector<std::int32_t> joints;
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        require(joint.type != JointType::Spherical,
                "joint '" + joint.name + "' is spherical: hands need revolute or prismatic joints");
        if (joint.isMovable() && joint.mimicOf == kNone)
        {
            joints.push_back(static_cast<std::int32_t>(i));
        }
    }
    return joints;
}

std::vector<Twist> handJacobian(const KinematicTree& tree,
                                const Eigen::Isometry3d& X_WH,
                                std::span<const double> positions,
                                std::span<const GraspContact> contacts)
{
    const std::vector<std::int32_t> joints = independentJoints(tree);
    const std::vector<Eigen::Isometry3d> poses = linkPoses(tree, X_WH, positions);
    std::vector<Twist> jacobian(joints.size() * contacts.size(), Twist::Zero());
    for (std::size_t i = 0; i < contacts.size(); ++i)
    {
        std::int32_t at = contacts[i].link;
        require(at >= 0 && at < static_cast<std::int32_t>(tree.size()),
                "contact " + std::to_string(i) + ": link " + std::to_string(at) +
                    " does not exist: give one of the hand's " + std::to_string(tree.size()));
        for (; at > 0; at = tree.links[static_cast<std::size_t>(at)].parent)
        {
            const Link& link = tree.links[static_cast<std::size_t>(at)];
            if (!link.joint.isMovable())
            {
                continue;
            }
            const bool follows = link.joint.mimicOf != kNone;
            const auto driver =
                std::lower_bound(joints.begin(), joints.end(), follows ? link.joint.mimicOf : at);
            const auto column = static_cast<std::size_t>(driver - joints.begin());
            jacobian[column * contacts.size() + i] +=
                (follows ? link.joint.mimicMultiplier : 1.0) *
                jointTwist(link, poses[static_cast<std::size_t>(at)], contacts[i].point);
        }
    }
    return jacobian;
}

std::vector<double> effortLimits(const KinematicTree& tree)
{
    const std::vector<std::int32_t> joints = independentJoints(tree);
    std::vector<double> limits(joints.size());
    std::transform(joints.begin(),
                   joints.end(),
                   limits.begin(),
                   [&](std::int32_t joint)
                   { return tree.links[static_cast<std::size_t>(joint)].joint.maxEffort; });
    return limits;
}
}  // namespace bullet_ccd::grasp
