/// Closings repeated from poses that are a little off and on coarser meshes, by several methods.
#pragma once

#include "benchmarks/closing/closing_run.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/grasp_types.h"

#include <nlohmann/json_fwd.hpp>

namespace bullet_ccd::benchmarks
{
/// An error of a pose: a shift by exactly `magnitude` [m] and a turn by exactly as many radians
/// about `center`, each in a direction that is uniform over all. The same seed gives the same two
/// directions for every magnitude.
[[nodiscard]] Eigen::Isometry3d poseError(std::uint64_t seed,
                                          double magnitude,
                                          const Eigen::Vector3d& center);

/// Where the approach to a grasp began, and its way up to the grasp. Throws std::invalid_argument
/// if the hand has no such preshape.
[[nodiscard]] ClosingStart startOf(const grasp::HandModel& hand, const grasp::Grasp& grasp);

/// The same, seen by a hand that is where `error` puts it.
[[nodiscard]] ClosingStart moved(ClosingStart start, const Eigen::Isometry3d& error);

/// Moves the hand from its start along its shift until the method sees a contact, closes there once
/// and scores what it holds. A grasp that was not closed has no positions.
struct GraspMethod
{
    std::string name;
    std::function<grasp::Grasp(const ClosingStart&)> run;
};

/// Ours at its usual tolerance and at 0.1 um; the discrete baseline at GraspIt!'s steps (10 mm,
/// 0.01 rad, contact within 0.1 mm), and at a tenth of them with contact within our tolerance.
/// Refers to both arguments.
[[nodiscard]] std::vector<GraspMethod> graspMethods(const grasp::HandModel& hand,
                                                    const grasp::GraspObject& object);

/// How a closing differs from another: "closed" (both were; else the differences are 0), "posture"
/// (postureDifference()), "sameLinks" (the very links touch), "shift" (mean distance of a contact
/// to the nearest one of its link [m]), "epsilon" (|change|); and of `other` alone "contacts" and
/// "success" (force closure and no penetration).
[[nodiscard]] nlohmann::json changeOf(const grasp::HandModel& hand,
                                      const grasp::Grasp& reference,
                                      const grasp::Grasp& other);

/// An object of 1024 * 4^level triangles, all vertices on the same smooth surface: "egg", "block",
/// "bottle" or "ring". Throws std::invalid_argument for another name.
[[nodiscard]] TriangleMesh meshOfFamily(const std::string& family, int level);
}  // namespace bullet_ccd::benchmarks
