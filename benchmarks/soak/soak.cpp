#include "benchmarks/soak/soak.h"

#include "benchmarks/support/checkpoint.h"
#include "tools/support/progress_line.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace bullet_ccd::reference
{
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SoakTally, queries, hits, overlapping, free, verdicts)
}

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;
using nlohmann::json;

/// What is known after all seeds before `next`.
struct SoakState
{
    std::uint64_t next = 0;
    std::vector<SoakTally> tallies = {};  ///< one a family
    std::vector<std::uint64_t> failures = {};
    std::map<std::string, std::int64_t> counts = {};
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SoakState, next, tallies, failures, counts)

class Soak
{
public:
    Soak(const SoakSubject& subject, const SoakOptions& options)
        : m_subject(subject),
          m_options(options),
          m_end(options.firstSeed +
                static_cast<std::uint64_t>(options.quick ? options.quickCount : options.count)),
          m_run{{"program", subject.program}, {"first seed", options.firstSeed}}
    {
        m_state.next = options.firstSeed;
        m_state.tallies.resize(subject.families.size());
        const auto kept = options.resume ? loadCheckpoint(options.checkpoint, m_run) : std::nullopt;
        if (kept)
        {
            kept->get_to(m_state);
        }
        if (m_state.next > m_end)
        {
            throw std::runtime_error(fmt::format(
                "{}: more is done than asked for, up to seed {}: ask for more with --count, or "
                "run without --resume",
                options.checkpoint,
                m_state.next - 1));
        }
    }

    bool go()
    {
        tools::ProgressLine progress(m_end - m_state.next, "seeds");
        const std::uint64_t start = m_state.next;
        while (m_state.next < m_end)
        {
            askRound();
            saveCheckpoint(m_options.checkpoint, m_run, m_state);
            progress.show(m_state.next - start,
                          fmt::format(", {} failures", m_state.failures.size()));
        }
        return summarize();
    }

private:
    const SoakSubject& m_subject;
    const SoakOptions& m_options;
    std::uint64_t m_end;
    json m_run;
    SoakState m_state;

    /// A round for each thread; the answers are counted in the order of their seeds.
    void askRound()
    {
        const std::uint64_t first = m_state.next;
        const std::uint64_t size =
            std::min(m_end - first, m_subject.round * static_cast<std::uint64_t>(m_options.jobs));
        std::vector<SoakAnswer> answers(size);
        tbb::task_arena(m_options.jobs)
            .execute(
                [&]
                {
                    tbb::parallel_for(std::uint64_t{0},
                                      size,
                                      [&](std::uint64_t i)
                                      { answers[i] = m_subject.ask(first + i); });
                });
        for (const SoakAnswer& answer : answers)
        {
            count(m_state.next++, answer);
        }
    }

    void count(std::uint64_t seed, const SoakAnswer& answer)
    {
        const Verdict verdict = answer.judgement.verdict;
        m_state.tallies[answer.family].add(answer.status, verdict);
        for (const auto& [name, number] : answer.counts)
        {
            m_state.counts[name] += number;
        }
        if (verdict == Verdict::Right)
        {
            return;
        }
        fmt::print("{} seed {} ({}): {}\n  {} --seed {} --count 1 --verbose\n",
                   verdict == Verdict::Undecided ? "not decided:" : "FAILED",
                   seed,
                   m_subject.families[answer.family],
                   answer.judgement.text(),
                   m_subject.program,
                   seed);
        std::fflush(stdout);
        if (verdict != Verdict::Undecided)
        {
            m_state.failures.push_back(seed);
        }
    }

    void printTable() const
    {
        fmt::print(
            "\n| family | queries | hit | free | overlapping | late | missed | false | gap | "
            "status | gave up | undecided |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
        SoakTally all;
        const auto row = [](const std::string& name, const SoakTally& tally)
        {
            const double scale =
                100.0 / static_cast<double>(std::max<std::int64_t>(1, tally.queries));
            fmt::print("| {} | {} | {:.1f} % | {:.1f} % | {:.1f} % ",
                       name,
                       tally.queries,
                       scale * static_cast<double>(tally.hits),
                       scale * static_cast<double>(tally.free),
                       scale * static_cast<double>(tally.overlapping));
            for (std::size_t i = 1; i < tally.verdicts.size(); ++i)
            {
                fmt::print("| {} ", tally.verdicts[i]);
            }
            fmt::print("|\n");
        };
        for (std::size_t i = 0; i < m_subject.families.size(); ++i)
        {
            row(m_subject.families[i], m_state.tallies[i]);
            all.add(m_state.tallies[i]);
        }
        row("all", all);
        for (const auto& [name, number] : m_state.counts)
        {
            fmt::print(
                "{}{}: {}", name == m_state.counts.begin()->first ? "\n" : ", ", name, number);
        }
    }

    [[nodiscard]] bool summarize() const
    {
        printTable();
        if (!m_state.failures.empty())
        {
            fmt::print("\n{} wrong answers; seeds:", m_state.failures.size());
            for (std::size_t i = 0; i < std::min<std::size_t>(m_state.failures.size(), 50); ++i)
            {
                fmt::print(" {}", m_state.failures[i]);
            }
            fmt::print("\n");
            return false;
        }
        const std::string complaints =
            vacuity(m_state.tallies, m_subject.families, m_subject.shares);
        fmt::print("\nno wrong answer{}{}\n",
                   complaints.empty() ? "" : ", but the run proves little:\n",
                   complaints);
        return complaints.empty();
    }
};

bool runVerbosely(const SoakSubject& subject, const SoakOptions& options)
{
    bool isRight = true;
    for (int i = 0; i < options.count; ++i)
    {
        const std::uint64_t seed = options.firstSeed + static_cast<std::uint64_t>(i);
        std::cout << "seed " << seed << '\n';
        if (subject.print)
        {
            subject.print(std::cout, seed);
        }
        const SoakAnswer answer = subject.ask(seed);
        std::cout << fmt::format("answer: {}, time {:.17g}, gap {:.17g}\njudgement: {}\n",
                                 nameOf(answer.status),
                                 answer.time,
                                 answer.gap,
                                 answer.judgement.text())
                  << std::flush;
        isRight = isRight && answer.judgement.verdict == Verdict::Right;
    }
    return isRight;
}
}  // namespace

Program soakProgram(const std::string& name,
                    const std::string& about,
                    const SoakOptions& defaults,
                    const std::function<SoakSubject(bool quick)>& subject,
                    const std::vector<ProgramOption>& more)
{
    const auto options = std::make_shared<SoakOptions>(defaults);
    std::vector<ProgramOption> all{
        {"--seed", &options->firstSeed, "first seed"},
        {"-n,--count", &options->count, "number of seeds, one query each"},
        {"-j,--jobs", &options->jobs, "threads"},
        {"--checkpoint", &options->checkpoint, "file that keeps the state of the run"},
        {"--resume", &options->resume, "go on from the checkpoint, if there is one"},
        {"--quick", &options->quick, "a reduced number, for tools/check --all"},
        {"--verbose", &options->verbose, "print each query and its answer; no checkpoint"}};
    all.insert(all.end(), more.begin(), more.end());
    const auto run = [=]
    {
        const SoakSubject asked = subject(options->quick);
        return options->verbose ? runVerbosely(asked, *options) : Soak(asked, *options).go();
    };
    return {.name = name, .about = about, .options = all, .run = run};
}
}  // namespace bullet_ccd::benchmarks
