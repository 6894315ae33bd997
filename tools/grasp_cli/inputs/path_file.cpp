#include "tools/grasp_cli/inputs/path_file.h"

#include "tools/support/csv_text.h"
#include "tools/support/pose_text.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <stdexcept>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
constexpr std::array<const char*, 7> kNames{"x", "y", "z", "qw", "qx", "qy", "qz"};

using Cells = std::vector<std::string>;

/// True if the row names columns instead of giving numbers. Throws std::invalid_argument for names
/// other than those, or in another order.
bool isHead(const Cells& cells)
{
    const bool startsWithLetter =
        !cells.front().empty() && std::isalpha(static_cast<unsigned char>(cells.front()[0])) != 0;
    if (!startsWithLetter)
    {
        return false;
    }
    if (!std::equal(cells.begin(), cells.end(), kNames.begin(), kNames.end()))
    {
        throw std::invalid_argument(fmt::format(
            "columns {}: they must be x,y,z,qw,qx,qy,qz, in this order", joined(cells, ",")));
    }
    return true;
}

double coordinate(const std::string& cell)
{
    const double value = numberFrom(cell);
    if (std::abs(value) > kFar)
    {
        throw std::invalid_argument(
            fmt::format("{} is farther than {:g} m: give metres", cell, kFar));
    }
    return value;
}

/// Throws std::invalid_argument "<what>: <remedy>".
Eigen::Isometry3d poseOf(const Cells& cells)
{
    if (cells.size() != kNames.size())
    {
        throw std::invalid_argument(
            fmt::format("{} numbers instead of 7: give x,y,z,qw,qx,qy,qz", cells.size()));
    }
    std::array<double, 7> values{};  // as poseFrom() wants them
    for (std::size_t k = 0; k < 3; ++k)
    {
        values[4 + k] = coordinate(cells[k]);
    }
    for (std::size_t k = 0; k < 4; ++k)
    {
        values[k] = numberFrom(cells[3 + k]);
    }
    return poseFrom(values);
}
}  // namespace

std::vector<Eigen::Isometry3d> readPathFile(const std::filesystem::path& path)
{
    const std::string content =
        contentOfFile(path, "give a CSV file of poses x,y,z,qw,qx,qy,qz, one a row");
    std::vector<Eigen::Isometry3d> poses;
    bool isFirst = true;
    for (const NumberedLine& line : linesOf(content))
    {
        if (trimmed(line.text).front() == '#')
        {
            continue;
        }
        try
        {
            const std::optional<Cells> cells = csvCells(line.text);
            if (!cells)
            {
                throw std::invalid_argument("a quote is not closed: write numbers without quotes");
            }
            if (!isFirst || !isHead(*cells))
            {
                poses.push_back(poseOf(*cells));
            }
        }
        catch (const std::invalid_argument& error)
        {
            throw std::runtime_error(
                fmt::format("{}:{}: {}", path.string(), line.line, error.what()));
        }
        isFirst = false;
    }
    if (poses.empty())
    {
        throw std::runtime_error(
            fmt::format("{}:1: no pose: write one or more rows x,y,z,qw,qx,qy,qz", path.string()));
    }
    return poses;
}
}  // namespace bullet_ccd::tools
