#include "grasp/task/two_arms.h"

#include "grasp/force/grasp_forces.h"
#include "grasp/squeeze/squeeze.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace bullet_ccd::grasp
{
namespace
{
const std::array<std::string, 2> kSides{"left_", "right_"};

void addArm(std::size_t side, const std::string& prefix, TwoArms& r)
{
    const auto& [hand, robot, X_WR] = r.arms[side];
    HandModel& whole = r.whole;
    r.first[side] = static_cast<std::int32_t>(whole.robot.tree.size());
    for (std::size_t i = 0; i < robot->tree.size(); ++i)
    {
        Link link = robot->tree.links[i];
        link.name = (i == 0 ? kSides[side] : prefix) + link.name;
        link.parent = i == 0 ? 0 : r.linkOf(side, link.parent);
        if (i == 0)
        {
            link.X_PL0 = X_WR;
        }
        link.joint.name =
            i == 0 ? kSides[side] + std::string("base_mount") : prefix + link.joint.name;
        if (link.joint.mimicOf != kNone)
        {
            link.joint.mimicOf = r.linkOf(side, link.joint.mimicOf);
        }
        whole.robot.tree.links.push_back(std::move(link));
        const SsvTree* shape = robot->linkTrees[i];
        whole.linkTrees.push_back(shape);
        whole.robot.linkMeshes.push_back(shape == nullptr ? TriangleMesh{} : shape->mesh());
        const bool isHand = std::ptrdiff_t(i) >= robot->handRoot;
        const std::size_t ofHand = isHand ? i - static_cast<std::size_t>(robot->handRoot) : 0;
        whole.closingDirections.push_back(isHand ? hand->closingDirections[ofHand] : 0);
        whole.closingSpeeds.push_back(
            isHand && !hand->closingSpeeds.empty() ? hand->closingSpeeds[ofHand] : 1.0);
    }
    for (const Finger& finger : hand->fingers)
    {
        whole.fingers.push_back({.name = prefix + finger.name, .links = {}});
        for (const std::int32_t link : finger.links)
        {
            whole.fingers.back().links.push_back(r.linkOf(side, robot->ofHand(link)));
        }
    }
    for (const auto& [a, b] : robot->selfPairs)
    {
        whole.selfPairs.emplace_back(r.linkOf(side, a), r.linkOf(side, b));
    }
}

/// Of the joints of an arm with its hand, in the order of independentJoints().
void addEfforts(const PlacedArm& arm, std::vector<double>& efforts)
{
    const std::vector<JointEffort> ofHand = jointEfforts(*arm.hand);
    auto next = ofHand.begin();
    for (const std::int32_t link : independentJoints(arm.robot->tree))
    {
        const Joint& joint = arm.robot->tree.links[static_cast<std::size_t>(link)].joint;
        const bool isStated = joint.maxEffort > 0.0 && std::isfinite(joint.maxEffort);
        efforts.push_back(link >= arm.robot->handRoot          ? (next++)->limit
                          : isStated                           ? joint.maxEffort
                          : joint.type == JointType::Prismatic ? kUsualForce
                                                               : kUsualTorque);
    }
}
}  // namespace

TwoArms joinArms(const std::array<PlacedArm, 2>& arms, const std::array<std::string, 2>& prefixes)
{
    TwoArms r{.arms = arms, .first = {}, .whole = {}, .efforts = {}};
    r.whole.robot.name = arms[0].robot->name + "_and_" + arms[1].robot->name;
    r.whole.robot.tree.links.push_back({.name = "world"});
    r.whole.linkTrees.push_back(nullptr);
    r.whole.robot.linkMeshes.emplace_back();
    r.whole.closingDirections.push_back(0);
    r.whole.closingSpeeds.push_back(1.0);
    addArm(0, prefixes[0], r);
    addArm(1, prefixes[1], r);
    const auto size = static_cast<std::int32_t>(r.whole.linkTrees.size());
    const auto hasGeometry = [&](std::int32_t link)
    { return r.whole.linkTrees[static_cast<std::size_t>(link)] != nullptr; };
    for (std::int32_t left = r.first[0]; left < r.first[1]; ++left)
    {
        for (std::int32_t right = r.first[1]; right < size; ++right)
        {
            if (hasGeometry(left) && hasGeometry(right))
            {
                r.whole.selfPairs.emplace_back(left, right);
            }
        }
    }
    r.whole.palm = r.handRoot(0);
    for (const PlacedArm& arm : arms)
    {
        addEfforts(arm, r.efforts);
    }
    return r;
}

std::vector<std::int32_t> TwoArms::joints() const
{
    std::vector<std::int32_t> all;
    for (std::size_t side = 0; side < 2; ++side)
    {
        for (const std::int32_t link : arms[side].robot->joints)
        {
            all.push_back(linkOf(side, link));
        }
    }
    return all;
}

std::vector<double> TwoArms::positions(const std::array<std::vector<double>, 2>& joints,
                                       const std::array<std::vector<double>, 2>& hands) const
{
    std::vector<double> q(whole.robot.tree.size(), 0.0);
    for (std::size_t side = 0; side < 2; ++side)
    {
        std::ranges::copy(hands[side], q.begin() + handRoot(side));
        for (std::size_t k = 0; k < joints[side].size(); ++k)
        {
            q[static_cast<std::size_t>(linkOf(side, arms[side].robot->joints[k]))] =
                joints[side][k];
        }
    }
    applyMimics(whole.robot.tree, q);
    return q;
}
}  // namespace bullet_ccd::grasp
