/// Counts and times of a batch.
#pragma once

#include "tools/ccd_cli/files/mesh_pair.h"
#include "tools/ccd_cli/run/query_run.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace bullet_ccd::tools
{
struct BatchSummary
{
    std::span<const TimedAnswer> answers;
    std::size_t badRows = 0;
    bool warm = false;
    double loadSeconds = 0.0;
    double buildSeconds = 0.0;
    double wallSeconds = 0.0;  ///< of all queries and repeats together
    std::optional<ModelShare> needed{};
};

/// Lines "<name>: <value>".
[[nodiscard]] std::string summaryText(const BatchSummary& summary);
}  // namespace bullet_ccd::tools
