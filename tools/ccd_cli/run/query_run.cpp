#include "tools/ccd_cli/run/query_run.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
constexpr double kNotTimed = -1.0;

class Run
{
public:
    Run(const SsvTree& treeA,
        const SsvTree& treeB,
        std::span<const RigidQuery> queries,
        const RunOptions& options,
        const std::function<bool(std::size_t)>& goOn)
        : m_treeA(treeA),
          m_treeB(treeB),
          m_queries(queries),
          m_options(options),
          m_goOn(goOn),
          m_answers(queries.size()),
          m_cold(queries.size() * static_cast<std::size_t>(options.repeat), kNotTimed),
          m_warm(options.warm ? m_cold.size() : 0, kNotTimed)
    {
    }

    std::vector<TimedAnswer> all()
    {
        const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
        const std::size_t jobs =
            m_options.jobs > 0 ? static_cast<std::size_t>(m_options.jobs) : cores;
        {
            std::vector<std::jthread> threads;
            for (std::size_t k = 1; k < std::min(jobs, m_cold.size()); ++k)
            {
                threads.emplace_back([this] { work(); });
            }
            work();
        }
        if (m_failure)
        {
            std::rethrow_exception(m_failure);
        }
        for (std::size_t k = 0; k < m_answers.size(); ++k)
        {
            m_answers[k].microseconds = median(m_cold, k);
            m_answers[k].warmMicroseconds = m_options.warm ? median(m_warm, k) : 0.0;
        }
        return std::move(m_answers);
    }

private:
    void work()
    {
        try
        {
            ToiWorkspace workspace;
            ToiWorkspace noting;
            ModelUse use;
            noteModelUse(noting, &use);
            if (!m_queries.empty())
            {
                (void)answer(m_queries[0], workspace);
            }
            for (std::size_t k = m_next++; k < m_cold.size(); k = m_next++)
            {
                step(k, workspace);
                if (m_options.uses != nullptr && k < m_queries.size())
                {
                    (void)answer(m_queries[k], noting);
                }
            }
            if (m_options.uses != nullptr)
            {
                const std::scoped_lock lock(m_mutex);
                m_options.uses->push_back(std::move(use));
            }
        }
        catch (...)
        {
            const std::scoped_lock lock(m_mutex);
            m_failure = std::current_exception();
            m_next = m_cold.size();
        }
    }

    /// Query k mod n in pass k / n.
    void step(std::size_t k, ToiWorkspace& workspace)
    {
        const std::size_t index = k % m_queries.size();
        const TimedAnswer timed = answer(m_queries[index], workspace);
        if (k < m_queries.size())
        {
            m_answers[index] = timed;
        }
        if (timed.result.status == ToiStatus::Stopped)
        {
            m_next = m_cold.size();
            return;
        }
        m_cold[k] = timed.microseconds;
        if (m_options.warm)
        {
            const TimedAnswer warm = answer(m_queries[index], workspace);
            m_warm[k] = warm.result.status == ToiStatus::Stopped ? kNotTimed : warm.microseconds;
        }
        if (!m_goOn(++m_count))
        {
            m_next = m_cold.size();
        }
    }

    [[nodiscard]] TimedAnswer answer(const RigidQuery& query, ToiWorkspace& workspace) const
    {
        const RigidBody bodyA{.tree = &m_treeA, .motion = query.motionA};
        const RigidBody bodyB{.tree = &m_treeB, .motion = query.motionB};
        const auto start = std::chrono::steady_clock::now();
        const ToiResult result = rigidToi(bodyA, bodyB, m_options.toi, workspace);
        const auto end = std::chrono::steady_clock::now();
        const std::chrono::duration<double, std::micro> elapsed = end - start;
        return {.isThere = true, .result = result, .microseconds = elapsed.count()};
    }

    [[nodiscard]] double median(const std::vector<double>& times, std::size_t query) const
    {
        std::vector<double> own;
        for (std::size_t k = query; k < times.size(); k += m_queries.size())
        {
            if (times[k] != kNotTimed)
            {
                own.push_back(times[k]);
            }
        }
        return quantile(std::move(own), 0.5);
    }

    const SsvTree& m_treeA;
    const SsvTree& m_treeB;
    std::span<const RigidQuery> m_queries;
    const RunOptions& m_options;
    const std::function<bool(std::size_t)>& m_goOn;
    std::vector<TimedAnswer> m_answers;
    std::vector<double> m_cold;  ///< microseconds, pass after pass
    std::vector<double> m_warm;
    std::atomic<std::size_t> m_next = 0;
    std::atomic<std::size_t> m_count = 0;
    std::mutex m_mutex;
    std::exception_ptr m_failure;
};
}  // namespace

std::vector<TimedAnswer> runQueries(const SsvTree& treeA,
                                    const SsvTree& treeB,
                                    std::span<const RigidQuery> queries,
                                    const RunOptions& options,
                                    const std::function<bool(std::size_t)>& goOn)
{
    return Run(treeA, treeB, queries, options, goOn).all();
}

double quantile(std::vector<double> values, double fraction)
{
    if (values.empty())
    {
        return 0.0;
    }
    std::sort(values.begin(), values.end());
    const double rank = fraction * static_cast<double>(values.size());
    const double last = static_cast<double>(values.size() - 1);
    const double below = std::max(0.0, std::ceil(rank) - 1.0);
    const double above = std::min(last, std::floor(rank));
    return 0.5 *
           (values[static_cast<std::size_t>(below)] + values[static_cast<std::size_t>(above)]);
}
}  // namespace bullet_ccd::tools
