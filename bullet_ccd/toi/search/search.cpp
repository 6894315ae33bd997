#include "bullet_ccd/toi/search/search.h"

#include "bullet_ccd/distance/tree_distance.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
/// The closest triangles of the two meshes, which have triangles as close as `found`.
EarliestHit closestTriangles(const ScenePair& pair,
                             const PairState& state,
                             EarliestHit found,
                             const NodeMarks& exempt = {})
{
    using Eigen::Map;
    using Eigen::Vector3d;
    const RelativeMotion& m = state.motion;
    Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
    X_BA.linear() = Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.R);
    X_BA.translation() = X_BA.linear() * (Map<const Vector3d>(m.armA) - pair.treeA->origin()) +
                         Map<const Vector3d>(m.p) + pair.treeB->origin();
    // A little above, so that the first of many that are equally far bounds the others.
    constexpr double kAbove = 1.0 + 1e-6;
    const TrianglePair closest =
        treeDistance(*pair.treeA, *pair.treeB, X_BA, kAbove * found.distance.distance, exempt);
    if (closest.triangleA != kNone && closest.distance < found.distance.distance)
    {
        found.triangleA = closest.triangleA;
        found.triangleB = closest.triangleB;
        found.distance = {.distance = closest.distance,
                          .pointA = closest.pointA - pair.treeB->origin(),
                          .pointB = closest.pointB - pair.treeB->origin()};
    }
    return found;
}

/// The bodies are within the tolerance where the query begins: from now on they must close in
/// further to count as in contact, so that they can separate or slide. Returns false if they are
/// as near as they may be, so that there is nothing to be done.
bool relaxThreshold(ScenePair& pair, const PairState& state, double start)
{
    PairLimits& limits = pair.limits;
    if (start <= limits.floor + 4.0 * state.rounding)
    {
        return false;
    }
    limits.threshold = std::min(limits.threshold, limits.floor + 0.75 * (start - limits.floor));
    return true;
}

/// Speeds below this part of that of the bodies are rounding: the bodies slide or rest.
constexpr double kRestingSpeed = 1e-12;

/// Speed at which two points that face each other close in.
double closingSpeed(const RelativeMotion& m, const TriangleDistance& d)
{
    using Eigen::Map;
    using Eigen::Vector3d;
    const Vector3d arm = d.pointA - Map<const Vector3d>(m.p);
    const Vector3d velocity =
        Map<const Vector3d>(m.velocity) + Map<const Vector3d>(m.wA).cross(arm) -
        Map<const Vector3d>(m.wB).cross(d.pointB + Map<const Vector3d>(m.armB));
    return velocity.dot((d.pointB - d.pointA).stableNormalized());
}

/// Counts a look at the triangles of two leaves.
void countTriangles(SearchState& state, const NodePair& leaves)
{
    ++state.counters.trianglePairs;
    state.scene.noteTriangles(leaves.pair);
    const ScenePair& pair = state.scene.pair(leaves.pair);
    if (state.use != nullptr)
    {
        state.use->note(*pair.treeA, pair.treeA->triangle(state.scene.nodeA(leaves).first));
        state.use->note(*pair.treeB, pair.treeB->triangle(state.scene.nodeB(leaves).first));
    }
}

/// Two triangles in contact at the time of their leaves.
EarliestHit hitOf(const SearchState& state, const NodePair& leaves, const TriangleDistance& apart)
{
    const ScenePair& pair = state.scene.pair(leaves.pair);
    const std::int32_t slotA = state.scene.nodeA(leaves).first;
    const std::int32_t slotB = state.scene.nodeB(leaves).first;
    // How long before they were near enough, too: a bound of the speed is known of rigid pairs.
    // What lies at the limit of what was asked for would be beyond it by rounding.
    const double nearer = (pair.limits.anyWithin ? 0.9 : 1.0) * pair.limits.near() - apart.distance;
    const double early =
        pair.isRigid && nearer > 0.0 && pair.speedScale > 0.0 ? nearer / pair.speedScale : 0.0;
    return {.time = leaves.time,
            .pair = leaves.pair,
            .triangleA = pair.treeA->triangle(slotA),
            .triangleB = pair.treeB->triangle(slotB),
            .slotA = slotA,
            .slotB = slotB,
            .distance = apart,
            .enough = std::max(leaves.time - early, 0.5 * leaves.time),
            .atStart = leaves.time == 0.0};
}

