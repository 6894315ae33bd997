/// Files of elementary queries: pairs of features whose vertices move on straight lines.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

namespace bullet_ccd::tools
{
struct ElementaryQuery
{
    ElementaryPair pair;
    std::optional<bool> touches;  ///< the truth, if the file has it
};

/// Reads a file without a header, of eight lines a query: the four vertices at t = 0, then at t =
/// 1, as ElementaryPair has them. A line has x, y and z as whole numerator and denominator, and the
/// truth, 0 or 1, which may be left out: x_num,x_den,y_num,y_den,z_num,z_den,truth. Numbers may
/// have any number of digits; a coordinate that is a double is read as that double.
/// @param kind  of all queries; without one the file's folder must be called edge-edge or
/// vertex-face
/// Throws std::runtime_error "<file>:<line>: <what>: <remedy>".
[[nodiscard]] std::vector<ElementaryQuery> readElementaryFile(const std::filesystem::path& path,
                                                              std::optional<ElementaryKind> kind);

/// The file itself; of a folder all files *.csv below it that are in a folder edge-edge or
/// vertex-face, in the order of their names.
/// Throws std::runtime_error "<path>: <what>: <remedy>" if there is none.
[[nodiscard]] std::vector<std::filesystem::path> elementaryFiles(const std::filesystem::path& path);
}  // namespace bullet_ccd::tools
