// A walking, running and kicking human of 15 links among 16 chessmen on their board, from one frame
// of the recorded motion to the next: answers checked, then timed in turns with each pair of a link
// and an obstacle on its own, with FCL's samples, and with stages of the query switched off.
#include "benchmarks/articulated/human_run.h"
#include "benchmarks/rigid/rigid_run.h"
#include "benchmarks/support/counters.h"
#include "benchmarks/support/data_folder.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"

#include <fmt/format.h>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
namespace
{
struct HumanOptions
{
    std::filesystem::path data = defaultDataFolder();
    std::vector<std::string> motions{"walk", "run", "kick"};
    int repeats = 7;
    bool fcl = true;
    bool list = false;
};

nlohmann::json rowOfMix(const Mix& mix)
{
    nlohmann::json row{{"method", mix.method}, {"us", mix.micros / mix.queries}};
    if (mix.counters.pairs > 0)
    {
        row.update(rowOf(mix.counters, mix.queries));
        row.update({{"wrong", mix.wrong}, {"late", mix.late}, {"early", mix.early}});
    }
    return row;
}

/// The whole query first.
void printTable(const std::vector<Mix>& mixes)
{
    const Mix& whole = mixes.front();
    const int free = whole.queries - whole.contacts;
    const auto share = [&](int part) { return 100.0 * part / whole.queries; };
    fmt::print(
        "  contact in {} queries ({:.0f} %), {} of them by a pair that intersects at the start\n"
        "  free with three pairs or more {} ({:.0f} %); with exempt pairs {} ({:.0f} %)\n"
        "  {}: {:.1f} us with contact, {:.1f} us free\n",
        whole.contacts,
        share(whole.contacts),
        whole.exemptContacts,
        whole.busy,
        share(whole.busy),
        whole.exempt,
        share(whole.exempt),
        whole.method,
        whole.microsOfContacts / std::max(1, whole.contacts),
        (whole.micros - whole.microsOfContacts) / std::max(1, free));
    const Table table(
        fmt::format("method:<20|us:>9.1f|wrong:>5|{}|late:>7.0e|early:>7.0e", kCounterColumns));
    for (const Mix& mix : mixes)
    {
        table.print(rowOfMix(mix));
    }
}

/// Mean time of FCL on the recorded bunny queries; 0 without FCL.
double unitMicros(const HumanOptions& options)
{
    if (!options.fcl)
    {
        return 0.0;
    }
    MeshLibrary meshes(options.data);
    return runSet(makeRigidSet("bunny_ident", meshes),
                  {.repeats = 1, .fclRepeats = 3, .check = false})
        .at(0)
        .values["fclMicroseconds"];
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

bool judge(const std::vector<Mix>& mixes, double unit)
{
    const Mix& mix = mixes.front();
    const auto timesOurs = [&](const std::string& method)
    { return std::ranges::find(mixes, method, &Mix::method)->micros / mix.micros; };
    const double count = mix.queries;
    bool holds = must("share of queries with contact", mix.contacts / count, 0.3, false);
    holds = must("share free with three pairs or more", mix.busy / count, 0.3, false) && holds;
    holds =
        must("rigidToi on each pair / ours (goal 10)", timesOurs("rigidToi on each"), 3.0, false) &&
        holds;
    if (unit > 0.0)
    {
        holds = must("FCL x 1,001 per link / ours", timesOurs("FCL x 1,001"), 10.0, false) && holds;
        fmt::print("  FCL x 1,001 on bunny_ident: {:.0f} us\n", unit);
        holds =
            must("ours / FCL on bunny_ident (goal 0.05)", mix.micros / count / unit, 0.1, true) &&
            holds;
    }
    return holds;
}

bool runHuman(const HumanOptions& options)
{
    const std::vector<Stage> stages = humanStages();
    std::vector<Mix> all;
    const double unit = unitMicros(options);
    for (const std::string& name : options.motions)
    {
        HumanRun motion(options.data, name, options.fcl);
        motion.describe(options.list);
        const std::vector<Mix> mixes = motion.run(stages, options.repeats);
        printTable(mixes);
        all.resize(mixes.size());
        for (std::size_t k = 0; k < mixes.size(); ++k)
        {
            add(all[k], mixes[k]);
        }
    }
    fmt::print("all: {} queries\n", all.front().queries);
    printTable(all);
    int wrong = 0;
    for (const Mix& mix : all)
    {
        wrong += mix.wrong;
    }
    const bool isRight = must("wrong answers of all stages", wrong, 0.0, true);
    return judge(all, unit) && isRight;
}

}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    HumanOptions human;
    return runProgram(
        argc,
        argv,
        {.name = "bench_articulated",
         .about = "Queries of moving linkages: answers checked, then timed",
         .options = {{"--data", &human.data, "data folder"}},
         .verbs = {{.name = "human",
                    .about = "15 links among 16 chessmen, beside FCL",
                    .options = {{"--motion", &human.motions, "walk, run, kick"},
                                {"--repeats", &human.repeats, "passes; the median counts"},
                                {"--list", &human.list, "list pairs that intersect at the start"},
                                {"!--no-fcl", &human.fcl, "without FCL"}},
                    .run = [&] { return runHuman(human); }}}});
}
