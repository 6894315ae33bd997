#include "benchmarks/rigid/rigid_run.h"

#include "benchmarks/rigid/rigid_targets.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <optional>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
/// Times of one method: per query, one entry a repeat.
using Times = std::vector<std::vector<double>>;

class SetRun
{
public:
    SetRun(const RigidSet& set, Hierarchies& hierarchies, const RunOptions& options)
        : m_set(set),
          m_options(options),
          m_treeA(hierarchies.tree(set.meshA)),
          m_treeB(hierarchies.tree(set.meshB))
    {
        if (isFclPresent())
        {
            m_modelA = &hierarchies.model(set.meshA);
            m_modelB = &hierarchies.model(set.meshB);
        }
    }

    /// Asks and checks; warms the workspace.
    void begin(const NaiveCache& cache)
    {
        m_isCached = findNaive(cache);
        for (const std::string& strategy : m_options.strategies)
        {
            m_rows.push_back(answer(strategy));
        }
        m_times.assign(m_rows.size(), Times(m_set.queries.size()));
    }

    void timeRepeat(int repeat)
    {
        if (!m_isCached && repeat < m_options.fclRepeats)
        {
            timeNaiveOnce();
        }
        for (std::size_t k = 0; k < m_rows.size(); ++k)
        {
            timeOnce(m_rows[k].strategy, m_times[k]);
        }
    }

    std::vector<RigidRow> finish(NaiveCache& cache)
    {
        if (!m_isCached)
        {
            m_fclMicros = meanOfMedians(m_naiveTimes);
            cache.store(m_set, {.answers = m_naive, .meanMicros = m_fclMicros});
        }
        for (std::size_t k = 0; k < m_rows.size(); ++k)
        {
            m_rows[k].micros = meanOfMedians(m_times[k]);
            m_rows[k].fclMicros = m_fclMicros;
            m_rows[k].isFclCached = m_isCached && m_modelA != nullptr;
        }
        return m_rows;
    }

private:
    ToiResult ask(const RigidQuery& query, ToiStrategy strategy)
    {
        const RigidBody a{.tree = &m_treeA, .motion = query.motionA};
        const RigidBody b{.tree = &m_treeB, .motion = query.motionB};
        return rigidToi(a, b, {.tolerance = m_options.tolerance, .strategy = strategy}, m_work);
    }

    /// Answers all queries, warms the workspace, checks.
    RigidRow answer(const std::string& strategy)
    {
        RigidRow row{.set = m_set.name, .strategy = strategy, .queries = m_set.queries.size()};
        std::vector<ToiResult> answers;
        for (const RigidQuery& query : m_set.queries)
        {
            answers.push_back(ask(query, strategyNamed(strategy)));
            row.nodePairs += static_cast<double>(answers.back().counters.nodePairs);
            row.trianglePairs += static_cast<double>(answers.back().counters.trianglePairs);
            row.states += static_cast<double>(answers.back().counters.states);
        }
        const double n = static_cast<double>(row.queries);
        row.nodePairs /= n;
        row.trianglePairs /= n;
        row.states /= n;
        if (!m_options.check)
        {
            return row;
        }
        std::optional<PeerView> peer;
        if (m_modelA != nullptr)
        {
            peer.emplace(PeerView{*m_modelA, *m_modelB, m_naive});
        }
        row.check = checkAnswers(m_set, answers, m_options.tolerance, peer ? &*peer : nullptr);
        return row;
    }

    void timeOnce(const std::string& strategyName, Times& times)
    {
        const ToiStrategy strategy = strategyNamed(strategyName);
        for (std::size_t i = 0; i < m_set.queries.size(); ++i)
        {
            times[i].push_back(microsecondsOf([&] { keep(ask(m_set.queries[i], strategy).time); }));
        }
    }

    /// Answers of the peer, which the check needs; true if they and their times were known.
    bool findNaive(const NaiveCache& cache)
    {
        if (m_modelA == nullptr)
        {
            return true;
        }
        if (const NaiveRun* cached = cache.find(m_set))
        {
            m_naive = cached->answers;
            m_fclMicros = cached->meanMicros;
            return true;
        }
        for (const RigidQuery& query : m_set.queries)
        {
            m_naive.push_back(
                fclNaive({*m_modelA, query.motionA}, {*m_modelB, query.motionB}, kNaiveSamples));
        }
        m_naiveTimes.resize(m_set.queries.size());
        return false;
    }

    void timeNaiveOnce()
    {
        for (std::size_t i = 0; i < m_set.queries.size(); ++i)
        {
            const RigidQuery& query = m_set.queries[i];
            const FclBody a{*m_modelA, query.motionA};
            const FclBody b{*m_modelB, query.motionB};
            m_naiveTimes[i].push_back(
                microsecondsOf([&] { keep(fclNaive(a, b, kNaiveSamples).time); }));
        }
    }

    const RigidSet& m_set;
    const RunOptions& m_options;
    const SsvTree& m_treeA;
    const SsvTree& m_treeB;
    const FclModel* m_modelA = nullptr;
    const FclModel* m_modelB = nullptr;
    ToiWorkspace m_work;
    std::vector<FclAnswer> m_naive;
    Times m_naiveTimes;
    double m_fclMicros = 0.0;
    bool m_isCached = false;
    std::vector<RigidRow> m_rows;
    std::vector<Times> m_times;
};
}  // namespace

const SsvTree& Hierarchies::tree(const std::shared_ptr<const TriangleMesh>& mesh)
{
    auto& entry = m_trees[mesh];
    if (!entry)
    {
        entry = std::make_unique<SsvTree>(buildSsvTree(*mesh));
    }
    return *entry;
}

const FclModel& Hierarchies::model(const std::shared_ptr<const TriangleMesh>& mesh)
{
    auto& entry = m_models[mesh];
    if (!entry)
    {
        entry = std::make_unique<FclModel>(*mesh);
    }
    return *entry;
}

ToiStrategy strategyNamed(const std::string& name)
{
    if (name == "best-first")
    {
        return ToiStrategy::BestFirst;
    }
    if (name == "interval")
    {
        return ToiStrategy::Interval;
    }
    if (name == "c2a")
    {
        return ToiStrategy::C2A;
    }
    throw std::invalid_argument("strategy '" + name + "' is unknown: best-first, interval or c2a");
}

std::vector<RigidRow> runTogether(std::span<const RigidSet> sets,
                                  const RunOptions& options,
                                  Hierarchies& hierarchies,
                                  NaiveCache& cache)
{
    std::vector<std::unique_ptr<SetRun>> runs;
    for (const RigidSet& set : sets)
    {
        runs.push_back(std::make_unique<SetRun>(set, hierarchies, options));
        runs.back()->begin(cache);
    }
    for (int repeat = 0; repeat < options.repeats; ++repeat)
    {
        for (const auto& run : runs)
        {
            run->timeRepeat(repeat);
        }
    }
    std::vector<RigidRow> rows;
    for (const auto& run : runs)
    {
        for (RigidRow& row : run->finish(cache))
        {
            rows.push_back(std::move(row));
        }
    }
    return rows;
}
}  // namespace bullet_ccd::benchmarks
