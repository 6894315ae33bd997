#include "tests/grasp/planner/test_hands.h"

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <numbers>

namespace bullet_ccd::tests
{
namespace
{
TriangleMesh boxAt(const Eigen::Vector3d& halfExtents, const Eigen::Vector3d& center)
{
    TriangleMesh mesh = makeBox(halfExtents);
    transformMesh(mesh, Eigen::Affine3d(Eigen::Translation3d(center)));
    return mesh;
}

/// Adds a link; returns its index.
std::int32_t addLink(grasp::HandModel& hand, Link link, TriangleMesh mesh, int closingDirection)
{
    link.joint.name = link.name + "_joint";
    hand.robot.tree.links.push_back(std::move(link));
    hand.robot.linkMeshes.push_back(mesh);
    hand.trees.push_back(buildSsvTree(std::move(mesh)));
    hand.closingDirections.push_back(closingDirection);
    return static_cast<std::int32_t>(hand.robot.tree.links.size()) - 1;
}

/// Call when all links are there: `trees` must not grow any more.
void finish(grasp::HandModel& hand, double graspDepth)
{
    for (const SsvTree& tree : hand.trees)
    {
        hand.linkTrees.push_back(&tree);
    }
    hand.preshapes.push_back({"open", std::vector<double>(hand.trees.size(), 0.0)});
    hand.X_RG.translation() = graspDepth * Eigen::Vector3d::UnitZ();
}

Link namedLink(std::string name, std::int32_t parent)
{
    Link link;
    link.name = std::move(name);
    link.parent = parent;
    return link;
}

Link slidingJaw(const char* name, double x)
{
    Link link = namedLink(name, 0);
    link.X_PL0.translation() = Eigen::Vector3d(x, 0.0, 0.0);
    link.joint.type = JointType::Prismatic;
    link.joint.axis =
        x < 0.0 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(-Eigen::Vector3d::UnitX());
    link.joint.lower = 0.0;
    link.joint.upper = 0.039;
    return link;
}
}  // namespace

grasp::HandModel makeGripper(bool coupled)
{
    grasp::HandModel hand;
    hand.robot.name = "gripper";
    addLink(hand, namedLink("palm", kNone), boxAt({0.06, 0.015, 0.02}, {0.0, 0.0, -0.025}), 0);
    const TriangleMesh jaw = boxAt({0.005, 0.01, 0.03}, {0.0, 0.0, 0.03});
    const std::int32_t left = addLink(hand, slidingJaw("left", -0.045), jaw, 1);
    Link rightLink = slidingJaw("right", 0.045);
    rightLink.joint.mimicOf = coupled ? left : kNone;
    const std::int32_t right = addLink(hand, std::move(rightLink), jaw, 1);
    hand.fingers = {{"left", {left}}, {"right", {right}}};
    hand.selfPairs = {{left, right}};
    finish(hand, 0.045);
    return hand;
}

grasp::HandModel makeThreeFingers()
{
    grasp::HandModel hand;
    hand.robot.name = "three_fingers";
    addLink(hand, namedLink("palm", kNone), boxAt({0.05, 0.05, 0.01}, {0.0, 0.0, -0.02}), 0);
    for (int k = 0; k < 3; ++k)
    {
        const double angle = 2.0 * std::numbers::pi * k / 3.0;
        const std::string name = "finger" + std::to_string(k);
        Link proximal = namedLink(name + "_proximal", 0);
        proximal.X_PL0 = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) *
                         Eigen::Translation3d(0.045, 0.0, 0.0);
        proximal.joint.type = JointType::Revolute;
        proximal.joint.axis = -Eigen::Vector3d::UnitY();
        proximal.joint.lower = -0.2;
        proximal.joint.upper = 1.4;
        Link distal = proximal;
        distal.name = name + "_distal";
        distal.X_PL0 = Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 0.05));
        const TriangleMesh bone = boxAt({0.006, 0.008, 0.022}, {0.0, 0.0, 0.024});
        const std::int32_t first = addLink(hand, std::move(proximal), bone, 1);
        distal.parent = first;
        const std::int32_t second = addLink(hand, std::move(distal), bone, 1);
        hand.fingers.push_back({name, {first, second}});
    }
    for (std::int32_t a = 1; a < 7; ++a)
    {
        for (std::int32_t b = a + 1; b < 7; ++b)
        {
            if ((a - 1) / 2 != (b - 1) / 2)
            {
                hand.selfPairs.emplace_back(a, b);
            }
        }
    }
    finish(hand, 0.05);
    return hand;
}
}  // namespace bullet_ccd::tests
