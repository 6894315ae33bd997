#include "grasp/task/arm_robot.h"

#include "bullet_ccd/io/nearest_name.h"
#include "bullet_ccd/math/check.h"
#include "grasp/hand/sampled_pairs.h"

#include <algorithm>
#include <set>
#include <sstream>
#include <stdexcept>

namespace bullet_ccd::grasp
{
namespace
{
/// The links that no other link hangs from.
std::vector<std::int32_t> tipsOf(const KinematicTree& tree)
{
    std::vector<char> isTip(tree.size(), 1);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        isTip[static_cast<std::size_t>(tree.links[i].parent)] = 0;
    }
    std::vector<std::int32_t> tips;
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        if (isTip[i] != 0)
        {
            tips.push_back(static_cast<std::int32_t>(i));
        }
    }
    return tips;
}

std::string namesOf(const KinematicTree& tree, const std::vector<std::int32_t>& links)
{
    std::string names;
    for (const std::int32_t link : links)
    {
        names += (names.empty() ? "" : ", ") + tree.links[static_cast<std::size_t>(link)].name;
    }
    return names;
}

std::int32_t flangeOf(const RobotModel& arm, const std::string& name)
{
    const std::vector<std::int32_t> tips = tipsOf(arm.tree);
    if (name.empty())
    {
        require(tips.size() == 1,
                arm.file.string() + ": the arm has several ends (" + namesOf(arm.tree, tips) +
                    "): name the link that carries the hand");
        return tips.front();
    }
    const std::int32_t flange = arm.tree.findLink(name);
    require(flange != kNone,
            arm.file.string() + ": the arm has no link '" + name +
                "' to carry the hand: its ends are " + namesOf(arm.tree, tips));
    return flange;
}

void addHand(const HandModel& hand, std::int32_t flange, const Eigen::Isometry3d& X_FH, ArmRobot& r)
{
    std::set<std::string> taken;
    for (const Link& link : r.tree.links)
    {
        taken.insert({link.name, link.joint.name});
    }
    std::set<std::string> ofHand;
    for (const Link& link : hand.robot.tree.links)
    {
        ofHand.insert({link.name, link.joint.name});
    }
    const auto own = [&](const std::string& name)
    {
        std::string mine = name;
        while (!name.empty() && (taken.contains(mine) || (mine != name && ofHand.contains(mine))))
        {
            mine = "hand_" + mine;
        }
        return mine;
    };
    for (std::size_t i = 0; i < hand.robot.tree.size(); ++i)
    {
        Link link = hand.robot.tree.links[i];
        link.name = own(link.name);
        link.joint.name = own(link.joint.name);
        link.parent = i == 0 ? flange : r.ofHand(link.parent);
        if (i == 0)
        {
            link.X_PL0 = X_FH;
            link.joint = {.name = own(link.joint.name.empty() ? "mount" : link.joint.name)};
        }
        if (link.joint.mimicOf != kNone)
        {
            link.joint.mimicOf = r.ofHand(link.joint.mimicOf);
        }
        r.tree.links.push_back(std::move(link));
        r.linkTrees.push_back(hand.linkTrees[i]);
    }
}

/// As many as it takes to tell that a pair overlaps by design.
constexpr int kPairSamples = 300;

void addSelfPairs(const HandModel& hand, ArmRobot& r)
{
    for (const SampledPair& pair : samplePairs(r.tree, r.linkTrees, {.samples = kPairSamples}))
    {
        const bool isHand = pair.first >= r.handRoot;
        const bool isByDesign = pair.finding == PairFinding::Adjacent ||
                                pair.finding == PairFinding::Default ||
                                pair.finding == PairFinding::Always;
        if (!isHand && !isByDesign)
        {
            r.selfPairs.emplace_back(pair.first, pair.second);
        }
    }
    for (const auto& [a, b] : hand.selfPairs)
    {
        r.selfPairs.emplace_back(r.ofHand(a), r.ofHand(b));
    }
}
}  // namespace

ArmRobot mountHand(const RobotModel& arm,
                   const HandModel& hand,
                   const std::string& flange,
                   const Eigen::Isometry3d& X_FH)
{
    ArmRobot r;
    r.name = arm.name + "_" + hand.robot.name;
    r.tree = arm.tree;
    r.handRoot = static_cast<std::int32_t>(arm.tree.size());
    const std::int32_t carrier = flangeOf(arm, flange);
    for (std::int32_t link = carrier; link > 0;
         link = arm.tree.links[static_cast<std::size_t>(link)].parent)
    {
        const Joint& joint = arm.tree.links[static_cast<std::size_t>(link)].joint;
        if (joint.isMovable())
        {
            require(joint.mimicOf == kNone && joint.type != JointType::Spherical,
                    arm.file.string() + ": joint " + joint.name +
                        " follows another or is spherical: an arm needs joints of its own");
            r.joints.push_back(link);
        }
    }
    std::ranges::reverse(r.joints);
    require(!r.joints.empty(),
            arm.file.string() + ": no joint moves link " +
                arm.tree.links[static_cast<std::size_t>(carrier)].name +
                ", which is to carry the hand");
    for (const TriangleMesh& mesh : arm.linkMeshes)
    {
        if (!mesh.triangles.empty())
        {
            r.armTrees.push_back(std::make_unique<const SsvTree>(buildSsvTree(mesh)));
        }
        r.linkTrees.push_back(mesh.triangles.empty() ? nullptr : r.armTrees.back().get());
    }
    addHand(hand, carrier, X_FH, r);
    addSelfPairs(hand, r);
    return r;
}

HandModel wholeRobot(const ArmRobot& robot, const HandModel& hand)
{
    HandModel whole;
    whole.robot.name = robot.name;
    whole.robot.tree = robot.tree;
    whole.linkTrees = robot.linkTrees;
    for (const SsvTree* shape : robot.linkTrees)
    {
        whole.robot.linkMeshes.push_back(shape == nullptr ? TriangleMesh{} : shape->mesh());
    }
    whole.selfPairs = robot.selfPairs;
    whole.palm = robot.ofHand(hand.palm);
    whole.fingers = hand.fingers;
    for (Finger& finger : whole.fingers)
    {
        for (std::int32_t& link : finger.links)
        {
            link = robot.ofHand(link);
        }
    }
    return whole;
}

std::vector<double> startPositions(const ArmRobot& robot,
                                   std::span<const std::pair<std::string, double>> named)
{
    std::vector<double> start;
    std::vector<std::string> names;
    for (const std::int32_t link : robot.joints)
    {
        const Joint& joint = robot.tree.links[static_cast<std::size_t>(link)].joint;
        start.push_back(std::clamp(0.0, joint.lower, joint.upper));
        names.push_back(joint.name);
    }
    for (const auto& [name, position] : named)
    {
        const auto found = std::ranges::find(names, name);
        if (found == names.end())
        {
            throw std::invalid_argument("start: the arm has no joint " + name +
                                        " above its hand: did you mean " +
                                        nearestName(name, names) + "?");
        }
        const auto k = static_cast<std::size_t>(found - names.begin());
        const Joint& joint = robot.tree.links[static_cast<std::size_t>(robot.joints[k])].joint;
        if (!(position >= joint.lower && position <= joint.upper))
        {
            std::ostringstream what;
            what << "start: " << position << " of joint " << name << " is not within "
                 << joint.lower << " to " << joint.upper;
            throw std::invalid_argument(what.str());
        }
        start[k] = position;
    }
    return start;
}
}  // namespace bullet_ccd::grasp
