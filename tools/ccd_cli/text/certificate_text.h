/// Certificates of trajectories as text, for people and for tables. Numbers for tables have the
/// shortest digits that give the same double back.
#pragma once

#include "tools/ccd_cli/run/certify_run.h"
#include "tools/ccd_cli/text/articulated_text.h"

#include <string>

namespace bullet_ccd::tools
{
/// free, contact, unknown or bad_input.
[[nodiscard]] std::string verdictWord(Verdict verdict);

/// Some lines to read.
[[nodiscard]] std::string readableText(const Certificate& certificate,
                                       const ArticulatedNames& names,
                                       const ToiOptions& options);

/// First line of the table, without line end.
[[nodiscard]] std::string certificateHeader();

/// One row.
[[nodiscard]] std::string certificateRow(const Certificate& certificate,
                                         const ArticulatedNames& names);
}  // namespace bullet_ccd::tools
