#include "benchmarks/stability/catalogue_methods.h"

#include "benchmarks/peers/bullet_peer.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/reference/scenes/articulated_scene.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;
using Eigen::Isometry3d;

/// Corners that triangles use, once each.
std::vector<Eigen::Vector3d> cornersInUse(const TriangleMesh& mesh)
{
    std::set<std::array<double, 3>> seen;
    std::vector<Eigen::Vector3d> corners;
    for (const Triangle& t : mesh.triangles)
    {
        for (const std::int32_t index : t)
        {
            const Eigen::Vector3d& v = mesh.vertices[static_cast<std::size_t>(index)];
            if (seen.insert({v.x(), v.y(), v.z()}).second)
            {
                corners.push_back(v);
            }
        }
    }
    return corners;
}

std::string notConvex(const RigidCase& tested)
{
    if (tested.nested)
    {
        return "hulls overlap from the start";
    }
    return isConvex(tested.scene.meshA) && isConvex(tested.scene.meshB) ? "" : "not convex";
}

std::string notConvexOrTurns(const RigidCase& tested)
{
    const bool turns =
        !tested.scene.motionA.w_W.isZero(0.0) || !tested.scene.motionB.w_W.isZero(0.0);
    return turns ? "translations only" : notConvex(tested);
}

PeerAnswer contactAt(double time)
{
    return {.outcome = PeerOutcome::Contact, .time = time};
}

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

/// The first of `steps` + 1 times at which something touches.
template <typename Touches>
PeerAnswer firstSample(int steps, const Touches& touches)
{
    for (int i = 0; i <= steps; ++i)
    {
        const double t = static_cast<double>(i) / steps;
        if (touches(t))
        {
            return contactAt(t);
        }
    }
    return {};
}

/// Two links, or a link and an obstacle, that move relative to each other.
struct MovingPair
{
    std::size_t link = 0;
    std::size_t other = 0;
    bool isObstacle = false;
};

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

/// @param touches of a pair, and the poses of its two bodies
template <typename Touches>
PeerAnswer samplePairs(const ArticulatedCase& tested, int steps, const Touches& touches)
{
    const std::vector<MovingPair> pairs = movingPairs(tested);
    const auto touchesAt = [&](double t)
    {
        std::vector<Isometry3d> poses;
        for (std::size_t link = 0; link < tested.tree.size(); ++link)
        {
            poses.push_back(
                oracleLinkPose(tested.tree, tested.motion, static_cast<std::int32_t>(link), t));
        }
        return std::ranges::any_of(
            pairs,
            [&](const MovingPair& pair)
            {
                return touches(pair,
                               poses[pair.link],
                               pair.isObstacle ? Isometry3d::Identity() : poses[pair.other]);
            });
    };
    return firstSample(steps, touchesAt);
}

/// Contact where a pair is within the tolerance of the case.
PeerAnswer distanceSampling(const ArticulatedCase& tested, int steps)
{
    const ArticulatedScene scene = sceneOf(tested);
    const BuiltScene built(scene);
    const double tolerance = tested.answer.finest();
    const auto isNear = [&](const MovingPair& pair, const Isometry3d& X_WL, const Isometry3d& X_WO)
    {
        const SsvTree& other =
            pair.isObstacle ? *built.obstacles()[pair.other].tree : built.linkTree(pair.other);
        const Isometry3d X_OL = X_WO.inverse() * X_WL;
        return treeDistance(built.linkTree(pair.link), other, X_OL, 2.0 * tolerance).distance <=
               tolerance;
    };
    return samplePairs(tested, steps, isNear);
}

PeerAnswer overlapSampling(const ArticulatedCase& tested, int steps)
{
    std::vector<std::optional<FclModel>> links;
    for (const TriangleMesh& mesh : tested.linkMeshes)
    {
        links.push_back(mesh.triangles.empty() ? std::nullopt : std::optional<FclModel>(mesh));
    }
    const std::vector<FclModel> obstacles(tested.obstacles.begin(), tested.obstacles.end());
    const auto overlaps =
        [&](const MovingPair& pair, const Isometry3d& X_WL, const Isometry3d& X_WO)
    {
        const FclModel& other = pair.isObstacle ? obstacles[pair.other] : *links[pair.other];
        return fclOverlap(*links[pair.link], X_WL, other, X_WO);
    };
    return samplePairs(tested, steps, overlaps);
}

/// FCL on a case; it gets the same two motions, see fcl_peer.h.
template <typename Ask>
PeerAnswer askFcl(const RigidCase& tested, const Ask& ask)
{
    const FclModel a(tested.scene.meshA);
    const FclModel b(tested.scene.meshB);
    const FclAnswer answer =
        ask(FclBody{a, tested.scene.motionA}, FclBody{b, tested.scene.motionB});
    return answer.hit ? contactAt(answer.time) : PeerAnswer{};
}

PeerAnswer fclSampling(const RigidCase& tested, int steps)
{
    return askFcl(tested,
                  [&](const FclBody& a, const FclBody& b) { return fclNaive(a, b, steps + 1); });
}

