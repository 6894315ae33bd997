/// Paths of a hand, as users write them.
#pragma once

#include <Eigen/Geometry>

#include <filesystem>
#include <vector>

namespace bullet_ccd::tools
{
/// Lengths beyond this are refused: they are most likely not given in metres [m].
inline constexpr double kFar = 1e3;

/// Poses from a CSV file: x, y, z [m], qw, qx, qy, qz in each row. A first row with these names may
/// head them; lines that begin with # are comments. Throws std::runtime_error
/// "<file>:<line>: <what>: <remedy>" for anything else, and for a file without poses.
[[nodiscard]] std::vector<Eigen::Isometry3d> readPathFile(const std::filesystem::path& path);
}  // namespace bullet_ccd::tools
