#include "bullet_ccd/toi/articulated/articulated_culling.h"

#include <algorithm>
#include <tuple>

namespace bullet_ccd
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Vector3d;

bool overlap(const AlignedBox3d& a, const AlignedBox3d& b)
{
    return (a.min().array() <= b.max().array()).all() && (b.min().array() <= a.max().array()).all();
}

/// An interval is halved where doubt about the motion widens a box by more than this part of the
/// link's size.
constexpr double kMuchDoubt = 0.25;
/// Boxes of links that come farther than a few times their size say little; halves are worth their
/// cost if they can save a good many pairs.
constexpr double kFar = 3.0;
constexpr std::size_t kManyPairs = 8;
}  // namespace

void LinkCulling::reset(const ArticulatedBody& body, const Environment& environment, double reach)
{
    m_body = body;
    m_environment = &environment;
    m_reach = reach;
    m_frames.reset(*body.tree, *body.motion);
    // Without surroundings the root is as good a place to look from as any.
    m_base = environment.bodies().empty() ? m_frames.place(0).frame : 0;
    m_links.clear();
    m_slotOfLink.assign(body.tree->size(), kNone);
    std::int64_t moving = 0;
    for (std::int32_t link = 0; link < static_cast<std::int32_t>(body.tree->size()); ++link)
    {
        const SsvTree* tree = body.linkTrees[static_cast<std::size_t>(link)];
        if (tree == nullptr)
        {
            continue;
        }
        const LinkPlace& place = m_frames.place(link);
        OrientedBox box = rootBox(*tree);
        box.center = place.X_FL * box.center;
        box.axes = place.X_FL.linear() * box.axes;
        m_slotOfLink[static_cast<std::size_t>(link)] = static_cast<std::int32_t>(m_links.size());
        m_links.push_back({.link = link,
                           .frame = place.frame,
                           .inFrame = box,
                           .size = box.half.norm() + box.radius,
                           .interval = 0});
        moving += place.frame != 0 ? 1 : 0;
    }
    const auto all = static_cast<std::int64_t>(m_links.size());
    m_pairCount = moving * static_cast<std::int64_t>(environment.bodies().size()) +
                  (all - moving) * static_cast<std::int64_t>(environment.movingCount());
    m_interval = 0;
    collectSelfPairs();
    m_pairCount += static_cast<std::int64_t>(m_selfPairs.size());
}

void LinkCulling::collectSelfPairs()
{
    m_selfPairs.clear();
    for (const auto& [linkA, linkB] : m_body.selfPairs)
    {
        const std::int32_t slotA = m_slotOfLink[static_cast<std::size_t>(linkA)];
        const std::int32_t slotB = m_slotOfLink[static_cast<std::size_t>(linkB)];
        if (m_links[static_cast<std::size_t>(slotA)].frame !=
            m_links[static_cast<std::size_t>(slotB)].frame)
        {
            m_selfPairs.push_back({.slotA = slotA,
                                   .slotB = slotB,
                                   .mask = m_body.maskOf({.link = linkA, .otherLink = linkB})});
        }
    }
}

void LinkCulling::addObstaclePair(std::int32_t slot,
                                  std::int32_t obstacle,
                                  std::vector<Candidate>& out)
{
    const SweptLink& link = m_links[static_cast<std::size_t>(slot)];
    if (link.frame != 0 || m_environment->moves(obstacle))
    {
        out.push_back({.slotA = slot,
                       .slotB = kNone,
                       .obstacle = obstacle,
                       .mask = m_body.maskOf({.link = link.link, .obstacle = obstacle})});
    }
}

void LinkCulling::allPairs(std::vector<Candidate>& out)
{
    const auto obstacles = static_cast<std::int32_t>(m_environment->bodies().size());
    for (std::int32_t slot = 0; slot < static_cast<std::int32_t>(m_links.size()); ++slot)
    {
        for (std::int32_t obstacle = 0; obstacle < obstacles; ++obstacle)
        {
            addObstaclePair(slot, obstacle, out);
        }
    }
    out.insert(out.end(), m_selfPairs.begin(), m_selfPairs.end());
}

void LinkCulling::startInterval(double from, double to)
{
    ++m_interval;
    m_sweep.reset(m_frames, m_base, from, to);
}

/// As startInterval() for the whole step, with boxes that sweep() does not have to find.
void LinkCulling::startSlices()
{
    ++m_interval;
    m_balls.clear();
    for (const SweptLink& link : m_links)
    {
        const SsvTree& tree = *m_body.linkTrees[static_cast<std::size_t>(link.link)];
        m_balls.push_back({.frame = link.frame,
                           .center = m_frames.place(link.link).X_FL * tree.origin(),
                           .radius = tree.radius()});
    }
    m_nearTimes.reset(m_frames, m_base, m_balls);
    for (std::size_t slot = 0; slot < m_links.size(); ++slot)
    {
        SweptLink& link = m_links[slot];
        link.interval = m_interval;
        link.swept = {.box = m_nearTimes.boxOf(slot)};
        link.swept.box.min() -= Vector3d::Constant(m_reach);
        link.swept.box.max() += Vector3d::Constant(m_reach);
    }
}

