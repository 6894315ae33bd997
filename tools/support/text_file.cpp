#include "tools/support/text_file.h"

#include <cerrno>
#include <fmt/format.h>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <unistd.h>

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

fs::path besideOf(const fs::path& target)
{
    return target.parent_path() /
           fmt::format(".{}.unfinished-{}", target.filename().string(), ::getpid());
}

void write(const fs::path& path, const std::string& text, const fs::path& asked)
{
    errno = 0;
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file << text << std::flush;
    if (!file)
    {
        const std::string reason = std::generic_category().message(errno);
        std::error_code ignored;
        if (path != asked)
        {
            fs::remove(path, ignored);
        }
        failTo(asked, reason);
    }
}
}  // namespace

void requireWritable(const fs::path& path)
{
    if (fs::is_directory(path))
    {
        failTo(path, "is a folder");
    }
    if (!isDevice(path))
    {
        const fs::path beside = besideOf(targetOf(path));
        write(beside, "", path);
        fs::remove(beside);
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
        write(path, text, path);
        return;
    }
    const fs::path target = targetOf(path);
    const fs::path beside = besideOf(target);
    write(beside, text, path);
    std::error_code error;
    fs::rename(beside, target, error);
    if (error)
    {
        std::error_code ignored;
        fs::remove(beside, ignored);
        failTo(path, error.message());
    }
}
}  // namespace bullet_ccd::tools
