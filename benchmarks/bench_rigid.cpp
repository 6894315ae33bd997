// Rigid time of impact against 1,001 overlap samples of FCL, on recorded and generated query sets.
//
// Every answer is checked before anything is timed; the exit code is 1 if one is wrong. Times are
// cold: a repeat asks every query of a set once, so that the caches hold the data of other queries;
// the number of a query is the median over the repeats, the number of a set the mean over its
// queries.
#include "benchmarks/naive_cache.h"
#include "benchmarks/rigid_check.h"
#include "benchmarks/rigid_scaling.h"
#include "benchmarks/rigid_sets.h"
#include "benchmarks/rigid_targets.h"
#include "benchmarks/timing.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

namespace
{
using namespace bullet_ccd;
using namespace bullet_ccd::benchmarks;

const std::map<std::string, ToiStrategy> kStrategies{{"best-first", ToiStrategy::BestFirst},
                                                     {"interval", ToiStrategy::Interval},
                                                     {"c2a", ToiStrategy::C2A}};

struct Arguments
{
    std::vector<std::string> sets;
    std::vector<std::string> strategies{"best-first"};
    std::string data = defaultDataFolder().string();
    std::string json;
    std::string fclCache;
    double tolerance = 1e-4;
    int repeats = 5;
    int fclRepeats = 1;
    int limit = 0;
    std::uint64_t seedShift = 0;
    bool quick = false;
    bool list = false;
    bool noCheck = false;
    bool scaling = false;
    int complaints = 3;
};

/// One line of the table.
struct Row
{
    std::string set;
    std::string strategy;
    std::size_t queries = 0;
    CheckResult check{};
    double micros = 0.0;     ///< mean
    double fclMicros = 0.0;  ///< mean; 0 without FCL
    double nodePairs = 0.0;
    double trianglePairs = 0.0;
    double states = 0.0;

    [[nodiscard]] double ratio() const { return fclMicros > 0.0 ? micros / fclMicros : 0.0; }
};

/// Hierarchies of the sets, shared between sets with the same mesh.
class Hierarchies
{
public:
    const SsvTree& tree(const std::shared_ptr<const TriangleMesh>& mesh)
    {
        auto& entry = m_trees[mesh];
        if (!entry)
        {
            entry = std::make_unique<SsvTree>(buildSsvTree(*mesh));
        }
        return *entry;
    }

    const FclModel& model(const std::shared_ptr<const TriangleMesh>& mesh)
    {
        auto& entry = m_models[mesh];
        if (!entry)
        {
            entry = std::make_unique<FclModel>(*mesh);
        }
        return *entry;
    }

private:
    std::map<std::shared_ptr<const TriangleMesh>, std::unique_ptr<SsvTree>> m_trees;
    std::map<std::shared_ptr<const TriangleMesh>, std::unique_ptr<FclModel>> m_models;
};

/// Times of one method: per query, one entry a repeat.
using Times = std::vector<std::vector<double>>;

class SetRun
{
public:
    SetRun(const RigidSet& set, Hierarchies& hierarchies, const Arguments& arguments)
        : m_set(set),
          m_arguments(arguments),
          m_treeA(hierarchies.tree(set.meshA)),
          m_treeB(hierarchies.tree(set.meshB))
    {
        if (isFclPresent())
        {
            m_modelA = &hierarchies.model(set.meshA);
            m_modelB = &hierarchies.model(set.meshB);
        }
    }

    /// Rows of all strategies.
    std::vector<Row> run(NaiveCache& cache)
    {
        measureNaive(cache);
        std::vector<Row> rows;
        for (const std::string& strategy : m_arguments.strategies)
        {
            rows.push_back(answer(strategy));
        }
        std::vector<Times> times(rows.size(), Times(m_set.queries.size()));
        for (int repeat = 0; repeat < m_arguments.repeats; ++repeat)
        {
            for (std::size_t k = 0; k < rows.size(); ++k)
            {
                timeOnce(rows[k].strategy, times[k]);
            }
        }
        for (std::size_t k = 0; k < rows.size(); ++k)
        {
            rows[k].micros = meanOfMedians(times[k]);
            rows[k].fclMicros = m_fclMicros;
        }
        return rows;
    }

private:
    ToiResult ask(const RigidQuery& query, const std::string& strategy)
    {
        const RigidBody a{.tree = &m_treeA, .motion = query.motionA};
        const RigidBody b{.tree = &m_treeB, .motion = query.motionB};
        return rigidToi(a,
                        b,
                        {.tolerance = m_arguments.tolerance, .strategy = kStrategies.at(strategy)},
                        m_work);
    }

    /// Answers all queries, warms the workspace, checks.
    Row answer(const std::string& strategy)
    {
        Row row{.set = m_set.name, .strategy = strategy, .queries = m_set.queries.size()};
        std::vector<ToiResult> answers;
        for (const RigidQuery& query : m_set.queries)
        {
            answers.push_back(ask(query, strategy));
            row.nodePairs += static_cast<double>(answers.back().counters.nodePairs);
            row.trianglePairs += static_cast<double>(answers.back().counters.trianglePairs);
            row.states += static_cast<double>(answers.back().counters.states);
        }
        const double n = static_cast<double>(row.queries);
        row.nodePairs /= n;
        row.trianglePairs /= n;
        row.states /= n;
        if (m_arguments.noCheck)
        {
            return row;
        }
        std::optional<PeerView> peer;
        if (m_modelA != nullptr)
        {
            peer.emplace(PeerView{*m_modelA, *m_modelB, m_naive});
        }
        row.check = checkAnswers(m_set, answers, m_arguments.tolerance, peer ? &*peer : nullptr);
        return row;
    }

