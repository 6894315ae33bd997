/// Which column of a query file holds what.
#pragma once

#include "tools/ccd_cli/files/query_file.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace bullet_ccd::tools
{
/// Indices of the columns of one body.
struct BodyColumns
{
    std::array<std::size_t, 7> start{};  ///< qw qx qy qz tx ty tz
    std::array<std::size_t, 7> end{};    ///< likewise; poses only
    std::array<std::size_t, 6> twist{};  ///< vx vy vz wx wy wz; twists only
};

struct QueryColumns
{
    QueryForm form = QueryForm::Poses;
    std::vector<std::string> names;  ///< of all columns
    std::size_t id = 0;
    BodyColumns a;
    BodyColumns b;
};

/// Finds the columns of one form in the header, which is line `line` of the file `path`.
/// Throws std::runtime_error as readQueryFile() says.
[[nodiscard]] QueryColumns queryColumns(std::string_view header,
                                        const std::filesystem::path& path,
                                        std::size_t line);
}  // namespace bullet_ccd::tools
