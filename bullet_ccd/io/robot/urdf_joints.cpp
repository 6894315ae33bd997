#include "bullet_ccd/io/robot/urdf_joints.h"

#include "bullet_ccd/io/robot/robot_parts.h"
#include "bullet_ccd/io/robot/urdf_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace bullet_ccd
{
namespace
{
JointType jointType(const urdf::Joint& joint, const std::string& where)
{
    switch (joint.type)
    {
        case urdf::Joint::FIXED:
            return JointType::Fixed;
        case urdf::Joint::REVOLUTE:
        case urdf::Joint::CONTINUOUS:
            return JointType::Revolute;
        case urdf::Joint::PRISMATIC:
            return JointType::Prismatic;
        case urdf::Joint::FLOATING:
            throw std::runtime_error(where +
                                     ": type floating is not supported: make it fixed; "
                                     "the pose of the whole robot is given elsewhere");
        case urdf::Joint::PLANAR:
            throw std::runtime_error(where +
                                     ": type planar is not supported: replace it by two "
                                     "prismatic joints and a continuous one");
        default:
            throw std::runtime_error(where +
                                     ": unknown type: use revolute, continuous, prismatic "
                                     "or fixed");
    }
}

void requireFinite(double value, const std::string& what)
{
    if (!std::isfinite(value))
    {
        throw std::runtime_error(what + " is " + std::to_string(value) + ": give a finite number");
    }
}

void setLimits(const urdf::Joint& source, const std::string& where, Joint& joint)
{
    if (!source.limits)
    {
        if (source.type != urdf::Joint::CONTINUOUS)
        {
            throw std::runtime_error(where +
                                     ": no limit element: add <limit lower upper effort "
                                     "velocity>, or make the joint continuous");
        }
        return;
    }
    const urdf::JointLimits& limits = *source.limits;
    if (source.type != urdf::Joint::CONTINUOUS)
    {
        requireFinite(limits.lower, where + ": lower limit");
        requireFinite(limits.upper, where + ": upper limit");
        if (limits.lower > limits.upper)
        {
            throw std::runtime_error(where + ": lower limit " + std::to_string(limits.lower) +
                                     " is above upper limit " + std::to_string(limits.upper) +
                                     ": exchange them");
        }
        joint.lower = limits.lower;
        joint.upper = limits.upper;
    }
    for (const auto& [name, value] :
         {std::pair("effort", limits.effort), std::pair("velocity", limits.velocity)})
    {
        requireFinite(value, where + ": " + name + " limit");
        if (value < 0.0)
        {
            throw std::runtime_error(where + ": " + name + " limit " + std::to_string(value) +
                                     " is negative: give its size, or 0 for unlimited");
        }
    }
    joint.maxEffort = limits.effort > 0.0 ? limits.effort : joint.maxEffort;
    joint.maxVelocity = limits.velocity > 0.0 ? limits.velocity : joint.maxVelocity;
}

Joint buildJoint(const urdf::Joint& source, const std::string& where)
{
    Joint joint;
    joint.name = source.name;
    joint.type = jointType(source, where);
    if (!joint.isMovable())
    {
        return joint;
    }
    const Eigen::Vector3d axis(source.axis.x, source.axis.y, source.axis.z);
    const double length = axis.stableNorm();
    if (!(length > 0.0) || !std::isfinite(length))
    {
        throw std::runtime_error(where + ": axis has no direction: give a finite xyz other than 0");
    }
    joint.axis = axis.stableNormalized();
    setLimits(source, where, joint);
    return joint;
}

/// Two joints with one child, or a loop away from the root, leave joints or links that no walk from
/// the root meets.
void requireTree(const urdf::ModelInterface& model, const std::string& file)
{
    std::map<std::string, std::string> jointAbove;
    for (const auto& [name, joint] : model.joints_)
    {
        const auto [other, isNew] = jointAbove.emplace(joint->child_link_name, name);
        if (!isNew)
        {
            throw std::runtime_error(file + ": link '" + joint->child_link_name +
                                     "' hangs from two joints, '" + other->second + "' and '" +
                                     name + "': a URDF is a tree, remove one of them");
        }
    }
    if (!model.root_link_)
    {
        throw std::runtime_error(file + ": no root link: joints form a loop, remove one of them");
    }
}

/// The joint that drives a mimic joint, and how, after all mimics in between.
void resolveMimic(const std::map<std::string, const urdf::Joint*>& joints,
                  const std::string& file,
                  const KinematicTree& tree,
                  Joint& joint)
{
    const urdf::Joint* source = joints.at(joint.name);
    for (std::size_t steps = 0; source->mimic; ++steps)
    {
        const std::string where = file + ": joint '" + source->name + "': mimic";
        const urdf::JointMimic& mimic = *source->mimic;
        requireFinite(mimic.multiplier, where + ": multiplier");
        requireFinite(mimic.offset, where + ": offset");
        const auto target = joints.find(mimic.joint_name);
        if (target == joints.end())
        {
            throw std::runtime_error(where + " target '" + mimic.joint_name +
                                     "' does not exist: name a joint of this robot");
        }
        if (steps > joints.size())
        {
            throw std::runtime_error(file + ": joint '" + joint.name +
                                     "': mimic follows itself through '" + mimic.joint_name +
                                     "': let one joint of the loop be driven");
        }
        // q = m q' + o, and q' = m' q'' + o': q = m m' q'' + m o' + o.
        joint.mimicOffset += joint.mimicMultiplier * mimic.offset;
        joint.mimicMultiplier *= mimic.multiplier;
        source = target->second;
    }
    joint.mimicOf = tree.findJoint(source->name);
    const std::string where = file + ": joint '" + joint.name + "': mimic";
    if (source->type == urdf::Joint::FIXED)
    {
        throw std::runtime_error(where + " target '" + source->name +
                                 "' is fixed: name a joint that moves, or make this one fixed");
    }
    requireFinite(joint.mimicMultiplier, where + ": combined multiplier");
    requireFinite(joint.mimicOffset, where + ": combined offset");
}

void resolveMimics(const urdf::ModelInterface& model, const std::string& file, KinematicTree& tree)
{
    std::map<std::string, const urdf::Joint*> joints;
    for (const auto& [name, joint] : model.joints_)
    {
        joints.emplace(name, joint.get());
    }
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        Joint& joint = tree.links[i].joint;
        if (joint.isMovable() && joints.at(joint.name)->mimic)
        {
            resolveMimic(joints, file, tree, joint);
        }
    }
}

}  // namespace

