/// Results that appear all at once or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// The name of a folder for what is called `name`, inside of another one: without slashes, and not
/// hidden.
[[nodiscard]] std::string folderNameOf(std::string name);

/// Throws std::runtime_error that names two of `names` for which there would be one folder.
void requireOwnFolders(const std::vector<std::string>& names);

/// Files are written into a hidden folder inside the output folder and moved to their places by
/// commit(); without it nothing that was there before is touched, but for hidden folders of
/// processes that were killed.
class OutputFolder
{
public:
    /// Creates the folder if needed and proves that it can be written.
    /// Throws std::runtime_error that names the folder and the reason.
    explicit OutputFolder(std::filesystem::path folder);
    ~OutputFolder();
    OutputFolder(const OutputFolder&) = delete;
    OutputFolder& operator=(const OutputFolder&) = delete;

    /// Where to write the file that will be called `name`.
    [[nodiscard]] std::filesystem::path stage(const std::string& name);
    /// Moves all staged files to their places. Throws std::runtime_error if one is missing or
    /// cannot be moved.
    void commit();
    [[nodiscard]] const std::filesystem::path& folder() const { return m_folder; }

private:
    std::filesystem::path m_folder;
    std::filesystem::path m_staging;
    std::vector<std::string> m_names;
    bool m_created = false;
    int m_lock = -1;  // says to others that the staging folder is in use
};
}  // namespace bullet_ccd::tools
