// Rigid time of impact against 1,001 overlap samples of FCL, on recorded and generated query sets.
//
// Every answer is checked before anything is timed; the exit code is 1 if one is wrong. Times are
// cold: a repeat asks every query of a set once, so that the caches hold the data of other queries;
// the number of a query is the median over the repeats, the number of a set the mean over its
// queries. Repeats of FCL and of the strategies take turns. Processor time of one thread.
#include "benchmarks/rigid/rigid_growth.h"
#include "benchmarks/rigid/rigid_run.h"
#include "benchmarks/rigid/rigid_sets.h"
#include "benchmarks/rigid/rigid_targets.h"
#include "benchmarks/support/data_folder.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/report.h"
#include "benchmarks/support/table.h"

#include <algorithm>
#include <fmt/format.h>

namespace bullet_ccd::benchmarks
{
namespace
{
using nlohmann::json;

struct Arguments
{
    std::vector<std::string> sets;
    std::vector<std::string> strategies{"best-first"};
    std::filesystem::path data = defaultDataFolder();
    std::string json;
    std::string fclCache;
    std::string exportFolder;
    RunOptions run;
    int limit = 0;
    std::uint64_t seedShift = 0;
    bool quick = false;
    bool list = false;
    bool scaling = false;
    bool kinds = false;
    int complaints = 3;
};

/// What a row is measured against.
void addTarget(json& row)
{
    const RigidTarget* target = findTarget(row["set"].get<std::string>());
    const double ratio = row["ratio"];
    if (target == nullptr)
    {
        return;
    }
    for (const auto& [key, value] : {std::pair("must", target->must), {"goal", target->goal}})
    {
        row[key] = value > 0.0 ? json(value) : json();
    }
    if (target->originalC2A > 0.0 && ratio > 0.0)
    {
        row["originalC2A"] = target->originalC2A / ratio;
    }
    if (target->must > 0.0 && ratio > target->must)
    {
        row["note"] = row["note"].get<std::string>() + " ABOVE MUST";
    }
}

void writeRows(const Arguments& arguments, json rows)
{
    if (!arguments.json.empty())
    {
        writeReport(arguments.json,
                    {{"tolerance", arguments.run.tolerance},
                     {"yardstick", fclVersion()},
                     {"rows", std::move(rows)}});
    }
}

bool runScaling(Arguments& arguments)
{
    MeshLibrary meshes(arguments.data);
    arguments.run.methods.resize(1);
    json rows = printGrowth(meshes, arguments.run, arguments.quick);
    const bool isRight =
        std::ranges::all_of(rows, [](const json& row) { return row["wrong"] == 0; });
    writeRows(arguments, std::move(rows));
    return isRight;
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

/// Kinds of volumes beside each other: what the hierarchy costs and what it saves. All must agree
/// on hits.
bool runKinds(Arguments& arguments)
{
    if (arguments.sets.empty())
    {
        arguments.sets = {
            "near_knot_16k", "pass_knot_16k", "pass_sphere_20k", "pass_torus", "pass_cylinder"};
        if (std::filesystem::exists(arguments.data / "rigid_queries"))
        {
            arguments.sets.insert(arguments.sets.begin(), {"bunny_ident", "bunny_near"});
        }
    }
    arguments.run.methods = allKinds();
    arguments.run.fcl = false;
    MeshLibrary meshes(arguments.data);
    NaiveCache cache("");
    const Table table(
        "set:<16|kind=strategy:<16|build ms=buildMilliseconds:>9.1f|bytes/t=bytesPerTriangle:>8.0f|"
        "node pairs=nodePairs:>11.0f|triangle pairs=trianglePairs:>14.1f|us=microseconds:>10.1f|"
        "hits=contacts:>6");
    json rows = json::array();
    bool isRight = true;
    for (const std::string& name : arguments.sets)
    {
        const RigidSet set = limitedSet(name, arguments, meshes);
        Hierarchies hierarchies;
        std::vector<RigidRow> ofSet =
            runTogether(std::span(&set, 1), arguments.run, hierarchies, cache);
        for (std::size_t k = 0; k < ofSet.size(); ++k)
        {
            const VolumeKind kind = arguments.run.methods[k].kind;
            json& row = ofSet[k].values;
            row["buildMilliseconds"] = buildMilliseconds(*set.meshA, kind);
            row["bytesPerTriangle"] = bytesOf(hierarchies.tree(set.meshA, kind)) /
                                      static_cast<double>(set.meshA->triangles.size());
            isRight = isRight && ofSet[k].check.wrong() == 0 &&
                      row["contacts"] == ofSet.front().values["contacts"];
            table.print(row);
            rows.push_back(row);
        }
    }
    fmt::print("{}\n", isRight ? "the kinds agree" : "WRONG: the kinds do not agree");
    writeRows(arguments, std::move(rows));
    return isRight;
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

/// Rows of "x" before those of "x_rest", strategy by strategy.
void printBothMoving(const std::vector<RigidRow>& rows)
{
    const std::size_t half = rows.size() / 2;
    for (std::size_t k = 0; k < half; ++k)
    {
        const auto micros = [&](std::size_t row)
        { return rows[row].values["microseconds"].get<double>(); };
        fmt::print("    {}: both bodies moving take {:.2f} x the time of one at rest (must: {})\n",
                   rows[k].values["strategy"].get<std::string>(),
                   micros(k) / micros(half + k),
                   kBothMovingMust);
    }
}

bool runSets(const Arguments& arguments)
{
    if (!isFclPresent())
    {
        fmt::print("FCL is not part of this build (libfcl-dev): no yardstick\n");
    }
    MeshLibrary meshes(arguments.data);
    Hierarchies hierarchies;
    NaiveCache cache(arguments.fclCache);
    json all = json::array();
    int wrong = 0;
    const Table table(
        "set:<21|strategy:<11|hits:>4|of=queries:>4|mis=missed:>3|lat=late:>3|fal=false:>3|"
        "ear=early:>3|x:>3|us=microseconds:>9.1f|FCL us=fclMicroseconds:>9.1f|ratio:>7.4f|"
        "must:>6.3f|goal:>6.3f|x C2A=originalC2A:>7.1f|err med=medianToiError:>8.1e|"
        "err max=maxToiError:>8.1e|nodes=nodePairs:>7.0f|tris=trianglePairs:>7.0f|states:>7.0f|"
        "note:<4");
    for (const std::vector<std::string>& group : groupsOf(arguments.sets))
    {
        std::vector<RigidSet> sets;
        for (const std::string& name : group)
        {
            sets.push_back(limitedSet(name, arguments, meshes));
        }
        std::vector<RigidRow> rows = runTogether(sets, arguments.run, hierarchies, cache);
        for (RigidRow& row : rows)
        {
            addTarget(row.values);
            row.values["x"] = row.check.badGaps + row.check.gaveUp;
            table.print(row.values);
            const std::vector<std::string>& complaints = row.check.complaints;
            const auto most = static_cast<std::size_t>(arguments.complaints);
            for (std::size_t i = 0; i < std::min(most, complaints.size()); ++i)
            {
                fmt::print("    {}\n", complaints[i]);
            }
            wrong += row.check.wrong();
            all.push_back(row.values);
        }
        if (group.size() > 1)
        {
            printBothMoving(rows);
        }
        cache.save();
    }
    writeRows(arguments, std::move(all));
    fmt::print("{} wrong answers{}\n",
               wrong,
               arguments.fclCache.empty() ? "" : "; * FCL times from an earlier run");
    return wrong == 0;
}

bool run(Arguments& arguments)
{
    if (arguments.list)
    {
        for (const auto* names : {&fileSetNames(), &generatedSetNames()})
        {
            fmt::print("{}\n", fmt::join(*names, "\n"));
        }
        return true;
    }
    arguments.run.methods = strategiesNamed(arguments.strategies);
    if (arguments.quick)
    {
        arguments.limit = 20;
        arguments.run.repeats = 2;
    }
    if (arguments.scaling)
    {
        return runScaling(arguments);
    }
    if (arguments.kinds)
    {
        return runKinds(arguments);
    }
    if (arguments.sets.empty())
    {
        arguments.sets = setsOfTable();
    }
    return runSets(arguments);
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    Arguments arguments;
    RunOptions& options = arguments.run;
    return runProgram(
        argc,
        argv,
        {.name = "bench_rigid",
         .about = "Rigid time of impact, checked and timed against FCL at 1,001 samples",
         .options =
             {{"--set", &arguments.sets, "names of sets; default: all but convex and 1M ones"},
              {"--strategy", &arguments.strategies, "best-first, interval, c2a, or all"},
              {"--data", &arguments.data, "folder with motions/ and rigid_queries/"},
              {"--tolerance", &options.tolerance, "distance in model units"},
              {"--repeats,--repeat", &options.repeats, "of ours"},
              {"--fcl-repeats", &options.fclRepeats, "of FCL"},
              {"--fcl-cache", &arguments.fclCache, "file that keeps FCL's times and answers"},
              {"--seed-shift", &arguments.seedShift, "other queries of the generated recipes"},
              {"--limit", &arguments.limit, "only the first queries of each set", 0},
              {"--json", &arguments.json, "write the table to this file"},
              {"--export", &arguments.exportFolder, "write poses of the sets there, as CSV"},
              {"--complaints", &arguments.complaints, "wrong answers to print a row", 0},
              {"--quick", &arguments.quick, "20 queries a set, 2 repeats"},
              {"--scaling", &arguments.scaling, "growth with the number of triangles instead"},
              {"--kinds", &arguments.kinds, "kinds of bounding volumes instead"},
              {"!--no-fcl", &options.fcl, "without FCL"},
              {"!--no-check", &options.check, "do not check the answers (profiling)"},
              {"--list", &arguments.list, "print the names of all sets"}},
         .run = [&] { return run(arguments); }});
}
