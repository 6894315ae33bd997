#include "tools/ccd_cli/pose_columns.h"

#include "tools/ccd_cli/pose_text.h"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
constexpr std::array<const char*, 7> kNames{"qw", "qx", "qy", "qz", "tx", "ty", "tz"};
}  // namespace

bool isPoseColumn(std::string_view name, std::string_view prefix)
{
    return name.substr(0, prefix.size()) == prefix &&
           std::find(kNames.begin(),
                     kNames.end(),
                     name.substr(std::min(prefix.size(), name.size()))) != kNames.end();
}

std::optional<PoseColumns> poseColumns(const CsvTable& table, const std::string& prefix)
{
    PoseColumns columns{};
    std::string missing;
    bool hasSome = false;
    for (std::size_t k = 0; k < kNames.size(); ++k)
    {
        const std::optional<std::size_t> column = table.find(prefix + kNames[k]);
        hasSome = hasSome || column.has_value();
        columns[k] = column.value_or(0);
        if (!column)
        {
            missing += fmt::format("{}{}{}", missing.empty() ? "" : ", ", prefix, kNames[k]);
        }
    }
    if (hasSome && !missing.empty())
    {
        table.failNames(
            fmt::format("a pose is given, but not {}: give all seven columns or none", missing));
    }
    return hasSome ? std::optional(columns) : std::nullopt;
}

Eigen::Isometry3d poseOf(const CsvTable& table, const CsvRow& row, const PoseColumns& columns)
{
    std::array<double, 7> values{};
    for (std::size_t k = 0; k < values.size(); ++k)
    {
        values[k] = table.number(row, columns[k]);
    }
    try
    {
        return poseFrom(values);
    }
    catch (const std::invalid_argument& error)
    {
        table.fail(row, columns[0], error.what());
    }
}
}  // namespace bullet_ccd::tools
