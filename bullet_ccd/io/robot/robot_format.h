/// Which language a robot's file is written in.
#pragma once

#include "bullet_ccd/io/robot_file.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace bullet_ccd
{
enum class RobotFormat : std::uint8_t
{
    Urdf,   ///< <robot>, and everything that is none of the others
    Xacro,  ///< <robot> with elements or expressions of xacro
    Mjcf,   ///< <mujoco>
    Sdf,    ///< <sdf>
};

/// By the content: the name of the first element, and whether it speaks of xacro.
[[nodiscard]] RobotFormat robotFormat(std::string_view text);

/// Throws std::runtime_error that names the format and the way out if the text is no URDF.
void requireUrdf(std::string_view text, const std::filesystem::path& path);

/// What the program xacro, looked for on PATH, makes of the file.
/// Throws std::runtime_error with the command to run if it is not there or fails.
[[nodiscard]] std::string expandXacro(const std::filesystem::path& path);

/// The robot of a URDF that is in memory; mesh files are relative to `path`. Throws as loadUrdf().
[[nodiscard]] RobotModel urdfFromText(const std::string& text, const std::filesystem::path& path);
}  // namespace bullet_ccd
