#include "tools/ccd_cli/files/query_columns.h"

#include "tools/support/csv_text.h"
#include "tools/support/pose_text.h"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <optional>
#include <span>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

constexpr std::array<std::string_view, 6> kTwistNames{"vx", "vy", "vz", "wx", "wy", "wz"};

std::vector<std::string> namesOf(std::string_view prefix, std::span<const std::string_view> names)
{
    std::vector<std::string> all;
    for (const std::string_view name : names)
    {
        all.push_back(fmt::format("{}_{}", prefix, name));
    }
    return all;
}

/// All columns of a form, in the order of the documentation.
std::vector<std::string> namesOf(QueryForm form)
{
    std::vector<std::string> all{"id"};
    const auto add = [&](std::string_view prefix, std::span<const std::string_view> names)
    {
        const std::vector<std::string> more = namesOf(prefix, names);
        all.insert(all.end(), more.begin(), more.end());
    };
    for (const std::string body : {"a", "b"})
    {
        add(body + "0", kPoseNames);
        if (form == QueryForm::Poses)
        {
            add(body + "1", kPoseNames);
        }
        else
        {
            add(body, kTwistNames);
        }
    }
    return all;
}

bool contains(const std::vector<std::string>& names, const std::string& name)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// The names of `all` that `names` lacks.
std::vector<std::string> without(const std::vector<std::string>& all,
                                 const std::vector<std::string>& names)
{
    std::vector<std::string> rest;
    std::copy_if(all.begin(),
                 all.end(),
                 std::back_inserter(rest),
                 [&](const std::string& name) { return !contains(names, name); });
    return rest;
}

std::string shortList(const std::vector<std::string>& names)
{
    constexpr std::size_t kShown = 8;
    std::string text;
    for (std::size_t k = 0; k < std::min(names.size(), kShown); ++k)
    {
        text += (k > 0 ? ", " : "") + names[k];
    }
    return names.size() > kShown ? text + fmt::format(" and {} more", names.size() - kShown) : text;
}

[[noreturn]] void failHeader(const fs::path& path, std::size_t line, const std::string& what)
{
    throw std::runtime_error(fmt::format(
        "{}:{}: {}: the first line must name the columns, poses: id,a0_qw,a0_qx,a0_qy,a0_qz,a0_tx,"
        "a0_ty,a0_tz,a1_..,b0_..,b1_.. or twists: id,a0_..,a_vx,a_vy,a_vz,a_wx,a_wy,a_wz,b0_..,"
        "b_vx,..",
        path.string(),
        line,
        what));
}

/// The form that the names belong to; the names are checked against it.
QueryForm formOf(const std::vector<std::string>& names, const fs::path& path, std::size_t line)
{
    const std::vector<std::string> poses = namesOf(QueryForm::Poses);
    const std::vector<std::string> twists = namesOf(QueryForm::Twists);
    // What only one of the forms has tells them apart.
    const auto hasOneOf = [&](const std::vector<std::string>& own)
    { return without(own, names).size() < own.size(); };
    const bool hasPoses = hasOneOf(without(poses, twists));
    const bool hasTwists = hasOneOf(without(twists, poses));
    if (hasPoses == hasTwists)
    {
        failHeader(path,
                   line,
                   hasPoses ? "columns of both forms, end poses and velocities"
                            : "columns of neither form, no end poses and no velocities");
    }
    const std::vector<std::string>& expected = hasPoses ? poses : twists;
    const std::vector<std::string> unknown = without(names, expected);
    if (!unknown.empty())
    {
        failHeader(path, line, fmt::format("unknown column '{}'", shortList(unknown)));
    }
    const std::vector<std::string> missing = without(expected, names);
    if (!missing.empty())
    {
        failHeader(path, line, "missing column " + shortList(missing));
    }
    if (names.size() > expected.size())
    {
        failHeader(path, line, "a column is named twice");
    }
    return hasPoses ? QueryForm::Poses : QueryForm::Twists;
}
}  // namespace

QueryColumns queryColumns(std::string_view header, const fs::path& path, std::size_t line)
{
    if (header.empty())
    {
        failHeader(path, line, "the file is empty");
    }
    if (header.find('\0') != std::string_view::npos)
    {
        failHeader(path, line, "not UTF-8 text, save it as UTF-8");
    }
    if (header.find(',') == std::string_view::npos && header.find(';') != std::string_view::npos)
    {
        failHeader(path, line, "semicolons between the cells, commas are expected");
    }
    const std::optional<std::vector<std::string>> cells = csvCells(header);
    if (!cells)
    {
        failHeader(path, line, "a quote is not closed, or text follows it");
    }
    QueryColumns columns;
    columns.names = *cells;
    columns.form = formOf(columns.names, path, line);
    const auto find = [&](const std::string& name)
    {
        const auto found = std::find(columns.names.begin(), columns.names.end(), name);
        return static_cast<std::size_t>(found - columns.names.begin());
    };
    const auto findAll = [&](std::string_view prefix, auto& indices, const auto& names)
    {
        const std::vector<std::string> wanted = namesOf(prefix, names);
        std::transform(wanted.begin(), wanted.end(), indices.begin(), find);
    };
    columns.id = find("id");
    for (const std::string prefix : {"a", "b"})
    {
        BodyColumns& body = prefix == "a" ? columns.a : columns.b;
        findAll(prefix + "0", body.start, kPoseNames);
        findAll(prefix + "1", body.end, kPoseNames);
        findAll(prefix, body.twist, kTwistNames);
    }
    return columns;
}
}  // namespace bullet_ccd::tools
