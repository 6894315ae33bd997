/// The rows of the tunnelling table: scenes in which thin or fast things meet, for every kind of
/// world, with a setting (time step and speed) and a phase (where in a step the bodies meet).
#pragma once

#include "benchmarks/reference/bullet/path_judge.h"
#include "benchmarks/reference/bullet/scene.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
struct Setting
{
    double timeStep = 1.0 / 240.0;  ///< [s]
    double speed = 1.0;             ///< [m/s], or [rad/s] for what turns
};

/// That a way [m or rad] takes, and so many more.
[[nodiscard]] inline int stepsFor(double way, const Setting& setting, int more = 12)
{
    return int(way / (setting.speed * setting.timeStep)) + more;
}

struct RunOutcome
{
    bool through = false;
    double closest = 0.0;    ///< of the surfaces, at a record [m]; of ours only
    double simulated = 0.0;  ///< [s]
    double lost = 0.0;       ///< by the counters, of the body that lost most [s]
    /// From outside: what a coordinate that no contact can change lags behind [s]; 0 if none.
    double lag = 0.0;
};

/// Stopped farther away than any margin and tolerance explain: meshes have contact points up to
/// twice the sum of their margins.
inline constexpr double kContactReach = 2.1e-3;

[[nodiscard]] inline bool isGhostStop(const RunOutcome& outcome)
{
    return !outcome.through && outcome.closest > kContactReach;
}

struct TunnellingRow
{
    std::string name;
    std::vector<Setting> settings;
    int phases = 50;
    std::function<RunOutcome(Kind, const Setting&, double phase)> run;  ///< phase in [0, 1)
};

[[nodiscard]] std::vector<TunnellingRow> bodyRows();
[[nodiscard]] std::vector<TunnellingRow> linkRows();
[[nodiscard]] std::vector<TunnellingRow> tunnellingRows();

/// A coordinate that grows at `speed` whatever happens: no contact has a force along it.
struct UniformCoordinate
{
    std::function<double()> read;
    double speed;
};

struct Run
{
    double timeStep;
    int steps;
    std::optional<UniformCoordinate> uniform = std::nullopt;
    std::function<void()> beforeStep = nullptr;
};

/// Steps the scene and judges the path.
[[nodiscard]] RunOutcome watchRun(Scene& scene, Kind kind, Watched watched, const Run& run);
}  // namespace bullet_ccd::reference
