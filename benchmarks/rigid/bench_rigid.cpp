// Rigid time of impact against 1,001 overlap samples of FCL, on recorded and generated query sets.
//
// Every answer is checked before anything is timed; the exit code is 1 if one is wrong. Times are
// cold: a repeat asks every query of a set once, so that the caches hold the data of other queries;
// the number of a query is the median over the repeats, the number of a set the mean over its
// queries. Repeats of FCL and of the strategies take turns. Processor time of one thread.
#include "benchmarks/rigid/rigid_run.h"
#include "benchmarks/rigid/rigid_scaling.h"
#include "benchmarks/rigid/rigid_sets.h"
#include "benchmarks/rigid/rigid_targets.h"
#include "benchmarks/support/timing.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

namespace
{
using namespace bullet_ccd;
using namespace bullet_ccd::benchmarks;

struct Arguments
{
    std::vector<std::string> sets;
    std::string data = defaultDataFolder().string();
    std::string json;
    std::string fclCache;
    std::string exportFolder;
    RunOptions run;
    int limit = 0;
    std::uint64_t seedShift = 0;
    bool quick = false;
    bool list = false;
    bool scaling = false;
    int complaints = 3;
};

std::string bound(double value)
{
    return value > 0.0 ? fmt::format("{:.3f}", value) : "-";
}

void printHeader()
{
    fmt::print(
        "{:<21}{:<11}{:>8} {:>16} {:>9} {:>10} {:>7} {:>6} {:>6} {:>7} {:>8} {:>8} {:>7} "
        "{:>7} {:>7}\n",
        "set",
        "strategy",
        "hits",
        "mis/lat/fal/ear/x",
        "us",
        "FCL us",
        "ratio",
        "must",
        "goal",
        "x C2A",
        "err med",
        "err max",
        "nodes",
        "tris",
        "states");
}

void printRow(const RigidRow& row)
{
    const RigidTarget* target = findTarget(row.set);
    const double ratio = row.ratio();
    const double c2a = target != nullptr && ratio > 0.0 ? target->originalC2A / ratio : 0.0;
    const CheckResult& check = row.check;
    fmt::print(
        "{:<21}{:<11}{:>8} {:>16} {:>9.1f} {:>10} {:>7.4f} {:>6} {:>6} {:>7} {:>8.1e} "
        "{:>8.1e} {:>7.0f} {:>7.0f} {:>7.0f}{}\n",
        row.set,
        row.strategy,
        fmt::format("{}/{}", check.hits, row.queries),
        fmt::format("{}/{}/{}/{}/{}",
                    check.missed,
                    check.late,
                    check.falseHits,
                    check.early,
                    check.badGaps + check.gaveUp),
        row.micros,
        fmt::format("{:.1f}{}", row.fclMicros, row.isFclCached ? "*" : ""),
        ratio,
        target != nullptr ? bound(target->must) : "-",
        target != nullptr ? bound(target->goal) : "-",
        c2a > 0.0 ? fmt::format("{:.1f}", c2a) : "-",
        medianOf(check.errors),
        check.errors.empty() ? 0.0 : std::ranges::max(check.errors),
        row.nodePairs,
        row.trianglePairs,
        row.states,
        target != nullptr && target->must > 0.0 && ratio > target->must ? "  ABOVE MUST" : "");
}

nlohmann::json toJson(const RigidRow& row)
{
    const CheckResult& check = row.check;
    return {{"set", row.set},
            {"strategy", row.strategy},
            {"queries", row.queries},
            {"hits", check.hits},
            {"missed", check.missed},
            {"late", check.late},
            {"false", check.falseHits},
            {"early", check.early},
            {"badGaps", check.badGaps},
            {"gaveUp", check.gaveUp},
            {"microseconds", row.micros},
            {"fclMicroseconds", row.fclMicros},
            {"ratio", row.ratio()},
            {"medianToiError", medianOf(check.errors)},
            {"maxToiError", check.errors.empty() ? 0.0 : std::ranges::max(check.errors)},
            {"nodePairs", row.nodePairs},
            {"trianglePairs", row.trianglePairs},
            {"states", row.states}};
}

Arguments parse(int argc, char** argv)
{
    Arguments arguments;
    CLI::App app("Rigid time of impact, checked and timed against FCL at 1,001 samples");
    app.add_option(
        "--set", arguments.sets, "names of sets; default: all but the convex and the 1M ones");
    app.add_option("--strategy", arguments.run.strategies, "best-first, interval, c2a, or all")
        ->delimiter(',');
    app.add_option("--data", arguments.data, "folder with motions/ and rigid_queries/");
    app.add_option("--tolerance", arguments.run.tolerance, "distance in model units")
        ->check(CLI::PositiveNumber);
    app.add_option("--repeats", arguments.run.repeats, "of ours")->check(CLI::PositiveNumber);
    app.add_option("--fcl-repeats", arguments.run.fclRepeats, "of FCL")->check(CLI::PositiveNumber);
    app.add_option("--fcl-cache", arguments.fclCache, "file that keeps FCL's times and answers");
    app.add_option("--seed-shift", arguments.seedShift, "other queries of the generated recipes");
    app.add_option("--limit", arguments.limit, "only the first queries of each set");
    app.add_option("--json", arguments.json, "write the table to this file");
    app.add_option("--export", arguments.exportFolder, "write poses of the sets there, as CSV");
    app.add_option("--complaints", arguments.complaints, "wrong answers to print a row");
    app.add_flag("--quick", arguments.quick, "20 queries a set, 2 repeats");
    app.add_flag("--scaling", arguments.scaling, "growth with the number of triangles instead");
    app.add_flag("!--no-check", arguments.run.check, "do not check the answers (profiling)");
    app.add_flag("--list", arguments.list, "print the names of all sets");
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        std::exit(app.exit(error));
    }
    if (arguments.run.strategies == std::vector<std::string>{"all"})
    {
        arguments.run.strategies = {"best-first", "interval", "c2a"};
    }
    if (arguments.quick)
    {
        arguments.limit = 20;
        arguments.run.repeats = 2;
    }
    for (const std::string& strategy : arguments.run.strategies)
    {
        static_cast<void>(strategyNamed(strategy));  // throws for an unknown one
    }
    if (arguments.sets.empty())
    {
        arguments.sets = setsOfTable();
    }
    return arguments;
}

