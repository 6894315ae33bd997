#include "tests/grasp/closing/finger_hand.h"

#include "benchmarks/reference/scenes/shapes.h"

#include <utility>

namespace bullet_ccd::tests
{
using namespace reference;

HandBuilder::HandBuilder()
{
    m_hand.robot.name = "test hand";
    Link palm;
    palm.name = "palm";
    m_hand.robot.tree.links.push_back(palm);
    m_hand.closingDirections.push_back(0);
    m_treeOf.push_back(kNone);
}

void HandBuilder::setPalm(const TriangleMesh& mesh)
{
    m_treeOf.front() = static_cast<std::int32_t>(m_hand.trees.size());
    m_hand.trees.push_back(buildSsvTree(mesh));
}

std::int32_t HandBuilder::add(std::int32_t parent,
                              const Eigen::Isometry3d& X_PL0,
                              const Joint& joint,
                              int direction,
                              const TriangleMesh& mesh)
{
    Link link;
    link.name = "link" + std::to_string(m_hand.robot.tree.size());
    link.parent = parent;
    link.X_PL0 = X_PL0;
    link.joint = joint;
    // Off the joint and not diagonal, so that Bullet's link frame differs from ours in every way.
    link.mass = 0.05;
    link.centerOfMass = {0.02, -0.01, 0.005};
    link.inertia << 3e-5, 1e-5, 2e-6, 1e-5, 4e-5, -3e-6, 2e-6, -3e-6, 6e-5;
    m_hand.robot.tree.links.push_back(link);
    m_hand.closingDirections.push_back(direction);
    m_treeOf.push_back(static_cast<std::int32_t>(m_hand.trees.size()));
    m_hand.trees.push_back(buildSsvTree(mesh));
    return static_cast<std::int32_t>(m_hand.robot.tree.size()) - 1;
}

void HandBuilder::mimic(std::int32_t link, std::int32_t of, double multiplier, double offset)
{
    Joint& joint = m_hand.robot.tree.links[static_cast<std::size_t>(link)].joint;
    joint.mimicOf = of;
    joint.mimicMultiplier = multiplier;
    joint.mimicOffset = offset;
}

grasp::HandModel HandBuilder::take()
{
    for (const std::int32_t index : m_treeOf)
    {
        m_hand.linkTrees.push_back(index == kNone ? nullptr
                                                  : &m_hand.trees[static_cast<std::size_t>(index)]);
    }
    return std::move(m_hand);  // the vector of trees keeps its storage
}

Joint revolute(const Eigen::Vector3d& axis, double lower, double upper)
{
    Joint joint;
    joint.type = JointType::Revolute;
    joint.axis = axis;
    joint.lower = lower;
    joint.upper = upper;
    return joint;
}

Joint prismatic(const Eigen::Vector3d& axis, double lower, double upper)
{
    Joint joint = revolute(axis, lower, upper);
    joint.type = JointType::Prismatic;
    return joint;
}

TriangleMesh finger(double length)
{
    return segment(Eigen::Vector3d::Zero(), {length, 0.0, 0.0});
}
}  // namespace bullet_ccd::tests