PeerAnswer fclAdvancing(const RigidCase& tested)
{
    return askFcl(tested,
                  [](const FclBody& a, const FclBody& b)
                  { return fclAdvancement(a, b, 1e-6, 1001); });
}

PeerAnswer castByBullet(const RigidCase& tested, BulletCast cast)
{
    const BulletHull a(tested.scene.meshA, 0.0);
    const BulletHull b(tested.scene.meshB, 0.0);
    const BulletAnswer answer = bulletCast(cast, a, tested.scene.motionA, b, tested.scene.motionB);
    return answer.hit ? contactAt(answer.time) : PeerAnswer{};
}

/// Contact where the hulls are within the tolerance of the case.
PeerAnswer bulletSampling(const RigidCase& tested, int steps)
{
    const BulletHull a(tested.scene.meshA, 0.0);
    const BulletHull b(tested.scene.meshB, 0.0);
    const auto isNear = [&](double t)
    {
        return bulletDistance(
                   a, tested.scene.motionA.at(t).X_W, b, tested.scene.motionB.at(t).X_W) <=
               tested.answer.finest();
    };
    return firstSample(steps, isNear);
}

template <typename Case>
void addOurs(std::vector<Method<Case>>& all)
{
    for (const ToiStrategy strategy :
         {ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A})
    {
        all.push_back({.name = nameOf(strategy),
                       .owner = "ours",
                       .setting = "the case's finest tolerance",
                       .run = [strategy](const Case& tested) { return ours(tested, strategy); }});
    }
}

template <typename Case>
Method<Case> sampling(const std::string& name,
                      const std::string& owner,
                      int steps,
                      PeerAnswer (*run)(const Case&, int))
{
    return {.name = name + " x" + std::to_string(steps),
            .owner = owner,
            .setting = std::to_string(steps) + " steps",
            .run = [run, steps](const Case& tested) { return run(tested, steps); }};
}
}  // namespace

std::vector<Method<RigidCase>> rigidMethods()
{
    std::vector<Method<RigidCase>> all;
    addOurs(all);
    all.push_back({.name = "FCL advancement",
                   .owner = "fcl",
                   .setting = "CCDC_CONSERVATIVE_ADVANCEMENT, toc_err 1e-6",
                   .run = fclAdvancing});
    for (const int steps : {97, 997, 9973})
    {
        all.push_back(sampling<RigidCase>("FCL sampling", "fcl", steps, fclSampling));
    }
    const auto cast = [&](const char* name, const char* setting, BulletCast kind, auto cannot)
    {
        all.push_back(
            {.name = name,
             .owner = "bullet",
             .setting = setting,
             .run = [kind](const RigidCase& tested) { return castByBullet(tested, kind); },
             .notApplicable = cannot});
    };
    cast("Bullet continuous",
         "btContinuousConvexCollision, margin 0",
         BulletCast::Continuous,
         notConvex);
    cast("Bullet subsimplex",
         "btSubsimplexConvexCast, margin 0",
         BulletCast::Subsimplex,
         notConvexOrTurns);
    cast("Bullet GJK cast", "btGjkConvexCast, margin 0", BulletCast::Gjk, notConvexOrTurns);
    for (const int steps : {59, 241})
    {
        all.push_back(sampling<RigidCase>("Bullet discrete", "bullet", steps, bulletSampling));
        all.back().setting += ", as a world at that rate";
        all.back().notApplicable = notConvex;
    }
    return all;
}

std::vector<Method<ArticulatedCase>> articulatedMethods()
{
    std::vector<Method<ArticulatedCase>> all;
    addOurs(all);
    for (const int steps : {59, 241, 997, 9973})
    {
        all.push_back(
            sampling<ArticulatedCase>("exact distance", "sampled", steps, distanceSampling));
    }
    for (const int steps : {241, 997})
    {
        all.push_back(sampling<ArticulatedCase>("FCL overlap", "fcl", steps, overlapSampling));
    }
    return all;
}

bool isConvex(const TriangleMesh& mesh)
{
    const std::vector<Eigen::Vector3d> corners = cornersInUse(mesh);
    if (corners.size() <= 3 || (corners.size() == 4 && mesh.triangles.size() == 2))
    {
        return true;
    }
    TriangleMesh merged = mesh;
    repairMesh(merged);
    const double size = bounds(mesh).diagonal().norm();
    const auto isOutside = [&](const Triangle& t)
    {
        const auto at = [&](std::size_t k)
        { return merged.vertices[static_cast<std::size_t>(t[k])]; };
        const Eigen::Vector3d n = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
        return std::all_of(corners.begin(),
                           corners.end(),
                           [&](const Eigen::Vector3d& v)
                           { return n.dot(v - at(0)) <= 1e-9 * size; });
    };
    return isWatertight(merged) &&
           std::all_of(merged.triangles.begin(), merged.triangles.end(), isOutside);
}
}  // namespace bullet_ccd::benchmarks
