/// Answers and times many rigid queries over the same two meshes.
#pragma once

#include "bullet_ccd/toi/model_use.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "tools/ccd_cli/files/query_file.h"
#include "tools/support/obstacles/model_share.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace bullet_ccd::tools
{
struct RunOptions
{
    ToiOptions toi;
    int jobs = 1;       ///< threads, 0 for one a core
    int repeat = 1;     ///< passes over all queries
    bool warm = false;  ///< ask every query again at once, and time that
    /// Where to add what the queries looked at, one for each thread; null: nowhere. They are asked
    /// once more for that, untimed.
    std::vector<ModelUse>* uses = nullptr;
};

struct TimedAnswer
{
    bool isThere = false;  ///< false if the run was stopped before
    ToiResult result;
    double microseconds = 0.0;           ///< of rigidToi() alone; median of the passes
    double warmMicroseconds = 0.0;       ///< likewise of the second time in a row
    std::optional<ModelShare> needed{};  ///< where somebody asked
};

/// Answers in the order of the queries; but for the times they do not depend on jobs and repeat.
///
/// Every thread has one workspace, used once before anything is timed. Between two times of one
/// query that enter its median lie all other queries.
/// @param goOn  called after every query by any thread, with the number of queries answered so far;
///              no further one is begun once it has returned false, or options.toi.stop is due
/// Rethrows what a query throws, after all threads have stopped.
[[nodiscard]] std::vector<TimedAnswer> runQueries(const SsvTree& treeA,
                                                  const SsvTree& treeB,
                                                  std::span<const RigidQuery> queries,
                                                  const RunOptions& options,
                                                  const std::function<bool(std::size_t)>& goOn);

/// The value that `fraction` of the values, 0 to 1, do not exceed; where two values fit equally
/// well, as for the median of an even number, their mean. 0 without values.
[[nodiscard]] double quantile(std::vector<double> values, double fraction);
}  // namespace bullet_ccd::tools
