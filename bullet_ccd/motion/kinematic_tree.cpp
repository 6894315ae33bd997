#include "bullet_ccd/motion/kinematic_tree.h"

#include "bullet_ccd/math/check.h"

namespace bullet_ccd
{
std::int32_t KinematicTree::findLink(const std::string& name) const
{
    for (std::size_t i = 0; i < links.size(); ++i)
    {
        if (links[i].name == name)
        {
            return static_cast<std::int32_t>(i);
        }
    }
    return kNone;
}

std::int32_t KinematicTree::findJoint(const std::string& name) const
{
    for (std::size_t i = 1; i < links.size(); ++i)
    {
        if (links[i].joint.name == name)
        {
            return static_cast<std::int32_t>(i);
        }
    }
    return kNone;
}

Eigen::Isometry3d linkInParent(const Link& link, double q)
{
    Eigen::Isometry3d X_PL = link.X_PL0;
    if (link.joint.type == JointType::Revolute)
    {
        X_PL.linear() *= Eigen::AngleAxisd(q, link.joint.axis).toRotationMatrix();
    }
    else if (link.joint.type == JointType::Prismatic)
    {
        X_PL.translation() += X_PL.linear() * (q * link.joint.axis);
    }
    return X_PL;
}

std::vector<Eigen::Isometry3d> linkPoses(const KinematicTree& tree,
                                         const Eigen::Isometry3d& X_WR,
                                         std::span<const double> positions)
{
    require(positions.size() == tree.size(),
            [&]
            {
                return "linkPoses: " + std::to_string(positions.size()) + " positions for " +
                       std::to_string(tree.size()) + " links: give one entry a link";
            });
    std::vector<Eigen::Isometry3d> poses;
    poses.reserve(tree.size());
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        const Link& link = tree.links[i];
        poses.push_back(link.parent == kNone ? X_WR
                                             : poses[static_cast<std::size_t>(link.parent)] *
                                                   linkInParent(link, positions[i]));
    }
    return poses;
}

void applyMimics(const KinematicTree& tree, std::span<double> positions)
{
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        if (joint.mimicOf != kNone)
        {
            positions[i] =
                joint.mimicMultiplier * positions[static_cast<std::size_t>(joint.mimicOf)] +
                joint.mimicOffset;
        }
    }
}

bool isAncestorOrSelf(const KinematicTree& tree, std::int32_t ancestor, std::int32_t link)
{
    while (link > ancestor)  // parents have smaller indices
    {
        link = tree.links[static_cast<std::size_t>(link)].parent;
    }
    return link == ancestor;
}
}  // namespace bullet_ccd