/// Volumes that are farther apart than the steps leave say nothing of whether the bodies touch
/// where the query begins. Before such a pair is taken for a contact, this finds out, and then it
/// has to close in further. Returns true if that is so.
bool relaxUnknownStart(SearchState& state, std::int32_t index)
{
    ScenePair& pair = state.scene.pair(index);
    const bool mayTouch = state.scene.mayStartTouching() || state.begin > 0.0 || !state.inOrder;
    if (pair.startIsKnown || pair.touchesAtStart || !mayTouch)
    {
        return false;
    }
    pair.startIsKnown = true;
    const PairState& pose = state.scene.stateAt(index, 0.0, state.counters);
    EarliestHit start;
    start.distance.distance = pair.limits.threshold;
    start = closestTriangles(
        pair, pose, start, pair.mask != nullptr ? pair.mask->nodeMarks() : NodeMarks{});
    if (start.triangleA == kNone || !relaxThreshold(pair, pose, start.distance.distance))
    {
        return false;
    }
    pair.touchesAtStart = true;
    state.start.touches = true;
    state.start.approaches = state.start.approaches || closingSpeed(pose.motion, start.distance) >
                                                           kRestingSpeed * pair.speedScale;
    return true;
}
}  // namespace

bool noteIfNear(SearchState& state, const NodePair& leaves)
{
    ScenePair& pair = state.scene.pair(leaves.pair);
    if (state.scene.isExempt(leaves))
    {
        return false;
    }
    countTriangles(state, leaves);
    constexpr bool kApart = true;  // the time is certified
    const PairState& pose = state.scene.stateAt(leaves.pair, leaves.time, state.counters);
    const TriangleDistance apart = triangleStep(*pair.treeA,
                                                *pair.treeB,
                                                pose,
                                                pair.limits.margin(),
                                                kApart,
                                                state.scene.nodeA(leaves).first,
                                                state.scene.nodeB(leaves).first)
                                       .distance;
    if (apart.distance > pair.limits.near())
    {
        return false;
    }
    if (relaxUnknownStart(state, leaves.pair) && apart.distance > pair.limits.near())
    {
        return false;
    }
    if (leaves.time < state.hit.time)
    {
        state.hit = hitOf(state, leaves, apart);
    }
    return true;
}

/// Certified step of two triangles that slide along each other, along directions that rest or turn
/// with either body.
double slidingTime(SearchState& state, const NodePair& p, const TriangleDistance& apart)
{
    const ScenePair& pair = state.scene.pair(p.pair);
    const std::int32_t slotA = state.scene.nodeA(p).first;
    const std::int32_t slotB = state.scene.nodeB(p).first;
    const Eigen::Vector3d across = apart.pointB - apart.pointA;
    const double margin = pair.limits.margin();
    double longest = slidingStep(*pair.treeA,
                                 *pair.treeB,
                                 state.scene.stateAt(p.pair, p.time, state.counters),
                                 margin,
                                 slotA,
                                 slotB,
                                 across);
    if (const PairState* seen =
            state.scene.turnedStateAt(p.pair, p.time, TurningWith::B, state.counters))
    {
        longest = std::max(
            longest, slidingStep(*pair.treeA, *pair.treeB, *seen, margin, slotA, slotB, across));
    }
    if (const PairState* seen =
            state.scene.turnedStateAt(p.pair, p.time, TurningWith::A, state.counters))
    {
        using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
        const Eigen::Vector3d back = Eigen::Map<const RowMajor>(seen->motion.R) * -across;
        longest = std::max(
            longest, slidingStep(*pair.treeB, *pair.treeA, *seen, margin, slotB, slotA, back));
    }
    return longest;
}

bool advanceTriangles(SearchState& state, NodePair& p)
{
    if (state.scene.isExempt(p) || state.scene.neverMeets(p))
    {
        return false;
    }
    countTriangles(state, p);
    checkLimit(state, state.certified, p.pair);
    ScenePair& pair = state.scene.pair(p.pair);
    const PairState& pose = state.scene.stateAt(p.pair, p.time, state.counters);
    const std::int32_t slotA = state.scene.nodeA(p).first;
    const std::int32_t slotB = state.scene.nodeB(p).first;
    const auto look = [&]
    {
        return triangleStep(*pair.treeA,
                            *pair.treeB,
                            state.scene.stateAt(p.pair, p.time, state.counters),
                            pair.limits.margin(),
                            p.time > 0.0,
                            slotA,
                            slotB);
    };
    TriangleStep step = look();
    const double distance = step.distance.distance;
    const auto found = [&] { return hitOf(state, p, step.distance); };
    if (p.time == 0.0 && distance <= pair.limits.threshold)
    {
        // Nothing is closer than triangles that cross. Of masked meshes others may be closer that
        // do not count; each is then met on its own.
        const bool mayBeCloser = distance > 0.0 && pair.mask == nullptr;
        const EarliestHit closest = mayBeCloser ? closestTriangles(pair, pose, found()) : found();
        if (!relaxThreshold(pair, pose, closest.distance.distance))
        {
            state.hit = closest;
            return false;
        }
        state.start.touches = true;
        pair.touchesAtStart = true;
        const bool closesIn =
            closingSpeed(pose.motion, step.distance) > kRestingSpeed * pair.speedScale;
        state.start.approaches = state.start.approaches || closesIn;
        step = look();
    }
    if (p.time > 0.0 && distance <= pair.limits.near() && relaxUnknownStart(state, p.pair))
    {
        step = look();
    }
    // Few queries look at so many triangles.
    constexpr std::int64_t kManyTriangles = 256;
    if (state.counters.trianglePairs > kManyTriangles && state.slides.now())
    {
        const double sliding = slidingTime(state, p, step.distance);
        state.slides.note(sliding > 2.0 * step.time);
        step.time = std::max(step.time, sliding);
    }
    const double next = std::nextafter(p.time + step.time * (1.0 - 1e-15), 0.0);  // rounded down
    const bool stalls = next <= p.time;
    if (distance <= pair.limits.near() || (stalls && distance <= pair.limits.threshold))
    {
        if (p.time < state.hit.time)
        {
            state.hit = found();
        }
        return false;
    }
    if (stalls)
    {
        // Apart, but neither time nor the coordinates resolve how much: nothing can be said.
        throw GaveUp{.time = state.certified, .pair = p.pair};
    }
    if (p.time + step.time > state.end)
    {
        return false;
    }
    p.lastStep = static_cast<float>(step.time);
    p.time = next;
    return true;
}

