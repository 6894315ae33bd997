/// Answers, checks and times of query sets.
#pragma once

#include "benchmarks/rigid/naive_cache.h"
#include "benchmarks/rigid/rigid_check.h"
#include "benchmarks/rigid/rigid_sets.h"
#include "benchmarks/rigid/volume_kinds.h"

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// A way to answer: a strategy of the query, on volumes of a kind.
struct RigidMethod
{
    std::string name;
    ToiStrategy strategy = ToiStrategy::BestFirst;
    VolumeKind kind = VolumeKind::RoundedBox;
};

/// The strategies of those names. Throws std::invalid_argument for an unknown one.
[[nodiscard]] std::vector<RigidMethod> strategiesNamed(const std::vector<std::string>& names);
/// The default strategy on every kind of volumes.
[[nodiscard]] const std::vector<RigidMethod>& allKinds();

struct RunOptions
{
    std::vector<RigidMethod> methods{{.name = "best-first"}};
    double tolerance = 1e-4;
    int repeats = 7;
    int fclRepeats = 3;
    bool check = true;
    bool fcl = true;  ///< if it is present
};

/// One set by one method.
struct RigidRow
{
    nlohmann::json values;  ///< "set", "strategy", "hits", "microseconds", ..
    CheckResult check;
};

/// Hierarchies of both sides, shared between sets with the same mesh.
class Hierarchies
{
public:
    const SsvTree& tree(const std::shared_ptr<const TriangleMesh>& mesh, VolumeKind kind);
    const FclModel& model(const std::shared_ptr<const TriangleMesh>& mesh);

private:
    using Mesh = std::shared_ptr<const TriangleMesh>;

    std::map<std::pair<Mesh, VolumeKind>, std::unique_ptr<SsvTree>> m_trees;
    std::map<Mesh, std::unique_ptr<FclModel>> m_models;
};

/// Answers and checks all sets, then times them in turns, so that sets which are compared with each
/// other see the same machine. Rows by set, then by method.
[[nodiscard]] std::vector<RigidRow> runTogether(std::span<const RigidSet> sets,
                                                const RunOptions& options,
                                                Hierarchies& hierarchies,
                                                NaiveCache& cache);
}  // namespace bullet_ccd::benchmarks
