#include "tools/soak/soak_run.h"

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
constexpr std::uint64_t kChunk = 480;  // whole rounds of families and strategies

struct Chunk
{
    std::uint64_t end = 0;
    SoakTallies tallies = {};
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
    Ledger(const SoakRun& run, Checkpoint state)
        : m_run(run),
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
        m_handedOut = std::min(end(), seed + kChunk);
        return seed;
    }

    void giveBack(std::uint64_t first, Chunk chunk)
    {
        const std::lock_guard lock(m_mutex);
        m_done.emplace(first, std::move(chunk));
        while (!m_done.empty() && m_done.begin()->first == m_state.nextSeed)
        {
            const Chunk& next = m_done.begin()->second;
            for (std::size_t i = 0; i < kSoakFamilies; ++i)
            {
                m_state.tallies[i].add(next.tallies[i]);
            }
            m_state.failures.insert(
                m_state.failures.end(), next.failures.begin(), next.failures.end());
            m_state.nextSeed = next.end;
            m_done.erase(m_done.begin());
        }
        report();
    }

    void mention(std::uint64_t seed, const SoakQuery& query, const SoakOutcome& outcome)
    {
        const std::lock_guard lock(m_mutex);
        const bool isUndecided = outcome.judgement.verdict == Verdict::Undecided;
        std::printf(
            "%s seed %llu (%s, %s): %s\n  tools/soak_rigid --seed %llu --count 1 --verbose\n",
            isUndecided ? "not decided:" : "FAILED",
            static_cast<unsigned long long>(seed),
            nameOf(query.family),
            nameOf(query.options.strategy),
            outcome.judgement.text().c_str(),
            static_cast<unsigned long long>(seed));
        std::fflush(stdout);
    }

    [[nodiscard]] std::uint64_t end() const { return m_run.firstSeed + m_run.count; }

    Checkpoint finish()
    {
        keep();
        return m_state;
    }

private:
    void report()
    {
        const bool isLast = m_state.nextSeed == end();
        if (!isLast && secondsSince(m_reported) < 5.0)
        {
            return;
        }
        m_reported = Clock::now();
        keep();
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

    void keep() const
    {
        if (!m_run.checkpointPath.empty())
        {
            save(m_state, m_run.checkpointPath);
        }
    }

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
    for (std::uint64_t first = ledger.take(); first < ledger.end(); first = ledger.take())
    {
        Chunk chunk{.end = std::min(ledger.end(), first + kChunk)};
        for (std::uint64_t seed = first; seed < chunk.end; ++seed)
        {
            const SoakQuery query = soakQuery(seed);
            const SoakOutcome outcome = runSoakQuery(query);
            chunk.tallies[static_cast<std::size_t>(query.family)].add(outcome);
            const Verdict verdict = outcome.judgement.verdict;
            if (verdict != Verdict::Right)
            {
                ledger.mention(seed, query, outcome);
            }
            if (verdict != Verdict::Right && verdict != Verdict::Undecided)
            {
                chunk.failures.push_back(seed);
            }
        }
        ledger.giveBack(first, std::move(chunk));
    }
}

Checkpoint startOf(const SoakRun& run)
{
    Checkpoint start{.firstSeed = run.firstSeed, .nextSeed = run.firstSeed};
    if (!run.resume)
    {
        return start;
    }
    const std::optional<Checkpoint> kept = load(run.checkpointPath);
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

Checkpoint runSoak(const SoakRun& run)
{
    Ledger ledger(run, startOf(run));
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
    return ledger.finish();
}
}  // namespace bullet_ccd::tests
