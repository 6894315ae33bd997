#include "bullet_ccd/math/replace_file.h"

#include <atomic>
#include <cerrno>
#include <fstream>
#include <string>
#include <unistd.h>

namespace bullet_ccd
{
namespace
{
namespace fs = std::filesystem;

/// Another one for every call of every process.
fs::path besideOf(const fs::path& file)
{
    static std::atomic<int> count = 0;
    return file.parent_path() / ('.' + file.filename().string() + ".unfinished-" +
                                 std::to_string(::getpid()) + '_' + std::to_string(count++));
}

std::error_code write(const fs::path& path, std::initializer_list<std::string_view> parts)
{
    errno = 0;
    std::ofstream stream(path, std::ios::binary | std::ios::trunc);
    for (const std::string_view part : parts)
    {
        stream.write(part.data(), static_cast<std::streamsize>(part.size()));
    }
    stream.close();
    if (stream)
    {
        return {};
    }
    return {errno != 0 ? errno : EIO, std::generic_category()};
}

void removeQuietly(const fs::path& path)
{
    std::error_code ignored;
    fs::remove(path, ignored);
}
}  // namespace

std::error_code replaceFile(const fs::path& file, std::initializer_list<std::string_view> parts)
{
    const fs::path beside = besideOf(file);
    std::error_code error = write(beside, parts);
    if (!error)
    {
        fs::rename(beside, file, error);
    }
    if (error)
    {
        removeQuietly(beside);
    }
    return error;
}

std::error_code tryReplaceFile(const fs::path& file)
{
    const fs::path beside = besideOf(file);
    const std::error_code error = write(beside, {});
    removeQuietly(beside);
    return error;
}
}  // namespace bullet_ccd
