#include "benchmarks/rigid/rigid_run.h"

#include "benchmarks/support/timing.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
class SetRun
{
public:
    SetRun(const RigidSet& set, const RunOptions& options)
        : m_set(set),
          m_options(options),
          m_treeA(std::make_shared<const SsvTree>(buildSsvTree(*set.meshA))),
          m_treeB(set.meshB == set.meshA
                      ? m_treeA
                      : std::make_shared<const SsvTree>(buildSsvTree(*set.meshB)))
    {
        if (options.fcl)
        {
            m_modelA.emplace(*set.meshA);
            m_modelB = set.meshB == set.meshA ? m_modelA : FclModel(*set.meshB);
        }
    }

    /// Asks, checks and warms the workspace; then all take turns, the peer first.
    std::vector<RigidRow> run()
    {
        for (std::size_t i = 0; m_modelA && i < m_set.queries.size(); ++i)
        {
            m_naive.push_back(askPeer(i));
        }
        std::vector<RigidRow> rows;
        std::vector<TimedMethod> timed{{.queries = m_naive.size(),
                                        .passes = m_options.fclRepeats,
                                        .ask = [this](std::size_t i) { keep(askPeer(i).time); }}};
        for (const RigidMethod& method : m_options.methods)
        {
            rows.push_back(answer(method));
            timed.push_back({.queries = m_set.queries.size(),
                             .passes = m_options.repeats,
                             .ask = [this, &method](std::size_t i) { keep(ask(i, method).time); }});
        }
        const std::vector<std::vector<double>> micros = timeInTurns(timed);
        const double fcl = meanOf(micros.front());
        for (std::size_t k = 0; k < rows.size(); ++k)
        {
            const double mean = meanOf(micros[k + 1]);
            rows[k].values["microseconds"] = mean;
            rows[k].values["fclMicroseconds"] = fcl;
            rows[k].values["ratio"] = fcl > 0.0 ? mean / fcl : 0.0;
        }
        return rows;
    }

private:
    ToiResult ask(std::size_t i, const RigidMethod& method)
    {
        const RigidQuery& query = m_set.queries[i];
        return rigidToi({.tree = m_treeA.get(), .motion = query.motionA},
                        {.tree = m_treeB.get(), .motion = query.motionB},
                        {.tolerance = m_options.tolerance, .strategy = method.strategy},
                        m_work);
    }

    [[nodiscard]] FclAnswer askPeer(std::size_t i) const
    {
        const RigidQuery& query = m_set.queries[i];
        return fclNaive({*m_modelA, query.motionA}, {*m_modelB, query.motionB}, kNaiveSamples);
    }

    RigidRow answer(const RigidMethod& method)
    {
        std::vector<ToiResult> answers;
        for (std::size_t i = 0; i < m_set.queries.size(); ++i)
        {
            answers.push_back(ask(i, method));
        }
        RigidRow row;
        if (m_options.check)
        {
            row.check = checkAnswers(m_set,
                                     answers,
                                     m_options.tolerance,
                                     {*m_treeA,
                                      *m_treeB,
                                      m_modelA ? &*m_modelA : nullptr,
                                      m_modelB ? &*m_modelB : nullptr,
                                      m_naive});
        }
        const auto mean = [&](std::int64_t ToiCounters::*number)
        {
            double sum = 0.0;
            for (const ToiResult& result : answers)
            {
                sum += static_cast<double>(result.counters.*number);
            }
            return sum / static_cast<double>(answers.size());
        };
        const std::vector<double>& errors = row.check.errors;
        const bool isJudged = m_modelA || !m_set.references.empty();
        const auto contacts = std::ranges::count_if(
            answers, [](const ToiResult& result) { return isContact(result.status); });
        row.values = {{"set", m_set.name},
                      {"strategy", method.name},
                      {"queries", answers.size()},
                      {"contacts", contacts},
                      {"hits", isJudged && m_options.check ? row.check.hits : contacts},
                      {"missed", row.check.missed},
                      {"late", row.check.late},
                      {"false", row.check.falseHits},
                      {"early", row.check.early},
                      {"badGaps", row.check.badGaps},
                      {"gaveUp", row.check.gaveUp},
                      {"medianToiError", medianOf(errors)},
                      {"maxToiError", errors.empty() ? 0.0 : std::ranges::max(errors)},
                      {"nodePairs", mean(&ToiCounters::nodePairs)},
                      {"trianglePairs", mean(&ToiCounters::trianglePairs)},
                      {"states", mean(&ToiCounters::states)}};
        return row;
    }

    const RigidSet& m_set;
    const RunOptions& m_options;
    std::shared_ptr<const SsvTree> m_treeA;
    std::shared_ptr<const SsvTree> m_treeB;
    std::optional<FclModel> m_modelA;
    std::optional<FclModel> m_modelB;
    ToiWorkspace m_work;
    std::vector<FclAnswer> m_naive;
};
}  // namespace

std::vector<RigidMethod> strategiesNamed(const std::vector<std::string>& names)
{
    static const std::vector<RigidMethod> kAll{{"best-first", ToiStrategy::BestFirst},
                                               {"interval", ToiStrategy::Interval},
                                               {"c2a", ToiStrategy::C2A}};
    if (names == std::vector<std::string>{"all"})
    {
        return kAll;
    }
    std::vector<RigidMethod> methods;
    for (const std::string& name : names)
    {
        const auto found = std::ranges::find(kAll, name, &RigidMethod::name);
        if (found == kAll.end())
        {
            throw std::invalid_argument("strategy '" + name +
                                        "' is unknown: best-first, interval, c2a or all");
        }
        methods.push_back(*found);
    }
    return methods;
}

std::vector<RigidRow> runSet(const RigidSet& set, const RunOptions& options)
{
    return SetRun(set, options).run();
}
}  // namespace bullet_ccd::benchmarks
