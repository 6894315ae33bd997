#include "benchmarks/reference/queries/trajectory_queries.h"

#include "benchmarks/reference/oracles/articulated_judge.h"
#include "benchmarks/reference/scenes/random.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>

namespace bullet_ccd::reference
{
namespace
{
/// Those without spherical joints and floating bases, which trajectories do not move.
constexpr std::array kFamilies{ChainFamily::Revolute,
                               ChainFamily::Prismatic,
                               ChainFamily::Mimic,
                               ChainFamily::SelfCollision,
                               ChainFamily::Fingers};

std::vector<double> near(const std::vector<double>& from,
                         const std::vector<double>& way,
                         double part,
                         double off,
                         Random& random)
{
    std::vector<double> q = from;
    for (std::size_t i = 0; i < q.size(); ++i)
    {
        q[i] += way[i] * (part + off * random.uniform(-1.0, 1.0));
    }
    return q;
}

Trajectory through(const ArticulatedScene& scene, TrajectoryKind kind, Random& random)
{
    const int pieces = random.integer(1, 2);
    const std::vector<double> none(scene.tree.size(), 0.0);
    std::vector<Waypoint> waypoints;
    double time = random.uniform(-1.0, 1.0);
    for (int k = 0; k <= pieces; ++k)
    {
        const double part = double(k) / pieces;
        Waypoint waypoint{
            .time = time,
            .positions =
                near(scene.motion.positions, scene.motion.rates, part, k == 0 ? 0.0 : 0.3, random)};
        if (kind != TrajectoryKind::Linear)
        {
            waypoint.velocities = near(none, scene.motion.rates, 1.0, 0.5, random);
        }
        if (kind == TrajectoryKind::Quintic)
        {
            waypoint.accelerations = near(none, scene.motion.rates, 0.0, 1.0, random);
        }
        waypoints.push_back(std::move(waypoint));
        time += random.uniform(0.2, 0.8);
    }
    return trajectoryThrough(scene.tree, scene.motion.root.X_W0, waypoints);
}

Trajectory spline(const ArticulatedScene& scene, Random& random)
{
    JointSpline spline{.degree = random.integer(1, 5), .knots = {}, .controlPoints = {}};
    const int points = spline.degree + random.integer(1, 2);
    for (int k = 0; k < points; ++k)
    {
        spline.controlPoints.push_back(near(scene.motion.positions,
                                            scene.motion.rates,
                                            double(k) / (points - 1),
                                            k == 0 ? 0.0 : 0.3,
                                            random));
    }
    double knot = 0.0;
    for (int k = 0; k < points + spline.degree + 1; ++k)
    {
        spline.knots.push_back(knot);
        knot += k < spline.degree || k >= points - 1 ? 0.0 : random.uniform(0.2, 0.8);
    }
    // The last of them stands for all that are clamped to the end.
    const double end = spline.knots[static_cast<std::size_t>(points) - 1] + 0.5;
    std::fill(spline.knots.begin() + points, spline.knots.end(), end);
    return splineTrajectory(scene.tree, scene.motion.root.X_W0, spline);
}

/// Every segment up to the one of the answer, with the part of the answer that concerns it.
Judgement judgeContact(const TrajectoryQuery& query, const TrajectoryToiResult& result)
{
    ArticulatedScene scene = query.chain.scene;
    for (std::size_t k = 0; k < query.trajectory.segments.size(); ++k)
    {
        scene.motion = query.trajectory.segments[k];
        const bool isLast =
            result.status != ToiStatus::Separated && std::ptrdiff_t(k) == result.segment;
        ArticulatedToiResult part;
        part.time = 1.0;
        if (isLast)
        {
            part.status = result.status;
            part.contacts = result.contacts;
            part.time = result.contacts.empty() ? 0.0 : result.contacts.front().time;
        }
        const Judgement judgement = judgeArticulated(scene, query.chain.options.toi, part);
        if (isLast || judgement.verdict != Verdict::Right)
        {
            return judgement;
        }
    }
    return {};
}

Judgement judgeLeast(const TrajectoryQuery& query, const TrajectoryLeastDistance& least)
{
    ArticulatedScene scene = query.chain.scene;
    const double rounding = distanceRounding(scene) + 1e-12;
    if (least.status == ToiStatus::IterationLimit)
    {
        return {
            .verdict = Verdict::GaveUp, .time = least.seconds, .distance = 0.0, .pair = "least"};
    }
    constexpr std::array kSamples{0.0, 0.25, 0.5, 0.75, 1.0};
    for (const JointMotion& segment : query.trajectory.segments)
    {
        scene.motion = segment;
        const double distance = leastDistanceAt(scene, kSamples);
        if (least.distance > distance + rounding)
        {
            return {.verdict = Verdict::Late, .time = 0.0, .distance = distance, .pair = "least"};
        }
    }
    if (least.segment != kNone)
    {
        scene.motion = query.trajectory.segments[static_cast<std::size_t>(least.segment)];
        const LinkContact named{
            .link = least.link, .obstacle = least.obstacle, .otherLink = least.otherLink};
        const double distance = leastDistanceAt(scene, {&least.time, 1}, &named);
        if (least.distance > distance + rounding)
        {
            return {.verdict = Verdict::Late,
                    .time = least.time,
                    .distance = distance,
                    .pair = "least"};
        }
        if (std::abs(distance - least.found) > rounding && distance > rounding)
        {
            return {.verdict = Verdict::WrongGap,
                    .time = least.time,
                    .distance = distance,
                    .pair = "least"};
        }
    }
    const double known = std::min(least.found, query.least.enough);
    if (std::isfinite(known) && least.distance < known - query.least.tolerance - rounding)
    {
        return {.verdict = Verdict::WrongGap,
                .time = least.time,
                .distance = least.distance,
                .pair = "least"};
    }
    return {};
}
}  // namespace

std::vector<std::string> trajectoryKindNames()
{
    return {"linear", "cubic", "quintic", "spline"};
}

TrajectoryQuery trajectoryQuery(std::uint64_t seed)
{
    TrajectoryQuery query{.family = static_cast<TrajectoryKind>(seed % kTrajectoryKinds)};
    const std::uint64_t turn = seed / kTrajectoryKinds;
    // The chain whose family and number of joints are those of this turn.
    query.chain = chainQuery(turn / kFamilies.size() * kChainFamilies +
                             static_cast<std::uint64_t>(kFamilies[turn % kFamilies.size()]));
    ArticulatedScene& scene = query.chain.scene;
    scene.motion.root = restAt(scene.motion.root.X_W0);
    for (RigidMotion& motion : scene.obstacleMotions)
    {
        motion = restAt(motion.X_W0);
    }
    Random random(seed * 0x9E3779B97F4A7C15ULL + 11);
    query.trajectory = query.family == TrajectoryKind::Spline
                           ? spline(scene, random)
                           : through(scene, query.family, random);
    query.least.tolerance = random.logUniform(1e-6, 1e-3);
    return query;
}

void print(std::ostream& out, const TrajectoryQuery& query)
{
    out << "trajectory " << trajectoryKindNames()[static_cast<std::size_t>(query.family)] << " of "
        << query.trajectory.segments.size() << " segments\n";
    for (const JointMotion& segment : query.trajectory.segments)
    {
        ChainQuery piece = query.chain;
        piece.scene.motion = segment;
        print(out, piece);
    }
}

Judgement judgeTrajectory(const TrajectoryQuery& query,
                          const TrajectoryToiResult& result,
                          const TrajectoryLeastDistance& least)
{
    const Judgement contact = judgeContact(query, result);
    return contact.verdict == Verdict::Right ? judgeLeast(query, least) : contact;
}

TrajectoryOutcome runTrajectoryQuery(const TrajectoryQuery& query)
{
    thread_local ToiWorkspace work;
    const BuiltScene built(query.chain.scene);
    TrajectoryOutcome outcome;
    outcome.result = trajectoryToi(built.body(),
                                   Environment(built.obstacles()),
                                   query.trajectory,
                                   query.chain.options,
                                   std::span(&work, 1));
    outcome.least = leastDistance(
        built.body(), built.obstacles(), query.trajectory, query.least, std::span(&work, 1));
    outcome.judgement = judgeTrajectory(query, outcome.result, outcome.least);
    return outcome;
}
}  // namespace bullet_ccd::reference
