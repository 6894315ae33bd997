#include "grasp/task/plan_file.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "grasp/report/grasp_model.h"
#include "grasp/report/grasp_scene.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <ostream>

namespace bullet_ccd::grasp
{
namespace
{
using nlohmann::ordered_json;

/// Joints that move by themselves.
std::vector<std::size_t> ownJoints(const KinematicTree& tree)
{
    std::vector<std::size_t> joints;
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        if (joint.isMovable() && joint.mimicOf == kNone)
        {
            joints.push_back(i);
        }
    }
    return joints;
}

ordered_json poseJson(const Eigen::Isometry3d& X)
{
    const Eigen::Quaterniond q = Eigen::Quaterniond(X.linear()).normalized();
    const Eigen::Vector3d p = X.translation();
    return {{"position_m", {p.x(), p.y(), p.z()}},
            {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

ordered_json legJson(const PickPlaceTask& task, const TaskLeg& leg)
{
    ordered_json waypoints = ordered_json::array();
    for (const Waypoint& waypoint : leg.waypoints)
    {
        ordered_json positions = ordered_json::array();
        for (const std::size_t joint : ownJoints(task.robot.tree))
        {
            positions.push_back(waypoint.positions[joint]);
        }
        waypoints.push_back({{"time_s", waypoint.time}, {"positions", positions}});
    }
    ordered_json clearance = leg.clearance;
    return {{"leg", leg.name},
            {"carries", leg.carries},
            {"certified_clearance_m", clearance},
            {"clearance_is_at_least", leg.clearance >= kEnoughClearance},
            {"waypoints", waypoints}};
}

/// Waypoints of all legs, each time once.
std::vector<const Waypoint*> waypointsOf(const PickPlacePlan& plan)
{
    std::vector<const Waypoint*> waypoints;
    for (const TaskLeg& leg : plan.legs)
    {
        for (const Waypoint& waypoint : leg.waypoints)
        {
            if (waypoints.empty() || waypoint.time > waypoints.back()->time)
            {
                waypoints.push_back(&waypoint);
            }
        }
    }
    return waypoints;
}

void exact(std::ostream& out)
{
    out << std::setprecision(std::numeric_limits<double>::max_digits10);
}
}  // namespace

void writePlanJson(std::ostream& out, const PickPlaceTask& task, const PickPlacePlan& plan)
{
    ordered_json json{{"schema", "bullet_ccd.pick_place/1"},
                      {"solved", plan.solved},
                      {"failure", plan.solved ? ordered_json() : ordered_json(plan.failure)},
                      {"robot", task.robot.name},
                      {"object", task.object.name},
                      {"object_start", poseJson(plan.X_WOStart)},
                      {"force_closures", plan.forceClosures},
                      {"attempts", ordered_json::array()}};
    for (const TaskAttempt& attempt : plan.attempts)
    {
        json["attempts"].push_back(
            {{"candidate", attempt.candidate},
             {"failed_leg", attempt.leg.empty() ? ordered_json() : ordered_json(attempt.leg)},
             {"reason", attempt.reason.empty() ? ordered_json() : ordered_json(attempt.reason)}});
    }
    if (plan.solved)
    {
        json["object_end"] = poseJson(plan.X_WOEnd);
        json["grasp"] = {{"candidate", plan.grasp.candidate},
                         {"preshape", plan.grasp.preshape},
                         {"epsilon", plan.grasp.quality.epsilon},
                         {"mass_kg", plan.mass.mass},
                         {"mass_from", toString(plan.mass.source)},
                         {"hand_pose_in_object", poseJson(plan.grasp.X_WH)}};
        json["joints"] = ordered_json::array();
        for (const std::size_t joint : ownJoints(task.robot.tree))
        {
            json["joints"].push_back(task.robot.tree.links[joint].joint.name);
        }
        json["duration_s"] = plan.legs.back().waypoints.back().time;
        json["legs"] = ordered_json::array();
        for (const TaskLeg& leg : plan.legs)
        {
            json["legs"].push_back(legJson(task, leg));
        }
    }
    out << json.dump(1) << "\n";
}

void writePlanCsv(std::ostream& out, const PickPlaceTask& task, const PickPlacePlan& plan)
{
    exact(out);
    const std::vector<std::size_t> joints = ownJoints(task.robot.tree);
    out << "time";
    for (const std::size_t joint : joints)
    {
        out << "," << task.robot.tree.links[joint].joint.name;
    }
    out << "\n";
    for (const Waypoint* waypoint : waypointsOf(plan))
    {
        out << waypoint->time;
        for (const std::size_t joint : joints)
        {
            out << "," << waypoint->positions[joint];
        }
        out << "\n";
    }
}

void writePlanYaml(std::ostream& out, const PickPlaceTask& task, const PickPlacePlan& plan)
{
    exact(out);
    const std::vector<std::size_t> joints = ownJoints(task.robot.tree);
    out << "# Comes to rest at every point; with velocities and accelerations of zero, "
           "controllers\n"
           "# of ROS move between them as was certified.\njoint_names:\n";
    for (const std::size_t joint : joints)
    {
        out << "  - " << task.robot.tree.links[joint].joint.name << "\n";
    }
    std::string zeros;
    for (std::size_t k = 0; k < joints.size(); ++k)
    {
        zeros += k == 0 ? "0" : ", 0";
    }
    out << "points:\n";
    for (const Waypoint* waypoint : waypointsOf(plan))
    {
        out << "  - positions: [";
        for (std::size_t k = 0; k < joints.size(); ++k)
        {
            out << (k == 0 ? "" : ", ") << waypoint->positions[joints[k]];
        }
        // Whole nanoseconds, as the message has them.
        const auto nanoseconds = std::llround(1e9 * waypoint->time);
        out << "]\n    velocities: [" << zeros << "]\n    accelerations: [" << zeros
            << "]\n    time_from_start: {sec: " << nanoseconds / 1'000'000'000
            << ", nanosec: " << nanoseconds % 1'000'000'000 << "}\n";
    }
}

TaskState stateAt(const PickPlaceTask& task, const PickPlacePlan& plan, double time)
{
    TaskState state;
    while (state.leg + 1 < plan.legs.size() && plan.legs[state.leg].waypoints.back().time < time)
    {
        ++state.leg;
    }
    const TaskLeg& leg = plan.legs[state.leg];
    std::vector<double> positions = leg.waypoints.front().positions;
    if (leg.waypoints.size() > 1)
    {
        positions = positionsAt(trajectoryThrough(task.robot.tree, task.X_WR, leg.waypoints), time);
        applyMimics(task.robot.tree, positions);
    }
    state.X_W = linkPoses(task.robot.tree, task.X_WR, positions);
    state.X_WO = leg.carries ? state.X_W[static_cast<std::size_t>(task.robot.handRoot)] * plan.X_HO
                             : restingPose(plan, state.leg);
    return state;
}

void writePlanModel(const PickPlaceTask& task,
                    const PickPlacePlan& plan,
                    const std::filesystem::path& file,
                    double interval)
{
    std::vector<MotionTrack> tracks;
    for (std::size_t i = 0; i < task.obstacles.size(); ++i)
    {
        tracks.push_back({.name = task.obstacleNames[i],
                          .tree = task.obstacles[i].tree,
                          .color = kObstacleColor,
                          .poses = {task.obstacles[i].motion.X_W0}});
    }
    const std::size_t obstacles = tracks.size();
    for (std::size_t link = 0; link < task.robot.tree.size(); ++link)
    {
        tracks.push_back({.name = task.robot.tree.links[link].name,
                          .tree = task.robot.linkTrees[link],
                          .color = Color(0.36F, 0.47F, 0.62F),
                          .poses = {}});
    }
    tracks.push_back({.name = "object: " + task.object.name,
                      .tree = &task.object.tree,
                      .color = kObjectColor,
                      .poses = {}});
    std::vector<float> times;
    const double duration = plan.legs.back().waypoints.back().time;
    const auto frames = static_cast<int>(std::ceil(duration / interval));
    for (int i = 0; i <= frames; ++i)
    {
        const double time = duration * i / frames;
        const TaskState state = stateAt(task, plan, time);
        times.push_back(static_cast<float>(time));
        for (std::size_t link = 0; link < state.X_W.size(); ++link)
        {
            tracks[obstacles + link].poses.push_back(state.X_W[link]);
        }
        tracks.back().poses.push_back(state.X_WO);
    }
    std::erase_if(tracks, [](const MotionTrack& track) { return track.tree == nullptr; });
    writeMotionModel("task", times, tracks, file);
}

double sampledDistance(const PickPlaceTask& task,
                       const PickPlacePlan& plan,
                       std::size_t leg,
                       int samples)
{
    // The links, then the object, then the obstacles.
    const TaskLeg& way = plan.legs[leg];
    std::vector<const SsvTree*> things = task.robot.linkTrees;
    const std::size_t links = things.size();
    things.push_back(&task.object.tree);
    for (const RigidBody& obstacle : task.obstacles)
    {
        things.push_back(obstacle.tree);
    }
    const auto root = static_cast<std::size_t>(task.robot.handRoot);
    const auto placesAt = [&](const std::vector<double>& q)
    {
        std::vector<Eigen::Isometry3d> X_W = linkPoses(task.robot.tree, task.X_WR, q);
        X_W.push_back(way.carries ? X_W[root] * plan.X_HO : restingPose(plan, leg));
        for (const RigidBody& obstacle : task.obstacles)
        {
            X_W.push_back(obstacle.motion.X_W0);
        }
        return X_W;
    };
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t i = 0; i <= links; ++i)
    {
        for (std::size_t k = std::max(i + 1, links); things[i] != nullptr && k < things.size(); ++k)
        {
            pairs.emplace_back(i, k);
        }
    }
    pairs.insert(pairs.end(), task.robot.selfPairs.begin(), task.robot.selfPairs.end());
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t w = 1; w < way.waypoints.size(); ++w)
    {
        const std::vector<double>& from = way.waypoints[w - 1].positions;
        const std::vector<double>& to = way.waypoints[w].positions;
        const auto atFrom = placesAt(from);
        const auto atTo = placesAt(to);
        std::vector<std::pair<std::size_t, std::size_t>> moving;
        std::ranges::copy_if(pairs,
                             std::back_inserter(moving),
                             [&](const auto& pair)
                             {
                                 const auto [i, k] = pair;
                                 return !(atFrom[k].inverse() * atFrom[i])
                                             .isApprox(atTo[k].inverse() * atTo[i], 1e-12);
                             });
        for (int n = 0; n <= samples; ++n)
        {
            const double t = double(n) / std::max(samples, 1);
            const double s = t * t * t * (10.0 + t * (6.0 * t - 15.0));
            std::vector<double> q = from;
            for (std::size_t j = 0; j < q.size(); ++j)
            {
                q[j] += s * (to[j] - from[j]);
            }
            const auto X_W = placesAt(q);
            for (const auto& [i, k] : moving)
            {
                least =
                    treeDistance(*things[i], *things[k], X_W[k].inverse() * X_W[i], least).distance;
            }
        }
    }
    return least;
}
}  // namespace bullet_ccd::grasp
