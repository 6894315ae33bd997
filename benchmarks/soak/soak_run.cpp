#include "benchmarks/soak/soak_run.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

namespace bullet_ccd::tests
{
namespace
{
using Clock = std::chrono::steady_clock;

struct Chunk
{
    std::uint64_t end = 0;
    std::vector<SoakTally> tallies = {};
    std::vector<std::uint64_t> failures = {};
};

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Hands out chunks of seeds and takes them back in any order; what is certain to be complete is
/// the part without holes.
class Ledger
{
public:
    Ledger(const SoakSubject& subject, const SoakRun& run, Checkpoint state)
        : m_subject(subject),
          m_run(run),
          m_state(std::move(state)),
          m_handedOut(m_state.nextSeed),
          m_resumedAt(m_state.nextSeed)
    {
    }

    /// First seed of the next chunk; the end of the run when there is none.
    std::uint64_t take()
    {
        const std::lock_guard lock(m_mutex);
        const std::uint64_t seed = m_handedOut;
        m_handedOut = endOfChunk(seed);
        return seed;
    }

    void giveBack(std::uint64_t first, Chunk chunk)
    {
        const std::lock_guard lock(m_mutex);
        m_done.emplace(first, std::move(chunk));
        while (!m_done.empty() && m_done.begin()->first == m_state.nextSeed)
        {
            const Chunk& next = m_done.begin()->second;
            for (std::size_t i = 0; i < next.tallies.size(); ++i)
            {
                m_state.tallies[i].add(next.tallies[i]);
            }
            m_state.failures.insert(
                m_state.failures.end(), next.failures.begin(), next.failures.end());
            m_state.nextSeed = next.end;
            m_done.erase(m_done.begin());
        }
        save(m_state, m_subject, m_run.checkpointPath);
        report();
    }

    void mention(std::uint64_t seed, const SoakAnswer& answer)
    {
        const std::lock_guard lock(m_mutex);
        const bool isUndecided = answer.judgement.verdict == Verdict::Undecided;
        std::printf("%s seed %llu (%s): %s\n  tools/%s --seed %llu --count 1 --verbose\n",
                    isUndecided ? "not decided:" : "FAILED",
                    static_cast<unsigned long long>(seed),
                    m_subject.families[answer.family].c_str(),
                    answer.judgement.text().c_str(),
                    m_subject.program.c_str(),
                    static_cast<unsigned long long>(seed));
        std::fflush(stdout);
    }

    [[nodiscard]] std::uint64_t end() const { return m_run.firstSeed + m_run.count; }
    [[nodiscard]] std::uint64_t endOfChunk(std::uint64_t first) const
    {
        return std::min(end(), first + m_subject.round);
    }
    [[nodiscard]] const SoakSubject& subject() const { return m_subject; }
    [[nodiscard]] const Checkpoint& state() const { return m_state; }

private:
    void report()
    {
        const bool isLast = m_state.nextSeed == end();
        if (!isLast && secondsSince(m_reported) < 5.0)
        {
            return;
        }
        m_reported = Clock::now();
        const auto done = static_cast<double>(m_state.nextSeed - m_run.firstSeed);
        const auto fresh = static_cast<double>(m_state.nextSeed - m_resumedAt);
        const double rate = fresh / std::max(1e-9, secondsSince(m_started));
        const double left = (static_cast<double>(m_run.count) - done) / std::max(1.0, rate);
        std::printf("%.0f of %llu (%.1f %%), %.0f a second, %.0f s left, %zu failures\n",
                    done,
                    static_cast<unsigned long long>(m_run.count),
                    100.0 * done / static_cast<double>(m_run.count),
                    rate,
                    left,
                    m_state.failures.size());
        std::fflush(stdout);
    }

    const SoakSubject& m_subject;
    const SoakRun& m_run;
    Checkpoint m_state;
    std::uint64_t m_handedOut;
    std::uint64_t m_resumedAt;
    std::mutex m_mutex;
    std::map<std::uint64_t, Chunk> m_done;
    Clock::time_point m_started = Clock::now();
    Clock::time_point m_reported = m_started;
};

void work(Ledger& ledger)
{
    const SoakSubject& subject = ledger.subject();
    for (std::uint64_t first = ledger.take(); first < ledger.end(); first = ledger.take())
    {
        Chunk chunk{.end = ledger.endOfChunk(first)};
        chunk.tallies.resize(subject.families.size());
        for (std::uint64_t seed = first; seed < chunk.end; ++seed)
        {
            const SoakAnswer answer = subject.ask(seed);
            const Verdict verdict = answer.judgement.verdict;
            chunk.tallies[answer.family].add(answer.status, verdict);
            if (verdict != Verdict::Right)
            {
                ledger.mention(seed, answer);
            }
            if (verdict != Verdict::Right && verdict != Verdict::Undecided)
            {
                chunk.failures.push_back(seed);
            }
        }
        ledger.giveBack(first, std::move(chunk));
    }
}

Checkpoint startOf(const SoakSubject& subject, const SoakRun& run)
{
    Checkpoint start{.firstSeed = run.firstSeed, .nextSeed = run.firstSeed};
    start.tallies.resize(subject.families.size());
    if (!run.resume)
    {
        return start;
    }
    const std::optional<Checkpoint> kept = load(subject, run.checkpointPath);
    if (!kept)
    {
        return start;
    }
    if (kept->firstSeed != run.firstSeed || kept->nextSeed > run.firstSeed + run.count)
    {
        throw std::runtime_error(run.checkpointPath + ": belongs to another range of seeds (from " +
                                 std::to_string(kept->firstSeed) + ", done before " +
                                 std::to_string(kept->nextSeed) +
                                 "): run without --resume, or choose another --checkpoint");
    }
    return *kept;
}
}  // namespace

Checkpoint runSoak(const SoakSubject& subject, const SoakRun& run)
{
    Ledger ledger(subject, run, startOf(subject, run));
    std::vector<std::thread> threads;
    for (int i = 1; i < run.jobs; ++i)
    {
        threads.emplace_back([&ledger] { work(ledger); });
    }
    work(ledger);
    for (std::thread& thread : threads)
    {
        thread.join();
    }
    return ledger.state();
}
}  // namespace bullet_ccd::tests
