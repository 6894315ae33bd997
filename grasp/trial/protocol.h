/// Protocols of simulated trials: what is done to an object that a hand holds.
///
/// The object's mesh frame at the start is W. A protocol speaks of the frame P: that of W, turned
/// (the shortest way) so that its z axis is the direction that is up for the object
/// (TrialOptions::up).
///
/// Protocols that ship, with their sources:
///
///     six      held; its weight along +x, -x, +y, -y, +z, -z, 1 s each, in turn. Source: the six
///              directions of DexGraspNet, without a fresh start for each.
///     hover    held; its weight along -z, 10 s.
///     shake    held; its weight along -z, and the hand moved by 20 mm sin(2 pi 2 Hz t) along x, y
///              and z in turn, 2 s each.
///     lift     the object stands on a table, and the hand closes with the object free to move; up
///              by 0.2 m in 1 s, then 3 s of hold. Source: the lift of MultiGripperGrasp and of
///              Isaac's grasp trials (hold time before a fall).
///     pull     held without weight; a force along +x, -x, +y, -y, +z, -z of P grows until it
///              slips, with a fresh start for each.
///     disturb  the hand is off by 5 mm and 5 degrees in a random direction before it closes, with
///              the object free and without weight; then as six.
///
/// Without a source are our own: hover looks for creep, shake for inertia, pull for what epsilon
/// promises, disturb for errors of the pose. What counts as held (10 mm, 15 degrees) is our own,
/// too; what counts as lost (0.1 m) is that of DexGraspBench.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"

#include <Eigen/Core>

#include <cstdint>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// What happens in one phase. Directions are in P and need not have length 1.
struct TrialPhase
{
    enum class Kind : std::uint8_t
    {
        Load,   ///< `amount` times its weight along `direction`
        Shake,  ///< its weight along -z; the hand moves by amount sin(2 pi frequency t) [m]
        Lift,   ///< its weight along -z; the hand goes by `amount` [m] along z, smoothly
        /// Nothing but a wrench that grows until the object slips: by kPullRate of the squeeze's
        /// sum of normal forces a second, up to that sum. Starts afresh.
        Pull,
    };
    Kind kind = Kind::Load;
    double time = 1.0;  ///< how long it lasts, not of Pull [s]
    Eigen::Vector3d direction = -Eigen::Vector3d::UnitZ();
    double amount = 1.0;
    double frequency = 0.0;  ///< [Hz]
    /// Of Pull: force, and moment over the radius of the object; made length 1.
    Wrench wrench = Wrench::Zero();
};

inline constexpr double kPullRate = 0.25;  ///< [1/s]

/// From where a trial begins.
enum class TrialStart : std::uint8_t
{
    Held,   ///< at the closed posture, opened until nothing touches; without weight
    Open,   ///< with the open hand at the pose of the grasp; without weight
    Table,  ///< the same, with the object on a table, which the hand must not be in
};

struct TrialProtocol
{
    std::string name;
    TrialStart start = TrialStart::Held;
    std::vector<TrialPhase> phases{};
    /// The hand is off by this much in a random direction, and turned by this much about a random
    /// axis through the object's centre of mass. It then makes the grasp's approach, up to its
    /// first contact. Not with TrialStart::Held.
    double shift = 0.0;  ///< [m]
    double turn = 0.0;   ///< [rad]
    /// Held: the object has moved by no more than this since the load began; with a lift, as seen
    /// from the hand.
    double heldWay = 0.010;                             ///< of its centre of mass [m]
    double heldTurn = 15.0 * std::numbers::pi / 180.0;  ///< [rad]
    /// Dropped: it has moved by more than this. The default is that of DexGraspBench.
    double lostWay = 0.100;  ///< [m]
};

/// "six", "hover", "shake", "lift", "pull", "disturb".
[[nodiscard]] BULLET_CCD_API const std::vector<std::string>& shippedProtocols();
/// Throws std::invalid_argument for a name that does not ship.
[[nodiscard]] BULLET_CCD_API TrialProtocol shippedProtocol(const std::string& name);

/// Phases that pull along `count` wrenches, evenly distributed over all directions of force and
/// (scaled) moment. The same seed gives the same ones.
[[nodiscard]] BULLET_CCD_API std::vector<TrialPhase> randomPulls(int count, std::uint64_t seed);

/// Reads a protocol from a YAML file; README.md in this folder has the keys.
/// Throws std::runtime_error: "<file>:<line>: <key>: <what>: <remedy>".
[[nodiscard]] BULLET_CCD_API TrialProtocol readProtocol(const std::filesystem::path& file);

/// A shipped one, or a file (*.yaml, *.yml). Throws as both do.
[[nodiscard]] BULLET_CCD_API TrialProtocol namedProtocol(const std::string& nameOrFile);

/// Throws std::invalid_argument that names what is wrong: no phases, times or amounts that are not
/// positive or not finite, directions without length, thresholds that are not in order.
BULLET_CCD_API void checkProtocol(const TrialProtocol& protocol);
}  // namespace bullet_ccd::grasp
