#include "tools/ccd_cli/files/elementary_file.h"

#include "tools/support/csv_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

constexpr std::size_t kLinesPerQuery = 8;
/// As many digits are in the range of a double.
constexpr std::size_t kMostDigits = 300;

std::optional<ElementaryKind> kindOfFolder(const fs::path& file)
{
    const fs::path folder = fs::absolute(file).parent_path().filename();
    if (folder == "edge-edge")
    {
        return ElementaryKind::EdgeEdge;
    }
    if (folder == "vertex-face")
    {
        return ElementaryKind::VertexFace;
    }
    return std::nullopt;
}

/// The whole number in units of 10^places, rounded once.
double inPowersOfTen(std::string_view whole, std::size_t places)
{
    const bool isNegative = whole.starts_with('-');
    std::string text(whole.substr(isNegative ? 1 : 0));
    if (places > 0)
    {
        text.insert(0, places, '0');
        text.insert(text.size() - places, 1, '.');
    }
    double value = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
    return isNegative ? -value : value;
}

/// One line of a file; errors name it.
class ElementaryLine
{
public:
    ElementaryLine(const fs::path& path, const NumberedLine& line)
        : m_path(path), m_line(line.line), m_cells(csvCells(line.text).value_or(Cells{}))
    {
        if (m_cells.size() != 6 && m_cells.size() != 7)
        {
            fail(fmt::format("{} cells: write x_num,x_den,y_num,y_den,z_num,z_den,truth",
                             m_cells.size()));
        }
    }

    [[nodiscard]] Eigen::Vector3d point() const
    {
        Eigen::Vector3d x;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const std::string_view numerator = whole(2 * k);
            const std::string_view denominator = whole(2 * k + 1);
            if (denominator.find_first_of("123456789") == std::string_view::npos)
            {
                fail("a denominator is 0: write a whole number that is not");
            }
            // Beyond the range of a double, both are taken in the same smaller unit.
            const std::size_t longest = std::max(numerator.size(), denominator.size());
            const std::size_t places = longest > kMostDigits ? longest - kMostDigits : 0;
            x[static_cast<Eigen::Index>(k)] =
                inPowersOfTen(numerator, places) / inPowersOfTen(denominator, places);
        }
        if (!x.allFinite())
        {
            fail("a coordinate is too large for a double: scale the query down");
        }
        return x;
    }

    [[nodiscard]] std::optional<bool> truth() const
    {
        if (m_cells.size() == 6)
        {
            return std::nullopt;
        }
        if (m_cells[6] != "0" && m_cells[6] != "1")
        {
            fail(fmt::format("truth '{}': write 0 or 1", m_cells[6]));
        }
        return m_cells[6] == "1";
    }

    [[noreturn]] void fail(const std::string& what) const
    {
        throw std::runtime_error(fmt::format("{}:{}: {}", m_path.string(), m_line, what));
    }

private:
    using Cells = std::vector<std::string>;

    /// Digits, maybe after a minus.
    [[nodiscard]] std::string_view whole(std::size_t cell) const
    {
        const std::string_view text = m_cells[cell];
        const std::string_view digits = text.substr(text.starts_with('-') ? 1 : 0);
        if (digits.empty() || digits.find_first_not_of("0123456789") != std::string_view::npos)
        {
            fail(
                fmt::format("column {}: '{}' is not a whole number: write numerators and "
                            "denominators as digits",
                            cell + 1,
                            text));
        }
        return text;
    }

    const fs::path& m_path;
    std::size_t m_line = 0;
    Cells m_cells;
};
}  // namespace

std::vector<ElementaryQuery> readElementaryFile(const fs::path& path,
                                                std::optional<ElementaryKind> kind)
{
    kind = kind ? kind : kindOfFolder(path);
    if (!kind)
    {
        throw std::runtime_error(fmt::format(
            "{}: its folder is not called edge-edge or vertex-face: give --edge-edge or "
            "--vertex-face",
            path.string()));
    }
    const std::string content = contentOfFile(path, "give a CSV file of elementary queries");
    std::vector<ElementaryQuery> queries;
    std::size_t row = 0;
    for (const NumberedLine& text : linesOf(content))
    {
        const ElementaryLine line(path, text);
        const std::size_t vertex = row % kLinesPerQuery;
        if (vertex == 0)
        {
            queries.push_back({.pair = {.kind = *kind}, .touches = line.truth()});
        }
        ElementaryQuery& query = queries.back();
        if (query.touches != line.truth())
        {
            line.fail(
                "another truth than in the line before: write the same in all eight lines of "
                "a query");
        }
        (vertex < 4 ? query.pair.start[vertex] : query.pair.end[vertex - 4]) = line.point();
        ++row;
    }
    if (row == 0 || row % kLinesPerQuery != 0)
    {
        throw std::runtime_error(
            fmt::format("{}: {} lines: write eight lines a query: four vertices "
                        "at t = 0, the same at t = 1",
                        path.string(),
                        row));
    }
    return queries;
}

std::vector<fs::path> elementaryFiles(const fs::path& path)
{
    if (!fs::exists(path))
    {
        throw std::runtime_error(path.string() + ": no such file: check the path");
    }
    if (!fs::is_directory(path))
    {
        return {path};
    }
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path))
    {
        if (entry.is_regular_file() && entry.path().extension() == ".csv" &&
            kindOfFolder(entry.path()))
        {
            files.push_back(entry.path());
        }
    }
    std::ranges::sort(files);
    if (files.empty())
    {
        throw std::runtime_error(path.string() +
                                 ": no edge-edge/*.csv or vertex-face/*.csv below: give a file");
    }
    return files;
}
}  // namespace bullet_ccd::tools