void writeJson(const Arguments& arguments, const nlohmann::json& rows)
{
    if (arguments.json.empty())
    {
        return;
    }
    std::ofstream out(arguments.json);
    out << nlohmann::json{{"tolerance", arguments.run.tolerance},
                          {"yardstick", fclVersion()},
                          {"rows", rows}}
               .dump(1)
        << '\n';
    if (!out)
    {
        throw std::runtime_error(arguments.json + ": cannot be written: name another file");
    }
}

int runScaling(const Arguments& arguments)
{
    MeshLibrary meshes(arguments.data);
    writeJson(arguments,
              printScaling(meshes,
                           {.tolerance = arguments.run.tolerance,
                            .strategy = strategyNamed(arguments.run.strategies.front()),
                            .repeats = arguments.run.repeats,
                            .quick = arguments.quick}));
    return 0;
}

/// Sets that are compared with each other: "x" and "x_rest" stay together.
std::vector<std::vector<std::string>> groupsOf(const std::vector<std::string>& names)
{
    std::vector<std::vector<std::string>> groups;
    for (const std::string& name : names)
    {
        if (!groups.empty() && name == groups.back().back() + "_rest")
        {
            groups.back().push_back(name);
        }
        else
        {
            groups.push_back({name});
        }
    }
    return groups;
}

RigidSet limitedSet(const std::string& name, const Arguments& arguments, MeshLibrary& meshes)
{
    RigidSet set = makeRigidSet(name, meshes, arguments.seedShift);
    const auto limit = static_cast<std::size_t>(arguments.limit);
    if (limit > 0 && set.queries.size() > limit)
    {
        set.queries.resize(limit);
        set.references.resize(std::min(set.references.size(), limit));
    }
    if (!arguments.exportFolder.empty())
    {
        writePoses(set, std::filesystem::path(arguments.exportFolder) / (name + ".csv"));
    }
    return set;
}

void printComplaints(const RigidRow& row, int most)
{
    const auto& complaints = row.check.complaints;
    for (std::size_t i = 0; i < complaints.size() && i < static_cast<std::size_t>(most); ++i)
    {
        fmt::print("    {}\n", complaints[i]);
    }
}

/// Rows of "x" before those of "x_rest", strategy by strategy.
void printBothMoving(const std::vector<RigidRow>& rows)
{
    for (std::size_t k = 0; 2 * k + 1 < rows.size(); ++k)
    {
        const RigidRow& rest = rows[rows.size() / 2 + k];
        fmt::print("    {}: both bodies moving take {:.2f} x the time of one at rest (must: {})\n",
                   rows[k].strategy,
                   rows[k].micros / rest.micros,
                   kBothMovingMust);
    }
}

int runSets(const Arguments& arguments)
{
    if (!isFclPresent())
    {
        fmt::print(
            "FCL is not part of this build (libfcl-dev): no yardstick, generated sets are "
            "not checked.\n");
    }
    MeshLibrary meshes(arguments.data);
    Hierarchies hierarchies;
    NaiveCache cache(arguments.fclCache);
    nlohmann::json table = nlohmann::json::array();
    int wrong = 0;
    printHeader();
    for (const std::vector<std::string>& group : groupsOf(arguments.sets))
    {
        std::vector<RigidSet> sets;
        for (const std::string& name : group)
        {
            sets.push_back(limitedSet(name, arguments, meshes));
        }
        const std::vector<RigidRow> rows = runTogether(sets, arguments.run, hierarchies, cache);
        for (const RigidRow& row : rows)
        {
            printRow(row);
            printComplaints(row, arguments.complaints);
            wrong += row.check.wrong();
            table.push_back(toJson(row));
        }
        if (group.size() > 1)
        {
            printBothMoving(rows);
        }
        std::fflush(stdout);
        cache.save();
    }
    writeJson(arguments, table);
    fmt::print("{} wrong answers{}\n",
               wrong,
               arguments.fclCache.empty() ? "" : "; * FCL times from an earlier run");
    return wrong == 0 ? 0 : 1;
}
}  // namespace

int main(int argc, char** argv)
{
    try
    {
        const Arguments arguments = parse(argc, argv);
        if (arguments.list)
        {
            for (const auto* names : {&fileSetNames(), &generatedSetNames()})
            {
                for (const std::string& name : *names)
                {
                    fmt::print("{}\n", name);
                }
            }
            return 0;
        }
        return arguments.scaling ? runScaling(arguments) : runSets(arguments);
    }
    catch (const std::exception& error)
    {
        std::cerr << "bench_rigid: " << error.what() << '\n';
        return 2;
    }
}
