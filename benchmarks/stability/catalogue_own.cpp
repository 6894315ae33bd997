/// This library's queries, and sampling with its exact distances.
#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/articulated_scene.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/stability/catalogue_peer.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/toi/articulated_toi.h"

namespace bullet_ccd::tests
{
namespace
{
PeerAnswer answerOf(ToiStatus status, double time, const ToiCounters& counters)
{
    PeerAnswer answer{.time = time, .pairs = counters.nodePairs + counters.trianglePairs};
    if (isContact(status))
    {
        answer.outcome = PeerOutcome::Contact;
    }
    else if (status == ToiStatus::IterationLimit)
    {
        answer.outcome = PeerOutcome::GaveUp;
    }
    return answer;
}

ArticulatedScene sceneOf(const ArticulatedCase& tested)
{
    return {.tree = tested.tree,
            .motion = tested.motion,
            .linkMeshes = tested.linkMeshes,
            .selfPairs = tested.selfPairs,
            .obstacles = tested.obstacles,
            .obstacleMotions = std::vector<RigidMotion>(tested.obstacles.size())};
}
}  // namespace

PeerAnswer ours(const RigidCase& tested, ToiStrategy strategy)
{
    const ToiResult result = queryToi(tested.scene,
                                      {.tolerance = tested.answer.finest(),
                                       .strategy = strategy,
                                       .maxIterations = tested.maxIterations});
    return answerOf(result.status, result.time, result.counters);
}

PeerAnswer ours(const ArticulatedCase& tested, ToiStrategy strategy)
{
    const ArticulatedToiResult result = query(
        sceneOf(tested),
        ArticulatedToiOptions{.toi = {.tolerance = tested.answer.finest(), .strategy = strategy}});
    return answerOf(result.status, result.time, result.counters);
}

std::vector<MovingPair> movingPairs(const ArticulatedCase& tested)
{
    std::vector<MovingPair> pairs;
    const auto moves = [&](std::int32_t base, std::int32_t link)
    { return bullet_ccd::moves(tested.tree, tested.motion, base, link); };
    for (std::size_t i = 0; i < tested.tree.size(); ++i)
    {
        const bool counts =
            !tested.linkMeshes[i].triangles.empty() && moves(kNone, static_cast<std::int32_t>(i));
        for (std::size_t k = 0; counts && k < tested.obstacles.size(); ++k)
        {
            pairs.push_back({.link = i, .other = k, .isObstacle = true});
        }
    }
    for (const auto& [a, b] : tested.selfPairs)
    {
        const std::int32_t base = commonAncestor(tested.tree, a, b);
        if (moves(base, a) || moves(base, b))
        {
            pairs.push_back(
                {.link = static_cast<std::size_t>(a), .other = static_cast<std::size_t>(b)});
        }
    }
    return pairs;
}

PeerAnswer distanceSampling(const ArticulatedCase& tested, int steps)
{
    const ArticulatedScene scene = sceneOf(tested);
    const BuiltScene built(scene);
    const std::vector<MovingPair> pairs = movingPairs(tested);
    const double tolerance = tested.answer.finest();
    for (int i = 0; i <= steps; ++i)
    {
        const double t = static_cast<double>(i) / steps;
        std::vector<Eigen::Isometry3d> poses;
        for (std::size_t link = 0; link < tested.tree.size(); ++link)
        {
            poses.push_back(
                oracleLinkPose(tested.tree, tested.motion, static_cast<std::int32_t>(link), t));
        }
        for (const MovingPair& pair : pairs)
        {
            const SsvTree& other =
                pair.isObstacle ? *built.obstacles()[pair.other].tree : built.linkTree(pair.other);
            const Eigen::Isometry3d X_OL =
                pair.isObstacle ? poses[pair.link] : poses[pair.other].inverse() * poses[pair.link];
            if (treeDistance(built.linkTree(pair.link), other, X_OL, 2.0 * tolerance).distance <=
                tolerance)
            {
                return contactAt(t);
            }
        }
    }
    return {};
}
}  // namespace bullet_ccd::tests
