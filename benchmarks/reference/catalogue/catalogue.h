/// The rows of the stability catalogue: what each is about and where it is tested. They stand in
/// README.md and are read from there.
///
/// The letter of an id is its group. Rows with cases (cases.h) run through all methods; the others
/// are properties, tested where they are named.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace bullet_ccd::reference
{
struct CatalogueRow
{
    std::string id;
    std::string group;  ///< its title
    std::string title;  ///< the set-up and what is hard about it
    std::string where;  ///< kIsCase, or "`Suite.Name`", a test, for a property
};

inline constexpr std::string_view kIsCase = "case, all methods";

/// All rows, ordered by id. Throws std::runtime_error if README.md is not where it was when this
/// was compiled.
[[nodiscard]] const std::vector<CatalogueRow>& catalogueRows();

/// Throws std::invalid_argument for an id that is not in the catalogue.
[[nodiscard]] const CatalogueRow& catalogueRow(std::string_view id);
}  // namespace bullet_ccd::reference
