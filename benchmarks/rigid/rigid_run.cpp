#include "benchmarks/rigid/rigid_run.h"

#include "benchmarks/rigid/rigid_targets.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
class SetRun
{
public:
    SetRun(const RigidSet& set, Hierarchies& hierarchies, const RunOptions& options)
        : m_set(set), m_options(options)
    {
        for (const RigidMethod& method : options.methods)
        {
            m_methods.push_back({.method = method,
                                 .treeA = hierarchies.tree(set.meshA, method.kind),
                                 .treeB = hierarchies.tree(set.meshB, method.kind)});
        }
        if (options.fcl && isFclPresent())
        {
            m_modelA = &hierarchies.model(set.meshA);
            m_modelB = &hierarchies.model(set.meshB);
        }
    }

    /// Asks and checks; warms the workspace.
    void answerAll(const NaiveCache& cache)
    {
        findNaive(cache);
        for (const Method& method : m_methods)
        {
            m_rows.push_back(answer(method));
        }
    }

    /// What is to be timed: the peer, then all methods.
    void addTo(std::vector<TimedMethod>& timed)
    {
        const std::size_t count = m_set.queries.size();
        timed.push_back({.queries = m_isKnown ? 0 : count,
                         .passes = m_options.fclRepeats,
                         .ask = [this](std::size_t i) { keep(askPeer(i).time); }});
        for (const Method& method : m_methods)
        {
            timed.push_back({.queries = count,
                             .passes = m_options.repeats,
                             .ask = [this, &method](std::size_t i) { keep(ask(i, method).time); }});
        }
    }

    /// @param micros of what addTo() added
    std::vector<RigidRow> finish(std::span<const std::vector<double>> micros, NaiveCache& cache)
    {
        if (!m_isKnown)
        {
            m_fclMicros = meanOf(micros.front());
            cache.store(m_set, {.answers = m_naive, .meanMicros = m_fclMicros});
        }
        for (std::size_t k = 0; k < m_rows.size(); ++k)
        {
            nlohmann::json& values = m_rows[k].values;
            const double mean = meanOf(micros[k + 1]);
            values["microseconds"] = mean;
            values["fclMicroseconds"] = m_fclMicros;
            values["ratio"] = m_fclMicros > 0.0 ? mean / m_fclMicros : 0.0;
            values["note"] = m_isKnown && m_modelA != nullptr ? "*" : "";
        }
        return std::move(m_rows);
    }

private:
    struct Method
    {
        const RigidMethod& method;
        const SsvTree& treeA;
        const SsvTree& treeB;
    };

    ToiResult ask(std::size_t i, const Method& method)
    {
        const RigidQuery& query = m_set.queries[i];
        return rigidToi({.tree = &method.treeA, .motion = query.motionA},
                        {.tree = &method.treeB, .motion = query.motionB},
                        {.tolerance = m_options.tolerance, .strategy = method.method.strategy},
                        m_work);
    }

    [[nodiscard]] FclAnswer askPeer(std::size_t i) const
    {
        const RigidQuery& query = m_set.queries[i];
        return fclNaive({*m_modelA, query.motionA}, {*m_modelB, query.motionB}, kNaiveSamples);
    }

    RigidRow answer(const Method& method)
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
                                     {method.treeA, method.treeB, m_modelA, m_modelB, m_naive});
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
        const bool isJudged = m_modelA != nullptr || !m_set.references.empty();
        const auto contacts = std::ranges::count_if(
            answers, [](const ToiResult& result) { return isContact(result.status); });
        row.values = {{"set", m_set.name},
                      {"strategy", method.method.name},
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

    /// Answers of the peer, which the check needs; its times, too, if they are known.
    void findNaive(const NaiveCache& cache)
    {
        if (m_modelA == nullptr)
        {
            m_isKnown = true;
        }
        else if (const NaiveRun* cached = cache.find(m_set))
        {
            m_naive = cached->answers;
            m_fclMicros = cached->meanMicros;
            m_isKnown = true;
        }
        else
        {
            for (std::size_t i = 0; i < m_set.queries.size(); ++i)
            {
                m_naive.push_back(askPeer(i));
            }
        }
    }

    const RigidSet& m_set;
    const RunOptions& m_options;
    std::vector<Method> m_methods;
    const FclModel* m_modelA = nullptr;
    const FclModel* m_modelB = nullptr;
    ToiWorkspace m_work;
    std::vector<FclAnswer> m_naive;
    double m_fclMicros = 0.0;
    bool m_isKnown = false;  ///< the peer's time, or there is no peer
    std::vector<RigidRow> m_rows;
};
}  // namespace

const SsvTree& Hierarchies::tree(const Mesh& mesh, VolumeKind kind)
{
    auto& entry = m_trees[{mesh, kind}];
    if (!entry)
    {
        entry = std::make_unique<SsvTree>(buildTreeOf(kind, *mesh));
    }
    return *entry;
}

const FclModel& Hierarchies::model(const Mesh& mesh)
{
    auto& entry = m_models[mesh];
    if (!entry)
    {
        entry = std::make_unique<FclModel>(*mesh);
    }
    return *entry;
}

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

const std::vector<RigidMethod>& allKinds()
{
    static const std::vector<RigidMethod> kKinds{
        {.name = "box", .kind = VolumeKind::Box},
        {.name = "rounded box", .kind = VolumeKind::RoundedBox},
        {.name = "swept rectangle", .kind = VolumeKind::SweptRectangle},
        {.name = "swept line", .kind = VolumeKind::SweptLine},
        {.name = "swept point", .kind = VolumeKind::SweptPoint},
        {.name = "cheapest", .kind = VolumeKind::Cheapest}};
    return kKinds;
}

std::vector<RigidRow> runTogether(std::span<const RigidSet> sets,
                                  const RunOptions& options,
                                  Hierarchies& hierarchies,
                                  NaiveCache& cache)
{
    std::vector<std::unique_ptr<SetRun>> runs;
    std::vector<TimedMethod> timed;
    for (const RigidSet& set : sets)
    {
        runs.push_back(std::make_unique<SetRun>(set, hierarchies, options));
        runs.back()->answerAll(cache);
        runs.back()->addTo(timed);
    }
    const std::vector<std::vector<double>> micros = timeInTurns(timed);
    const std::size_t ofOneSet = options.methods.size() + 1;
    std::vector<RigidRow> rows;
    for (std::size_t i = 0; i < runs.size(); ++i)
    {
        for (RigidRow& row :
             runs[i]->finish(std::span(micros).subspan(i * ofOneSet, ofOneSet), cache))
        {
            rows.push_back(std::move(row));
        }
    }
    return rows;
}
}  // namespace bullet_ccd::benchmarks
