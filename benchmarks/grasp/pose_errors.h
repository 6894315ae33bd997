/// Grasps that are repeated with the pose a little off, by several methods.
#pragma once

#include "grasp/planner/grasp_planner.h"
#include "tools/grasp_cli/inputs/catalogue.h"

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// An error of a pose: a shift by exactly `magnitude` [m] and a turn by exactly as many radians
/// about `center`, each in a direction that is uniform over all. The same seed gives the same two
/// directions for every magnitude.
[[nodiscard]] Eigen::Isometry3d poseError(std::uint64_t seed,
                                          double magnitude,
                                          const Eigen::Vector3d& center);

/// Moves the hand from its start along the shift until the method sees a contact, closes there once
/// and scores what it holds. A grasp that was not closed has no positions.
struct GraspMethod
{
    std::string name;
    std::function<grasp::Grasp(const Eigen::Isometry3d& X_WStart, const Eigen::Vector3d& shift)>
        run;
};

/// Ours at its usual tolerance and at 0.1 um; the discrete baseline at GraspIt!'s steps (10 mm,
/// 0.01 rad, contact within 0.1 mm), and at a tenth of them with contact within our tolerance.
/// Refers to all arguments.
[[nodiscard]] std::vector<GraspMethod> graspMethods(const grasp::HandModel& hand,
                                                    const grasp::GraspObject& object,
                                                    const grasp::Preshape& preshape);

/// Repeats the first two force closures of a plan by every method, without an error and five times
/// with each of 1e-6 to 1e-3 m and rad, and compares each with itself without the error.
/// @return a row of the log
[[nodiscard]] nlohmann::json judgePoseErrors(const tools::LoadedHand& hand,
                                             const tools::LoadedObject& object,
                                             const grasp::PlannerOptions& options);

/// Prints a line per method and size of the error over all rows.
/// @return whether there was a force closure to repeat
[[nodiscard]] bool summarizePoseErrors(const std::vector<nlohmann::json>& rows);
}  // namespace bullet_ccd::benchmarks
