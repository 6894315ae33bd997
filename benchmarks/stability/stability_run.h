/// One run of a world of stability_worlds.h, and what was measured in it.
#pragma once

#include "benchmarks/stability/stability_worlds.h"

#include <nlohmann/json_fwd.hpp>

namespace bullet_ccd::benchmarks
{
/// What solves for the forces of contacts and motors.
enum class StabilitySolver : std::uint8_t
{
    Sweeps,   ///< sequential impulses, as Bullet's worlds have them
    Holding,  ///< grasp::HoldingSolver; in double precision
    Dantzig,  ///< reference::DirectSolver
    Lemke,    ///< same
};

struct StabilitySetting
{
    reference::Kind kind = reference::Kind::Stock;
    int rate = 60;         ///< steps a second
    int iterations = 10;   ///< of the solver
    double seconds = 1.0;  ///< of simulated time
    StabilitySolver solver = StabilitySolver::Sweeps;
};

/// What a run came to.
enum class StabilityVerdict : std::uint8_t
{
    Held,      ///< or, where nothing is held: stopped
    Slipped,   ///< the object left its place in the hand by more than kSlip
    Dropped,   ///< by more than kDrop
    Through,   ///< something has passed through something else
    Exploded,  ///< a number that is not finite, or a speed that nothing in the world can reach
};
[[nodiscard]] const char* toString(StabilityVerdict verdict);

inline constexpr double kSlip = 1e-3;     // [m]
inline constexpr double kDrop = 0.02;     // [m]
inline constexpr double kRunaway = 10.0;  // [m/s]

struct StabilityOutcome
{
    StabilityVerdict verdict = StabilityVerdict::Held;
    double simulated = 0.0;  ///< [s]; less than asked for if it exploded
    /// Of the object in the hand's frame, from when rest is expected to the end.
    double drift = 0.0;        ///< [m]
    double turn = 0.0;         ///< [rad]
    double meanKinetic = 0.0;  ///< of all that moves, in that time [J]
    double maxKinetic = 0.0;   ///< [J]
    double energyGain = 0.0;   ///< passive worlds: largest energy / energy at the start - 1
    double depth = 0.0;        ///< deepest penetration seen at ends of steps [m]
    double restDepth = 0.0;    ///< the same from when rest is expected [m]
    double realTime = 0.0;     ///< processor time of steps, a simulated second [s]
    btCcdCounters counters = {};
    double lostTime = 0.0;  ///< of the object that lost most [s]
};

/// Runs a world in this process. Penetration is measured on meshes by an exact check
/// (benchmarks/reference/audit), up to 120 times a second until rest is expected and ten times a
/// second from then on; at all steps of passive worlds.
[[nodiscard]] StabilityOutcome runStability(const StabilityWorld& world,
                                            const StabilitySetting& setting);

/// With the setting; numbers that are not finite are left out.
[[nodiscard]] nlohmann::json toJson(const StabilityWorld& world,
                                    const StabilitySetting& setting,
                                    const StabilityOutcome& outcome);
}  // namespace bullet_ccd::benchmarks
