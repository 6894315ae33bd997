/// Pick and place: an arm with a hand takes an object and puts it down elsewhere, and every motion
/// on the way is certified as a whole.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/math/stop_condition.h"
#include "bullet_ccd/trajectory/trajectory.h"
#include "grasp/planner/grasp_planner.h"
#include "grasp/quality/object_mass.h"
#include "grasp/task/arm_robot.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// A level rectangle on which objects can be put down, in W [m].
struct TargetRegion
{
    Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< on the surface
    Eigen::Vector2d size =
        Eigen::Vector2d::Zero();  ///< along x and y; the object's middle is in it
};

/// What is to be done. All that is referred to must outlive the query. Gravity points along -z of
/// W.
struct PickPlaceTask
{
    const HandModel& hand;
    const ArmRobot& robot;
    Eigen::Isometry3d X_WR = Eigen::Isometry3d::Identity();  ///< root of the arm
    std::vector<double> start;  ///< one entry for each of robot.joints [rad or m]
    const GraspObject& object;
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
    std::span<const RigidBody> obstacles;  ///< all else, at rest
    std::vector<std::string> obstacleNames;
    TargetRegion target;
};

struct PickPlaceOptions
{
    /// Of the first round; as many more are pinches (ApproachSource::Pinch).
    PlannerOptions grasps{
        .candidates = 40, .approach = {.source = ApproachSource::Mixed}, .volumes = 0};
    int graspsTried = 40;   ///< the firmest that are tried
    double approach = 0.1;  ///< way of the hand straight to the object, and back [m]
    double lift = 0.1;      ///< way of the object up, and down to its new place [m]
    /// Between the object and what it rests on [m]. An object that is nearer is raised by what is
    /// missing before anything is planned, and put down at this distance.
    double gap = 1e-4;
    /// Kept to all that is not to be touched [m]: by the open hand to the object when it arrives
    /// and leaves, and on all ways but those of the object to and from what it stands on.
    /// Where there is room, ways of the arm keep five times as much, or half of that.
    double margin = 2e-3;
    double firmness = 12.0;  ///< SqueezeOptions::firmness
    /// Where no grasp leads to a plan with the object put down as it stood, turned about the
    /// vertical only, it may also stand on another face of its convex hull (stablePoses()).
    bool placesOnOtherFaces = true;
    /// Grasps that do not hold so many times grasps.mass by their squeeze are not tried.
    double holds = 2.0;
    /// Says why a grasp that is within reach is not to be tried, or nothing: rehearsal() in
    /// trial/plan_execution.h asks a simulation.
    std::function<std::string(const Grasp&)> objection{};
    double acceleration = 3.0;  ///< of every joint at most [rad/s^2 or m/s^2]
    double freeSpeed = 1.0;     ///< of joints without a limit [rad/s or m/s]
    std::uint64_t seed = 1;
    StopCondition stop{};  ///< when it is due, the search ends without a plan
};

/// One motion. The joints come to rest at every waypoint and move linearly from one to the next, by
/// a polynomial of fifth degree in time: velocities and accelerations of all waypoints are zero,
/// and trajectoryThrough() gives the motion.
struct TaskLeg
{
    std::string name;  ///< transit, approach, close, lift, carry, place, open, retreat or return
    bool carries = false;  ///< the object moves with the hand
    std::vector<Waypoint>
        waypoints;  ///< one entry per link of the robot; times of the whole task [s]
    /// Certified: nothing that is tested comes nearer [m]; kEnoughClearance if all is farther away.
    double clearance = 0.0;
};
inline constexpr double kEnoughClearance = 0.02;

/// Where the links and the object are at a time of the plan [s].
struct TaskState
{
    std::vector<Eigen::Isometry3d> X_W;  ///< of the links of the robot
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
    std::size_t leg = 0;
};

/// A grasp that was tried, and what stood in its way.
struct TaskAttempt
{
    std::int64_t candidate = 0;
    std::string leg;     ///< reach, rehearsal, or as TaskLeg::name; empty: it is the plan
    std::string reason;  ///< with the names of the links and obstacles that touch
};

struct PickPlacePlan
{
    bool solved = false;
    bool stopped = false;            ///< PickPlaceOptions::stop ended the search
    std::string failure;             ///< why there is no plan
    std::int64_t forceClosures = 0;  ///< among the candidates
    std::vector<TaskAttempt> attempts;
    /// In the object's frame; the hand is where the arm brings it to, and quality.largestMass is
    /// what its squeeze holds.
    Grasp grasp;
    ObjectMass mass;  ///< that grasps had to hold, and what it follows from
    Eigen::Isometry3d X_HO = Eigen::Isometry3d::Identity();  ///< object in the hand's root link
    Eigen::Isometry3d X_WOStart = Eigen::Isometry3d::Identity();  ///< raised by the gap
    Eigen::Isometry3d X_WOEnd = Eigen::Isometry3d::Identity();
    /// How far the object falls from where it was given until it is as near as
    /// PickPlaceOptions::gap to what is below it [m]; infinite if nothing is.
    double startHeight = 0.0;
    /// What the object stands on, as far as it touches it where it was given. It is lifted from
    /// there, too: see the guarantee of planPickPlace().
    std::vector<std::string> partsFrom;
    std::vector<TaskLeg> legs;
};

/// Plans the task. Grasps are planned among the obstacles and tried best first; of each, several
/// postures of the arm and several places in the target. Where a leg fails, its reason is recorded.
/// Those that fail once the object is lifted are tried again with the object put down on other
/// faces. If none of the first candidates can be carried out, 3, 9 and 27 times as many are
/// planned.
/// Straight ways for which there is no room are halved, and halved again.
///
/// Guarantee: every leg of a plan is certified by trajectoryToi() as it is timed: no link and no
/// carried object comes within a micrometre of anything that it moves relative to, except that
/// while the hand closes and opens, its links and the object come within the closing tolerance.
/// Speeds stay below the limits of the joints. The legs are those of the object where it is raised.
/// From where it was given the lift is certified, too: without the triangles with which it and what
/// it stands on touch, until the first waypoint, up to which they are shown to part. Throws
/// std::invalid_argument if the object intersects an obstacle or is inside one where it starts, the
/// arm does at its start, the sizes do not fit, or a number is not finite.
[[nodiscard]] BULLET_CCD_API PickPlacePlan planPickPlace(const PickPlaceTask& task,
                                                         const PickPlaceOptions& options = {});

/// Where the object is at the end of the first `leg` legs, and while leg `leg` begins; for a leg
/// that carries it, it is the hand's pose times X_HO at all times.
[[nodiscard]] BULLET_CCD_API const Eigen::Isometry3d& restingPose(const PickPlacePlan& plan,
                                                                  std::size_t leg);
}  // namespace bullet_ccd::grasp
