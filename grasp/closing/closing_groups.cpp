#include "grasp/closing/closing_groups.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <numeric>

namespace bullet_ccd::grasp
{
namespace
{
std::size_t at(std::int32_t index)
{
    return static_cast<std::size_t>(index);
}

/// For each link one that stands for its set; kNone where no closing joint is above.
class Sets
{
public:
    explicit Sets(const HandModel& hand) : m_parent(hand.robot.tree.size())
    {
        std::iota(m_parent.begin(), m_parent.end(), 0);
        std::vector<char> moves(m_parent.size(), 0);
        const std::vector<Link>& links = hand.robot.tree.links;
        for (std::size_t i = 1; i < links.size(); ++i)
        {
            const Joint& joint = links[i].joint;
            const std::size_t driver = joint.mimicOf != kNone ? at(joint.mimicOf) : i;
            const bool closes = joint.isMovable() && hand.closingDirections[driver] != 0;
            moves[i] = closes || moves[at(links[i].parent)] != 0 ? 1 : 0;
            if (moves[at(links[i].parent)] != 0)
            {
                join(static_cast<std::int32_t>(i), links[i].parent);
            }
            if (closes)
            {
                join(static_cast<std::int32_t>(i), static_cast<std::int32_t>(driver));
            }
        }
        for (std::size_t i = 0; i < moves.size(); ++i)
        {
            m_set.push_back(moves[i] != 0 ? find(static_cast<std::int32_t>(i)) : kNone);
        }
    }

    [[nodiscard]] std::int32_t of(std::size_t link) const { return m_set[link]; }

private:
    std::int32_t find(std::int32_t link) const
    {
        while (m_parent[at(link)] != link)
        {
            link = m_parent[at(link)];
        }
        return link;
    }
    void join(std::int32_t a, std::int32_t b) { m_parent[at(find(a))] = find(b); }

    std::vector<std::int32_t> m_parent;
    std::vector<std::int32_t> m_set;
};

void addPair(std::vector<LinkPair>& pairs,
             std::vector<const SsvTree*>& trees,
             const HandModel& hand,
             const LinkPair& pair)
{
    pairs.push_back(pair);
    trees[at(pair.first)] = hand.linkTrees[at(pair.first)];
    trees[at(pair.second)] = hand.linkTrees[at(pair.second)];
}
}  // namespace

ClosingGroups closingGroups(const HandModel& hand)
{
    const Sets sets(hand);
    const std::size_t count = hand.robot.tree.size();
    ClosingGroups result{.groups = {},
                         .groupOf = std::vector<std::int32_t>(count, kNone),
                         .crossPairs = {},
                         .crossTrees = std::vector<const SsvTree*>(count, nullptr)};
    std::vector<std::int32_t> groupOfSet(count, kNone);
    for (std::size_t link = 0; link < count; ++link)
    {
        const std::int32_t set = sets.of(link);
        if (set == kNone)
        {
            continue;
        }
        std::int32_t& group = groupOfSet[at(set)];
        if (group == kNone)
        {
            group = static_cast<std::int32_t>(result.groups.size());
            result.groups.push_back({.links = {},
                                     .selfPairs = {},
                                     .linkTrees = std::vector<const SsvTree*>(count, nullptr)});
        }
        result.groupOf[link] = group;
        result.groups[at(group)].links.push_back(static_cast<std::int32_t>(link));
        result.groups[at(group)].linkTrees[link] = hand.linkTrees[link];
    }
    for (const LinkPair& pair : hand.selfPairs)
    {
        const std::int32_t a = result.groupOf[at(pair.first)];
        const std::int32_t b = result.groupOf[at(pair.second)];
        if (a != kNone && b != kNone && a != b)
        {
            addPair(result.crossPairs, result.crossTrees, hand, pair);
        }
        else if (a != kNone || b != kNone)
        {
            ClosingGroup& group = result.groups[at(a != kNone ? a : b)];
            addPair(group.selfPairs, group.linkTrees, hand, pair);
        }
    }
    return result;
}

std::vector<std::int32_t> closingTurns(const HandModel& hand,
                                       const ClosingGroups& groups,
                                       const ClosingOptions& options)
{
    if (options.order == ClosingOrder::Together)
    {
        return {};
    }
    std::vector<std::int32_t> turnOfGroup(groups.groups.size(), kNone);
    std::int32_t next = 0;
    const auto add = [&](std::int32_t group)
    {
        if (group != kNone && turnOfGroup[at(group)] == kNone)
        {
            turnOfGroup[at(group)] = next++;
        }
    };
    const auto addFinger = [&](const Finger& finger)
    {
        for (const std::int32_t link : finger.links)
        {
            add(groups.groupOf[at(link)]);
        }
    };
    for (const std::string& name : options.firstFingers)
    {
        const auto finger = std::find_if(hand.fingers.begin(),
                                         hand.fingers.end(),
                                         [&](const Finger& f) { return f.name == name; });
        require(finger != hand.fingers.end(), "closing: no finger of the hand has this name");
        addFinger(*finger);
    }
    std::for_each(hand.fingers.begin(), hand.fingers.end(), addFinger);
    // What closes and is part of no finger comes last.
    std::for_each(groups.groupOf.begin(), groups.groupOf.end(), add);
    std::vector<std::int32_t> turns(groups.groupOf.size(), kNone);
    for (std::size_t link = 0; link < turns.size(); ++link)
    {
        const std::int32_t group = groups.groupOf[link];
        turns[link] = group == kNone ? kNone : turnOfGroup[at(group)];
    }
    return turns;
}
}  // namespace bullet_ccd::grasp
