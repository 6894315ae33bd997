#include "benchmarks/articulated/first_order.h"

#include "bullet_ccd/distance/ssv_pair.h"
#include "bullet_ccd/toi/search/search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

class FirstOrderSearch
{
public:
    FirstOrderSearch(SearchState& state, FirstOrderBound bound) : m_state(state), m_bound(bound) {}

    void run()
    {
        EarliestFirst& queue = m_state.queue;
        for (std::int32_t i = 0; i < m_state.scene.size(); ++i)
        {
            queue.push({.pair = i, .nodeA = 0, .nodeB = 0, .lastStep = kFar});
        }
        while (!queue.empty() && queue.time() < m_state.hit.time)
        {
            const NodePair p = queue.top();
            queue.pop();
            checkLimit(m_state, p.time, p.pair);
            if (m_state.scene.isExempt(p))
            {
                continue;
            }
            const SsvNode& a = m_state.scene.nodeA(p);
            const SsvNode& b = m_state.scene.nodeB(p);
            if (a.isLeaf() && b.isLeaf())
            {
                advance(p, triangleTime(p));
                continue;
            }
            // A pair that came far for its size is worth another step before it is opened.
            const double way =
                static_cast<double>(p.lastStep) * m_state.scene.pair(p.pair).speedScale;
            if (way >= static_cast<double>(a.size() + b.size()))
            {
                advance(p, nodeTime(p));
                continue;
            }
            const Opening opening(a, b);
            for (std::int32_t k = 0; k < opening.count; ++k)
            {
                const NodePair child = opening.child(p, k);
                advance(child, nodeTime(child));
            }
        }
    }

private:
    static constexpr float kFar = std::numeric_limits<float>::infinity();

    /// Puts the pair back into the queue, unless it keeps its margin until the end.
    void advance(NodePair p, double step)
    {
        p.lastStep = static_cast<float>(step);
        p.time = std::nextafter(p.time + step * (1.0 - 1e-15), 0.0);  // rounded down
        if (p.time <= 1.0 && p.time < m_state.hit.time)
        {
            m_state.queue.push(p);
        }
    }

    [[nodiscard]] double speedOf(
        const PairSide& link, const Vector3d& n, double t, double ahead, double reach) const
    {
        if (m_bound == FirstOrderBound::Directional)
        {
            return directionalSpeed(*link.frames, link.frame, n, t, ahead, reach);
        }
        const SpeedBound speed = link.frames->speedBound(0, link.frame);
        return speed.constant + speed.perRadius * reach;
    }

    /// Time in which what is in the link's node closes a gap along n, in W.
    [[nodiscard]] double closingTime(const NodePair& p, double gap, const Vector3d& n)
    {
        const PairSide& link = m_state.scene.pair(p.pair).sideA;
        const SsvNode& node = m_state.scene.nodeA(p);
        const double reach =
            (link.X * place(node).center).norm() + static_cast<double>(node.size());
        const double left = std::max(1.0 - p.time, 0.0);
        double ahead = left;
        double best = 0.0;
        // The shorter the time ahead, the sharper the bound, which then must not be used beyond it.
        for (int i = 0; i < 4; ++i)
        {
            const double speed = speedOf(link, n, p.time, ahead, reach);
            const double time = speed > 0.0 ? gap / speed : 2.0;
            if (time >= ahead)
            {
                return ahead < left ? std::max(best, ahead) : 2.0;
            }
            best = std::max(best, time);
            ahead = 2.0 * best;
        }
        return best;
    }

    /// The best over all axes that separate the two volumes.
    [[nodiscard]] double nodeTime(const NodePair& p)
    {
        ++m_state.counters.nodePairs;
        PairScene& scene = m_state.scene;
        const PairState& at = scene.stateAt(p.pair, p.time, m_state.counters);
        const double margin = scene.pair(p.pair).limits.margin() + at.rounding;
        const Matrix3d R =
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(at.motion.R);
        const PlacedSsv a = place(scene.nodeA(p), R, Eigen::Map<const Vector3d>(at.motion.p));
        const PlacedSsv b = place(scene.nodeB(p));
        const Matrix3d toWorld = scene.worldOfB(p.pair, p.time).linear();
        double best = 0.0;
        forEachSeparatingAxis(a,
                              b,
                              [&](double gap, const auto& along)
                              {
                                  if (gap > margin)
                                  {
                                      Vector3d n;
                                      for (Eigen::Index k = 0; k < 3; ++k)
                                      {
                                          n[k] = along(a.axes.row(k), b.axes.row(k));
                                      }
                                      n = (toWorld * n).normalized();
                                      best = std::max(best, closingTime(p, gap - margin, n));
                                  }
                                  return false;
                              });
        return best;
    }

