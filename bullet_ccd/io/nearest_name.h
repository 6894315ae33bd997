/// What a user may have meant by a name that does not exist.
#pragma once

#include "bullet_ccd/export.h"

#include <span>
#include <string>

namespace bullet_ccd
{
/// The name that takes the fewest insertions, deletions and replacements of letters to reach, the
/// first of equals; empty if there are no names.
[[nodiscard]] BULLET_CCD_API std::string nearestName(const std::string& name,
                                                     std::span<const std::string> names);
}  // namespace bullet_ccd
