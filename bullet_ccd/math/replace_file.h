/// Files that are there as a whole or not at all.
#pragma once

#include "bullet_ccd/export.h"

#include <filesystem>
#include <initializer_list>
#include <string_view>
#include <system_error>

namespace bullet_ccd
{
/// Writes the parts, one after the other, as the file. Whoever reads it meanwhile, from any thread
/// or process, sees what was there before or all that is new; so does who looks after a failure.
/// @return  what went wrong; false if nothing
[[nodiscard]] BULLET_CCD_API std::error_code replaceFile(
    const std::filesystem::path& file, std::initializer_list<std::string_view> parts);

/// Whether replaceFile() could write there; leaves what is there as it is.
[[nodiscard]] BULLET_CCD_API std::error_code tryReplaceFile(const std::filesystem::path& file);
}  // namespace bullet_ccd
