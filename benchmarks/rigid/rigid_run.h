/// Answers, checks and times of query sets.
#pragma once

#include "benchmarks/rigid/naive_cache.h"
#include "benchmarks/rigid/rigid_check.h"
#include "benchmarks/rigid/rigid_sets.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
struct RunOptions
{
    std::vector<std::string> strategies{"best-first"};
    double tolerance = 1e-4;
    int repeats = 7;
    int fclRepeats = 3;
    bool check = true;
};

/// One set by one strategy.
struct RigidRow
{
    std::string set;
    std::string strategy;
    std::size_t queries = 0;
    CheckResult check{};
    double micros = 0.0;     ///< mean
    double fclMicros = 0.0;  ///< mean; 0 without FCL
    bool isFclCached = false;
    double nodePairs = 0.0;
    double trianglePairs = 0.0;
    double states = 0.0;

    [[nodiscard]] double ratio() const { return fclMicros > 0.0 ? micros / fclMicros : 0.0; }
};

/// Hierarchies of both sides, shared between sets with the same mesh.
class Hierarchies
{
public:
    const SsvTree& tree(const std::shared_ptr<const TriangleMesh>& mesh);
    const FclModel& model(const std::shared_ptr<const TriangleMesh>& mesh);

private:
    std::map<std::shared_ptr<const TriangleMesh>, std::unique_ptr<SsvTree>> m_trees;
    std::map<std::shared_ptr<const TriangleMesh>, std::unique_ptr<FclModel>> m_models;
};

/// The strategy of that name; throws std::invalid_argument for an unknown one.
[[nodiscard]] ToiStrategy strategyNamed(const std::string& name);

/// Answers and checks all sets, then times them in turns, so that sets which are compared with each
/// other see the same machine. Rows by set, then by strategy.
[[nodiscard]] std::vector<RigidRow> runTogether(std::span<const RigidSet> sets,
                                                const RunOptions& options,
                                                Hierarchies& hierarchies,
                                                NaiveCache& cache);
}  // namespace bullet_ccd::benchmarks
