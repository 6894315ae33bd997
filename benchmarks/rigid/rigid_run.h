/// Answers, checks and times of query sets.
#pragma once

#include "benchmarks/rigid/rigid_check.h"
#include "benchmarks/rigid/rigid_sets.h"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
struct RigidMethod
{
    std::string name;
    ToiStrategy strategy = ToiStrategy::BestFirst;
};

/// The strategies of those names. Throws std::invalid_argument for an unknown one.
[[nodiscard]] std::vector<RigidMethod> strategiesNamed(const std::vector<std::string>& names);

struct RunOptions
{
    std::vector<RigidMethod> methods{{.name = "best-first"}};
    double tolerance = 1e-4;
    int repeats = 7;
    int fclRepeats = 3;
    bool check = true;
    bool fcl = true;
};

/// One set by one method.
struct RigidRow
{
    nlohmann::json values;  ///< "set", "strategy", "hits", "microseconds", ..
    CheckResult check;
};

/// Answers and checks a set, then times all methods in turns.
/// @return a row per method
[[nodiscard]] std::vector<RigidRow> runSet(const RigidSet& set, const RunOptions& options);
}  // namespace bullet_ccd::benchmarks
