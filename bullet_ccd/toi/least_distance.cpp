#include "bullet_ccd/toi/least_distance.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd
{
namespace
{
constexpr int kSamples = 32;       // of a pair's distance over the motion
constexpr int kGoldenSteps = 40;   // each leaves 0.62 of the interval: 2 / 32 become 3e-10
constexpr int kQuickQueries = 16;  // that ask for all at once
constexpr int kChangesOfPair = 8;  // of triangles, in one local search

class LeastDistanceSearch
{
public:
    LeastDistanceSearch(std::span<const MovingBody> bodies,
                        std::span<const BodyPair> pairs,
                        const LeastDistanceOptions& options,
                        ToiWorkspace& work)
        : m_bodies(bodies), m_pairs(pairs), m_options(options), m_work(work)
    {
        m_best.found = options.enough;
    }

    LeastDistanceResult run()
    {
        for (std::size_t i = 0; i < m_pairs.size(); ++i)
        {
            lookAt(static_cast<std::int32_t>(i), 0.0);
        }
        if (m_isStopped && m_best.pair == kNone)
        {
            m_best.status = ToiStatus::Stopped;
            return m_best;
        }
        descend();
        while (!certified())
        {
            const bool isHalfway = m_contact.status == ToiStatus::Separated;
            if (m_best.queries >= m_options.maxQueries || (!isHalfway && !improve()))
            {
                m_best.status = m_isStopped || m_contact.status == ToiStatus::Stopped
                                    ? ToiStatus::Stopped
                                    : ToiStatus::IterationLimit;
                break;
            }
        }
        return m_best;
    }

private:
    std::span<const MovingBody> m_bodies;
    std::span<const BodyPair> m_pairs;
    LeastDistanceOptions m_options;
    ToiWorkspace& m_work;
    LeastDistanceResult m_best;
    FirstContactResult m_contact;  // of the last query
    bool m_isStopped = false;      // in a search for the distance at one time

    [[nodiscard]] std::array<const MovingBody*, 2> bodiesOf(std::int32_t pair) const
    {
        const BodyPair& named = m_pairs[static_cast<std::size_t>(pair)];
        return {&m_bodies[static_cast<std::size_t>(named.bodyA)],
                &m_bodies[static_cast<std::size_t>(named.bodyB)]};
    }

    /// Notes the distance of a pair at a time if it is the smallest so far.
    bool lookAt(std::int32_t pair, double time)
    {
        const auto [a, b] = bodiesOf(pair);
        const Eigen::Isometry3d X_WA = geometryPoseAt(*a, time);
        const Eigen::Isometry3d X_WB = geometryPoseAt(*b, time);
        const PairMask* mask = m_pairs[static_cast<std::size_t>(pair)].mask;
        const DistanceBounds bounds =
            distanceBounds(*a->tree,
                           *b->tree,
                           X_WB.inverse() * X_WA,
                           m_best.found,
                           m_options.stop,
                           mask != nullptr ? mask->nodeMarks() : NodeMarks{});
        m_isStopped = m_isStopped || !bounds.isComplete;
        const TrianglePair& near = bounds.nearest;
        if (near.triangleA == kNone)
        {
            return false;
        }
        m_best.found = near.distance;
        m_best.time = time;
        m_best.pair = pair;
        m_best.triangleA = near.triangleA;
        m_best.triangleB = near.triangleB;
        m_best.pointA = X_WB * near.pointA;
        m_best.pointB = X_WB * near.pointB;
        const Eigen::Vector3d apart = m_best.pointB - m_best.pointA;
        m_best.normal = near.distance > 0.0 ? Eigen::Vector3d(apart.normalized())
                                            : Eigen::Vector3d(Eigen::Vector3d::Zero());
        return true;
    }

    /// Distance of the two triangles of the best pair at a time.
    [[nodiscard]] double distanceAt(double time) const
    {
        const auto [a, b] = bodiesOf(m_best.pair);
        const auto cornersAt = [&](const MovingBody& body, std::int32_t triangle)
        {
            const Eigen::Isometry3d X_WG = geometryPoseAt(body, time);
            TriangleCorners corners = body.tree->cornersOfTriangle(triangle);
            for (Eigen::Vector3d& corner : corners)
            {
                corner = X_WG * (corner + body.tree->origin());
            }
            return corners;
        };
        return triangleDistance(cornersAt(*a, m_best.triangleA), cornersAt(*b, m_best.triangleB))
            .distance;
    }

    /// The time at which the best pair of triangles is nearest, as far as samples show it.
    [[nodiscard]] double nearestTime() const
    {
        int best = 0;
        double least = distanceAt(0.0);
        for (int i = 1; i <= kSamples; ++i)
        {
            const double distance = distanceAt(double(i) / kSamples);
            if (distance < least)
            {
                best = i;
                least = distance;
            }
        }
        double low = double(std::max(best - 1, 0)) / kSamples;
        double high = double(std::min(best + 1, kSamples)) / kSamples;
        constexpr double kPart = 1.0 / std::numbers::phi;
        double left = high - kPart * (high - low);
        double right = low + kPart * (high - low);
        double atLeft = distanceAt(left);
        double atRight = distanceAt(right);
        for (int step = 0; step < kGoldenSteps; ++step)
        {
            if (atLeft <= atRight)
            {
                high = right;
                right = left;
                atRight = atLeft;
                left = high - kPart * (high - low);
                atLeft = distanceAt(left);
            }
            else
            {
                low = left;
                left = right;
                atLeft = atRight;
                right = low + kPart * (high - low);
                atRight = distanceAt(right);
            }
        }
        // The ends of the motion and the time that is known are candidates, too.
        const double middle = atLeft <= atRight ? left : right;
        const std::array<double, 4> candidates{m_best.time, middle, low, high};
        return *std::ranges::min_element(
            candidates, {}, [this](double t) { return distanceAt(t); });
    }

    /// Follows the best pair of triangles, and those that turn out to be nearer, to a dip.
    void descend()
    {
        for (int change = 0; change < kChangesOfPair && m_best.pair != kNone; ++change)
        {
            if (!lookAt(m_best.pair, nearestTime()))
            {
                return;
            }
        }
    }

    /// Asks whether the answer is complete.
    bool certified()
    {
        const bool isOpen = m_best.pair == kNone;  // nothing is nearer than `enough` so far
        const double goal = isOpen ? m_options.enough
                                   : std::min(m_options.enough, m_best.found - m_options.tolerance);
        // Where every answer is followed by one that is nearer by little, halves find the least.
        const double half = 0.5 * (m_best.distance + goal);
        const bool isSlow = !isOpen && m_best.queries >= kQuickQueries;
        const double separation = isSlow && half < goal - m_options.tolerance ? half : goal;
        if (!(separation > 0.0))
        {
            m_best.distance = 0.0;
            m_best.status = m_best.found > 0.0 ? ToiStatus::Separated : ToiStatus::Overlapping;
            return true;
        }
        if (m_pairs.empty())
        {
            m_best.distance = separation;
            return true;
        }
        m_contact = firstContact(m_bodies,
                                 m_pairs,
                                 {.tolerance = 0.25 * m_options.tolerance,
                                  .minimumSeparation = separation,
                                  .maxIterations = m_options.maxIterations,
                                  .stop = m_options.stop},
                                 m_work);
        ++m_best.queries;
        m_best.counters.nodePairs += m_contact.counters.nodePairs;
        m_best.counters.trianglePairs += m_contact.counters.trianglePairs;
        m_best.counters.states += m_contact.counters.states;
        if (m_contact.status != ToiStatus::Separated)
        {
            return false;
        }
        m_best.distance = separation;
        return separation == goal;
    }

    /// Goes on from the contact of the last query; false if that is of no use.
    bool improve()
    {
        if (m_contact.pair == kNone || gaveUp(m_contact.status))
        {
            return false;
        }
        const double before = m_best.found;
        if (m_best.pair == kNone)
        {
            // The contact is within a quarter of the tolerance above `enough`.
            m_best.found = std::numeric_limits<double>::infinity();
        }
        if (!lookAt(m_contact.pair, m_contact.time))
        {
            m_best.found = before;
            return false;
        }
        descend();
        return std::isinf(before) || m_best.found < before + m_options.tolerance;
    }
};
}  // namespace

LeastDistanceResult leastDistance(std::span<const MovingBody> bodies,
                                  std::span<const BodyPair> pairs,
                                  const LeastDistanceOptions& options,
                                  ToiWorkspace& work)
{
    require(options.tolerance > 0.0 && std::isfinite(options.tolerance),
            "leastDistance: the tolerance is " + std::to_string(options.tolerance) +
                " m: it must be above 0");
    require(
        options.enough > 0.0,
        "leastDistance: `enough` is " + std::to_string(options.enough) + " m: it must be above 0");
    require(!pairs.empty() || std::isfinite(options.enough),
            "leastDistance: without pairs there is no distance: give `enough`, which is the answer "
            "then");
    // A query about nothing checks the input by the rules of all queries.
    (void)firstContact(bodies, pairs, {.tolerance = options.tolerance, .maxIterations = 1}, work);
    return LeastDistanceSearch(bodies, pairs, options, work).run();
}

LeastDistanceResult leastDistance(const RigidBody& bodyA,
                                  const RigidBody& bodyB,
                                  const LeastDistanceOptions& options,
                                  ToiWorkspace& work)
{
    const std::array<MovingBody, 2> bodies{movingBody(bodyA), movingBody(bodyB)};
    constexpr std::array<BodyPair, 1> kPair{BodyPair{.bodyA = 0, .bodyB = 1}};
    return leastDistance(bodies, kPair, options, work);
}

ArticulatedLeastDistance leastDistance(const ArticulatedBody& body,
                                       std::span<const RigidBody> obstacles,
                                       const LeastDistanceOptions& options,
                                       ToiWorkspace& work)
{
    require(body.tree != nullptr && body.motion != nullptr &&
                body.linkTrees.size() == body.tree->size(),
            "leastDistance: an articulated body needs a tree, a motion, and one hierarchy (or "
            "null) per link");
    std::vector<MovingBody> bodies;
    std::vector<std::int32_t> bodyOfLink(body.tree->size(), kNone);
    for (std::size_t i = 0; i < body.tree->size(); ++i)
    {
        if (body.linkTrees[i] != nullptr)
        {
            bodyOfLink[i] = static_cast<std::int32_t>(bodies.size());
            bodies.push_back({.tree = body.linkTrees[i],
                              .motion = LinkMotion{.tree = body.tree,
                                                   .motion = body.motion,
                                                   .link = static_cast<std::int32_t>(i)}});
        }
    }
    const auto firstObstacle = static_cast<std::int32_t>(bodies.size());
    for (const RigidBody& obstacle : obstacles)
    {
        bodies.push_back(movingBody(obstacle));
    }

    std::vector<BodyPair> pairs;
    std::vector<ArticulatedLeastDistance> names;  // of each pair
    const auto addPair = [&](ArticulatedLeastDistance name, std::int32_t other)
    {
        const auto mask = std::ranges::find_if(body.masks,
                                               [&](const LinkMask& each)
                                               {
                                                   return each.link == name.link &&
                                                          each.otherLink == name.otherLink &&
                                                          each.obstacle == name.obstacle;
                                               });
        pairs.push_back({.bodyA = bodyOfLink[static_cast<std::size_t>(name.link)],
                         .bodyB = other,
                         .mask = mask == body.masks.end() ? nullptr : mask->mask});
        names.push_back(std::move(name));
    };
    for (std::size_t i = 0; i < bodyOfLink.size(); ++i)
    {
        const auto link = static_cast<std::int32_t>(i);
        const bool isMoving = moves(*body.tree, *body.motion, kNone, link);
        for (std::size_t k = 0; bodyOfLink[i] != kNone && k < obstacles.size(); ++k)
        {
            const RigidMotion& motion = obstacles[k].motion;
            if (isMoving || obstacles[k].userMotion != nullptr || !motion.v_W.isZero(0.0) ||
                !motion.w_W.isZero(0.0))
            {
                const auto obstacle = static_cast<std::int32_t>(k);
                addPair({{}, link, obstacle, kNone}, firstObstacle + obstacle);
            }
        }
    }
    for (const auto& [a, b] : body.selfPairs)
    {
        const std::int32_t base = commonAncestor(*body.tree, a, b);
        if (moves(*body.tree, *body.motion, base, a) || moves(*body.tree, *body.motion, base, b))
        {
            addPair({{}, a, kNone, b}, bodyOfLink[static_cast<std::size_t>(b)]);
        }
    }
    ArticulatedLeastDistance result{leastDistance(bodies, pairs, options, work)};
    if (result.pair != kNone)
    {
        const ArticulatedLeastDistance& name = names[static_cast<std::size_t>(result.pair)];
        result.link = name.link;
        result.obstacle = name.obstacle;
        result.otherLink = name.otherLink;
        result.pair = kNone;
    }
    return result;
}
}  // namespace bullet_ccd
