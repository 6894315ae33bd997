#include "bullet_ccd/toi/articulated_toi.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/toi/articulated/toi_scratch.h"

#include <algorithm>
#include <tuple>

namespace bullet_ccd
{
namespace
{
using Eigen::Isometry3d;

/// Intervals are not halved more often than this.
constexpr int kDeepest = 6;

/// Surfaces that are apart by no more than the minimum separation are searched for up to this part
/// of the tolerance beyond it.
constexpr double kCertain = 1e-3;

/// One query. The bodies of the search are the links, by their slots, and the obstacles, which are
/// added when they are needed.
class ArticulatedQuery
{
public:
    ArticulatedQuery(const ArticulatedBody& body,
                     const Environment& environment,
                     const ArticulatedToiOptions& options,
                     ToiWorkspace::Scratch& scratch)
        : m_body(body),
          m_environment(environment),
          m_options(options),
          m_state(scratch.state),
          m_scratch(scratch.articulated),
          m_culling(scratch.articulated.culling)
    {
    }

    ArticulatedToiResult run()
    {
        start();
        const std::size_t count = m_scratch.candidates.size();
        try
        {
            if (!findsAnyContact())
            {
                process(0.0, 1.0, 0, count, 0);
            }
        }
        catch (const GaveUp& end)
        {
            m_result.status = end.status;
            m_result.time = end.time;
            m_result.contacts.clear();
        }
        countPairs(count);
        return std::move(m_result);
    }

private:
    void start()
    {
        const ToiOptions& toi = m_options.toi;
        m_culling.reset(m_body, m_environment, toi.minimumSeparation + toi.tolerance);
        m_state.reset(toi);
        m_state.anyContact = m_options.anyContact;
        m_scratch.candidates.clear();
        m_scratch.relaxed.clear();
        m_scratch.bodies.clear();
        m_scratch.bodyOfObstacle.assign(m_environment.bodies().size(), kNone);
        if (m_options.cullBySpace)
        {
            // What does not halve intervals takes slices of them instead.
            m_culling.pairsOfStep(toi.strategy == ToiStrategy::Interval, m_scratch.candidates);
        }
        else
        {
            m_culling.allPairs(m_scratch.candidates);
        }
        m_scratch.fates.assign(m_scratch.candidates.size(), {});
        for (std::size_t i = 0; i < m_scratch.candidates.size(); ++i)
        {
            m_scratch.candidates[i].root = static_cast<std::int32_t>(i);
        }
        for (const SweptLink& link : m_culling.links())
        {
            m_scratch.bodies.push_back(
                {.tree = m_body.linkTrees[static_cast<std::size_t>(link.link)],
                 .motion = LinkMotion{.tree = m_body.tree,
                                      .motion = m_body.motion,
                                      .link = link.link,
                                      .frames = &m_culling.frames()}});
        }
    }

    /// Where any contact will do: looks at the pairs halfway between the times from and until which
    /// they may meet, where what comes near and leaves again is nearest.
    bool findsAnyContact()
    {
        const ToiOptions& toi = m_options.toi;
        if (!m_options.anyContact || toi.strategy != ToiStrategy::Interval)
        {
            return false;
        }
        for (const Candidate& candidate : m_scratch.candidates)
        {
            const BodyPair pair = bodiesOf(candidate);
            const double middle = 0.5 * (candidate.from + candidate.until);
            const TrianglePair found =
                closest(pair,
                        poseAt(pair.bodyB, middle).inverse() * poseAt(pair.bodyA, middle),
                        toi.minimumSeparation + kCertain * toi.tolerance,
                        toi.minimumSeparation + toi.tolerance,
                        toi.stop);
            if (found.triangleA != kNone && found.distance <= toi.minimumSeparation)
            {
                m_result.status = ToiStatus::Hit;
                m_result.time = middle;
                m_result.contacts.push_back(contactOf(pair, middle));
                return true;
            }
        }
        return false;
    }

    [[nodiscard]] bool maySubdivide(int depth) const
    {
        return m_options.subdivide && m_options.cullBySpace && m_options.cullByTime &&
               m_options.toi.strategy == ToiStrategy::BestFirst && depth < kDeepest;
    }

