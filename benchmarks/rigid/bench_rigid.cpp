// Rigid time of impact against 1,001 overlap samples of FCL, on recorded and generated query sets.
//
// Every answer is checked before anything is timed; the exit code is 1 if one is wrong. Times are
// cold: a repeat asks every query of a set once, so that the caches hold the data of other queries;
// the number of a query is the median over the repeats, the number of a set the mean over its
// queries. Repeats of FCL and of the strategies take turns. Processor time of one thread.
#include "benchmarks/rigid/rigid_check.h"
#include "benchmarks/rigid/rigid_sets.h"
#include "benchmarks/support/files.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using nlohmann::json;

struct RigidMethod
{
    std::string name;
    ToiStrategy strategy = ToiStrategy::BestFirst;
};

struct RunOptions
{
    std::vector<RigidMethod> methods{{.name = "best-first"}};
    double tolerance = 1e-4;
    int repeats = 7;
    int fclRepeats = 3;
    int fclEvery = 1;  ///< FCL is asked one of so many of its samples; its time counts so often
    bool check = true;
    bool fcl = true;
};

/// One set by one method.
struct RigidRow
{
    nlohmann::json values;  ///< "set", "strategy", "hits", "microseconds", ..
    CheckResult check;
};

/// Answers and checks a set, then times all methods in turns.
class SetRun
{
public:
    SetRun(const RigidSet& set, const RunOptions& options)
        : m_set(set),
          m_options(options),
          m_treeA(std::make_shared<const SsvTree>(buildSsvTree(*set.meshA))),
          m_treeB(set.meshB == set.meshA
                      ? m_treeA
                      : std::make_shared<const SsvTree>(buildSsvTree(*set.meshB)))
    {
        if (options.fcl)
        {
            m_modelA.emplace(*set.meshA);
            m_modelB = set.meshB == set.meshA ? m_modelA : FclModel(*set.meshB);
        }
    }

    /// Asks, checks and warms the workspace; then all take turns, the peer first.
    std::vector<RigidRow> run()
    {
        for (std::size_t i = 0; m_modelA && i < m_set.queries.size(); ++i)
        {
            m_naive.push_back(askPeer(i));
        }
        std::vector<RigidRow> rows;
        std::vector<TimedMethod> timed{{.queries = m_naive.size(),
                                        .passes = m_options.fclRepeats,
                                        .ask = [this](std::size_t i) { keep(askPeer(i).time); }}};
        for (const RigidMethod& method : m_options.methods)
        {
            rows.push_back(answer(method));
            timed.push_back({.queries = m_set.queries.size(),
                             .passes = m_options.repeats,
                             .ask = [this, &method](std::size_t i) { keep(ask(i, method).time); }});
        }
        const std::vector<std::vector<double>> micros = timeInTurns(timed);
        const double fcl = meanOf(micros.front()) * kNaiveSamples / samples();
        for (std::size_t k = 0; k < rows.size(); ++k)
        {
            const double mean = meanOf(micros[k + 1]);
            rows[k].values["microseconds"] = mean;
            rows[k].values["fclMicroseconds"] = fcl;
            rows[k].values["ratio"] = fcl > 0.0 ? mean / fcl : 0.0;
        }
        return rows;
    }

private:
    ToiResult ask(std::size_t i, const RigidMethod& method)
    {
        const RigidQuery& query = m_set.queries[i];
        return rigidToi({.tree = m_treeA.get(), .motion = query.motionA},
                        {.tree = m_treeB.get(), .motion = query.motionB},
                        {.tolerance = m_options.tolerance, .strategy = method.strategy},
                        m_work);
    }

    [[nodiscard]] FclAnswer askPeer(std::size_t i) const
    {
        const RigidQuery& query = m_set.queries[i];
        return fclNaive({*m_modelA, query.motionA}, {*m_modelB, query.motionB}, samples());
    }
    [[nodiscard]] int samples() const { return (kNaiveSamples - 1) / m_options.fclEvery + 1; }

