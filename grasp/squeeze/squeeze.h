/// How hard each joint of a hand has to press so that a grasp holds firmly.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// What a squeeze is for.
struct SqueezeOptions
{
    std::optional<double> mass{};  ///< of the object [kg]
    /// Of the object, W [m]; none: the mean of the contacts.
    std::optional<Eigen::Vector3d> centerOfMass{};
    double friction = 0.5;  ///< Coulomb coefficient
    /// Half of this times its weight may pull in any direction before a contact slips, with fingers
    /// that answer like springs (elastic_hold.h), and the normal forces add up to this times weight
    /// / friction at least, of which two opposite fingers need 1, where the efforts allow it.
    double firmness = 12.0;
    /// Efforts of the independent joints in place of those of the hand [N m or N]; empty: none.
    std::vector<double> efforts{};
};

/// The effort of a motor, and whether it is the robot's own. A motor of several joints (mimic)
/// gives what all of them may bear, each times its multiplier.
struct JointEffort
{
    double limit = 0.0;  ///< [N m or N]
    /// The robot says none, 0, or more than such a joint has: kMostArmTorque for joints that turn,
    /// do not close and carry all that close (wrists, arms), else kMostTorque or kMostForce. Each
    /// joint bears kUsualTorque or kUsualForce then.
    bool isAssumed = false;
    /// Of a position controller that gives each joint its effort at an error of kFullEffortAngle or
    /// kFullEffortWay of that joint [N m/rad or N/m].
    double stiffness = 0.0;
};
inline constexpr double kMostTorque = 8.0;       ///< [N m]
inline constexpr double kMostArmTorque = 400.0;  ///< [N m]
inline constexpr double kMostForce = 500.0;      ///< [N]
inline constexpr double kUsualTorque = 1.0;      ///< [N m]
inline constexpr double kUsualForce = 40.0;      ///< [N]

/// Of a contact point on skins that hardly give way [N/m]: what squeezes and trials count on.
inline constexpr double kSkinStiffness = 2e4;
inline constexpr double kFullEffortAngle = 0.2;  ///< [rad]
inline constexpr double kFullEffortWay = 0.01;   ///< [m]

/// One entry per independent joint (independentJoints()).
[[nodiscard]] BULLET_CCD_API std::vector<JointEffort> jointEfforts(const HandModel& hand);

/// Entries are those of independentJoints().
struct Squeeze
{
    std::string reason;  ///< why there is none; empty: there is one
    std::vector<JointEffort> efforts;
    std::vector<double> torques;          ///< that press the contacts together [N m or N]
    std::vector<double> stiffness;        ///< of the position controller [N m/rad or N/m]
    std::vector<double> targets;          ///< positions that make it press so [rad or m]
    double normalForce = 0.0;             ///< sum over the contacts [N]
    std::vector<Eigen::Vector3d> forces;  ///< on the object, one a contact, W [N]
    /// ElasticHold::weights of the preload that was found, at most half of the firmness.
    double weights = 0.0;

    [[nodiscard]] bool exists() const { return reason.empty(); }
};

/// Finds contact forces that balance each other within the efforts and hold the object in any
/// direction (holdElastically() of force/elastic_hold.h), and the joint torques J^T f and targets
/// q + J^T f / stiffness that give them. The torque of a mimic joint is that of the joint it
/// follows. Targets may lie beyond the limits of a joint.
///
/// There is none if the contacts hold nothing within friction, or if the efforts are too small for
/// 1.2 times weight / friction. `reason` says which.
/// Throws std::invalid_argument without a mass (massOf() of object_mass.h is the usual one), and
/// for a mass or friction that is not positive.
[[nodiscard]] BULLET_CCD_API Squeeze squeezeOf(const HandModel& hand,
                                               const Grasp& grasp,
                                               const SqueezeOptions& options);
}  // namespace bullet_ccd::grasp
