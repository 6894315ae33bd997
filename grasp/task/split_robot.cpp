#include "grasp/task/split_robot.h"

#include "bullet_ccd/io/nearest_name.h"
#include "grasp/hand/srdf_file.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
/// As many joints has an arm at least.
constexpr int kArmJoints = 3;

const Link& linkAt(const KinematicTree& tree, std::int32_t link)
{
    return tree.links[static_cast<std::size_t>(link)];
}

[[noreturn]] void fail(const RobotModel& robot, const std::string& what)
{
    throw std::runtime_error(robot.file.string() + ": " + what);
}

/// A link that divides into chains that move, and how many joints there are from where the search
/// began.
struct Palm
{
    std::int32_t link = 0;
    int joints = 0;
};

class PalmSearch
{
public:
    explicit PalmSearch(const RobotModel& robot) : m_tree(robot.tree), m_children(m_tree.size())
    {
        // A link is behind its parent. Those below which a joint moves a shape count.
        std::vector<bool> hasShape(m_tree.size(), false);
        std::vector<bool> moves(m_tree.size(), false);
        for (std::size_t i = m_tree.size(); i-- > 1;)
        {
            const Link& link = m_tree.links[i];
            const auto parent = static_cast<std::size_t>(link.parent);
            hasShape[i] = hasShape[i] || !robot.linkMeshes[i].triangles.empty();
            moves[i] = moves[i] || (link.joint.isMovable() && hasShape[i]);
            hasShape[parent] = hasShape[parent] || hasShape[i];
            moves[parent] = moves[parent] || moves[i];
            if (moves[i])
            {
                m_children[parent].push_back(static_cast<std::int32_t>(i));
            }
        }
    }

    [[nodiscard]] std::vector<Palm> below(std::int32_t link) const
    {
        const auto& children = m_children[static_cast<std::size_t>(link)];
        const bool divides = children.size() > 1;
        std::vector<Palm> palms;
        for (auto child = children.rbegin(); child != children.rend(); ++child)
        {
            for (Palm palm : below(*child))
            {
                palm.joints += linkAt(m_tree, *child).joint.isMovable() ? 1 : 0;
                if (!divides || palm.joints >= kArmJoints)
                {
                    palms.push_back(palm);
                }
            }
        }
        if (divides && palms.empty())
        {
            palms.push_back({.link = link});
        }
        return palms;
    }

private:
    const KinematicTree& m_tree;
    std::vector<std::vector<std::int32_t>> m_children;
};

std::int32_t namedLink(const RobotModel& robot, const std::string& name)
{
    const std::int32_t link = robot.tree.findLink(name);
    if (link == kNone)
    {
        std::vector<std::string> names;
        for (const Link& each : robot.tree.links)
        {
            names.push_back(each.name);
        }
        fail(robot,
             "there is no link '" + name + "': did you mean '" + nearestName(name, names) + "'?");
    }
    return link;
}

std::int32_t rootOf(const RobotModel& robot, const Srdf& srdf, const SrdfEndEffector& effector)
{
    const auto group = std::ranges::find(srdf.groups, effector.group, &SrdfGroup::name);
    if (group == srdf.groups.end() || group->links.empty())
    {
        fail(robot,
             srdf.file.string() + ": end_effector '" + effector.name + "': its group '" +
                 effector.group + "' lists no link: name the link with which the hand begins");
    }
    const std::int32_t parent = namedLink(robot, effector.parentLink);
    for (std::int32_t link = namedLink(robot, group->links.front()); link > 0;
         link = linkAt(robot.tree, link).parent)
    {
        if (linkAt(robot.tree, link).parent == parent)
        {
            return link;
        }
    }
    fail(robot,
         srdf.file.string() + ": end_effector '" + effector.name + "': link '" +
             group->links.front() + "' does not hang from its parent_link '" + effector.parentLink +
             "': correct the SRDF");
}

/// The links that `keeps` holds, in their order; the first is the root.
RobotModel partOf(const RobotModel& robot, const std::vector<char>& keeps, const std::string& name)
{
    RobotModel part{.name = name, .file = robot.file, .tree = {}, .linkMeshes = {}, .notes = {}};
    std::vector<std::int32_t> now(robot.tree.size(), kNone);
    for (std::size_t i = 0; i < robot.tree.size(); ++i)
    {
        if (keeps[i] == 0)
        {
            continue;
        }
        now[i] = static_cast<std::int32_t>(part.tree.size());
        Link link = robot.tree.links[i];
        link.parent = now[i] == 0 ? kNone : now[static_cast<std::size_t>(link.parent)];
        part.tree.links.push_back(std::move(link));
        part.linkMeshes.push_back(robot.linkMeshes[i]);
    }
    for (Link& link : part.tree.links)
    {
        std::int32_t& leader = link.joint.mimicOf;
        if (leader != kNone)
        {
            const std::string& leading = linkAt(robot.tree, leader).joint.name;
            leader = now[static_cast<std::size_t>(leader)];
            if (leader == kNone)
            {
                fail(robot,
                     "joint '" + link.joint.name + "' follows '" + leading +
                         "' of another part of the robot, which is not supported");
            }
        }
    }
    return part;
}

std::vector<char> subtree(const KinematicTree& tree, std::int32_t root)
{
    std::vector<char> isBelow(tree.size(), 0);
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        isBelow[i] = isAncestorOrSelf(tree, root, static_cast<std::int32_t>(i)) ? 1 : 0;
    }
    return isBelow;
}
}  // namespace

