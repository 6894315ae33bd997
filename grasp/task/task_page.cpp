#include "grasp/task/task_page.h"

#include "grasp/report/grasp_scene.h"
#include "grasp/report/motion_page.h"
#include "grasp/report/report_facts.h"

#include <cmath>
#include <functional>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kPageInterval = 1.0 / 12.0;  // [s]

TaskMotion motionOf(const Stage& stage,
                    double duration,
                    const std::function<TaskState(double)>& at,
                    double interval)
{
    TaskMotion motion;
    std::vector<MotionTrack>& tracks = motion.tracks;
    for (std::size_t i = 0; i < stage.obstacles.size(); ++i)
    {
        tracks.push_back({.name = stage.obstacleNames[i],
                          .tree = stage.obstacles[i].tree,
                          .color = kObstacleColor,
                          .poses = {stage.obstacles[i].motion.X_W0},
                          .kind = "surroundings"});
    }
    const std::size_t obstacles = tracks.size();
    for (std::size_t link = 0; link < stage.tree.size(); ++link)
    {
        tracks.push_back({.name = stage.tree.links[link].name,
                          .tree = stage.linkTrees[link],
                          .color = Color(0.36F, 0.47F, 0.62F),
                          .poses = {},
                          .kind = "robot"});
    }
    tracks.push_back({.name = "object: " + stage.object.name,
                      .tree = &stage.object.tree,
                      .color = kObjectColor,
                      .poses = {},
                      .kind = "object"});
    const auto frames = static_cast<int>(std::ceil(duration / interval));
    for (int i = 0; i <= frames; ++i)
    {
        const double time = frames > 0 ? duration * i / frames : 0.0;
        const TaskState state = at(time);
        motion.times.push_back(static_cast<float>(time));
        for (std::size_t link = 0; link < state.X_W.size(); ++link)
        {
            tracks[obstacles + link].poses.push_back(state.X_W[link]);
        }
        tracks.back().poses.push_back(state.X_WO);
    }
    std::erase_if(tracks, [](const MotionTrack& track) { return track.tree == nullptr; });
    return motion;
}

double durationOf(const std::vector<TaskLeg>& legs)
{
    return legs.back().waypoints.back().time;
}

PageTable legsTable(const std::vector<TaskLeg>& legs)
{
    PageTable table{
        .title = "Motions, each certified as a whole",
        .header = {"leg", "from [s]", "to [s]", "waypoints", "nothing nearer than [mm]"},
        .rows = {}};
    for (const TaskLeg& leg : legs)
    {
        table.rows.push_back({leg.name,
                              fixed(leg.waypoints.front().time, 2),
                              fixed(leg.waypoints.back().time, 2),
                              std::to_string(leg.waypoints.size()),
                              leg.clearance >= kEnoughClearance
                                  ? "at least " + fixed(1e3 * kEnoughClearance, 0)
                                  : fixed(1e3 * leg.clearance, 3)});
    }
    return table;
}

PageTable sceneTable(const Stage& stage, const Eigen::Isometry3d& X_WO)
{
    PageTable table{.title = "The scene",
                    .header = {"what", "x [m]", "y [m]", "z [m]", "size of its box [m]"},
                    .rows = {}};
    const auto add = [&](const std::string& name, const SsvTree& tree, const Eigen::Isometry3d& X)
    {
        const Eigen::Vector3d size = bounds(tree.mesh()).sizes();
        const Eigen::Vector3d p = X.translation();
        table.rows.push_back(
            {name,
             fixed(p.x(), 3),
             fixed(p.y(), 3),
             fixed(p.z(), 3),
             fixed(size.x(), 3) + " × " + fixed(size.y(), 3) + " × " + fixed(size.z(), 3)});
    };
    add(stage.object.name + ": is taken", stage.object.tree, X_WO);
    for (std::size_t i = 0; i < stage.obstacles.size(); ++i)
    {
        add(stage.obstacleNames[i], *stage.obstacles[i].tree, stage.obstacles[i].motion.X_W0);
    }
    return table;
}

PageTable factsTable(const TaskPageExtras& extras)
{
    PageTable table{.title = "The plan", .header = {}, .rows = {}};
    for (const auto& [name, value] : extras.facts)
    {
        table.rows.push_back({name, value});
    }
    return table;
}

/// What both kinds of plans share.
template <typename Task, typename Plan>
MotionPage pageOf(const Task& task,
                  const Plan& plan,
                  const std::string& title,
                  PageTable facts,
                  PageTable attempts,
                  const TaskPageExtras& extras)
{
    TaskMotion motion = motionOf(task, plan, kPageInterval);
    MotionPage page{.title = title,
                    .subtitle = plan.solved ? "Planned: " + fixed(durationOf(plan.legs), 1) +
                                                  " s, " + std::to_string(plan.legs.size()) +
                                                  " motions, each certified"
                                            : "No plan: " + plan.failure,
                    .isGood = plan.solved,
                    .tables = {},
                    .files = extras.files,
                    .times = std::move(motion.times),
                    .tracks = std::move(motion.tracks),
                    .stages = {}};
    page.tables.push_back(std::move(facts));
    if (plan.solved)
    {
        for (const TaskLeg& leg : plan.legs)
        {
            page.stages.emplace_back(leg.name, leg.waypoints.front().time);
        }
        page.tables.push_back(legsTable(plan.legs));
    }
    page.tables.push_back(std::move(attempts));
    page.tables.push_back(sceneTable(stageOf(task), plan.X_WOStart));
    return page;
}
}  // namespace