    /// Candidates [begin, end) are those whose boxes over [from, to] meet. The earlier half comes
    /// first, and the later one only if there was no contact: nothing that happens after the answer
    /// is looked at.
    void process(double from, double to, std::size_t begin, std::size_t end, int depth)
    {
        if (begin == end)
        {
            return;
        }
        if (!maySubdivide(depth) || !m_culling.isWide(m_scratch.candidates, begin, end))
        {
            search(from, to, begin, end);
            return;
        }
        ++m_result.counters.subdivisions;
        const double middle = 0.5 * (from + to);
        for (const auto& [first, last] : {std::pair{from, middle}, std::pair{middle, to}})
        {
            m_culling.pairsOfInterval(m_scratch.candidates, begin, end, first, last);
            process(first, last, end, m_scratch.candidates.size(), depth + 1);
            m_scratch.candidates.resize(end);
            if (m_state.hit.found())
            {
                return;
            }
        }
    }

    std::int32_t bodyOf(std::int32_t obstacle)
    {
        std::int32_t& index = m_scratch.bodyOfObstacle[static_cast<std::size_t>(obstacle)];
        if (index == kNone)
        {
            index = static_cast<std::int32_t>(m_scratch.bodies.size());
            m_scratch.bodies.push_back(
                movingBody(m_environment.bodies()[static_cast<std::size_t>(obstacle)]));
        }
        return index;
    }

    BodyPair bodiesOf(const Candidate& candidate)
    {
        const bool isSelf = candidate.slotB != kNone;
        return {.bodyA = candidate.slotA,
                .bodyB = isSelf ? candidate.slotB : bodyOf(candidate.obstacle),
                .mask = candidate.mask};
    }

    void search(double from, double to, std::size_t begin, std::size_t end)
    {
        m_scratch.pairs.clear();
        for (std::size_t i = begin; i < end; ++i)
        {
            m_scratch.pairs.push_back(bodiesOf(m_scratch.candidates[i]));
        }
        m_state.begin = from;
        m_state.end = to;
        if (m_options.cullByTime)
        {
            searchPairs(begin, m_scratch.pairs);
        }
        else
        {
            searchOneByOne(begin);
        }
        if (m_state.hit.found())
        {
            describe();
        }
    }

    void searchPairs(std::size_t begin, std::span<const BodyPair> pairs)
    {
        m_state.scene.reset(m_scratch.bodies, pairs, m_options.toi);
        const auto count = static_cast<std::int32_t>(pairs.size());
        for (const ArticulatedScratch::Relaxed& relaxed : m_scratch.relaxed)
        {
            for (std::int32_t i = 0; i < count; ++i)
            {
                const BodyPair& pair = pairs[static_cast<std::size_t>(i)];
                if (pair.bodyA == relaxed.bodyA && pair.bodyB == relaxed.bodyB)
                {
                    m_state.scene.pair(i).limits.threshold = relaxed.threshold;
                }
            }
        }
        for (std::int32_t i = 0; i < count; ++i)
        {
            const Candidate& candidate = m_scratch.candidates[begin + static_cast<std::size_t>(i)];
            m_state.scene.pair(i).from = candidate.from;
            m_state.scene.pair(i).until = candidate.until;
        }
        searchScene(m_state);
        const double usual = m_options.toi.minimumSeparation + m_options.toi.tolerance;
        for (std::int32_t i = 0; i < count; ++i)
        {
            const ScenePair& pair = m_state.scene.pair(i);
            const Candidate& candidate = m_scratch.candidates[begin + static_cast<std::size_t>(i)];
            ArticulatedScratch::Fate& fate =
                m_scratch.fates[static_cast<std::size_t>(candidate.root)];
            fate.isSearched = true;
            fate.sawTriangles = fate.sawTriangles || pair.sawTriangles;
            if (m_state.begin == 0.0 && pair.limits.threshold < usual)
            {
                m_scratch.relaxed.push_back({pairs[static_cast<std::size_t>(i)].bodyA,
                                             pairs[static_cast<std::size_t>(i)].bodyB,
                                             pair.limits.threshold});
            }
        }
    }

