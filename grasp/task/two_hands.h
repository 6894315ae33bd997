/// Two hands on one object: pairs of grasps of which neither holds it alone, reached by two arms at
/// once.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/squeeze/squeeze.h"
#include "grasp/task/pick_place.h"
#include "grasp/task/two_arms.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// What is to be lifted. All that is referred to must outlive the query. Gravity points along -z of
/// W.
struct TwoHandTask
{
    const TwoArms& arms;
    std::array<std::vector<double>, 2> start;  ///< of the arms' joints [rad or m]
    const GraspObject& object;
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
    std::span<const RigidBody> obstacles;  ///< all else, at rest
    std::vector<std::string> obstacleNames;
};

/// Two candidates that were tried together, and what stood in their way.
struct PairAttempt
{
    std::array<std::int64_t, 2> candidates{};
    std::string leg;  ///< squeeze, simulation, or as TaskLeg::name; empty: it is the plan
    std::string reason;
};

/// What carries the weight of the object, and how hard the hands press towards each other.
struct TwoHandForces
{
    /// Sums of the normal forces of each hand in the least forces that carry the weight [N].
    std::array<double, 2> normal{};
    double effort = 0.0;  ///< the largest share of its effort that a joint needs for them
    /// Resultant of the left hand in the squeeze, which that of the right hand balances [N].
    double internal = 0.0;
    double squeeze = 0.0;  ///< sum of all normal forces of the squeeze [N]
};

struct TwoHandPlan
{
    bool solved = false;
    bool stopped = false;  ///< PickPlaceOptions::stop ended the search
    std::string failure;   ///< why there is no plan
    /// Among the candidates of each arm: that touch but hold nothing alone, and of these those that
    /// the arm can bring the hand to and lift from.
    std::array<std::int64_t, 2> touching{};
    std::array<std::int64_t, 2> reached{};
    std::int64_t singleHanded = 0;  ///< candidates that are force closures alone: not used
    std::int64_t pairs = 0;         ///< force closures of two hands together
    std::vector<PairAttempt> attempts;
    /// In the object's frame, as of one hand (TwoArms::whole): contacts of both.
    Grasp grasp;
    std::array<double, 2> aloneEpsilon{};  ///< of the contacts of each hand
    Squeeze squeeze;                       ///< of all joints
    TwoHandForces forces;
    ObjectMass mass;
    Eigen::Isometry3d X_WOStart = Eigen::Isometry3d::Identity();  ///< raised by the gap
    Eigen::Isometry3d X_HO = Eigen::Isometry3d::Identity();  ///< object in the left hand's root
    std::vector<TaskLeg> legs;  ///< transit, approach, close and lift; all links of `whole`
};

struct TwoHandOptions
{
    /// Of grasps, ways and limits; all but `objection`. The object is raised by `gap`. Candidates
    /// come against the surface: a mixed source would go where one hand alone holds the object.
    PickPlaceOptions common{
        .grasps = {.candidates = 80, .approach = {.source = ApproachSource::Surface}, .volumes = 0},
        .graspsTried = 20,
        .lift = 0.2,
        .gap = 1e-3};
    /// Says why a plan is not good enough, or nothing: a simulation, for example.
    std::function<std::string(const TwoHandPlan&)> objection{};
};

/// Candidates are planned as for one hand. Those that touch the object and are no force closure are
/// taken together, one of each arm, where their contacts are one. Such pairs are tried by epsilon:
/// the squeeze of all joints of both arms and hands must hold `holds` times the weight whichever
/// way it pulls; then both hands come straight at once, close at once, and lift.
///
/// Guarantee: every leg is certified by trajectoryToi() as it is timed, with both arms moving: no
/// link and, while it is lifted, no part of the object comes within a micrometre of anything that
/// it moves relative to; the object is taken to move with the left hand, and what the right hand
/// does to it is not looked at then. Between two waypoints of the lift the hands move towards each
/// other by no more than the arms' way off the straight line.
/// Throws std::invalid_argument for sizes that do not fit, numbers that are not finite, an object
/// that intersects an obstacle and arms that touch where they start.
[[nodiscard]] BULLET_CCD_API TwoHandPlan planTwoHands(const TwoHandTask& task,
                                                      const TwoHandOptions& options = {});

/// Where the links and the object are at a time of the plan [s].
/// @pre the plan is solved
[[nodiscard]] BULLET_CCD_API TaskState stateAt(const TwoHandTask& task,
                                               const TwoHandPlan& plan,
                                               double time);
}  // namespace bullet_ccd::grasp
