/// Simulated trials: does a grasp hold?
///
/// A trial starts at the posture of the grasp, with the object free. The joints are driven to the
/// targets of the squeeze (position controllers with its stiffness, within the efforts) in 0.25 s
/// and the object may come to rest for up to 1 s. Then the protocol loads it.
///
///     six    its weight along +x, -x, +y, -y, +z, -z of its mesh frame, 1 s each, in turn. Source:
///            the six directions of DexGraspNet, without a fresh start for each.
///     hover  its weight along -z, 10 s.
///     shake  its weight along -z, and the hand moved by 20 mm sin(2 pi 2 Hz t) along x, y and z in
///            turn, 2 s each.
///
/// Held: the object has moved by at most 10 mm and 15 degrees since the load began. Dropped: by
/// more than 100 mm (the threshold of DexGraspBench). Slipped: what is between.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/check/penetration_check.h"
#include "grasp/squeeze/squeeze.h"

#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
enum class TrialProtocol : std::uint8_t
{
    Six,
    Hover,
    Shake,
};
[[nodiscard]] BULLET_CCD_API const char* toString(TrialProtocol protocol);

enum class TrialOutcome : std::uint8_t
{
    Held,
    Slipped,
    Dropped,
    Ejected,       ///< gone before the load began
    NeverTouched,  ///< no contact pressed on it
    NotSettled,    ///< it still moved when the load should have begun
    NoSqueeze,     ///< there are no torques to hold it with
};
[[nodiscard]] BULLET_CCD_API const char* toString(TrialOutcome outcome);

struct TrialOptions
{
    SqueezeOptions squeeze{};  ///< also mass and friction of the trial
    double rate = 240.0;       ///< steps per second
};

struct TrialResult
{
    TrialOutcome outcome = TrialOutcome::NoSqueeze;
    std::string reason;       ///< of NoSqueeze
    double slip = 0.0;        ///< largest way of the centre of mass under load [m]
    double turn = 0.0;        ///< largest turn of the object under load [rad]
    double lostAt = 0.0;      ///< since the trial began, of Dropped and Ejected [s]
    double peakForce = 0.0;   ///< largest normal force of a contact point [N]
    double meanForce = 0.0;   ///< of all normal forces together, over the time under load [N]
    double peakEnergy = 0.0;  ///< kinetic, of the object under load [J]
    std::vector<double> peakTorques;  ///< one entry per independent joint [N m or N]
    /// The worst of what the independent check found at the end of every second.
    PenetrationReport penetration;
    double seconds = 0.0;    ///< of simulated time
    long inexactSolves = 0;  ///< of the solver, over all steps
};

/// Runs one trial in a world of its own. The same arguments give the same bits. Its time is that
/// of the protocol at most. Throws std::invalid_argument for a grasp that was never closed, and as
/// squeezeOf() does.
[[nodiscard]] BULLET_CCD_API TrialResult runTrial(const HandModel& hand,
                                                  const GraspObject& object,
                                                  const Grasp& grasp,
                                                  TrialProtocol protocol,
                                                  const TrialOptions& options);
}  // namespace bullet_ccd::grasp
