/// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <string>

namespace bullet_ccd::tools
{
/// Proves that writeWholeFile() can write there. Leaves what is there as it is.
/// Throws std::runtime_error "<path>: <reason>: <remedy>".
void requireWritable(const std::filesystem::path& path);

/// Writes into a file beside the target and renames it, so that whoever reads or interrupts sees
/// the old content or the new. What is not a file (a device, a pipe) is written directly.
/// Throws as requireWritable().
void writeWholeFile(const std::filesystem::path& path, const std::string& text);
}  // namespace bullet_ccd::tools