Stage stageOf(const PickPlaceTask& task)
{
    return {task.robot.tree, task.robot.linkTrees, task.object, task.obstacles, task.obstacleNames};
}

Stage stageOf(const TwoHandTask& task)
{
    return {task.arms.whole.robot.tree,
            task.arms.whole.linkTrees,
            task.object,
            task.obstacles,
            task.obstacleNames};
}

TaskMotion motionOf(const PickPlaceTask& task, const PickPlacePlan& plan, double interval)
{
    if (plan.solved)
    {
        return motionOf(
            stageOf(task),
            durationOf(plan.legs),
            [&](double time) { return stateAt(task, plan, time); },
            interval);
    }
    const KinematicTree& tree = task.robot.tree;
    std::vector<double> positions(tree.size(), 0.0);
    std::ranges::copy(task.hand.preshapes.front().positions,
                      positions.begin() + task.robot.handRoot);
    for (std::size_t k = 0; k < task.start.size(); ++k)
    {
        positions[static_cast<std::size_t>(task.robot.joints[k])] = task.start[k];
    }
    applyMimics(tree, positions);
    const TaskState start{.X_W = linkPoses(tree, task.X_WR, positions), .X_WO = task.X_WO};
    return motionOf(
        stageOf(task), 0.0, [&](double) { return start; }, interval);
}

TaskMotion motionOf(const TwoHandTask& task, const TwoHandPlan& plan, double interval)
{
    if (plan.solved)
    {
        return motionOf(
            stageOf(task),
            durationOf(plan.legs),
            [&](double time) { return stateAt(task, plan, time); },
            interval);
    }
    const TwoArms& arms = task.arms;
    const std::vector<double> positions =
        arms.positions(task.start,
                       {arms.arms[0].hand->preshapes.front().positions,
                        arms.arms[1].hand->preshapes.front().positions});
    const TaskState start{
        .X_W = linkPoses(arms.whole.robot.tree, Eigen::Isometry3d::Identity(), positions),
        .X_WO = task.X_WO};
    return motionOf(
        stageOf(task), 0.0, [&](double) { return start; }, interval);
}

void writeTaskPage(const PickPlaceTask& task,
                   const PickPlacePlan& plan,
                   const TaskPageExtras& extras,
                   const std::filesystem::path& file)
{
    PageTable facts = factsTable(extras);
    facts.rows.push_back(
        {"force closures among the candidates", std::to_string(plan.forceClosures)});
    if (plan.solved)
    {
        facts.rows.push_back({"grasp",
                              "candidate " + std::to_string(plan.grasp.candidate) + ", epsilon " +
                                  fixed(plan.grasp.quality.epsilon, 3)});
        facts.rows.push_back({"mass", massText(plan.mass)});
    }
    PageTable attempts{
        .title = "Grasps that were tried", .header = {"candidate", "failed at", "why"}, .rows = {}};
    for (const TaskAttempt& attempt : plan.attempts)
    {
        attempts.rows.push_back({std::to_string(attempt.candidate),
                                 attempt.leg.empty() ? "is the plan" : attempt.leg,
                                 attempt.reason});
    }
    writeMotionPage(pageOf(task,
                           plan,
                           "Moving " + task.object.name + ": " + task.robot.name,
                           std::move(facts),
                           std::move(attempts),
                           extras),
                    extras.viewer,
                    extras.picture,
                    file);
}

void writeTaskPage(const TwoHandTask& task,
                   const TwoHandPlan& plan,
                   const TaskPageExtras& extras,
                   const std::filesystem::path& file)
{
    PageTable facts = factsTable(extras);
    facts.rows.push_back({"robot", task.arms.whole.robot.name});
    facts.rows.push_back({"mass", massText(plan.mass)});
    facts.rows.push_back({"pairs of grasps that are force closures", std::to_string(plan.pairs)});
    if (plan.solved)
    {
        const TwoHandForces& forces = plan.forces;
        facts.rows.push_back({"epsilon",
                              "left hand alone " + fixed(plan.aloneEpsilon[0], 3) +
                                  ", right hand alone " + fixed(plan.aloneEpsilon[1], 3) +
                                  ", both " + fixed(plan.grasp.quality.epsilon, 3)});
        facts.rows.push_back({"normal forces that carry the weight",
                              "left " + fixed(forces.normal[0], 1) + " N, right " +
                                  fixed(forces.normal[1], 1) + " N, at most " +
                                  fixed(1e2 * forces.effort, 1) + " % of an effort"});
        facts.rows.push_back({"squeeze",
                              fixed(forces.squeeze, 0) +
                                  " N, of which the hands press towards each "
                                  "other with " +
                                  fixed(forces.internal, 0) + " N"});
    }
    PageTable attempts{.title = "Pairs that were tried",
                       .header = {"left", "right", "failed at", "why"},
                       .rows = {}};
    for (const PairAttempt& attempt : plan.attempts)
    {
        attempts.rows.push_back({std::to_string(attempt.candidates[0]),
                                 std::to_string(attempt.candidates[1]),
                                 attempt.leg.empty() ? "is the plan" : attempt.leg,
                                 attempt.reason});
    }
    writeMotionPage(pageOf(task,
                           plan,
                           "Two hands on " + task.object.name,
                           std::move(facts),
                           std::move(attempts),
                           extras),
                    extras.viewer,
                    extras.picture,
                    file);
}
}  // namespace bullet_ccd::grasp
