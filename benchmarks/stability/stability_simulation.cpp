/// Hands that hold, squeeze, pinch and hit for a long time or with little mass: drift, energy and
/// penetration in stock Bullet and in ours, over time steps and iterations of the solver.
#include "benchmarks/stability/stability_run.h"
#include "benchmarks/support/report.h"
#include "benchmarks/support/sandbox.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <iostream>
#include <nlohmann/json.hpp>
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

struct Arguments
{
    std::string output;
    std::string data;
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
    const auto [end, text, seconds] =
        runSandboxed(1,
                     {.seconds = kRunLimit},
                     [&](std::size_t)
                     { return toJson(world, setting, runStability(world, setting)).dump(); })[0];
    if (end == SandboxEnd::Answered)
    {
        return nlohmann::json::parse(text);
    }
    nlohmann::json row = toJson(world, setting, {});
    row["verdict"] = end == SandboxEnd::TimedOut ? "timed out" : "crashed";
    return row;
}

void print(const nlohmann::json& row)
{
    const auto number = [&](const char* name) { return row.value(name, 0.0); };
    fmt::print(
        "{:<20}{:<14} 1/{:<5}{:>4} it  {:<9} drift {:.1e} m {:.1e} rad  kinetic {:.1e} J  "
        "gain {:.1e}  depth {:.1e} rest {:.1e} m  {:.1e} s/s\n",
        row["world"].get<std::string>(),
        row["method"].get<std::string>(),
        row["rate"].get<int>(),
        row["iterations"].get<int>(),
        row["verdict"].get<std::string>(),
        number("drift"),
        number("turn"),
        number("maxKinetic"),
        number("energyGain"),
        number("depth"),
        number("restDepth"),
        number("realTime"));
    std::fflush(stdout);
}

nlohmann::json runAll(const Arguments& arguments)
{
    nlohmann::json rows = nlohmann::json::array();
    for (const StabilityWorld& world : stabilityWorlds())
    {
        if (world.name.find(arguments.only) == std::string::npos)
        {
            continue;
        }
        for (const reference::Kind kind : world.kinds)
        {
            for (const int rate : arguments.rates)
            {
                for (const int iterations : arguments.iterations)
                {
                    rows.push_back(
                        runOne(world,
                               {.kind = kind,
                                .rate = rate,
                                .iterations = iterations,
                                .seconds = secondsOf(world, rate, iterations, arguments)}));
                    print(rows.back());
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

void write(const Arguments& arguments, nlohmann::json rows, double seconds)
{
    writeReport(arguments.output,
                {{"family", "simulation"},
                 {"title", "Stability of simulated grasps"},
                 {"precision", reference::kDouble ? "double" : "single"},
                 {"peers", {fmt::format("Bullet {}", btGetVersion())}},
                 {"quick", arguments.quick},
                 {"rates", arguments.rates},
                 {"iterations", arguments.iterations},
                 {"slip", kSlip},
                 {"drop", kDrop},
                 {"seconds", seconds},
                 {"worlds", worldsAsJson()},
                 {"runs", std::move(rows)}});
}
}  // namespace

int main(int argc, char** argv)
{
    Arguments arguments;
    CLI::App app("Drift, energy and penetration of simulated grasps, stock Bullet and ours");
    app.add_option("-o,--output", arguments.output, "JSON file")->required();
    app.add_option("--data", arguments.data, "not needed: worlds are made by the program itself");
    app.add_option("--only", arguments.only, "worlds whose name contains this");
    app.add_option("--rates", arguments.rates, "steps a second")->check(CLI::PositiveNumber);
    app.add_option("--iterations", arguments.iterations, "of the solver")
        ->check(CLI::PositiveNumber);
    app.add_flag("--quick", arguments.quick, "two time steps, two numbers of iterations");
    CLI11_PARSE(app, argc, argv);
    if (arguments.quick)
    {
        arguments.rates = {60, 240};
        arguments.iterations = {10, 50};
    }
    try
    {
        const auto begin = std::chrono::steady_clock::now();
        nlohmann::json rows = runAll(arguments);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
        write(arguments, std::move(rows), seconds.count());
    }
    catch (const std::exception& error)
    {
        std::cerr << "stability_simulation: " << error.what() << '\n';
        return 2;
    }
    return 0;
}
