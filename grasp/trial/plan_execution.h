/// Does a plan of pick and place work out? It is carried out in a Bullet world by an arm and a hand
/// whose joints are driven by position controllers of limited effort.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/math/stop_condition.h"
#include "grasp/squeeze/squeeze.h"
#include "grasp/task/pick_place.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
struct ExecutionOptions
{
    std::optional<double> mass{};  ///< of the object [kg]; none: massOf() its volume
    double friction = 0.5;         ///< Coulomb coefficient of all pairs
    double firmness = 12.0;        ///< PickPlaceOptions::firmness
    /// One entry per obstacle [kg]: those above 0 are free; empty: all are fixed.
    std::vector<double> obstacleMasses{};
    double rate = 240.0;                    ///< steps per second
    double skin = 1e-3;                     ///< as TrialOptions::skin [m]
    double skinStiffness = kSkinStiffness;  ///< as TrialOptions::skinStiffness [N/m]
    double placeTolerance = 0.01;   ///< of the object's centre of mass from where it is to be [m]
    double othersTolerance = 5e-3;  ///< that no free obstacle moves farther than [m]
    StopCondition stop{};           ///< looked at before every step
};

struct ExecutionResult
{
    bool succeeded = false;
    bool stopped = false;        ///< ExecutionOptions::stop ended it: it says nothing
    std::string reason;          ///< why not, and the leg during which the object went astray
    double missed = 0.0;         ///< how far the object's centre of mass is from its place [m]
    double othersMoved = 0.0;    ///< the farthest way of a free obstacle [m]
    double leastDistance = 0.0;  ///< of what may not intersect, at 60 samples a second [m]
    double grip = 0.0;           ///< sum of the normal forces that the squeeze is made for [N]
    double seconds = 0.0;        ///< of simulated time
    double inexact = 0.0;        ///< share of the solver's answers that are not exact
};

/// For PickPlaceOptions::objection: the hand alone closes on the object where it stands, squeezes,
/// lifts it by 10 cm, and it is pulled sideways by half its weight. All rub by 0.8 of the friction,
/// and the object must not turn by more than 4 degrees or slip by more than 3 mm. The answer says
/// what it did instead.
/// @param task      must outlive the answer
[[nodiscard]] BULLET_CCD_API std::function<std::string(const Grasp&)> rehearsal(
    const PickPlaceTask& task, const ExecutionOptions& options = {});

/// The legs of the plan are followed as they are timed. After the hand has closed it squeezes
/// (squeeze.h) for half a second, and lets go for a quarter before it opens; a second after the end
/// the result is judged: the object is within `placeTolerance` of its place, no free obstacle has
/// moved farther than `othersTolerance`, and at no sample did two bodies or links intersect that
/// the plan tests. The weight of the arm is taken as compensated by its controller. A joint without
/// effort in the URDF has kUsualTorque or kUsualForce.
///
/// Deterministic: the same arguments give the same bits.
/// @pre the plan is solved
/// Throws std::invalid_argument for sizes that do not fit and numbers out of range.
[[nodiscard]] BULLET_CCD_API ExecutionResult executePlan(const PickPlaceTask& task,
                                                         const PickPlacePlan& plan,
                                                         const ExecutionOptions& options = {});
}  // namespace bullet_ccd::grasp