    /// Without temporal culling: no pair knows of the answers of others. If a search gives up, the
    /// pairs after it have not been asked, and may meet as soon as the interval begins.
    void searchOneByOne(std::size_t begin)
    {
        std::int32_t first = kNone;
        EarliestHit earliest;
        const std::span<const BodyPair> pairs = m_scratch.pairs;
        for (std::size_t i = 0; i < pairs.size(); ++i)
        {
            m_state.hit = {};
            try
            {
                searchPairs(begin + i, pairs.subspan(i, 1));
            }
            catch (GaveUp& end)
            {
                end.time = i + 1 < pairs.size() ? m_state.begin : end.time;
                if (end.time < earliest.time)
                {
                    throw;
                }
                m_state.hit = {};
                break;
            }
            if (m_state.hit.found() && m_state.hit.time < earliest.time)
            {
                earliest = m_state.hit;
                first = static_cast<std::int32_t>(i);
            }
        }
        m_state.hit = earliest;
        m_state.hit.pair = first;
        m_state.scene.reset(m_scratch.bodies, pairs, m_options.toi);
    }

    /// Names the two sides of a pair of the scene in hand.
    [[nodiscard]] LinkContact contactOf(const BodyPair& pair, double time) const
    {
        const std::vector<SweptLink>& links = m_culling.links();
        const auto slots = static_cast<std::int32_t>(links.size());
        const SweptLink& link = links[static_cast<std::size_t>(pair.bodyA)];
        LinkContact contact{.link = link.link, .time = time};
        std::int32_t mover = link.frame;
        if (pair.bodyB < slots)
        {
            const SweptLink& other = links[static_cast<std::size_t>(pair.bodyB)];
            contact.otherLink = other.link;
            const MovingFrames& frames = m_culling.frames();
            const std::int32_t common = frames.commonFrame(link.frame, other.frame);
            mover = link.frame != common ? link.frame : other.frame;
        }
        else
        {
            const auto& known = m_scratch.bodyOfObstacle;
            contact.obstacle = static_cast<std::int32_t>(
                std::find(known.begin(), known.end(), pair.bodyB) - known.begin());
        }
        contact.stopJoint = m_culling.frames().frames()[static_cast<std::size_t>(mover)].link;
        return contact;
    }

    [[nodiscard]] Isometry3d poseAt(std::int32_t body, double t) const
    {
        return geometryPoseAt(m_scratch.bodies[static_cast<std::size_t>(body)], t);
    }

    /// Closest pair of triangles that count, if it is within `threshold`.
    /// @param accuracy  that will do of the distance; 0: as near as rounding allows
    [[nodiscard]] TrianglePair closest(const BodyPair& pair,
                                       const Isometry3d& X_BA,
                                       double threshold,
                                       double accuracy,
                                       const StopCondition& stop = {}) const
    {
        const SsvTree& treeA = *m_scratch.bodies[static_cast<std::size_t>(pair.bodyA)].tree;
        const SsvTree& treeB = *m_scratch.bodies[static_cast<std::size_t>(pair.bodyB)].tree;
        const NodeMarks exempt = pair.mask != nullptr ? pair.mask->nodeMarks() : NodeMarks{};
        return accuracy > 0.0
                   ? distanceWithin(treeA, treeB, X_BA, accuracy, stop, exempt, threshold).nearest
                   : treeDistance(treeA, treeB, X_BA, threshold, exempt);
    }

    /// Distance of a pair at time t if it is at most `threshold`, as a contact in W.
    bool findContact(const BodyPair& pair,
                     double t,
                     double threshold,
                     LinkContact& contact,
                     double accuracy = 0.0)
    {
        const Isometry3d X_WB = poseAt(pair.bodyB, t);
        const TrianglePair found =
            closest(pair, X_WB.inverse() * poseAt(pair.bodyA, t), threshold, accuracy);
        if (found.triangleA == kNone || found.distance <= 0.0)
        {
            return false;
        }
        contact.gap = found.distance;
        contact.pointLink = X_WB * found.pointA;
        contact.pointOther = X_WB * found.pointB;
        contact.triangleLink = found.triangleA;
        contact.triangleOther = found.triangleB;
        // Not divided by the distance: the witnesses are rounded where the tree's origin is added.
        contact.normal = X_WB.linear() * (found.pointB - found.pointA).normalized();
        return true;
    }

