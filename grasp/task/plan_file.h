/// Plans of pick and place as files.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/task/pick_place.h"

#include <filesystem>
#include <iosfwd>

namespace bullet_ccd::grasp
{
/// The plan as one JSON object; README.md in this folder lists its keys.
BULLET_CCD_API void writePlanJson(std::ostream& out,
                                  const PickPlaceTask& task,
                                  const PickPlacePlan& plan);

/// All legs as one trajectory: a row a waypoint, with the columns time [s] and one for each joint
/// that moves by itself.
/// @pre the plan is solved
BULLET_CCD_API void writePlanCsv(std::ostream& out,
                                 const PickPlaceTask& task,
                                 const PickPlacePlan& plan);

/// The same as trajectory_msgs/JointTrajectory in YAML, with velocities and accelerations, so that
/// controllers move as was certified.
/// @pre the plan is solved
BULLET_CCD_API void writePlanYaml(std::ostream& out,
                                  const PickPlaceTask& task,
                                  const PickPlacePlan& plan);

/// An animation of the whole task as binary glTF 2.0: a node a link, the object, the obstacles, all
/// in W, z up turned to glTF's y up. Key frames are `interval` apart [s].
/// @pre the plan is solved
/// Throws std::runtime_error if the file cannot be written.
BULLET_CCD_API void writePlanModel(const PickPlaceTask& task,
                                   const PickPlacePlan& plan,
                                   const std::filesystem::path& file,
                                   double interval = 1.0 / 15.0);

/// Where the links and the object are at a time of the plan [s].
struct TaskState
{
    std::vector<Eigen::Isometry3d> X_W;  ///< of the links of the robot
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
    std::size_t leg = 0;
};
/// @pre the plan is solved
[[nodiscard]] BULLET_CCD_API TaskState stateAt(const PickPlaceTask& task,
                                               const PickPlacePlan& plan,
                                               double time);

/// The smallest distance of two things that the leg moves relative to each other, at samples of
/// each motion between two waypoints [m]; infinite for a leg without a motion. It shares nothing
/// with the certificates: the polynomials and poses are computed anew, and every pair is measured
/// by itself. It is never below the leg's clearance.
/// @pre the plan is solved
[[nodiscard]] BULLET_CCD_API double sampledDistance(const PickPlaceTask& task,
                                                    const PickPlacePlan& plan,
                                                    std::size_t leg,
                                                    int samples);
}  // namespace bullet_ccd::grasp