    RigidRow answer(const RigidMethod& method)
    {
        std::vector<ToiResult> answers;
        for (std::size_t i = 0; i < m_set.queries.size(); ++i)
        {
            answers.push_back(ask(i, method));
        }
        RigidRow row;
        if (m_options.check)
        {
            row.check = checkAnswers(m_set,
                                     answers,
                                     m_options.tolerance,
                                     {*m_treeA,
                                      *m_treeB,
                                      m_modelA ? &*m_modelA : nullptr,
                                      m_modelB ? &*m_modelB : nullptr,
                                      m_naive});
        }
        const auto mean = [&](std::int64_t ToiCounters::*number)
        {
            double sum = 0.0;
            for (const ToiResult& result : answers)
            {
                sum += static_cast<double>(result.counters.*number);
            }
            return sum / static_cast<double>(answers.size());
        };
        const std::vector<double>& errors = row.check.errors;
        const bool isJudged = m_modelA || !m_set.references.empty();
        const auto contacts = std::ranges::count_if(
            answers, [](const ToiResult& result) { return isContact(result.status); });
        row.values = {{"set", m_set.name},
                      {"strategy", method.name},
                      {"queries", answers.size()},
                      {"contacts", contacts},
                      {"hits", isJudged && m_options.check ? row.check.hits : contacts},
                      {"missed", row.check.missed},
                      {"late", row.check.late},
                      {"false", row.check.falseHits},
                      {"early", row.check.early},
                      {"badGaps", row.check.badGaps},
                      {"gaveUp", row.check.gaveUp},
                      {"medianToiError", medianOf(errors)},
                      {"maxToiError", errors.empty() ? 0.0 : std::ranges::max(errors)},
                      {"nodePairs", mean(&ToiCounters::nodePairs)},
                      {"trianglePairs", mean(&ToiCounters::trianglePairs)},
                      {"states", mean(&ToiCounters::states)}};
        return row;
    }

    const RigidSet& m_set;
    const RunOptions& m_options;
    std::shared_ptr<const SsvTree> m_treeA;
    std::shared_ptr<const SsvTree> m_treeB;
    std::optional<FclModel> m_modelA;
    std::optional<FclModel> m_modelB;
    ToiWorkspace m_work;
    std::vector<FclAnswer> m_naive;
};
/// Throws std::invalid_argument for an unknown name.
std::vector<RigidMethod> strategiesNamed(const std::vector<std::string>& names)
{
    static const std::vector<RigidMethod> kAll{{"best-first", ToiStrategy::BestFirst},
                                               {"interval", ToiStrategy::Interval},
                                               {"c2a", ToiStrategy::C2A}};
    if (names == std::vector<std::string>{"all"})
    {
        return kAll;
    }
    std::vector<RigidMethod> methods;
    for (const std::string& name : names)
    {
        const auto found = std::ranges::find(kAll, name, &RigidMethod::name);
        if (found == kAll.end())
        {
            throw std::invalid_argument("strategy '" + name +
                                        "' is unknown: best-first, interval, c2a or all");
        }
        methods.push_back(*found);
    }
    return methods;
}

struct Arguments
{
    std::vector<std::string> sets;
    std::vector<std::string> strategies{"best-first"};
    std::filesystem::path data = defaultDataFolder();
    std::string json;
    RunOptions run;
    int limit = 0;
    std::uint64_t seedShift = 0;
    bool quick = false;
    bool list = false;
    int complaints = 3;
};

