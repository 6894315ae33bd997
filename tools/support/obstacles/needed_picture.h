/// What a scene needed, drawn: what was modelled finely apart from what was left coarse.
#pragma once

#include "bullet_ccd/toi/model_use.h"

#include <Eigen/Geometry>

#include <filesystem>
#include <span>

namespace bullet_ccd::tools
{
/// A body where it is to be drawn.
struct DrawnBody
{
    const SsvTree* tree = nullptr;  ///< null: nothing is drawn
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
};

/// Writes all bodies in W into one mesh file, PLY with a colour for each face: orange where a
/// triangle was looked at, grey where it was left to its volumes.
/// @param uses  one for each thread that asked
/// Throws std::runtime_error "<path>: <reason>: <remedy>".
void writeNeededPicture(const std::filesystem::path& path,
                        std::span<const ModelUse> uses,
                        std::span<const DrawnBody> bodies);
}  // namespace bullet_ccd::tools
