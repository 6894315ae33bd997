#include "grasp/hand/self_pairs.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <algorithm>
#include <set>
#include <string>

namespace bullet_ccd::grasp
{
namespace
{
using LinkPair = std::pair<std::int32_t, std::int32_t>;

/// Closing joints on the way from `link` up to `ancestor`.
int closingJoints(const HandModel& hand, std::int32_t link, std::int32_t ancestor)
{
    int count = 0;
    for (; link != ancestor; link = hand.robot.tree.links[static_cast<std::size_t>(link)].parent)
    {
        count += hand.closingDirections[static_cast<std::size_t>(link)] != 0 ? 1 : 0;
    }
    return count;
}

/// For every preshape, whether the pair overlaps in it.
std::vector<bool> overlaps(const HandModel& hand,
                           const LinkPair& pair,
                           const std::vector<std::vector<Eigen::Isometry3d>>& poses)
{
    const auto a = static_cast<std::size_t>(pair.first);
    const auto b = static_cast<std::size_t>(pair.second);
    std::vector<bool> result;
    for (const std::vector<Eigen::Isometry3d>& X_R : poses)
    {
        result.push_back(
            treeDistance(
                *hand.linkTrees[a], *hand.linkTrees[b], X_R[b].inverse() * X_R[a], kPreshapeOverlap)
                .distance < kPreshapeOverlap);
    }
    return result;
}

std::string named(const HandModel& hand, const LinkPair& pair)
{
    return hand.robot.tree.links[static_cast<std::size_t>(pair.first)].name + "/" +
           hand.robot.tree.links[static_cast<std::size_t>(pair.second)].name;
}

void append(std::string& list, const std::string& item)
{
    list += (list.empty() ? "" : ", ") + item;
}

int movableJoints(const HandModel& hand, std::int32_t link, std::int32_t ancestor)
{
    int count = 0;
    for (; link != ancestor; link = hand.robot.tree.links[static_cast<std::size_t>(link)].parent)
    {
        count += hand.robot.tree.links[static_cast<std::size_t>(link)].joint.isMovable() ? 1 : 0;
    }
    return count;
}
}  // namespace

bool canTouch(const HandModel& hand, std::int32_t first, std::int32_t second)
{
    if (hand.linkTrees[static_cast<std::size_t>(first)] == nullptr ||
        hand.linkTrees[static_cast<std::size_t>(second)] == nullptr)
    {
        return false;
    }
    const std::int32_t base = commonAncestor(hand.robot.tree, first, second);
    return closingJoints(hand, first, base) + closingJoints(hand, second, base) >= 2;
}

bool selfOverlaps(const HandModel& hand,
                  const std::vector<double>& positions,
                  const std::vector<double>& reference)
{
    const std::vector<std::vector<Eigen::Isometry3d>> poses{
        linkPoses(hand.robot.tree, Eigen::Isometry3d::Identity(), positions),
        linkPoses(hand.robot.tree, Eigen::Isometry3d::Identity(), reference)};
    const auto count = static_cast<std::int32_t>(hand.linkTrees.size());
    for (LinkPair pair(0, 0); pair.first < count; ++pair.first)
    {
        for (pair.second = pair.first + 1; pair.second < count; ++pair.second)
        {
            if (hand.linkTrees[static_cast<std::size_t>(pair.first)] == nullptr ||
                hand.linkTrees[static_cast<std::size_t>(pair.second)] == nullptr)
            {
                continue;
            }
            const std::int32_t base = commonAncestor(hand.robot.tree, pair.first, pair.second);
            if (movableJoints(hand, pair.first, base) + movableJoints(hand, pair.second, base) < 2)
            {
                continue;
            }
            const std::vector<bool> overlap = overlaps(hand, pair, poses);
            if (overlap[0] && !overlap[1])
            {
                return true;
            }
        }
    }
    return false;
}

void setSelfPairs(HandModel& hand, const std::vector<LinkPair>& disabled)
{
    std::set<LinkPair> off;
    for (const LinkPair& pair : disabled)
    {
        off.insert(std::minmax(pair.first, pair.second));
    }
    std::vector<std::vector<Eigen::Isometry3d>> poses;
    for (const Preshape& preshape : hand.preshapes)
    {
        poses.push_back(
            linkPoses(hand.robot.tree, Eigen::Isometry3d::Identity(), preshape.positions));
    }
    std::string always;
    std::vector<std::string> sometimes(hand.preshapes.size());
    hand.selfPairs.clear();
    const auto count = static_cast<std::int32_t>(hand.linkTrees.size());
    for (LinkPair pair(0, 0); pair.first < count; ++pair.first)
    {
        for (pair.second = pair.first + 1; pair.second < count; ++pair.second)
        {
            if (off.contains(pair) || !canTouch(hand, pair.first, pair.second))
            {
                continue;
            }
            const std::vector<bool> overlap = overlaps(hand, pair, poses);
            if (std::find(overlap.begin(), overlap.end(), false) == overlap.end())
            {
                append(always, named(hand, pair));
                continue;
            }
            for (std::size_t k = 0; k < overlap.size(); ++k)
            {
                if (overlap[k])
                {
                    append(sometimes[k], named(hand, pair));
                }
            }
            hand.selfPairs.push_back(pair);
        }
    }
    if (!always.empty())
    {
        hand.notes.push_back("links overlap in every preshape, not tested against each other: " +
                             always);
    }
    for (std::size_t k = 0; k < sometimes.size(); ++k)
    {
        if (!sometimes[k].empty())
        {
            hand.notes.push_back("preshape '" + hand.preshapes[k].name +
                                 "' overlaps itself and will be rejected: " + sometimes[k]);
        }
    }
}
}  // namespace bullet_ccd::grasp
