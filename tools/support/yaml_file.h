/// YAML files whose errors name the file, the line, the key, the value and the remedy.
#pragma once

#include <filesystem>
#include <string>
#include <vector>
#include <yaml-cpp/yaml.h>

namespace bullet_ccd::tools
{
class YamlFile
{
public:
    explicit YamlFile(std::filesystem::path path) : m_path(std::move(path)) {}

    [[nodiscard]] const std::filesystem::path& path() const { return m_path; }

    /// The content. Throws std::runtime_error if the file cannot be read or is not YAML.
    /// @param remedy what to give instead of a file that cannot be read
    [[nodiscard]] YAML::Node load(const std::string& remedy) const;

    /// All keys are known, there once, and have a value; else fails.
    void checkKeys(const YAML::Node& map, const std::vector<std::string>& known) const;

    /// The scalar of the key; fails where there is none.
    [[nodiscard]] std::string textOf(const YAML::Node& node, const std::string& key) const;

    /// The number of the key; fails as numberFrom() says.
    [[nodiscard]] double numberOf(const YAML::Node& node, const std::string& key) const;

    /// A list of `count` numbers; fails for anything else.
    [[nodiscard]] std::vector<double> numbersOf(const YAML::Node& node,
                                                const std::string& key,
                                                std::size_t count) const;

    /// "<file>:<line>: " of the node.
    [[nodiscard]] std::string place(const YAML::Node& node) const;

    /// Throws std::runtime_error "<file>:<line>: <key><what>".
    [[noreturn]] void fail(const YAML::Node& node,
                           const std::string& key,
                           const std::string& what) const;

private:
    std::filesystem::path m_path;
};
}  // namespace bullet_ccd::tools