/// Sets that the table has by default (the convex ones serve the chart), and what the original C2A
/// (axis of rotation corrected) took on their queries, as a multiple of FCL at 1,001 samples; 0
/// where that is not known.
const std::vector<std::pair<std::string, double>> kTable{{"bunny_ident", 3.25},
                                                         {"bunny_ani", 4.24},
                                                         {"plate", 0.69},
                                                         {"knot_64k", 2.40},
                                                         {"sphere_320k", 2.12},
                                                         {"bunny_near", 0.11},
                                                         {"bunny_rot", 1.19},
                                                         {"bunny_trans", 0.33},
                                                         {"finger", 0.79},
                                                         {"tunnel", 0.74},
                                                         {"bunny_random", 3.30},
                                                         {"bunny_both", 0.0},
                                                         {"bunny_both_rest", 0.0},
                                                         {"knot_1k", 0.50},
                                                         {"knot_4k", 0.90},
                                                         {"knot_16k", 1.49},
                                                         {"knot_256k", 3.41},
                                                         {"sphere_1k", 0.43},
                                                         {"sphere_5k", 0.72},
                                                         {"sphere_20k", 1.10},
                                                         {"sphere_80k", 1.71},
                                                         {"tunnel_flat", 0.0},
                                                         {"flat_plate_10k", 0.0},
                                                         {"flat_plate_100k", 0.0},
                                                         {"flat_box_10k", 0.0},
                                                         {"flat_box_100k", 0.0},
                                                         {"flat_cylinder_10k", 0.0},
                                                         {"flat_cylinder_100k", 0.0},
                                                         {"worst_gears", 0.0},
                                                         {"worst_shells_02", 0.0},
                                                         {"worst_shells_2", 0.0},
                                                         {"worst_screws", 0.0},
                                                         {"worst_combs", 0.0},
                                                         {"worst_links", 0.0}};

/// How many times our time the original C2A took.
void addOriginal(json& row)
{
    const double ratio = row["ratio"];
    for (const auto& [set, original] : kTable)
    {
        if (set == row["set"] && original > 0.0 && ratio > 0.0)
        {
            row["originalC2A"] = original / ratio;
        }
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

RigidSet limitedSet(const std::string& name, const Arguments& arguments, MeshLibrary& meshes)
{
    RigidSet set = makeRigidSet(name, meshes, arguments.seedShift);
    const auto limit = static_cast<std::size_t>(arguments.limit);
    if (limit > 0 && set.queries.size() > limit)
    {
        set.queries.resize(limit);
        set.references.resize(std::min(set.references.size(), limit));
    }
    return set;
}

bool runSets(const Arguments& arguments)
{
    MeshLibrary meshes(arguments.data);
    json all = json::array();
    int wrong = 0;
    const Table table(
        "set:<21|strategy:<11|hits:>4|of=queries:>4|mis=missed:>3|lat=late:>3|fal=false:>3|"
        "ear=early:>3|x:>3|us=microseconds:>9.1f|FCL us=fclMicroseconds:>9.1f|ratio:>7.4f|"
        "x C2A=originalC2A:>7.1f|err med=medianToiError:>8.1e|err max=maxToiError:>8.1e|"
        "nodes=nodePairs:>7.0f|tris=trianglePairs:>7.0f|states:>7.0f");
    for (const std::string& name : arguments.sets)
    {
        const RigidSet set = limitedSet(name, arguments, meshes);
        for (RigidRow& row : SetRun(set, arguments.run).run())
        {
            addOriginal(row.values);
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
    }
    writeRows(arguments, std::move(all));
    fmt::print("{} wrong answers\n", wrong);
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
    if (arguments.sets.empty())
    {
        for (const auto& [set, original] : kTable)
        {
            arguments.sets.push_back(set);
        }
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
              {"--fcl-every",
               &options.fclEvery,
               "asks FCL one of N samples; its time counts N-fold"},
              {"--seed-shift", &arguments.seedShift, "other queries of the generated recipes"},
              {"--limit", &arguments.limit, "only the first queries of each set", 0},
              {"--json", &arguments.json, "write the table to this file"},
              {"--complaints", &arguments.complaints, "wrong answers to print a row", 0},
              {"--quick", &arguments.quick, "20 queries a set, 2 repeats"},
              {"!--no-fcl", &options.fcl, "without FCL"},
              {"!--no-check", &options.check, "do not check the answers (profiling)"},
              {"--list", &arguments.list, "print the names of all sets"}},
         .run = [&] { return run(arguments); }});
}
