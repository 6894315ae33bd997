/// Every case through every method, and every relation on the cases that a method gets right.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace bullet_ccd::benchmarks
{
struct CatalogueOptions
{
    double limit = 30.0;         ///< seconds for a case
    double variantLimit = 10.0;  ///< and for a variant
    std::string only = {};       ///< one case, by its id
    bool relations = true;
    bool firstVariantOnly = false;
};

/// Prints a row of verdicts per case as it comes, and sums. Gives what benchmarks/run stability
/// draws: `methods`, each with what it kept of every relation; `cases`, each with an answer per
/// method of its kind; `failures` of this library; `elsewhere`, the rows of the catalogue that only
/// tests ask. Throws std::invalid_argument if there is no such case.
///
/// The verdict of an answer is "pass", "inaccurate" (early beyond what is promised), "late",
/// "missed", "false contact", "gave up", "crashed", "timed out" or "not applicable". It is judged
/// by the tolerance of the case, and peers, which are asked for a time, by 1e-4 of the motion if
/// that is more. Late is what is beyond the rounding of the scene, and for peers beyond 1e-9.
[[nodiscard]] nlohmann::json runCatalogue(const CatalogueOptions& options);
}  // namespace bullet_ccd::benchmarks
