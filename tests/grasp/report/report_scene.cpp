#include "tests/grasp/report/report_scene.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"

#include <cmath>
#include <numbers>

namespace bullet_ccd::tests
{
grasp::HandModel makeBoxHand()
{
    grasp::HandModel hand;
    hand.robot.name = "box_hand";
    const auto addLink = [&](const std::string& name,
                             const Eigen::Vector3d& place,
                             const Eigen::Vector3d& halfExtents)
    {
        Link& link = hand.robot.tree.links.emplace_back();
        link.name = name;
        link.parent = hand.robot.tree.size() == 1 ? kNone : 0;
        link.X_PL0 = Eigen::Translation3d(place);
        hand.robot.linkMeshes.push_back(makeBox(halfExtents));
    };
    addLink("palm", {0.0, 0.0, 0.0}, {0.075, 0.03, 0.012});
    addLink("left", {-0.065, 0.0, -0.06}, {0.01, 0.012, 0.048});
    addLink("right", {0.065, 0.0, -0.06}, {0.01, 0.012, 0.048});
    hand.fingers = {{"left", {1}}, {"right", {2}}};
    hand.preshapes = {{"open", {0.0, 0.0, 0.0}}};
    return hand;
}

grasp::Grasp makeBoxGrasp(int contactCount)
{
    grasp::Grasp grasp;
    grasp.preshape = "open";
    grasp.approach_W = -Eigen::Vector3d::UnitZ();
    grasp.X_WH = Eigen::Translation3d(0.0, 0.0, 0.08);
    grasp.positions = {0.0, 0.0, 0.0};
    for (int i = 0; i < contactCount; ++i)
    {
        const double phi = 2.0 * std::numbers::pi * i / contactCount;
        grasp::GraspContact& contact = grasp.contacts.emplace_back();
        contact.link = 1 + i % 2;
        contact.normal = -Eigen::Vector3d(std::cos(phi), std::sin(phi), 0.0);
        contact.point = -0.05 * contact.normal;
    }
    return grasp;
}

std::filesystem::path outputFile(const std::string& name)
{
    static const TempFolder folder;
    return folder.path() / name;
}
}  // namespace bullet_ccd::tests