KinematicTree buildTree(const urdf::ModelInterface& model,
                        const std::string& file,
                        std::vector<std::string>& notes)
{
    requireTree(model, file);
    struct Entry
    {
        const urdf::Link* link;
        std::int32_t parent;
    };
    KinematicTree tree;
    std::vector<Entry> stack{{model.root_link_.get(), kNone}};
    while (!stack.empty())
    {
        const Entry entry = stack.back();
        stack.pop_back();
        Link link;
        link.name = entry.link->name;
        link.parent = entry.parent;
        if (entry.parent != kNone)
        {
            const urdf::Joint& joint = *entry.link->parent_joint;
            const std::string where = file + ": joint '" + joint.name + "'";
            link.X_PL0 = toEigen(joint.parent_to_joint_origin_transform, where);
            link.joint = buildJoint(joint, where);
        }
        const auto index = static_cast<std::int32_t>(tree.size());
        tree.links.push_back(std::move(link));
        for (auto child = entry.link->child_links.rbegin(); child != entry.link->child_links.rend();
             ++child)
        {
            stack.push_back({child->get(), index});
        }
    }
    if (tree.size() != model.links_.size())
    {
        std::vector<std::string> lost;
        for (const auto& [name, link] : model.links_)
        {
            if (tree.findLink(name) == kNone)
            {
                lost.push_back(name);
            }
        }
        // Links of a loop own each other.
        for (const auto& [name, link] : model.links_)
        {
            link->child_links.clear();
        }
        throw std::runtime_error(
            file + ": links " + listNames(lost) +
            " form a loop that does not "
            "hang from the root: a URDF is a tree, remove a joint of the loop");
    }
    resolveMimics(model, file, tree);
    noteMimicLimits(tree, notes);
    noteUnlimited(tree, notes);
    return tree;
}
}  // namespace bullet_ccd