    /// A pair that was within the tolerance at the start counts only if it closed in further: the
    /// same rule as in the search.
    bool closedIn(const BodyPair& pair, double reach, LinkContact& contact)
    {
        LinkContact begin;
        return !findContact(pair, 0.0, reach, begin) ||
               (findContact(pair, contact.time, reach, contact) && contact.gap <= 0.75 * begin.gap);
    }

    /// The hit of the state, and what else is in contact then.
    void describe()
    {
        const FirstContactResult first = describeHit(m_state);
        m_result.status = first.status;
        m_result.time = first.time;
        const std::vector<BodyPair>& pairs = m_scratch.pairs;
        LinkContact contact = contactOf(pairs[static_cast<std::size_t>(first.pair)], first.time);
        contact.gap = first.gap;
        contact.pointLink = first.pointA;
        contact.pointOther = first.pointB;
        contact.normal = first.normal;
        contact.triangleLink = first.triangleA;
        contact.triangleOther = first.triangleB;
        m_result.contacts.push_back(contact);
        if (first.status != ToiStatus::Hit || m_options.anyContact)
        {
            return;
        }
        const double reach = m_options.toi.tolerance + m_options.toi.minimumSeparation;
        const double accuracy = m_options.toi.anyWithin ? 0.25 * m_options.toi.tolerance : 0.0;
        for (std::size_t i = 0; i < pairs.size(); ++i)
        {
            LinkContact other = contactOf(pairs[i], first.time);
            if (static_cast<std::int32_t>(i) != first.pair &&
                findContact(pairs[i], first.time, reach, other, accuracy) &&
                closedIn(pairs[i], reach, other))
            {
                m_result.contacts.push_back(other);
            }
        }
        std::sort(m_result.contacts.begin() + 1,
                  m_result.contacts.end(),
                  [](const LinkContact& a, const LinkContact& b) {
                      return std::tie(a.link, a.obstacle, a.otherLink) <
                             std::tie(b.link, b.obstacle, b.otherLink);
                  });
    }

    void countPairs(std::size_t candidates)
    {
        ArticulatedCounters& counters = m_result.counters;
        static_cast<ToiCounters&>(counters) = m_state.counters;
        counters.pairs = m_culling.pairCount();
        const bool isDone = !m_state.hit.found() && m_result.status == ToiStatus::Separated;
        counters.culledBySpace = counters.pairs - static_cast<std::int64_t>(candidates);
        for (std::size_t i = 0; i < candidates; ++i)
        {
            const ArticulatedScratch::Fate& fate = m_scratch.fates[i];
            if (!fate.sawTriangles)
            {
                // What was never searched had its boxes apart all the way, or comes later.
                ++(isDone && !fate.isSearched ? counters.culledBySpace : counters.culledByTime);
            }
        }
    }

    const ArticulatedBody& m_body;
    const Environment& m_environment;
    const ArticulatedToiOptions& m_options;
    SearchState& m_state;
    ArticulatedScratch& m_scratch;
    LinkCulling& m_culling;
    ArticulatedToiResult m_result;
};
}  // namespace

ArticulatedToiResult articulatedToi(const ArticulatedBody& body,
                                    const Environment& environment,
                                    const ArticulatedToiOptions& options,
                                    ToiWorkspace& work)
{
    checkOptions(options.toi);
    checkBody(body);
    return ArticulatedQuery(body, environment, options, work.scratch()).run();
}

ArticulatedToiResult articulatedToi(const ArticulatedBody& body,
                                    std::span<const RigidBody> obstacles,
                                    const ToiOptions& options,
                                    ToiWorkspace& work)
{
    Environment& environment = work.scratch().articulated.environment;
    environment.reset(obstacles);
    return articulatedToi(body, environment, {.toi = options}, work);
}
}  // namespace bullet_ccd
