/// Plans of tasks as files.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/task/pick_place.h"
#include "grasp/task/two_hands.h"

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

/// One leg as writePlanCsv() writes all of them.
BULLET_CCD_API void writeLegCsv(std::ostream& out, const PickPlaceTask& task, const TaskLeg& leg);

/// The robot as robot.urdf with its meshes (writeUrdf()), and the pairs of its links that are not
/// tested as robot.srdf: what other programs need to read the trajectories. The folder must exist.
/// Throws std::runtime_error if a file cannot be written.
BULLET_CCD_API void writeRobot(const PickPlaceTask& task, const std::filesystem::path& folder);

/// An animation of the whole task as binary glTF 2.0: a node a link, the object, the obstacles, all
/// in W, z up turned to glTF's y up. Key frames are `interval` apart [s].
/// @pre the plan is solved
/// Throws std::runtime_error if the file cannot be written.
BULLET_CCD_API void writePlanModel(const PickPlaceTask& task,
                                   const PickPlacePlan& plan,
                                   const std::filesystem::path& file,
                                   double interval = 1.0 / 15.0);

/// Renders eight moments of the whole arm to a PNG, four a row: before the hand comes straight, at
/// the object, closed on it, lifted, half the way, above its place, put down, drawn back.
/// @pre the plan is solved
BULLET_CCD_API void drawPlan(const PickPlaceTask& task,
                             const PickPlacePlan& plan,
                             const std::filesystem::path& file);

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

// The same for two hands.

BULLET_CCD_API void writeLiftJson(std::ostream& out,
                                  const TwoHandTask& task,
                                  const TwoHandPlan& plan);
/// @pre the plan is solved
BULLET_CCD_API void writeLiftModel(const TwoHandTask& task,
                                   const TwoHandPlan& plan,
                                   const std::filesystem::path& file,
                                   double interval = 1.0 / 15.0);
/// Renders both arms before the hands come straight, closed, and when they have lifted, to a PNG.
/// @pre the plan is solved
BULLET_CCD_API void drawLift(const TwoHandTask& task,
                             const TwoHandPlan& plan,
                             const std::filesystem::path& file);
/// As above; what the object is lifted from counts, what its hands do to each other while they hold
/// it, too, but not how far they are from the object.
[[nodiscard]] BULLET_CCD_API double sampledDistance(const TwoHandTask& task,
                                                    const TwoHandPlan& plan,
                                                    std::size_t leg,
                                                    int samples);
}  // namespace bullet_ccd::grasp