/// Sets the times of pairs[begin, ..) and removes those that never meet.
void LinkCulling::narrow(std::vector<Candidate>& pairs, std::size_t begin)
{
    std::size_t kept = begin;
    for (std::size_t i = begin; i < pairs.size(); ++i)
    {
        Candidate pair = pairs[i];
        const auto slot = static_cast<std::size_t>(pair.slotA);
        std::optional<std::pair<double, double>> times(std::in_place, 0.0, 1.0);
        if (pair.slotB != kNone)
        {
            times = m_nearTimes.near(slot, static_cast<std::size_t>(pair.slotB), m_reach);
        }
        else if (!m_environment->moves(pair.obstacle))
        {
            const RigidBody& obstacle =
                m_environment->bodies()[static_cast<std::size_t>(pair.obstacle)];
            OrientedBox box = rootBox(*obstacle.tree);
            box.center = obstacle.motion.X_W0 * box.center;
            box.axes = obstacle.motion.X_W0.linear() * box.axes;
            times = m_nearTimes.near(slot, box, m_reach);
        }
        if (times.has_value())
        {
            std::tie(pair.from, pair.until) = *times;
            pairs[kept++] = pair;
        }
    }
    pairs.resize(kept);
}

const SweptLink& LinkCulling::sweep(std::int32_t slot)
{
    SweptLink& link = m_links[static_cast<std::size_t>(slot)];
    if (link.interval != m_interval)
    {
        link.interval = m_interval;
        link.swept = m_sweep.boxOver(link.frame, link.inFrame);
        link.swept.box.min() -= Vector3d::Constant(m_reach);
        link.swept.box.max() += Vector3d::Constant(m_reach);
    }
    return link;
}

/// Appends the tree over links [begin, end), which are near each other in the body.
void LinkCulling::buildNodes(std::int32_t begin, std::int32_t end)
{
    const std::size_t index = m_nodes.size();
    m_nodes.push_back({});
    if (end - begin == 1)
    {
        m_nodes[index].slot = begin;
        m_nodes[index].box = sweep(begin).swept.box;
        return;
    }
    const std::int32_t middle = begin + (end - begin) / 2;
    buildNodes(begin, middle);
    const auto right = m_nodes.size();
    buildNodes(middle, end);
    m_nodes[index].right = static_cast<std::int32_t>(right);
    m_nodes[index].box = m_nodes[index + 1].box.merged(m_nodes[right].box);
}

void LinkCulling::traverse(std::int32_t linkNode,
                           std::int32_t obstacleNode,
                           std::vector<Candidate>& out)
{
    const Node& a = m_nodes[static_cast<std::size_t>(linkNode)];
    const Environment::Node& b = m_environment->nodes()[static_cast<std::size_t>(obstacleNode)];
    if (!overlap(a.box, b.box))
    {
        return;
    }
    if (b.right != kNone && (a.right == kNone || a.box.volume() <= b.box.volume()))
    {
        traverse(linkNode, obstacleNode + 1, out);
        traverse(linkNode, b.right, out);
        return;
    }
    if (a.right != kNone)
    {
        traverse(linkNode + 1, obstacleNode, out);
        traverse(a.right, obstacleNode, out);
        return;
    }
    for (std::int32_t i = b.first; i < b.first + b.count; ++i)
    {
        const std::int32_t obstacle = m_environment->order()[static_cast<std::size_t>(i)];
        if (overlap(a.box, m_environment->box(obstacle)))
        {
            addObstaclePair(a.slot, obstacle, out);
        }
    }
}

void LinkCulling::pairsOfStep(bool bySlices, std::vector<Candidate>& out)
{
    const std::size_t begin = out.size();
    bySlices ? startSlices() : startInterval(0.0, 1.0);
    m_nodes.clear();
    if (!m_links.empty() && !m_environment->bodies().empty())
    {
        buildNodes(0, static_cast<std::int32_t>(m_links.size()));
        traverse(0, 0, out);
    }
    for (const Candidate& pair : m_selfPairs)
    {
        if (meets(pair, 0.0, 1.0))
        {
            out.push_back(pair);
        }
    }
    if (bySlices)
    {
        narrow(out, begin);
    }
}

bool LinkCulling::meets(const Candidate& candidate, double from, double to)
{
    const AlignedBox3d& box = sweep(candidate.slotA).swept.box;
    if (candidate.slotB != kNone)
    {
        return overlap(box, sweep(candidate.slotB).swept.box);
    }
    if (!overlap(box, m_environment->box(candidate.obstacle)))
    {
        return false;
    }
    const RigidBody& obstacle =
        m_environment->bodies()[static_cast<std::size_t>(candidate.obstacle)];
    return !m_environment->moves(candidate.obstacle) ||
           overlap(box, boundsOver(obstacle, from, to));
}

void LinkCulling::pairsOfInterval(
    std::vector<Candidate>& candidates, std::size_t begin, std::size_t end, double from, double to)
{
    startInterval(from, to);
    for (std::size_t i = begin; i < end; ++i)
    {
        const Candidate candidate = candidates[i];
        if (meets(candidate, from, to))
        {
            candidates.push_back(candidate);
        }
    }
}

bool LinkCulling::isWide(const std::vector<Candidate>& candidates,
                         std::size_t begin,
                         std::size_t end) const
{
    const bool many = end - begin > kManyPairs;
    const auto isWideLink = [&](std::int32_t slot)
    {
        const SweptLink& link = m_links[static_cast<std::size_t>(slot)];
        const double wide = link.swept.box.diagonal().norm() - 4.0 * m_reach;
        return link.swept.excess > kMuchDoubt * std::max(link.size, 0.1 * wide) ||
               (many && wide > 2.0 * kFar * link.size);
    };
    return std::any_of(candidates.begin() + static_cast<std::ptrdiff_t>(begin),
                       candidates.begin() + static_cast<std::ptrdiff_t>(end),
                       [&](const Candidate& candidate)
                       {
                           return isWideLink(candidate.slotA) ||
                                  (candidate.slotB != kNone && isWideLink(candidate.slotB));
                       });
}
}  // namespace bullet_ccd
