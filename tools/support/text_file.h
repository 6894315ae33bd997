/// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>

namespace bullet_ccd::tools
{
/// Proves that writeWholeFile() can write there. Leaves what is there as it is.
/// Throws std::runtime_error "<path>: <reason>: <remedy>".
void requireWritable(const std::filesystem::path& path);

/// Throws std::runtime_error if the output is one of the inputs.
void requireOtherFile(const std::string& output, std::initializer_list<std::string> inputs);

/// Writes into a file beside the target and renames it, so that whoever reads or interrupts sees
/// the old content or the new. What is not a file (a device, a pipe) is written directly.
/// Throws as requireWritable().
void writeWholeFile(const std::filesystem::path& path, const std::string& text);
}  // namespace bullet_ccd::tools