    void timeOnce(const std::string& strategy, Times& times)
    {
        for (std::size_t i = 0; i < m_set.queries.size(); ++i)
        {
            times[i].push_back(microsecondsOf([&] { keep(ask(m_set.queries[i], strategy).time); }));
        }
    }

    void measureNaive(NaiveCache& cache)
    {
        if (m_modelA == nullptr)
        {
            return;
        }
        if (const NaiveRun* cached = cache.find(m_set))
        {
            m_naive = cached->answers;
            m_fclMicros = cached->meanMicros;
            return;
        }
        Times times(m_set.queries.size());
        m_naive.resize(m_set.queries.size());
        for (int repeat = 0; repeat < m_arguments.fclRepeats; ++repeat)
        {
            for (std::size_t i = 0; i < m_set.queries.size(); ++i)
            {
                const RigidQuery& query = m_set.queries[i];
                const FclBody a{*m_modelA, query.motionA};
                const FclBody b{*m_modelB, query.motionB};
                times[i].push_back(
                    microsecondsOf([&] { m_naive[i] = fclNaive(a, b, kNaiveSamples); }));
            }
        }
        m_fclMicros = meanOfMedians(times);
        cache.store(m_set, {.answers = m_naive, .meanMicros = m_fclMicros});
    }

    const RigidSet& m_set;
    const Arguments& m_arguments;
    const SsvTree& m_treeA;
    const SsvTree& m_treeB;
    const FclModel* m_modelA = nullptr;
    const FclModel* m_modelB = nullptr;
    ToiWorkspace m_work;
    std::vector<FclAnswer> m_naive;
    double m_fclMicros = 0.0;
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

void printRow(const Row& row)
{
    const RigidTarget* target = findTarget(row.set);
    const double ratio = row.ratio();
    const double c2a = target != nullptr && ratio > 0.0 ? target->originalC2A / ratio : 0.0;
    const CheckResult& check = row.check;
    fmt::print(
        "{:<21}{:<11}{:>8} {:>16} {:>9.1f} {:>10.1f} {:>7.4f} {:>6} {:>6} {:>7} {:>8.1e} "
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
        row.fclMicros,
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

nlohmann::json toJson(const Row& row)
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
    app.add_option("--set", arguments.sets, "names of sets; default: those with a target");
    app.add_option("--strategy", arguments.strategies, "best-first, interval, c2a, or all")
        ->delimiter(',');
    app.add_option("--data", arguments.data, "folder with motions/ and rigid_queries/");
    app.add_option("--tolerance", arguments.tolerance, "distance in model units")
        ->check(CLI::PositiveNumber);
    app.add_option("--repeats", arguments.repeats, "of ours")->check(CLI::PositiveNumber);
    app.add_option("--fcl-repeats", arguments.fclRepeats, "of FCL")->check(CLI::PositiveNumber);
    app.add_option("--fcl-cache", arguments.fclCache, "file that keeps FCL's times and answers");
    app.add_option("--seed-shift", arguments.seedShift, "other queries of the generated recipes");
    app.add_option("--limit", arguments.limit, "only the first queries of each set");
    app.add_option("--json", arguments.json, "write the table to this file");
    app.add_option("--complaints", arguments.complaints, "wrong answers to print a row");
    app.add_flag("--quick", arguments.quick, "20 queries a set, 2 repeats");
    app.add_flag("--scaling", arguments.scaling, "growth with the number of triangles instead");
    app.add_flag("--no-check", arguments.noCheck, "do not check the answers (profiling)");
    app.add_flag("--list", arguments.list, "print the names of all sets");
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        std::exit(app.exit(error));
    }
    if (arguments.strategies == std::vector<std::string>{"all"})
    {
        arguments.strategies = {"best-first", "interval", "c2a"};
    }
    if (arguments.quick)
    {
        arguments.limit = 20;
        arguments.repeats = 2;
    }
    for (const std::string& strategy : arguments.strategies)
    {
        if (!kStrategies.contains(strategy))
        {
            throw std::invalid_argument("--strategy " + strategy +
                                        ": is none of best-first, interval, c2a, all");
        }
    }
    if (arguments.sets.empty())
    {
        arguments.sets = setsWithTargets();
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
    out << nlohmann::json{{"tolerance", arguments.tolerance},
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
                           {.tolerance = arguments.tolerance,
                            .strategy = kStrategies.at(arguments.strategies.front()),
                            .repeats = arguments.repeats,
                            .quick = arguments.quick}));
    return 0;
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
    nlohmann::json rows = nlohmann::json::array();
    int wrong = 0;
    printHeader();
    for (const std::string& name : arguments.sets)
    {
        RigidSet set = makeRigidSet(name, meshes, arguments.seedShift);
        if (arguments.limit > 0 && set.queries.size() > static_cast<std::size_t>(arguments.limit))
        {
            set.queries.resize(static_cast<std::size_t>(arguments.limit));
            set.references.resize(std::min(set.references.size(), set.queries.size()));
        }
        for (const Row& row : SetRun(set, hierarchies, arguments).run(cache))
        {
            printRow(row);
            for (std::size_t i = 0; i < row.check.complaints.size() &&
                                    i < static_cast<std::size_t>(arguments.complaints);
                 ++i)
            {
                fmt::print("    {}\n", row.check.complaints[i]);
            }
            std::fflush(stdout);
            wrong += row.check.wrong();
            rows.push_back(toJson(row));
        }
        cache.save();
    }
    writeJson(arguments, rows);
    fmt::print("{} wrong answers\n", wrong);
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
