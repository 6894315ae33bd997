#include "bullet_ccd/toi/least_distance.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/motion/moving_frames.h"
#include "bullet_ccd/toi/articulated/articulated_culling.h"

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
constexpr int kSamples = 8;          // of all distances over the motion
constexpr int kGoldenSteps = 40;     // at most; each leaves 0.62 of the interval
constexpr int kQuickQueries = 16;    // that ask for all at once
constexpr int kChangesOfPair = 8;    // of triangles, in one local search
constexpr double kAccuracy = 0.125;  // of a search for where the distance is least

/// What a time-of-impact query says of the pairs.
struct Answer
{
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;
    std::int32_t pair = kNone;
    ToiCounters counters;
};

/// @tparam Ask  answers a query of ToiOptions about all pairs with an Answer
template <typename Ask>
class LeastDistanceSearch
{
public:
    LeastDistanceSearch(std::span<const MovingBody> bodies,
                        std::span<const BodyPair> pairs,
                        const LeastDistanceOptions& options,
                        const Ask& ask)
        : m_bodies(bodies), m_pairs(pairs), m_options(options), m_ask(ask)
    {
        m_best.found = options.enough;
    }

    LeastDistanceResult run()
    {
        // The middle first: what is found there spares most of the others a look.
        for (const int sample : {4, 0, 8, 2, 6, 1, 3, 5, 7})
        {
            lookAtAll(double(sample) / kSamples, sample == 4);
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
        if (m_best.pair != kNone)
        {
            // What was found within an accuracy, as it is.
            constexpr double kAbove = 1.0 + 1e-6;
            lookAt(m_best.pair, m_best.time, 0.0, kAbove * m_best.found);
        }
        return m_best;
    }

private:
    std::span<const MovingBody> m_bodies;
    std::span<const BodyPair> m_pairs;
    LeastDistanceOptions m_options;
    const Ask& m_ask;
    LeastDistanceResult m_best;
    Answer m_contact;                        // of the last query
    std::vector<Eigen::Vector3d> m_centers;  // of the bodies at the time of a sample
    bool m_isStopped = false;                // in a search for the distance at one time

    [[nodiscard]] std::array<const MovingBody*, 2> bodiesOf(std::int32_t pair) const
    {
        const BodyPair& named = m_pairs[static_cast<std::size_t>(pair)];
        return {&m_bodies[static_cast<std::size_t>(named.bodyA)],
                &m_bodies[static_cast<std::size_t>(named.bodyB)]};
    }

    /// Notes the smallest distance at a time. Where surfaces cross that do not count, around
    /// joints, a look costs more than what it may spare.
    void lookAtAll(double time, bool masked)
    {
        m_centers.clear();
        for (const MovingBody& body : m_bodies)
        {
            m_centers.push_back(geometryPoseAt(body, time) * body.tree->origin());
        }
        for (std::size_t i = 0; i < m_pairs.size(); ++i)
        {
            const auto a = static_cast<std::size_t>(m_pairs[i].bodyA);
            const auto b = static_cast<std::size_t>(m_pairs[i].bodyB);
            const double farther = (m_centers[a] - m_centers[b]).norm() -
                                   m_bodies[a].tree->radius() - m_bodies[b].tree->radius();
            if (farther < m_best.found && (masked || m_pairs[i].mask == nullptr))
            {
                lookAt(static_cast<std::int32_t>(i), time);
            }
        }
    }

    /// What an answer may be off by before it is worth a further look.
    [[nodiscard]] double accuracy() const { return kAccuracy * m_options.tolerance; }

    /// Notes the distance of a pair at a time, to a part of the tolerance, if it is the smallest so
    /// far by more than that.
    bool lookAt(std::int32_t pair, double time)
    {
        return lookAt(pair, time, accuracy(), m_best.found - accuracy());
    }

    bool lookAt(std::int32_t pair, double time, double accuracy, double below)
    {
        if (!(below > 0.0))
        {
            return false;
        }
        const auto [a, b] = bodiesOf(pair);
        const Eigen::Isometry3d X_WA = geometryPoseAt(*a, time);
        const Eigen::Isometry3d X_WB = geometryPoseAt(*b, time);
        const PairMask* mask = m_pairs[static_cast<std::size_t>(pair)].mask;
        const NodeMarks exempt = mask != nullptr ? mask->nodeMarks() : NodeMarks{};
        const Eigen::Isometry3d X_BA = X_WB.inverse() * X_WA;
        const DistanceBounds bounds =
            accuracy > 0.0
                ? distanceWithin(*a->tree, *b->tree, X_BA, accuracy, m_options.stop, exempt, below)
                : distanceBounds(*a->tree, *b->tree, X_BA, below, m_options.stop, exempt);
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

    /// The time within `reach` of the best one at which the best pair of triangles is nearest, as
    /// far as a search for one dip shows it.
    [[nodiscard]] double nearestTime(double reach) const
    {
        double low = std::max(m_best.time - reach, 0.0);
        double high = std::min(m_best.time + reach, 1.0);
        constexpr double kPart = 1.0 / std::numbers::phi;
        double left = high - kPart * (high - low);
        double right = low + kPart * (high - low);
        double atLow = distanceAt(low);
        double atHigh = distanceAt(high);
        double atLeft = distanceAt(left);
        double atRight = distanceAt(right);
        const auto isDone = [&]
        {
            const double least = std::min({atLow, atLeft, atRight, atHigh});
            return std::max(atLow, atHigh) - least < accuracy();
        };
        for (int step = 0; step < kGoldenSteps && !isDone(); ++step)
        {
            if (atLeft <= atRight)
            {
                high = right;
                atHigh = atRight;
                right = left;
                atRight = atLeft;
                left = high - kPart * (high - low);
                atLeft = distanceAt(left);
            }
            else
            {
                low = left;
                atLow = atLeft;
                left = right;
                atLeft = atRight;
                right = low + kPart * (high - low);
                atRight = distanceAt(right);
            }
        }
        const std::array<std::pair<double, double>, 4> candidates{
            std::pair{atLeft, left}, {atRight, right}, {atLow, low}, {atHigh, high}};
        return std::ranges::min_element(candidates)->second;
    }

    /// Follows the best pair of triangles, and those that turn out to be nearer, to a dip.
    void descend()
    {
        double reach = 1.0 / kSamples;
        for (int change = 0; change < kChangesOfPair && m_best.pair != kNone; ++change)
        {
            const double before = m_best.time;
            if (!lookAt(m_best.pair, nearestTime(reach)))
            {
                return;
            }
            reach = std::min(reach, 2.0 * std::abs(m_best.time - before));
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
        m_contact = m_ask(ToiOptions{.tolerance = 0.25 * m_options.tolerance,
                                     .minimumSeparation = separation,
                                     .maxIterations = m_options.maxIterations,
                                     .stop = m_options.stop});
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
        // It is below what was found by three quarters of the tolerance, and may be above `enough`.
        const double below =
            m_best.pair == kNone ? std::numeric_limits<double>::infinity() : m_best.found;
        if (!lookAt(m_contact.pair, m_contact.time, accuracy(), below))
        {
            m_best.found = before;
            return false;
        }
        descend();
        return std::isinf(before) || m_best.found < before + m_options.tolerance;
    }
};

void checkOptions(const LeastDistanceOptions& options, bool hasPairs)
{
    require(options.tolerance > 0.0 && std::isfinite(options.tolerance),
            [&]
            {
                return "leastDistance: the tolerance is " + std::to_string(options.tolerance) +
                       " m: it must be above 0";
            });
    require(options.enough > 0.0,
            [&]
            {
                return "leastDistance: `enough` is " + std::to_string(options.enough) +
                       " m: it must be above 0";
            });
    require(hasPairs || std::isfinite(options.enough),
            "leastDistance: without pairs there is no distance: give `enough`, which is the answer "
            "then");
}

/// The pairs of an articulated body that articulatedToi() tests, by the names that it gives them.
class ArticulatedPairs
{
public:
    ArticulatedPairs(const ArticulatedBody& body, std::span<const RigidBody> obstacles)
        : m_body(body), m_bodyOfLink(body.tree->size(), kNone)
    {
        m_frames.reset(*body.tree, *body.motion);
        for (std::size_t i = 0; i < body.tree->size(); ++i)
        {
            if (body.linkTrees[i] != nullptr)
            {
                m_bodyOfLink[i] = static_cast<std::int32_t>(m_bodies.size());
                m_bodies.push_back({.tree = body.linkTrees[i],
                                    .motion = LinkMotion{.tree = body.tree,
                                                         .motion = body.motion,
                                                         .link = static_cast<std::int32_t>(i),
                                                         .frames = &m_frames}});
            }
        }
        addObstacles(obstacles);
        for (const auto& [a, b] : body.selfPairs)
        {
            if (m_frames.place(a).frame != m_frames.place(b).frame)
            {
                addPair({.link = a, .otherLink = b}, m_bodyOfLink[static_cast<std::size_t>(b)]);
            }
        }
    }

    [[nodiscard]] std::span<const MovingBody> bodies() const { return m_bodies; }
    [[nodiscard]] std::span<const BodyPair> pairs() const { return m_pairs; }
    [[nodiscard]] const LinkMask& name(std::int32_t pair) const
    {
        return m_names[static_cast<std::size_t>(pair)];
    }
    [[nodiscard]] std::int32_t pairOf(const LinkContact& contact) const
    {
        const LinkMask pair{
            .link = contact.link, .otherLink = contact.otherLink, .obstacle = contact.obstacle};
        const auto name =
            std::ranges::find_if(m_names, [&](const LinkMask& each) { return each.isLike(pair); });
        return static_cast<std::int32_t>(name - m_names.begin());
    }

private:
    void addObstacles(std::span<const RigidBody> obstacles)
    {
        const auto first = static_cast<std::int32_t>(m_bodies.size());
        for (std::size_t k = 0; k < obstacles.size(); ++k)
        {
            m_bodies.push_back(movingBody(obstacles[k]));
            const RigidMotion& motion = obstacles[k].motion;
            const bool isMoving = obstacles[k].userMotion != nullptr || !motion.v_W.isZero(0.0) ||
                                  !motion.w_W.isZero(0.0);
            const auto obstacle = static_cast<std::int32_t>(k);
            for (std::int32_t link = 0; link < static_cast<std::int32_t>(m_bodyOfLink.size());
                 ++link)
            {
                if (m_bodyOfLink[static_cast<std::size_t>(link)] != kNone &&
                    (isMoving || m_frames.place(link).frame != 0))
                {
                    addPair({.link = link, .obstacle = obstacle}, first + obstacle);
                }
            }
        }
    }

    void addPair(LinkMask name, std::int32_t other)
    {
        name.mask = m_body.maskOf(name);
        m_pairs.push_back({.bodyA = m_bodyOfLink[static_cast<std::size_t>(name.link)],
                           .bodyB = other,
                           .mask = name.mask});
        m_names.push_back(name);
    }

    const ArticulatedBody& m_body;
    MovingFrames m_frames;
    std::vector<std::int32_t> m_bodyOfLink;
    std::vector<MovingBody> m_bodies;
    std::vector<BodyPair> m_pairs;
    std::vector<LinkMask> m_names;  // of the pairs
};
}  // namespace

LeastDistanceResult leastDistance(std::span<const MovingBody> bodies,
                                  std::span<const BodyPair> pairs,
                                  const LeastDistanceOptions& options,
                                  ToiWorkspace& work)
{
    checkOptions(options, !pairs.empty());
    // A query about nothing checks the input by the rules of all queries.
    (void)firstContact(bodies, pairs, {.tolerance = options.tolerance, .maxIterations = 1}, work);
    const auto ask = [&](ToiOptions toi)
    {
        toi.strategy = ToiStrategy::Interval;
        const FirstContactResult result = firstContact(bodies, pairs, toi, work);
        return Answer{result.status, result.time, result.pair, result.counters};
    };
    return LeastDistanceSearch(bodies, pairs, options, ask).run();
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
                                       const Environment& environment,
                                       const LeastDistanceOptions& options,
                                       ToiWorkspace& work)
{
    checkBody(body);
    const ArticulatedPairs named(body, environment.bodies());
    checkOptions(options, !named.pairs().empty());
    const auto ask = [&](ToiOptions toi)
    {
        toi.strategy = ToiStrategy::Interval;
        const ArticulatedToiResult result = articulatedToi(body, environment, {.toi = toi}, work);
        return Answer{result.status,
                      result.time,
                      result.contacts.empty() ? kNone : named.pairOf(result.contacts.front()),
                      result.counters};
    };
    ArticulatedLeastDistance result{
        LeastDistanceSearch(named.bodies(), named.pairs(), options, ask).run()};
    if (result.pair != kNone)
    {
        const LinkMask& name = named.name(result.pair);
        result.link = name.link;
        result.obstacle = name.obstacle;
        result.otherLink = name.otherLink;
        result.pair = kNone;
    }
    return result;
}

ArticulatedLeastDistance leastDistance(const ArticulatedBody& body,
                                       std::span<const RigidBody> obstacles,
                                       const LeastDistanceOptions& options,
                                       ToiWorkspace& work)
{
    return leastDistance(body, Environment(obstacles), options, work);
}
}  // namespace bullet_ccd
