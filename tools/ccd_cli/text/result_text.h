/// Results of queries as text: for tables, for programs, for people.
///
/// All numbers have the shortest digits that give the same double back.
#pragma once

#include "bullet_ccd/contact/contacts.h"
#include "tools/ccd_cli/run/query_run.h"

#include <cstddef>
#include <span>
#include <string>

namespace bullet_ccd::tools
{
/// separated, hit, overlapping, touching_leaving, touching_pressing, iteration_limit or stopped.
[[nodiscard]] std::string statusWord(ToiStatus status);

/// Instead of a status for rows that are no query.
inline constexpr const char* kBadRowWord = "bad_row";

/// First line of the table, without line end.
[[nodiscard]] std::string resultHeader(bool warm);

/// One row. p is the middle of the two witness points; p and n are empty where there is no contact,
/// n also if the surfaces intersect, and the gap if the query gave up.
[[nodiscard]] std::string resultRow(const std::string& id, const TimedAnswer& answer, bool warm);
[[nodiscard]] std::string badResultRow(const std::string& id, bool warm);

/// One JSON object, a few lines and one for each contact; null for what there is not. A hit has
/// contacts, other answers have none.
[[nodiscard]] std::string jsonText(const TimedAnswer& answer,
                                   std::span<const FeatureContact> contacts);

/// Three numbers as JSON, or null.
[[nodiscard]] std::string jsonArray(const Eigen::Vector3d& v, bool present = true);

/// "contact", or the distance that must be kept: what is excluded before the time of an answer.
[[nodiscard]] std::string excludedWords(const ToiOptions& options);

/// Contacts that readableText() names; of others it gives the number.
inline constexpr std::size_t kShownContacts = 20;

/// Some lines to read.
[[nodiscard]] std::string readableText(const TimedAnswer& answer,
                                       const ToiOptions& options,
                                       std::span<const FeatureContact> contacts);
}  // namespace bullet_ccd::tools
