/// Random and adversarial rigid queries, every answer judged by proof or counterexample. Exit code
/// 1 on any wrong answer, 2 if the run proves little, 3 if it could not be run.
#include "tools/soak/soak_run.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <thread>

namespace
{
using namespace bullet_ccd::tests;

int runVerbosely(std::uint64_t first, std::uint64_t count)
{
    int wrong = 0;
    for (std::uint64_t seed = first; seed < first + count; ++seed)
    {
        const SoakQuery query = soakQuery(seed);
        std::cout << "seed " << seed << '\n';
        print(std::cout, query);
        const SoakOutcome outcome = runSoakQuery(query);
        std::printf("answer: %s, time %.17g, gap %.17g\njudgement: %s\n",
                    nameOf(outcome.result.status),
                    outcome.result.time,
                    outcome.result.gap,
                    outcome.judgement.text().c_str());
        std::fflush(stdout);
        wrong += outcome.judgement.verdict == Verdict::Right ? 0 : 1;
    }
    return wrong > 0 ? 1 : 0;
}

void printTable(const Checkpoint& checkpoint)
{
    std::printf(
        "\n| family | queries | hit | free | overlapping | late | missed | false | gap | "
        "status | gave up | undecided |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    SoakTally all;
    const auto row = [](const char* name, const SoakTally& tally)
    {
        const double scale = 100.0 / static_cast<double>(std::max<std::int64_t>(1, tally.queries));
        std::printf("| %s | %lld | %.1f %% | %.1f %% | %.1f %% ",
                    name,
                    static_cast<long long>(tally.queries),
                    scale * static_cast<double>(tally.hits),
                    scale * static_cast<double>(tally.free),
                    scale * static_cast<double>(tally.overlapping));
        for (std::size_t i = 1; i < tally.verdicts.size(); ++i)
        {
            std::printf("| %lld ", static_cast<long long>(tally.verdicts[i]));
        }
        std::printf("|\n");
    };
    for (std::size_t i = 0; i < kSoakFamilies; ++i)
    {
        row(nameOf(static_cast<SoakFamily>(i)), checkpoint.tallies[i]);
        all.add(checkpoint.tallies[i]);
    }
    row("all", all);
}

int summarize(const Checkpoint& checkpoint)
{
    printTable(checkpoint);
    if (!checkpoint.failures.empty())
    {
        std::printf("\n%zu wrong answers; seeds:", checkpoint.failures.size());
        for (std::size_t i = 0; i < std::min<std::size_t>(checkpoint.failures.size(), 50); ++i)
        {
            std::printf(" %llu", static_cast<unsigned long long>(checkpoint.failures[i]));
        }
        std::printf("\n");
        return 1;
    }
    const std::string complaints = vacuity(checkpoint.tallies);
    if (!complaints.empty())
    {
        std::printf("\nno wrong answer, but the run proves little:\n%s", complaints.c_str());
        return 2;
    }
    std::printf("\nno wrong answer\n");
    return 0;
}
}  // namespace

int main(int argc, char** argv)
{
    CLI::App app{
        "Random and adversarial rigid queries, every answer judged by proof or "
        "counterexample."};
    SoakRun run;
    run.jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    run.checkpointPath = "soak_rigid.checkpoint";
    bool verbose = false;
    app.add_option("--seed", run.firstSeed, "first seed")->capture_default_str();
    app.add_option("-n,--count", run.count, "number of queries")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    app.add_option("-j,--jobs", run.jobs, "threads")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    app.add_option("--checkpoint", run.checkpointPath, "file that keeps the state of the run")
        ->capture_default_str();
    app.add_flag("--resume", run.resume, "go on from the checkpoint, if there is one");
    app.add_flag("--verbose", verbose, "print each query and its answer; keeps no checkpoint");
    CLI11_PARSE(app, argc, argv);
    try
    {
        return verbose ? runVerbosely(run.firstSeed, run.count) : summarize(runSoak(run));
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "soak_rigid: %s\n", error.what());
        return 3;
    }
}
