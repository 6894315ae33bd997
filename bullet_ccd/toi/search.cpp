#include "bullet_ccd/toi/search.h"

#include "bullet_ccd/distance/tree_distance.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
/// Distance of the two meshes if it is below `upperBound`, else that.
double meshDistance(const ScenePair& pair, const RelativeMotion& m, double upperBound)
{
    using Eigen::Map;
    using Eigen::Vector3d;
    Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
    X_BA.linear() = Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.R);
    X_BA.translation() = X_BA.linear() * (Map<const Vector3d>(m.armA) - pair.treeA->origin()) +
                         Map<const Vector3d>(m.p) + pair.treeB->origin();
    return treeDistance(*pair.treeA, *pair.treeB, X_BA, upperBound).distance;
}

/// The bodies are within the tolerance where the query begins: from now on they must close in
/// further to count as in contact, so that they can separate or slide. Returns false if they are
/// as near as they may be, so that there is nothing to be done.
bool relaxThreshold(ScenePair& pair, const PairState& state, double upperBound)
{
    PairLimits& limits = pair.limits;
    const double start = meshDistance(pair, state.motion, upperBound);
    if (start <= limits.floor + 4.0 * state.rounding)
    {
        return false;
    }
    limits.threshold = std::min(limits.threshold, limits.floor + 0.75 * (start - limits.floor));
    return true;
}

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

void noteHit(SearchState& state, const NodePair& p, const TriangleDistance& distance)
{
    EarliestHit& hit = state.hit;
    const std::int32_t slotA = state.scene.nodeA(p).first;
    const std::int32_t slotB = state.scene.nodeB(p).first;
    if (p.time < hit.time)
    {
        hit = {.time = p.time,
               .pair = p.pair,
               .slotA = slotA,
               .slotB = slotB,
               .distance = distance,
               .atStart = p.time == 0.0};
    }
}
}  // namespace

bool advanceTriangles(SearchState& state, NodePair& p)
{
    ++state.counters.trianglePairs;
    ScenePair& pair = state.scene.pair(p.pair);
    const PairState& pose = state.scene.stateAt(p.pair, p.time, state.counters);
    const std::int32_t slotA = state.scene.nodeA(p).first;
    const std::int32_t slotB = state.scene.nodeB(p).first;
    const auto look = [&]
    {
        return triangleStep(
            *pair.treeA, *pair.treeB, pose, pair.limits.margin(), p.time > 0.0, slotA, slotB);
    };
    TriangleStep step = look();
    const double distance = step.distance.distance;
    if (p.time == 0.0 && distance <= pair.limits.threshold && relaxThreshold(pair, pose, distance))
    {
        state.start.touches = true;
        // Speeds below the rounding of the velocities are those of bodies that slide or rest.
        const bool closesIn =
            closingSpeed(pose.motion, step.distance) > 1e-12 * state.scene.pair(p.pair).speedScale;
        state.start.approaches = state.start.approaches || closesIn;
        step = look();
    }
    // Rounded down; a step that time no longer resolves is one that has arrived.
    const double next = std::nextafter(p.time + step.time * (1.0 - 1e-15), 0.0);
    if (distance <= pair.limits.near() || next <= p.time)
    {
        noteHit(state, p, step.distance);
        return false;
    }
    if (p.time + step.time > 1.0)
    {
        return false;
    }
    p.lastStep = static_cast<float>(step.time);
    p.time = next;
    return true;
}

void checkLimit(const SearchState& state, const NodePair& earliest)
{
    if (state.counters.nodePairs + state.counters.trianglePairs > state.options.maxIterations)
    {
        throw IterationLimitReached{.time = earliest.time, .pair = earliest.pair};
    }
}
}  // namespace bullet_ccd
