/// Certified paths of an arm from one configuration to another, by RRT-Connect.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/math/stop_condition.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// What moves among what. All is referred to and must outlive the query.
struct JointProblem
{
    ArticulatedBody body;  ///< its motion is not used
    const Environment* environment = nullptr;
    std::span<const std::int32_t> joints{};  ///< the links below the joints that are planned
    std::vector<double> positions{};         ///< of all joints, one entry per link [rad or m]
    Eigen::Isometry3d X_WR = Eigen::Isometry3d::Identity();
    ToiOptions toi{};
};

struct JointPathOptions
{
    int iterations = 4000;  ///< of RRT-Connect
    int shortcuts = 80;     ///< tries to make the path shorter
    std::uint64_t seed = 1;
    StopCondition stop{};  ///< ends the search
};

using JointPositions = std::vector<double>;  ///< one entry per planned joint

/// Waypoints between which the joints move linearly, or why there are none.
struct JointPathResult
{
    std::vector<JointPositions> waypoints;
    std::string failure;
};

/// Guarantee: every motion between waypoints is certified, after the shortcuts, too
/// (CertifiedRobot::isFreeMotion()).
/// Throws std::invalid_argument as CertifiedRobot does.
[[nodiscard]] BULLET_CCD_API JointPathResult planJointPath(const JointProblem& problem,
                                                           const JointPositions& from,
                                                           const JointPositions& to,
                                                           const JointPathOptions& options = {});
}  // namespace bullet_ccd::grasp
