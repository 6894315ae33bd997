#include "benchmarks/soak/soak_program.h"

#include "benchmarks/soak/soak_run.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <thread>

namespace bullet_ccd::tests
{
namespace
{
int runVerbosely(const SoakSubject& subject, std::uint64_t first, std::uint64_t count)
{
    int wrong = 0;
    for (std::uint64_t seed = first; seed < first + count; ++seed)
    {
        std::cout << "seed " << seed << '\n';
        subject.print(std::cout, seed);
        const SoakAnswer answer = subject.ask(seed);
        std::printf("answer: %s, time %.17g, gap %.17g\njudgement: %s\n",
                    nameOf(answer.status),
                    answer.time,
                    answer.gap,
                    answer.judgement.text().c_str());
        std::fflush(stdout);
        wrong += answer.judgement.verdict == Verdict::Right ? 0 : 1;
    }
    return wrong > 0 ? 1 : 0;
}

void printTable(const SoakSubject& subject, const Checkpoint& checkpoint)
{
    std::printf(
        "\n| family | queries | hit | free | overlapping | late | missed | false | gap | "
        "status | gave up | undecided |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    SoakTally all;
    const auto row = [](const std::string& name, const SoakTally& tally)
    {
        const double scale = 100.0 / static_cast<double>(std::max<std::int64_t>(1, tally.queries));
        std::printf("| %s | %lld | %.1f %% | %.1f %% | %.1f %% ",
                    name.c_str(),
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
    for (std::size_t i = 0; i < subject.families.size(); ++i)
    {
        row(subject.families[i], checkpoint.tallies[i]);
        all.add(checkpoint.tallies[i]);
    }
    row("all", all);
}

int summarize(const SoakSubject& subject, const Checkpoint& checkpoint)
{
    printTable(subject, checkpoint);
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
    const std::string complaints = vacuity(checkpoint.tallies, subject.families, subject.shares);
    if (!complaints.empty())
    {
        std::printf("\nno wrong answer, but the run proves little:\n%s", complaints.c_str());
        return 2;
    }
    std::printf("\nno wrong answer\n");
    return 0;
}
}  // namespace

int soakProgram(const SoakSubject& subject, int argc, char** argv)
{
    CLI::App app{subject.description};
    SoakRun run;
    run.count = subject.count;
    run.jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    run.checkpointPath = subject.program + ".checkpoint";
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
        return verbose ? runVerbosely(subject, run.firstSeed, run.count)
                       : summarize(subject, runSoak(subject, run));
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "%s: %s\n", subject.program.c_str(), error.what());
        return 3;
    }
}
}  // namespace bullet_ccd::tests
