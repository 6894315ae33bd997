#include "grasp/task/plan_file.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/io/robot_file.h"
#include "grasp/hand/sampled_pairs.h"
#include "grasp/report/grasp_model.h"
#include "grasp/report/grasp_picture.h"
#include "grasp/task/task_page.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <functional>
#include <iomanip>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <ostream>
#include <set>
#include <stdexcept>
#include <utility>

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

ordered_json legJson(const KinematicTree& tree, const TaskLeg& leg)
{
    ordered_json waypoints = ordered_json::array();
    for (const Waypoint& waypoint : leg.waypoints)
    {
        ordered_json positions = ordered_json::array();
        for (const std::size_t joint : ownJoints(tree))
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

void addLegs(const KinematicTree& tree, const std::vector<TaskLeg>& legs, ordered_json& json)
{
    json["joints"] = ordered_json::array();
    for (const std::size_t joint : ownJoints(tree))
    {
        json["joints"].push_back(tree.links[joint].joint.name);
    }
    json["duration_s"] = legs.back().waypoints.back().time;
    json["legs"] = ordered_json::array();
    for (const TaskLeg& leg : legs)
    {
        json["legs"].push_back(legJson(tree, leg));
    }
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
        json["parts_from"] = plan.partsFrom;
        json["grasp"] = {
            {"candidate", plan.grasp.candidate},
            {"preshape", plan.grasp.preshape},
            {"epsilon", plan.grasp.quality.epsilon},
            {"mass_kg", plan.mass.mass},
            {"mass_from", toString(plan.mass.source)},
            {"hand_pose_in_object", poseJson(plan.grasp.X_WH)},
            {"hand_link", task.robot.tree.links[std::size_t(task.robot.handRoot)].name},
            {"object_pose_in_hand", poseJson(plan.X_HO)}};
        addLegs(task.robot.tree, plan.legs, json);
    }
    out << json.dump(1) << "\n";
}

namespace
{
/// As it is, or quoted where YAML would take it for something else; JSON's strings are YAML's.
std::string yamlText(const std::string& name)
{
    const bool isPlain =
        !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
        std::ranges::all_of(name,
                            [](unsigned char c)
                            { return std::isalnum(c) != 0 || c == '_' || c == '/' || c == '.'; });
    return isPlain ? name : nlohmann::json(name).dump();
}

void writeRows(std::ostream& out,
               const KinematicTree& tree,
               const std::vector<const Waypoint*>& waypoints)
{
    exact(out);
    const std::vector<std::size_t> joints = ownJoints(tree);
    out << "time";
    for (const std::size_t joint : joints)
    {
        out << "," << tree.links[joint].joint.name;
    }
    out << "\n";
    for (const Waypoint* waypoint : waypoints)
    {
        out << waypoint->time;
        for (const std::size_t joint : joints)
        {
            out << "," << waypoint->positions[joint];
        }
        out << "\n";
    }
}
}  // namespace

void writePlanCsv(std::ostream& out, const PickPlaceTask& task, const PickPlacePlan& plan)
{
    writeRows(out, task.robot.tree, waypointsOf(plan));
}

void writeLegCsv(std::ostream& out, const PickPlaceTask& task, const TaskLeg& leg)
{
    std::vector<const Waypoint*> waypoints;
    for (const Waypoint& waypoint : leg.waypoints)
    {
        waypoints.push_back(&waypoint);
    }
    writeRows(out, task.robot.tree, waypoints);
}

void writeRobot(const PickPlaceTask& task, const std::filesystem::path& folder)
{
    const HandModel whole = wholeRobot(task.robot, task.hand);
    writeUrdf(whole.robot, folder / "robot.urdf");
    const std::set<std::pair<std::int32_t, std::int32_t>> tested(whole.selfPairs.begin(),
                                                                 whole.selfPairs.end());
    std::vector<SampledPair> others;
    const auto size = static_cast<std::int32_t>(whole.linkTrees.size());
    for (std::int32_t a = 0; a < size; ++a)
    {
        for (std::int32_t b = a + 1; b < size; ++b)
        {
            if (!tested.contains({a, b}))
            {
                others.push_back({.first = a, .second = b, .finding = PairFinding::Default});
            }
        }
    }
    std::ofstream out(folder / "robot.srdf");
    out << disabledPairsSrdf(whole.robot.name, whole.robot.tree, others);
    out.close();
    if (!out)
    {
        throw std::runtime_error((folder / "robot.srdf").string() +
                                 ": cannot be written: is the disk full?");
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
        out << "  - " << yamlText(task.robot.tree.links[joint].joint.name) << "\n";
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

void drawPlan(const PickPlaceTask& task,
              const PickPlacePlan& plan,
              const std::filesystem::path& file)
{
    std::vector<Moment> moments;
    const auto add = [&](std::size_t leg, double part)
    {
        const std::vector<Waypoint>& way = plan.legs[leg].waypoints;
        std::vector<double> q = way.back().positions;
        if (part < 1.0)
        {
            q = positionsAt(trajectoryThrough(task.robot.tree, task.X_WR, way),
                            way.front().time + part * (way.back().time - way.front().time));
            applyMimics(task.robot.tree, q);
        }
        const Eigen::Isometry3d X_WH =
            linkPoses(task.robot.tree, task.X_WR, q)[static_cast<std::size_t>(task.robot.handRoot)];
        moments.push_back(
            {.X_WH = task.X_WR,
             .positions = q,
             .X_WO = plan.legs[leg].carries ? X_WH * plan.X_HO : restingPose(plan, leg)});
    };
    for (std::size_t leg = 0; leg < plan.legs.size(); ++leg)
    {
        const TaskLeg& way = plan.legs[leg];
        if (way.name == "carry")
        {
            add(leg, 0.5);
        }
        if (way.name != "open" && way.name != "return")
        {
            add(leg, 1.0);
        }
    }
    drawMoments(wholeRobot(task.robot, task.hand),
                task.object,
                moments,
                {.width = 1800,
                 .height = 960,
                 .obstacles = task.obstacles,
                 .columns = 4,
                 .wholeHand = true},
                file);
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

namespace
{
/// Distances at samples of a leg.
/// @param placesAt  poses of the links, the object and the obstacles, at positions of the joints
/// @param pairs     of these
double sampled(
    const TaskLeg& way,
    const std::vector<const SsvTree*>& things,
    const std::function<std::vector<Eigen::Isometry3d>(const std::vector<double>&)>& placesAt,
    const std::vector<std::pair<std::size_t, std::size_t>>& pairs,
    int samples)
{
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

/// The links, then the object, then the obstacles.
std::vector<const SsvTree*> thingsOf(const Stage& stage)
{
    std::vector<const SsvTree*> things = stage.linkTrees;
    things.push_back(&stage.object.tree);
    for (const RigidBody& obstacle : stage.obstacles)
    {
        things.push_back(obstacle.tree);
    }
    return things;
}
}  // namespace

void writePlanModel(const PickPlaceTask& task,
                    const PickPlacePlan& plan,
                    const std::filesystem::path& file,
                    double interval)
{
    const TaskMotion motion = motionOf(task, plan, interval);
    writeMotionModel("task", motion.times, motion.tracks, file);
}

double sampledDistance(const PickPlaceTask& task,
                       const PickPlacePlan& plan,
                       std::size_t leg,
                       int samples)
{
    const TaskLeg& way = plan.legs[leg];
    const std::vector<const SsvTree*> things = thingsOf(stageOf(task));
    const std::size_t links = task.robot.tree.size();
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
    return sampled(way, things, placesAt, pairs, samples);
}

void writeLiftJson(std::ostream& out, const TwoHandTask& task, const TwoHandPlan& plan)
{
    const TwoArms& arms = task.arms;
    ordered_json json{{"schema", "bullet_ccd.two_hands/1"},
                      {"solved", plan.solved},
                      {"failure", plan.solved ? ordered_json() : ordered_json(plan.failure)},
                      {"robot", arms.whole.robot.name},
                      {"object", task.object.name},
                      {"object_start", poseJson(plan.X_WOStart)},
                      {"mass_kg", plan.mass.mass},
                      {"mass_from", toString(plan.mass.source)},
                      {"touching", plan.touching},
                      {"reached", plan.reached},
                      {"force_closures_of_one_hand", plan.singleHanded},
                      {"force_closures_of_two_hands", plan.pairs},
                      {"attempts", ordered_json::array()}};
    for (const PairAttempt& attempt : plan.attempts)
    {
        json["attempts"].push_back(
            {{"candidates", attempt.candidates},
             {"failed_leg", attempt.leg.empty() ? ordered_json() : ordered_json(attempt.leg)},
             {"reason", attempt.reason.empty() ? ordered_json() : ordered_json(attempt.reason)}});
    }
    if (plan.solved)
    {
        json["epsilon"] = plan.grasp.quality.epsilon;
        json["epsilon_of_one_hand"] = plan.aloneEpsilon;
        json["largest_mass_kg"] = *plan.grasp.quality.largestMass;
        json["normal_forces_for_the_weight_N"] = plan.forces.normal;
        json["largest_share_of_effort"] = plan.forces.effort;
        json["squeeze_N"] = plan.forces.squeeze;
        json["internal_force_N"] = plan.forces.internal;
        json["contacts"] = ordered_json::array();
        for (std::size_t i = 0; i < plan.grasp.contacts.size(); ++i)
        {
            const GraspContact& contact = plan.grasp.contacts[i];
            const Eigen::Vector3d& p = contact.point;
            const Eigen::Vector3d& n = contact.normal;
            const Eigen::Vector3d& f = plan.squeeze.forces[i];
            json["contacts"].push_back({{"link", linkName(arms.whole, contact.link)},
                                        {"point_m", {p.x(), p.y(), p.z()}},
                                        {"normal", {n.x(), n.y(), n.z()}},
                                        {"squeeze_force_N", {f.x(), f.y(), f.z()}}});
        }
        addLegs(arms.whole.robot.tree, plan.legs, json);
    }
    out << json.dump(1) << "\n";
}

void writeLiftModel(const TwoHandTask& task,
                    const TwoHandPlan& plan,
                    const std::filesystem::path& file,
                    double interval)
{
    const TaskMotion motion = motionOf(task, plan, interval);
    writeMotionModel("task", motion.times, motion.tracks, file);
}

void drawLift(const TwoHandTask& task, const TwoHandPlan& plan, const std::filesystem::path& file)
{
    std::vector<Moment> moments;
    for (const char* leg : {"transit", "close", "lift"})
    {
        const std::vector<double>& q =
            std::ranges::find(plan.legs, leg, &TaskLeg::name)->waypoints.back().positions;
        const Eigen::Isometry3d X_WH =
            linkPoses(task.arms.whole.robot.tree,
                      Eigen::Isometry3d::Identity(),
                      q)[static_cast<std::size_t>(task.arms.handRoot(0))];
        moments.push_back({.positions = q,
                           .X_WO = std::string(leg) == "lift" ? X_WH * plan.X_HO : plan.X_WOStart});
    }
    drawMoments(task.arms.whole,
                task.object,
                moments,
                {.width = 1800, .height = 560, .obstacles = task.obstacles, .wholeHand = true},
                file);
}

double sampledDistance(const TwoHandTask& task,
                       const TwoHandPlan& plan,
                       std::size_t leg,
                       int samples)
{
    const TwoArms& arms = task.arms;
    const TaskLeg& way = plan.legs[leg];
    const Stage stage = stageOf(task);
    const std::vector<const SsvTree*> things = thingsOf(stage);
    const std::size_t links = stage.tree.size();
    const auto placesAt = [&](const std::vector<double>& q)
    {
        std::vector<Eigen::Isometry3d> X_W =
            linkPoses(stage.tree, Eigen::Isometry3d::Identity(), q);
        X_W.push_back(way.carries ? X_W[static_cast<std::size_t>(arms.handRoot(0))] * plan.X_HO
                                  : plan.X_WOStart);
        for (const RigidBody& obstacle : task.obstacles)
        {
            X_W.push_back(obstacle.motion.X_W0);
        }
        return X_W;
    };
    const auto isOfHand = [&](std::size_t link)
    {
        const auto i = static_cast<std::int32_t>(link);
        return (i >= arms.handRoot(0) && i < arms.first[1]) || i >= arms.handRoot(1);
    };
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t i = 0; i <= links; ++i)
    {
        for (std::size_t k = std::max(i + 1, links); things[i] != nullptr && k < things.size(); ++k)
        {
            if (!(way.carries && k == links && isOfHand(i)))
            {
                pairs.emplace_back(i, k);
            }
        }
    }
    pairs.insert(pairs.end(), arms.whole.selfPairs.begin(), arms.whole.selfPairs.end());
    return sampled(way, things, placesAt, pairs, samples);
}
}  // namespace bullet_ccd::grasp
