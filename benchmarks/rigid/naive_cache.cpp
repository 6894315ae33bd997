#include "benchmarks/rigid/naive_cache.h"

#include "benchmarks/support/hash.h"

#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
/// Name of a set by the content of its queries.
std::string keyOf(const RigidSet& set)
{
    ContentHash hash;
    for (const RigidQuery& query : set.queries)
    {
        for (const RigidMotion* motion : {&query.motionA, &query.motionB})
        {
            for (const double t : {0.0, 1.0})
            {
                const Eigen::Matrix4d X = motion->at(t).X_W.matrix();
                hash.add(std::span(X.data(), 16));
            }
        }
    }
    return fmt::format("{}:{}:{:016x}", set.name, set.queries.size(), hash.value());
}
}  // namespace

NaiveCache::NaiveCache(std::string file) : m_file(std::move(file))
{
    std::ifstream in(m_file);
    if (m_file.empty() || !in)
    {
        return;
    }
    const nlohmann::json all = nlohmann::json::parse(in);
    for (const auto& [key, entry] : all.items())
    {
        NaiveRun run{.answers = {}, .meanMicros = entry.at("meanMicroseconds")};
        for (const double time : entry.at("times"))
        {
            run.answers.push_back({.hit = time >= 0.0, .time = time >= 0.0 ? time : 1.0});
        }
        m_runs[key] = std::move(run);
    }
}

const NaiveRun* NaiveCache::find(const RigidSet& set) const
{
    const auto found = m_runs.find(keyOf(set));
    return found == m_runs.end() ? nullptr : &found->second;
}

void NaiveCache::store(const RigidSet& set, NaiveRun run)
{
    m_runs[keyOf(set)] = std::move(run);
}

void NaiveCache::save() const
{
    if (m_file.empty())
    {
        return;
    }
    nlohmann::json all;
    for (const auto& [key, run] : m_runs)
    {
        nlohmann::json times = nlohmann::json::array();
        for (const FclAnswer& answer : run.answers)
        {
            times.push_back(answer.hit ? answer.time : -1.0);
        }
        all[key] = {{"meanMicroseconds", run.meanMicros}, {"times", times}};
    }
    std::ofstream out(m_file);
    out << all.dump() << '\n';
    if (!out)
    {
        throw std::runtime_error(m_file + ": cannot be written: name another file");
    }
}
}  // namespace bullet_ccd::benchmarks
