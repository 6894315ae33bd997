/// Simulated trials: does a grasp hold?
///
/// The hand squeezes (squeeze.h): its joints are driven by position controllers of limited effort,
/// and the object is free. From a start with the open hand, the joints close within 1 s by a tenth
/// of the squeeze's torques until they stop (or TrialOptions::closesAsPlanned). Then, and from a
/// start at the closed posture, the squeeze grows in 0.25 s and the object may come to rest for up
/// to 1 s more. Then the protocol (protocol.h) loads it.
///
/// Surfaces are covered by skins: they rest on each other at the gap `skin`, and what is compressed
/// is the gap alone, so the meshes never meet. A contact point gives way by its force over
/// `skinStiffness` (less and less the deeper it is), so that features which are almost as near as
/// the first one share the load, as they do on the pads of fingers, and as the planner's contacts
/// do. The default is about that of 3 mm of soft rubber (1 MPa) on 1 cm^2 over a few points.
///
/// Brief trials (TrialOptions::brief) cut a phase of constant load short where the object, at its
/// pace of the last 0.1 s, would move on by less than 1 mm and 1 degree, and stay within what
/// counts as held, to the end of the phase: that time passes without being simulated.
///
/// Outcomes are
///     Held            moved by at most the protocol's heldWay and heldTurn since the load began;
///     Dropped         moved by more than its lostWay;
///     Slipped         what is between, and of pulls what moved by more than heldWay or heldTurn;
///     Ejected         lost before the load began;
///     NeverTouched    no contact pressed on it before the load began;
///     NotSettled      it still moved when the load should have begun, or does not stand by itself;
///     NoSqueeze       there are no torques to hold it with;
///     Stopped         the caller ended the trial (TrialOptions::stop): pulls that ended before
///                     are in the result, the rest of it says nothing.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/math/stop_condition.h"
#include "grasp/check/penetration_check.h"
#include "grasp/squeeze/squeeze.h"
#include "grasp/trial/protocol.h"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bullet_ccd::grasp
{
enum class TrialOutcome : std::uint8_t
{
    Held,
    Slipped,
    Dropped,
    Ejected,
    NeverTouched,
    NotSettled,
    NoSqueeze,
    Stopped,
};
[[nodiscard]] BULLET_CCD_API const char* toString(TrialOutcome outcome);

/// How a trial looks after a step to a viewer at rest, who sees the hand lift and shake.
struct TrialFrame
{
    std::string_view stage;  ///< "stand" (on the table), "close", "squeeze" or "load"
    double time = 0.0;       ///< since the trial, or its pull, began [s]
    Eigen::Isometry3d X_WH = Eigen::Isometry3d::Identity();  ///< of the root link
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();  ///< of the object's mesh frame
    std::vector<double> positions{};                         ///< one entry per link [rad or m]
    bool touches = false;                                    ///< a link presses on the object
};

struct TrialOptions
{
    /// Also the mass of the trial; none: massOf() the object's volume.
    SqueezeOptions squeeze{};
    /// Of the surfaces; without it that which the squeeze counts on.
    std::optional<double> friction{};
    /// Steps per second, 60 or more. Outcomes at 120, 240 and 480 are as good as the same.
    double rate = 120.0;
    Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< for the object, in its frame, of any length
    std::uint64_t seed = 1;                         ///< of errors of the pose
    double skin = 1e-3;                             ///< [m]
    double skinStiffness = kSkinStiffness;  ///< of a contact point that hardly gives way [N/m]
    bool brief = false;                     ///< cut what hardly moves short
    /// From a start with the open hand joints go where the grasp has them and stay there until the
    /// squeeze, as those of a robot that follows a plan do. Else each goes on until something stops
    /// it, and what stands loosely is pushed along by the finger that comes first.
    bool closesAsPlanned = false;
    /// The independent check of this hand and object, used again from trial to trial by one thread
    /// at a time; null: the trial makes its own.
    PenetrationCheck* check = nullptr;
    StopCondition stop{};                            ///< looked at before every step
    std::function<void(const TrialFrame&)> watch{};  ///< is called after every step
};

/// What one pull came to.
struct TrialPull
{
    Wrench wrench = Wrench::Zero();  ///< as in the phase, of length 1
    /// At which the object slipped, or the largest that was tried: the force, or the moment over
    /// the radius, along the wrench [N].
    double size = 0.0;
    double share = 0.0;  ///< size over the sum of normal forces then: what epsilon bounds
    bool slipped = false;
};

struct TrialResult
{
    TrialOutcome outcome = TrialOutcome::NoSqueeze;
    std::string reason;       ///< of every outcome but Held
    double slip = 0.0;        ///< largest way of the centre of mass under load [m]
    double turn = 0.0;        ///< largest turn of the object under load [rad]
    double lostAt = 0.0;      ///< since the trial began, of Dropped and Ejected [s]
    double peakForce = 0.0;   ///< largest normal force of a contact point [N]
    double meanForce = 0.0;   ///< of all normal forces together, over the time under load [N]
    double peakEnergy = 0.0;  ///< kinetic, of the object under load [J]
    std::vector<double> peakTorques{};  ///< one entry per independent joint [N m or N]
    std::vector<double> meanTorques{};  ///< their sizes in the mean over the time under load, same
    std::vector<TrialPull> pulls{};     ///< one entry per pull that ended
    /// Where the object's mesh frame was in W, as seen from the hand: when it had first moved by
    /// more than heldWay or heldTurn under load, else at the end.
    Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
    /// The worst of what the independent check found at the end of every second.
    PenetrationReport penetration{};
    double seconds = 0.0;    ///< of simulated time
    long steps = 0;          ///< in that time
    long skipped = 0;        ///< of these, of a brief trial, that were not simulated
    long inexactSolves = 0;  ///< of the solver, over all steps
};

/// Runs one trial in a world of its own (one for every pull). The same arguments give the same
/// bits. Its time is bounded by the protocol's. Throws std::invalid_argument for a grasp that was
/// never closed, for numbers out of range, and as squeezeOf() and checkProtocol() do.
[[nodiscard]] BULLET_CCD_API TrialResult runTrial(const HandModel& hand,
                                                  const GraspObject& object,
                                                  const Grasp& grasp,
                                                  const TrialProtocol& protocol,
                                                  const TrialOptions& options);
}  // namespace bullet_ccd::grasp
