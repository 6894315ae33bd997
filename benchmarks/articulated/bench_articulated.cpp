/// human: a walking, running and kicking human of 15 links among 16 chessmen on their board, from
/// one frame of the recorded motion to the next: answers checked, then timed in turns with each
/// pair of a link and an obstacle on its own, with FCL's samples, and with stages of the query
/// switched off.
/// hands, arms: joints that go through their whole range in one query, beside dense samples.
#include "benchmarks/articulated/crossing_arms.h"
#include "benchmarks/articulated/hand_closings.h"
#include "benchmarks/articulated/human_run.h"
#include "benchmarks/rigid/rigid_run.h"
#include "benchmarks/support/timing.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
namespace
{
struct HumanOptions
{
    std::string data = defaultDataFolder().string();
    std::vector<std::string> motions{"walk", "run", "kick"};
    int repeats = 7;
    bool fcl = true;
    bool list = false;
    bool bounds = false;
};

double sumOf(const std::vector<double>& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Times of all queries, and of those with and without a contact.
struct Sums
{
    std::vector<double> stages;
    double rigid = 0.0;
    double fcl = 0.0;
    double hits = 0.0;  ///< of the whole query
    double free = 0.0;  ///< the same
};

void add(Sums& sum, const Sums& more)
{
    sum.stages.resize(more.stages.size(), 0.0);
    for (std::size_t k = 0; k < sum.stages.size(); ++k)
    {
        sum.stages[k] += more.stages[k];
    }
    sum.rigid += more.rigid;
    sum.fcl += more.fcl;
    sum.hits += more.hits;
    sum.free += more.free;
}

Sums sumsOf(const HumanTimes& times, const std::vector<bool>& hits)
{
    Sums sums;
    for (const std::vector<double>& stage : times.stages)
    {
        sums.stages.push_back(sumOf(stage));
    }
    sums.rigid = sumOf(times.rigid);
    sums.fcl = sumOf(times.fcl);
    for (std::size_t f = 0; f < hits.size(); ++f)
    {
        (hits[f] ? sums.hits : sums.free) += times.stages[0][f];
    }
    return sums;
}

void printStage(const char* name, const Mix& mix, double micros)
{
    const ArticulatedCounters& c = mix.counters;
    const auto mean = [&](std::int64_t sum) { return static_cast<double>(sum) / mix.queries; };
    const auto share = [&](std::int64_t part)
    { return 100.0 * static_cast<double>(part) / static_cast<double>(c.pairs); };
    fmt::print(
        "  {:<20} {:9.1f} {:5} {:7.1f} {:7.2f} {:7.0f} {:7.1f} {:6.0f} {:6.2f} {:7.0e} "
        "{:7.0e}\n",
        name,
        micros / mix.queries,
        mix.wrong,
        share(c.culledBySpace),
        share(c.culledByTime),
        mean(c.nodePairs),
        mean(c.trianglePairs),
        mean(c.states),
        mean(c.subdivisions),
        mix.late,
        mix.early);
}

void printTable(const std::vector<Stage>& stages, const std::vector<Mix>& mixes, const Sums& sums)
{
    const Mix& mix = mixes[0];
    const auto share = [&](int part) { return 100.0 * part / mix.queries; };
    fmt::print(
        "  contact in {} queries ({:.0f} %), {} of them by a pair that intersects at the "
        "start\n  free with three pairs or more {} ({:.0f} %); with exempt pairs {} ({:.0f} "
        "%)\n",
        mix.contacts,
        share(mix.contacts),
        mix.exemptContacts,
        mix.busy,
        share(mix.busy),
        mix.exempt,
        share(mix.exempt));
    fmt::print("  {:<20} {:>9} {:>5} {:>7} {:>7} {:>7} {:>7} {:>6} {:>6} {:>7} {:>7}\n",
               "",
               "us",
               "wrong",
               "space %",
               "time %",
               "nodes",
               "triang.",
               "states",
               "halved",
               "late",
               "early");
    for (std::size_t k = 0; k < stages.size(); ++k)
    {
        printStage(stages[k].name, mixes[k], sums.stages[k]);
    }
    const int free = mix.queries - mix.contacts;
    fmt::print("  {:<20} {:9.1f}\n  {:<20} {:9.1f}\n",
               "  with contact",
               mix.contacts == 0 ? 0.0 : sums.hits / mix.contacts,
               "  free",
               free == 0 ? 0.0 : sums.free / free);
    fmt::print("  {:<20} {:9.1f}\n", "rigidToi on each", sums.rigid / mix.queries);
    if (sums.fcl > 0.0)
    {
        fmt::print("  {:<20} {:9.1f}\n", "FCL x 1,001", sums.fcl / mix.queries);
    }
}

/// Mean time of FCL on the recorded bunny queries; 0 without FCL.
double unitMicros(const HumanOptions& options)
{
    if (!options.fcl || !isFclPresent())
    {
        return 0.0;
    }
    MeshLibrary meshes(options.data);
    const std::array sets{makeRigidSet("bunny_ident", meshes)};
    Hierarchies hierarchies;
    NaiveCache cache("");
    return runTogether(sets, {.repeats = 1, .fclRepeats = 3, .check = false}, hierarchies, cache)
        .at(0)
        .fclMicros;
}

bool must(const char* what, double value, double bound, bool isUpper)
{
    const bool holds = isUpper ? value <= bound : value >= bound;
    fmt::print("  {:<45} {:9.3f}  must be {} {:<5} {}\n",
               what,
               value,
               isUpper ? "<=" : ">=",
               bound,
               holds ? "holds" : "MISSED");
    return holds;
}

bool judge(const Mix& mix, const Sums& sums, double unit)
{
    const double count = mix.queries;
    const double ours = sums.stages[0];
    bool holds = must("share of queries with contact", mix.contacts / count, 0.3, false);
    holds = must("share free with three pairs or more", mix.busy / count, 0.3, false) && holds;
    holds = must("rigidToi on each pair / ours (goal 10)", sums.rigid / ours, 3.0, false) && holds;
    if (unit > 0.0)
    {
        holds = must("FCL x 1,001 per link / ours", sums.fcl / ours, 10.0, false) && holds;
        fmt::print("  FCL x 1,001 on bunny_ident: {:.0f} us\n", unit);
        holds =
            must("ours / FCL on bunny_ident (goal 0.05)", ours / count / unit, 0.1, true) && holds;
    }
    return holds;
}

int runHuman(const HumanOptions& options)
{
    const std::vector<Stage> stages = humanStages(options.bounds);
    std::vector<Mix> mixes(stages.size());
    Sums sums;
    int wrong = 0;
    const double unit = unitMicros(options);
    for (const std::string& name : options.motions)
    {
        HumanRun motion(options.data, name, options.fcl);
        motion.describe(options.list);
        motion.askPeers();
        std::vector<Mix> ofMotion(stages.size());
        for (std::size_t k = stages.size(); k-- > 0;)  // the whole query last: hits()
        {
            ofMotion[k] = motion.check(stages[k]);
            add(mixes[k], ofMotion[k]);
            wrong += ofMotion[k].wrong;
        }
        const Sums ofTimes = sumsOf(motion.time(stages, options.repeats), motion.hits());
        printTable(stages, ofMotion, ofTimes);
        add(sums, ofTimes);
    }
    fmt::print("all: {} queries\n", mixes[0].queries);
    printTable(stages, mixes, sums);
    const bool isRight = must("wrong answers of all stages", wrong, 0.0, true);
    return judge(mixes[0], sums, unit) && isRight ? 0 : 1;
}
struct Options
{
    HumanOptions human;
    ClosingOptions hands{.data = {}, .share = BULLET_CCD_SHARE};
    ArmsOptions arms;
};

void addHuman(CLI::App& app, HumanOptions& options)
{
    CLI::App* human = app.add_subcommand("human", "15 links among 16 chessmen, beside FCL");
    human->add_option("--motion", options.motions, "walk, run, kick")->type_name("NAME");
    human->add_option("--repeats", options.repeats, "passes; the median counts")
        ->capture_default_str();
    human->add_flag("--list", options.list, "list pairs that intersect at the start");
    human->add_flag("--bounds", options.bounds, "the other motion bounds, too: takes minutes");
    human->add_flag("!--no-fcl", options.fcl, "without FCL");
}

template <class Sampled>
void addSampled(CLI::App* command, Sampled& options)
{
    command->add_option("-n,--configurations", options.configurations, "random queries")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
    command->add_option("--repeats", options.repeats, "passes; the median counts")
        ->capture_default_str();
    command->add_option("--seed", options.seed, "of the random queries")->capture_default_str();
}

int run(const CLI::App& app, Options& options)
{
    if (app.got_subcommand("human"))
    {
        return runHuman(options.human);
    }
    if (!isFclPresent())
    {
        throw std::runtime_error("hands and arms are compared with FCL: install libfcl-dev");
    }
    options.hands.data = options.human.data;
    options.arms.data = options.human.data;
    const bool isRight = app.got_subcommand("hands") ? runHandClosings(options.hands)
                                                     : runCrossingArms(options.arms);
    return isRight ? 0 : 1;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    Options options;
    CLI::App app("Queries of moving linkages: answers checked, then timed");
    app.add_option("--data", options.human.data, "data folder")->capture_default_str();
    app.require_subcommand(1);
    addHuman(app, options.human);
    CLI::App* hands = app.add_subcommand("hands", "hands that close around household objects");
    hands->add_option("--hand", options.hands.hands, "folders in hands/ of the data")
        ->capture_default_str();
    addSampled(hands, options.hands);
    addSampled(app.add_subcommand("arms", "two arms that cross each other"), options.arms);
    app.footer("Exit codes: 0 all that must hold does, 1 not, 2 usage or missing files.");
    try
    {
        app.parse(argc, argv);
        return run(app, options);
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : 2;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "bench_articulated: %s\n", error.what());
        return 2;
    }
}
