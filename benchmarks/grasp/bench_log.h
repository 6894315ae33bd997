/// Results of a long run over many hands and objects, one JSON line each, that a later run goes on
/// with.
#pragma once

#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
class BenchLog
{
public:
    /// Opens the file, or begins it with `settings` as its first line. A last line that was cut off
    /// when a run was killed is dropped.
    /// Throws std::runtime_error "<file>: <what>: <remedy>" if it cannot be written; if it exists
    /// and `resume` is not set; if it was begun with other settings.
    BenchLog(std::filesystem::path file, const nlohmann::json& settings, bool resume);

    /// True if there is a row of this hand and object.
    [[nodiscard]] bool has(const std::string& hand, const std::string& object) const;
    /// Adds a row with "hand" and "object", on the disk at once. From any thread.
    void add(const nlohmann::json& row);
    /// In the order in which they were added.
    [[nodiscard]] const std::vector<nlohmann::json>& rows() const { return m_rows; }

private:
    std::filesystem::path m_file;
    std::ofstream m_out;
    std::vector<nlohmann::json> m_rows;
    mutable std::mutex m_mutex;

    void read(const nlohmann::json& settings);
};
}  // namespace bullet_ccd::benchmarks
