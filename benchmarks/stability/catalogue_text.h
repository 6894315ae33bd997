/// Results of the catalogue as JSON and as Markdown tables.
#pragma once

#include "benchmarks/stability/catalogue_run.h"

#include <nlohmann/json_fwd.hpp>

namespace bullet_ccd::tests
{
/// Both tables, the rows that are tested elsewhere, and how it was built.
[[nodiscard]] nlohmann::json toJson(std::span<const CatalogueTable> tables,
                                    const CatalogueOptions& options);

/// A line a case, a column a method; sums.
[[nodiscard]] std::string toMarkdown(const CatalogueTable& table);
}  // namespace bullet_ccd::tests