bool pressesFromStart(SearchState& state)
{
    const EarliestHit& hit = state.hit;
    const ScenePair& pair = state.scene.pair(hit.pair);
    const PairState& pose = state.scene.stateAt(hit.pair, 0.0, state.counters);
    const double near = state.options.minimumSeparation + state.options.tolerance;
    const auto presses = [&](const TriangleDistance& d)
    {
        return d.distance > 0.0 && d.distance <= near &&
               closingSpeed(pose.motion, d) > kRestingSpeed * pair.speedScale;
    };
    constexpr bool kApart = true;  // or it would be no later contact
    const TriangleDistance ofHit =
        triangleStep(
            *pair.treeA, *pair.treeB, pose, pair.limits.margin(), kApart, hit.slotA, hit.slotB)
            .distance;
    if (presses(ofHit))
    {
        return true;
    }
    EarliestHit start;
    start.distance.distance = near;
    const NodeMarks exempt = pair.mask != nullptr ? pair.mask->nodeMarks() : NodeMarks{};
    return presses(closestTriangles(pair, pose, start, exempt).distance);
}

void moveHit(SearchState& state, double time)
{
    EarliestHit& hit = state.hit;
    const ScenePair& pair = state.scene.pair(hit.pair);
    const PairState& pose = state.scene.stateAt(hit.pair, time, state.counters);
    constexpr bool kApart = true;  // the time is certified
    hit.distance =
        triangleStep(
            *pair.treeA, *pair.treeB, pose, pair.limits.margin(), kApart, hit.slotA, hit.slotB)
            .distance;
    hit.time = time;
}

void searchScene(SearchState& state)
{
    switch (state.options.strategy)
    {
        case ToiStrategy::BestFirst:
            searchBestFirst(state);
            break;
        case ToiStrategy::Interval:
            searchIntervals(state);
            break;
        case ToiStrategy::C2A:
            searchC2A(state);
            break;
    }
}

FirstContactResult describeHit(SearchState& state)
{
    FirstContactResult result;
    const EarliestHit& hit = state.hit;
    result.status = hit.atStart ? ToiStatus::Overlapping : ToiStatus::Hit;
    result.time = hit.time;
    result.gap = hit.distance.distance;
    result.pair = hit.pair;
    result.triangleA = hit.triangleA;
    result.triangleB = hit.triangleB;
    const Eigen::Isometry3d X_WB = state.scene.worldOfB(hit.pair, hit.time);
    result.pointA = X_WB * hit.distance.pointA;
    result.pointB = X_WB * hit.distance.pointB;
    if (result.gap > 0.0)
    {
        const Eigen::Vector3d across = hit.distance.pointB - hit.distance.pointA;
        result.normal = X_WB.linear() * across.stableNormalized();
    }
    return result;
}

void SearchState::reset(const ToiOptions& asked)
{
    hit = {};
    start = {};
    counters = {};
    slides = {};
    begin = 0.0;
    end = 1.0;
    certified = 0.0;
    inOrder = true;
    anyContact = false;
    options = asked;
    nextCheck = asked.stop.isGiven() ? -1 : asked.maxIterations;
}

void lookAtLimits(SearchState& state, double time, std::int32_t pair)
{
    if (state.pairs() > state.options.maxIterations)
    {
        throw GaveUp{.status = ToiStatus::IterationLimit, .time = time, .pair = pair};
    }
    if (state.options.stop.isDue())
    {
        throw GaveUp{.status = ToiStatus::Stopped, .time = time, .pair = pair};
    }
    constexpr std::int64_t kPairsBetween = 512;  // a tenth of a millisecond
    state.nextCheck = std::min(state.options.maxIterations, state.pairs() + kPairsBetween);
}
}  // namespace bullet_ccd
