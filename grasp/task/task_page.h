/// Plans of tasks as a page: the scene in three dimensions, moving as planned, and tables.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/report/grasp_model.h"
#include "grasp/task/pick_place.h"
#include "grasp/task/two_hands.h"

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
/// What moves, among what.
struct Stage
{
    const KinematicTree& tree;
    const std::vector<const SsvTree*>& linkTrees;
    const GraspObject& object;
    std::span<const RigidBody> obstacles;
    const std::vector<std::string>& obstacleNames;
};
[[nodiscard]] Stage stageOf(const PickPlaceTask& task);
[[nodiscard]] Stage stageOf(const TwoHandTask& task);

/// Obstacles, links and the object: where they are at each time [s].
struct TaskMotion
{
    std::vector<float> times;
    std::vector<MotionTrack> tracks;
};
/// The whole plan, at times that are about `interval` apart [s]; without a plan all at the start.
[[nodiscard]] TaskMotion motionOf(const PickPlaceTask& task,
                                  const PickPlacePlan& plan,
                                  double interval);
[[nodiscard]] TaskMotion motionOf(const TwoHandTask& task,
                                  const TwoHandPlan& plan,
                                  double interval);

struct TaskPageExtras
{
    std::filesystem::path viewer;  ///< the template; empty: a page with `picture`
    std::string picture;           ///< in the folder of the page; empty: none
    std::vector<std::string> files;
    std::vector<std::pair<std::string, std::string>> facts;  ///< in front of those of the plan
};

/// The legs with their certified clearances, the grasps that were tried and why they failed, what
/// stands in the scene, and, in three dimensions, all of it moving. Without a plan the scene stands
/// as the task begins.
/// Throws std::runtime_error "<file>: <what>: <remedy>".
BULLET_CCD_API void writeTaskPage(const PickPlaceTask& task,
                                  const PickPlacePlan& plan,
                                  const TaskPageExtras& extras,
                                  const std::filesystem::path& file);

BULLET_CCD_API void writeTaskPage(const TwoHandTask& task,
                                  const TwoHandPlan& plan,
                                  const TaskPageExtras& extras,
                                  const std::filesystem::path& file);
}  // namespace bullet_ccd::grasp
