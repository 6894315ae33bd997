/// Answers of robots as text: for tables, for programs, for people. Numbers for tables and programs
/// have the shortest digits that give the same double back.
#pragma once

#include "tools/ccd_cli/run/articulated_run.h"
#include "tools/support/obstacles/model_share.h"
#include "tools/support/obstacles/obstacle_list.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace bullet_ccd::tools
{
/// Who is who in the answers.
struct ArticulatedNames
{
    const RobotLinks& links;
    std::span<const Obstacle> obstacles;
};

/// One query as it is shown: its first contacts, or those of a sequence.
struct ArticulatedReport
{
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;
    std::span<const LinkContact> contacts;
    std::size_t shown = 0;                ///< how many of the contacts to show
    std::span<const double> stopTimes{};  ///< of a sequence
    ArticulatedCounters counters;
    double microseconds = 0.0;
    std::optional<ModelShare> needed{};
};

/// Some lines to read.
[[nodiscard]] std::string readableText(const ArticulatedReport& report,
                                       const ArticulatedNames& names,
                                       const ToiOptions& options);

/// One JSON object; null for what there is not.
[[nodiscard]] std::string jsonText(const ArticulatedReport& report, const ArticulatedNames& names);

/// First line of the table, without line end.
[[nodiscard]] std::string articulatedHeader();

/// One row: the first contact, and how many there are at that time.
[[nodiscard]] std::string articulatedRow(const std::string& id,
                                         const ArticulatedAnswer& answer,
                                         const ArticulatedNames& names);
}  // namespace bullet_ccd::tools
