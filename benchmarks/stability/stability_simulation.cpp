/// Hands that hold, squeeze, pinch and hit for a long time or with little mass: drift, energy and
/// penetration in stock Bullet and in ours, over time steps and iterations of the solver.
#include "benchmarks/stability/stability_run.h"
#include "benchmarks/support/files.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/sandbox.h"
#include "benchmarks/support/table.h"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

namespace
{
using namespace bullet_ccd::benchmarks;
namespace reference = bullet_ccd::reference;

/// A run that takes longer than this is ended [s].
constexpr double kRunLimit = 60.0;
/// Simulated time of long holds where not all of it is asked for [s].
constexpr double kPartOfHold = 6.0;
constexpr double kQuickHold = 4.0;
/// Holds are run to their end with so many iterations of the solver, at steps that are not finer
/// than this.
constexpr int kUsualIterations = 50;
constexpr int kUsualRate = 240;
/// Of what the holding solver holds, in a minute.
constexpr double kStillWay = 1e-4;                             // [m]
constexpr double kStillTurn = 0.1 * std::numbers::pi / 180.0;  // [rad]

struct Arguments
{
    std::string output;
    std::string only;
    std::vector<int> rates{60, 120, 240, 480, 1000};
    std::vector<int> iterations{10, 20, 50, 100, 200};
    bool quick = false;
};

double secondsOf(const StabilityWorld& world, int rate, int iterations, const Arguments& arguments)
{
    const double part = arguments.quick ? kQuickHold : kPartOfHold;
    const bool isWhole = !arguments.quick && iterations == kUsualIterations && rate <= kUsualRate;
    return isWhole ? world.seconds : std::min(world.seconds, part);
}

nlohmann::json runOne(const StabilityWorld& world, const StabilitySetting& setting)
{
    const auto [end, text, seconds] = runSandboxed(
        kRunLimit, [&] { return toJson(world, setting, runStability(world, setting)).dump(); });
    if (end == SandboxEnd::Answered)
    {
        return nlohmann::json::parse(text);
    }
    nlohmann::json row = toJson(world, setting, {});
    row["verdict"] = end == SandboxEnd::TimedOut ? "timed out" : "crashed";
    return row;
}

/// Of the holding solver where a hand presses with far more than it needs.
bool isStill(const StabilityWorld& world, const nlohmann::json& row)
{
    return (world.group != "hold" && world.name.find("light_jaws") == std::string::npos) ||
           (row["verdict"] == "held" && row["drift"] <= kStillWay && row["turn"] <= kStillTurn);
}

nlohmann::json runAll(const Arguments& arguments, bool& isGood)
{
    const Table table(
        "world:<20|method:<36|1/s=rate:>5|iterations:>10|verdict:<9|drift [m]=drift:>9.1e|"
        "turn [rad]=turn:>10.1e|kinetic [J]=maxKinetic:>11.1e|gain=energyGain:>7.1e|"
        "depth [m]=depth:>9.1e|at rest [m]=restDepth:>11.1e|s/s=realTime:>7.1e");
    nlohmann::json rows = nlohmann::json::array();
    for (const StabilityWorld& world : only(stabilityWorlds(), arguments.only))
    {
        const auto ask = [&](const StabilitySetting& setting)
        {
            rows.push_back(runOne(world, setting));
            table.print(rows.back());
            isGood = isGood &&
                     (setting.solver != StabilitySolver::Holding || isStill(world, rows.back()));
        };
        for (const int rate : arguments.rates)
        {
            for (const reference::Kind kind : world.kinds)
            {
                for (const int count : arguments.iterations)
                {
                    ask({kind, rate, count, secondsOf(world, rate, count, arguments)});
                }
            }
            // Direct solvers where something is held at rest; one of them takes its time.
            const bool isHold = world.group == "hold" && rate <= kUsualRate && !arguments.quick;
            for (const auto solver :
                 {StabilitySolver::Holding, StabilitySolver::Dantzig, StabilitySolver::Lemke})
            {
                const double most = arguments.quick                    ? kQuickHold
                                    : solver == StabilitySolver::Lemke ? kPartOfHold
                                                                       : world.seconds;
                if (reference::kDouble && (isHold || solver == StabilitySolver::Holding))
                {
                    ask({reference::Kind::World,
                         rate,
                         arguments.iterations.front(),
                         std::min(most, world.seconds),
                         solver});
                }
            }
        }
    }
    return rows;
}

nlohmann::json worldsAsJson()
{
    nlohmann::json worlds = nlohmann::json::array();
    for (const StabilityWorld& world : stabilityWorlds())
    {
        worlds.push_back({{"name", world.name},
                          {"group", world.group},
                          {"title", world.title},
                          {"seconds", world.seconds},
                          {"passive", world.isPassive}});
    }
    return worlds;
}

bool run(Arguments arguments)
{
    if (arguments.quick)
    {
        arguments.rates = {60, 240};
        arguments.iterations = {10, 50};
    }
    bool isGood = true;
    nlohmann::json runs = runAll(arguments, isGood);
    writeReport(arguments.output,
                {{"family", "simulation"},
                 {"title", "Stability of simulated grasps"},
                 {"precision", reference::kDouble ? "double" : "single"},
                 {"peers", {fmt::format("Bullet {}", btGetVersion())}},
                 {"rates", arguments.rates},
                 {"iterations", arguments.iterations},
                 {"slip", kSlip},
                 {"drop", kDrop},
                 {"worlds", worldsAsJson()},
                 {"runs", std::move(runs)}});
    fmt::print("what the holding solver holds {} within 0.1 mm and 0.1 degrees\n",
               isGood ? "stays" : "does NOT stay");
    return isGood;
}
}  // namespace

int main(int argc, char** argv)
{
    Arguments arguments;
    return runProgram(
        argc,
        argv,
        {.name = "stability_simulation",
         .about = "Drift, energy and penetration of simulated grasps, stock Bullet and ours",
         .options = {{.names = "-o,--output",
                      .value = &arguments.output,
                      .help = "JSON file",
                      .isRequired = true},
                     {"--only", &arguments.only, "worlds whose name contains this"},
                     {"--rates", &arguments.rates, "steps a second"},
                     {"--iterations", &arguments.iterations, "of the solver"},
                     {"--quick",
                      &arguments.quick,
                      "two time steps and numbers of iterations, fewer solvers"}},
         .run = [&] { return run(arguments); }});
}
