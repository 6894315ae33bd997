#include "tools/grasp_cli/plan/output_folder.h"

#include <algorithm>
#include <fcntl.h>
#include <fmt/format.h>
#include <map>
#include <stdexcept>
#include <string_view>
#include <sys/file.h>
#include <unistd.h>
#include <utility>

namespace bullet_ccd::tools
{
namespace fs = std::filesystem;

namespace
{
[[noreturn]] void failTo(const fs::path& path, const std::string& reason)
{
    throw std::runtime_error(fmt::format(
        "{}: cannot be written ({}): choose another folder with -o", path.string(), reason));
}

constexpr std::string_view kStaging = ".unfinished-";  // and the number of the process

/// A lock that goes with its process. Negative if the folder is locked or cannot be.
int lockedFolder(const fs::path& folder)
{
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor >= 0 && ::flock(descriptor, LOCK_EX | LOCK_NB) != 0)
    {
        ::close(descriptor);
        return -1;
    }
    return descriptor;
}

/// What processes that were killed left behind.
void removeAbandoned(const fs::path& folder)
{
    std::error_code error;
    std::vector<fs::path> abandoned;
    for (const auto& entry : fs::directory_iterator(folder, error))
    {
        const bool isStaging = entry.path().filename().string().starts_with(kStaging);
        if (const int lock = isStaging ? lockedFolder(entry.path()) : -1; lock >= 0)
        {
            abandoned.push_back(entry.path());
            ::close(lock);
        }
    }
    for (const fs::path& path : abandoned)
    {
        fs::remove_all(path, error);
    }
}
}  // namespace

std::string folderNameOf(std::string name)
{
    std::ranges::replace(name, '/', '_');
    if (name.starts_with('.'))
    {
        name.front() = '_';
    }
    return name;
}

void requireOwnFolders(const std::vector<std::string>& names)
{
    std::map<std::string, std::string> nameOfFolder;
    for (const std::string& name : names)
    {
        const auto [at, isNew] = nameOfFolder.emplace(folderNameOf(name), name);
        if (!isNew)
        {
            throw std::runtime_error(
                fmt::format("objects: {} and {} would both be written to a folder {}: give one of "
                            "them another name, or run them one by one",
                            at->second,
                            name,
                            at->first));
        }
    }
}

OutputFolder::OutputFolder(fs::path folder) : m_folder(std::move(folder))
{
    std::error_code error;
    m_created = fs::create_directories(m_folder, error);
    if (error)
    {
        failTo(m_folder, error.message());
    }
    removeAbandoned(m_folder);
    m_staging = m_folder / fmt::format("{}{}", kStaging, ::getpid());
    fs::create_directory(m_staging, error);
    if (error)
    {
        failTo(m_folder, error.message());
    }
    m_lock = lockedFolder(m_staging);
}

OutputFolder::~OutputFolder()
{
    std::error_code ignored;
    fs::remove_all(m_staging, ignored);
    if (m_lock >= 0)
    {
        ::close(m_lock);
    }
    if (m_created)
    {
        fs::remove(m_folder, ignored);  // only succeeds if nothing came of it
    }
}

fs::path OutputFolder::stage(const std::string& name)
{
    if (std::find(m_names.begin(), m_names.end(), name) == m_names.end())
    {
        m_names.push_back(name);
    }
    return m_staging / name;
}

void OutputFolder::commit()
{
    for (const std::string& name : m_names)
    {
        if (!fs::exists(m_staging / name))
        {
            failTo(m_folder / name, "it was not produced");
        }
    }
    for (const std::string& name : m_names)
    {
        std::error_code error;
        fs::rename(m_staging / name, m_folder / name, error);
        if (error)
        {
            failTo(m_folder / name, error.message());
        }
    }
    m_names.clear();
}
}  // namespace bullet_ccd::tools
