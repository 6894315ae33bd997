/// Results: a row is a JSON object, what is printed is a view of it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// Prints rows as they come, so that a long run shows what it has.
class Table
{
public:
    /// Prints the head.
    /// @param columns separated by '|': the head, '=' and the key if that is another, ':' and a
    ///        format with a width as fmt has it, such as "set:<21|us=microseconds:>9.1f"
    explicit Table(std::string_view columns);

    /// Cells of keys that the row has not, or null, are "-".
    void print(const nlohmann::json& row) const;

    /// The same as texts of no particular width, for files.
    [[nodiscard]] std::vector<std::string> heads() const;
    [[nodiscard]] std::vector<std::string> cells(const nlohmann::json& row) const;

private:
    struct Column
    {
        std::string head;
        std::string key;
        std::string place;   ///< alignment and width
        std::string number;  ///< precision and type of a number; empty: a whole one
    };
    void printLine(const std::vector<std::string>& cells) const;

    std::vector<Column> m_columns;
};
}  // namespace bullet_ccd::benchmarks