std::vector<std::int32_t> findHandRoots(const RobotModel& robot,
                                        const std::optional<std::filesystem::path>& srdfFile,
                                        std::span<const std::string> named)
{
    std::vector<std::int32_t> roots;
    for (const std::string& name : named)
    {
        roots.push_back(namedLink(robot, name));
    }
    if (roots.empty() && srdfFile)
    {
        const Srdf srdf = readSrdf(*srdfFile);
        for (const SrdfEndEffector& effector : srdf.endEffectors)
        {
            roots.push_back(rootOf(robot, srdf, effector));
        }
    }
    if (!roots.empty())
    {
        return roots;
    }
    for (const Palm& palm : PalmSearch(robot).below(0))
    {
        std::int32_t root = palm.link;
        if (palm.joints == 0)
        {
            fail(robot,
                 "it divides at link '" + linkAt(robot.tree, root).name +
                     "', which no joint moves: is this a hand without an arm? Name the link with "
                     "which its hand begins, or give arm and hand");
        }
        while (!linkAt(robot.tree, root).joint.isMovable() &&
               !linkAt(robot.tree, linkAt(robot.tree, root).parent).joint.isMovable())
        {
            root = linkAt(robot.tree, root).parent;
        }
        roots.push_back(root);
    }
    if (roots.empty())
    {
        fail(robot,
             "it does not divide into fingers anywhere: give a hand, or name the link with which "
             "the hand of this robot begins");
    }
    return roots;
}

SplitRobot splitRobot(const RobotModel& robot, std::int32_t handRoot)
{
    const Link& root = linkAt(robot.tree, handRoot);
    if (handRoot == 0)
    {
        fail(robot, "link '" + root.name + "' is the root: nothing would be left for the arm");
    }
    const std::vector<char> isHand = subtree(robot.tree, handRoot);
    const bool moves = root.joint.isMovable();
    std::vector<char> isArm(isHand.size());
    std::ranges::transform(isHand, isArm.begin(), [](char is) { return is == 0 ? 1 : 0; });
    isArm[static_cast<std::size_t>(handRoot)] = moves ? 1 : 0;

    SplitRobot split{.arm = partOf(robot, isArm, robot.name),
                     .hand = partOf(robot, isHand, robot.name + "_hand"),
                     .flange = {},
                     .X_FH = Eigen::Isometry3d::Identity()};
    Link& first = split.hand.tree.links.front();
    first.joint = {.name = moves ? root.name + "_mount" : first.joint.name};
    first.X_PL0.setIdentity();
    if (moves)
    {
        split.flange = root.name + "_carrier";
        const auto carrier = static_cast<std::size_t>(split.arm.tree.findLink(root.name));
        Link& link = split.arm.tree.links[carrier];
        link = {
            .name = split.flange, .parent = link.parent, .X_PL0 = link.X_PL0, .joint = link.joint};
        split.arm.linkMeshes[carrier] = {};
    }
    else
    {
        split.flange = linkAt(robot.tree, root.parent).name;
        split.X_FH = root.X_PL0;
    }
    return split;
}

std::array<SplitRobot, 2> splitArms(const RobotModel& robot,
                                    const std::array<std::int32_t, 2>& handRoots)
{
    const KinematicTree& tree = robot.tree;
    const std::int32_t common = commonAncestor(tree, handRoots[0], handRoots[1]);
    if (common == handRoots[0] || common == handRoots[1])
    {
        fail(robot,
             "of the links '" + linkAt(tree, handRoots[0]).name + "' and '" +
                 linkAt(tree, handRoots[1]).name + "' one hangs from the other: name two hands");
    }
    for (std::int32_t link = common; link != kNone; link = linkAt(tree, link).parent)
    {
        const bool hasShape = !robot.linkMeshes[static_cast<std::size_t>(link)].triangles.empty();
        if (hasShape || linkAt(tree, link).joint.isMovable())
        {
            fail(robot,
                 "link '" + linkAt(tree, link).name + "' carries both arms and " +
                     (hasShape ? "has a shape" : "is moved by a joint") +
                     ", which is not supported: two arms must stand by themselves");
        }
    }
    const std::vector<Eigen::Isometry3d> X_RL =
        linkPoses(tree, Eigen::Isometry3d::Identity(), std::vector<double>(tree.size(), 0.0));
    std::array<SplitRobot, 2> arms;
    std::array<double, 2> y{};
    for (std::size_t side = 0; side < 2; ++side)
    {
        std::int32_t top = handRoots[side];  // of this arm alone
        std::int32_t shoulder = top;
        for (; linkAt(tree, top).parent != common; top = linkAt(tree, top).parent)
        {
            shoulder = linkAt(tree, top).joint.isMovable() ? top : shoulder;
        }
        shoulder = linkAt(tree, top).joint.isMovable() ? top : shoulder;
        y[side] = X_RL[static_cast<std::size_t>(shoulder)].translation().y();
        std::vector<char> keeps = subtree(tree, top);
        for (std::int32_t link = common; link != kNone; link = linkAt(tree, link).parent)
        {
            keeps[static_cast<std::size_t>(link)] = 1;
        }
        const RobotModel one = partOf(robot, keeps, robot.name);
        arms[side] = splitRobot(one, one.tree.findLink(linkAt(tree, handRoots[side]).name));
    }
    if (y[1] > y[0])
    {
        std::swap(arms[0], arms[1]);
    }
    return arms;
}
}  // namespace bullet_ccd::grasp
