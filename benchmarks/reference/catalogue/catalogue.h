/// The rows of the stability catalogue: what each is about and where it is tested.
///
/// The letter of an id is its group. Rows with cases (cases.h) run through all methods; the others
/// are properties, tested where they are named, or need bodies that deform.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace bullet_ccd::reference
{
struct CatalogueRow
{
    std::string_view id;
    std::string_view title;  ///< the set-up and what is hard about it
    /// "" for a row with a case; "path of a test file: Suite.Name" for a property; kDeformable.
    std::string_view tested = {};
};

inline constexpr std::string_view kDeformable = "comes with deformable bodies";

/// All rows, ordered by id.
[[nodiscard]] std::span<const CatalogueRow> catalogueRows();

/// Throws std::invalid_argument for an id that is not in the catalogue.
[[nodiscard]] const CatalogueRow& catalogueRow(std::string_view id);

/// All rows as a Markdown table.
[[nodiscard]] std::string catalogueTable();

/// Title of the group that the id belongs to.
[[nodiscard]] std::string_view groupTitle(std::string_view id);
}  // namespace bullet_ccd::reference
