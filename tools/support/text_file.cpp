#include "tools/support/text_file.h"

#include "bullet_ccd/math/replace_file.h"

#include <cerrno>
#include <fmt/format.h>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

[[noreturn]] void failTo(const fs::path& path, const std::string& reason)
{
    throw std::runtime_error(
        fmt::format("{}: cannot be written ({}): choose another file", path.string(), reason));
}

/// Where the content goes if `path` is a link.
fs::path targetOf(const fs::path& path)
{
    std::error_code error;
    const fs::path target = fs::canonical(path, error);
    return error ? path : target;
}

bool isDevice(const fs::path& path)
{
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}
}  // namespace

void requireWritable(const fs::path& path)
{
    if (fs::is_directory(path))
    {
        failTo(path, "is a folder");
    }
    if (isDevice(path))
    {
        return;
    }
    if (const std::error_code error = tryReplaceFile(targetOf(path)))
    {
        failTo(path, error.message());
    }
}

void requireOtherFile(const std::string& output, std::initializer_list<std::string> inputs)
{
    for (const std::string& input : inputs)
    {
        std::error_code error;
        if (fs::equivalent(output, input, error) && !error)
        {
            throw std::runtime_error(output + ": is also an input: choose another file");
        }
    }
}

void writeWholeFile(const fs::path& path, const std::string& text)
{
    if (isDevice(path))
    {
        errno = 0;
        std::ofstream file(path, std::ios::binary);
        file << text << std::flush;
        if (!file)
        {
            failTo(path, std::generic_category().message(errno));
        }
        return;
    }
    if (const std::error_code error = replaceFile(targetOf(path), {text}))
    {
        failTo(path, error.message());
    }
}
}  // namespace bullet_ccd::tools