    /// Notes a contact.
    [[nodiscard]] double triangleTime(const NodePair& p)
    {
        ++m_state.counters.trianglePairs;
        PairScene& scene = m_state.scene;
        ScenePair& pair = scene.pair(p.pair);
        const PairLimits& limits = pair.limits;
        const PairState& at = scene.stateAt(p.pair, p.time, m_state.counters);
        const std::int32_t slotA = scene.nodeA(p).first;
        const std::int32_t slotB = scene.nodeB(p).first;
        const TriangleDistance found =
            triangleStep(*pair.treeA, *pair.treeB, at, limits.margin(), p.time > 0.0, slotA, slotB)
                .distance;
        const bool atStart = p.time == 0.0;
        if (found.distance <= (atStart ? limits.threshold : limits.near()))
        {
            m_state.hit = {.time = p.time,
                           .pair = p.pair,
                           .triangleA = pair.treeA->triangle(slotA),
                           .triangleB = pair.treeB->triangle(slotB),
                           .distance = found,
                           .atStart = atStart};
            return 2.0;
        }
        const double gap = found.distance - limits.margin() - at.rounding;
        const Vector3d across = found.pointB - found.pointA;
        const Matrix3d toWorld = scene.worldOfB(p.pair, p.time).linear();
        return closingTime(p, gap, toWorld * across.stableNormalized());
    }

    SearchState& m_state;
    FirstOrderBound m_bound;
};

}  // namespace

double directionalSpeed(MovingFrames& frames,
                        std::int32_t frame,
                        const Vector3d& n,
                        double t,
                        double ahead,
                        double radius)
{
    constexpr double kUp = 1.0 + 1e-12;  // a few dozen roundings
    const auto at = [&](std::int32_t k) -> const MovingFrame&
    { return frames.frames()[static_cast<std::size_t>(k)]; };
    double above = 0.0;  // angular speed of the frames above the one in hand
    for (std::int32_t k = frame; k != 0; k = at(k).parent)
    {
        above += at(k).slides ? 0.0 : std::abs(at(k).rate);
    }
    double speed = 0.0;
    double reach = radius;
    for (std::int32_t k = frame; k != 0; k = at(k).parent)
    {
        const MovingFrame& here = at(k);
        const double rate = std::abs(here.rate);
        above -= here.slides ? 0.0 : rate;
        const Vector3d z = frames.stateAt(0, k, t).X_W.linear().col(2);
        const double drift = ahead * std::max(above, 0.0) * kUp + 1e-12;
        if (here.slides)
        {
            const double cosine =
                std::clamp((here.rate > 0.0 ? n : Vector3d(-n)).dot(z), -1.0, 1.0);
            speed += rate * std::cos(std::max(0.0, std::acos(cosine) - drift));
            reach += std::max(std::abs(here.position), std::abs(here.position + here.rate));
        }
        else
        {
            const double angle = std::asin(std::min(1.0, n.cross(z).norm()));
            speed += rate * reach * std::sin(std::min(0.5 * std::numbers::pi, angle + drift));
        }
        reach += here.X_PF.translation().norm();
    }
    return speed + 1e-12 * std::abs(speed);
}

ArticulatedToiResult firstOrderToi(const ArticulatedBody& body,
                                   std::span<const RigidBody> obstacles,
                                   FirstOrderBound bound,
                                   const ToiOptions& options)
{
    MovingFrames frames;
    frames.reset(*body.tree, *body.motion);
    const auto links = static_cast<std::int32_t>(body.tree->size());
    std::vector<MovingBody> bodies;  // the links, then the obstacles
    std::vector<BodyPair> pairs;
    for (std::int32_t link = 0; link < links; ++link)
    {
        const SsvTree* tree = body.linkTrees[static_cast<std::size_t>(link)];
        bodies.push_back(
            {.tree = tree,
             .motion = LinkMotion{
                 .tree = body.tree, .motion = body.motion, .link = link, .frames = &frames}});
        const bool moves = tree != nullptr && frames.place(link).frame != 0;
        for (std::int32_t k = 0; k < std::ssize(obstacles) && moves; ++k)
        {
            const auto mask = std::ranges::find_if(
                body.masks, [&](const LinkMask& m) { return m.link == link && m.obstacle == k; });
            pairs.push_back({.bodyA = link,
                             .bodyB = links + k,
                             .mask = mask != body.masks.end() ? mask->mask : nullptr});
        }
    }
    for (const RigidBody& obstacle : obstacles)
    {
        bodies.push_back(movingBody(obstacle));
    }

    SearchState state;
    state.reset(options);
    state.scene.reset(bodies, pairs, options);
    ArticulatedToiResult result;
    try
    {
        FirstOrderSearch(state, bound).run();
        if (state.hit.found())
        {
            const FirstContactResult hit = describeHit(state);
            const BodyPair& pair = pairs[static_cast<std::size_t>(hit.pair)];
            result.status = hit.status;
            result.time = hit.time;
            result.contacts.push_back({.link = pair.bodyA,
                                       .obstacle = pair.bodyB - links,
                                       .gap = hit.gap,
                                       .pointLink = hit.pointA,
                                       .pointOther = hit.pointB,
                                       .normal = hit.normal,
                                       .triangleLink = hit.triangleA,
                                       .triangleOther = hit.triangleB,
                                       .time = hit.time});
        }
    }
    catch (const GaveUp& end)
    {
        result.status = end.status;
        result.time = end.time;
    }
    static_cast<ToiCounters&>(result.counters) = state.counters;
    result.counters.pairs = std::ssize(pairs);
    return result;
}
}  // namespace bullet_ccd::benchmarks
