/// Poses in YAML files.
#pragma once

#include "tools/support/yaml_file.h"

#include <Eigen/Geometry>

namespace bullet_ccd::tools
{
/// The pose of a map with the keys
///
///   position    [tx, ty, tz], default 0
///   quaternion  [qw, qx, qy, qz], or
///   rpy         [roll, pitch, yaw] about the fixed axes x, y, z in that order, as in URDF [rad]
///
/// Fails as YamlFile says.
[[nodiscard]] Eigen::Isometry3d yamlPose(const YamlFile& file, const YAML::Node& node);
}  // namespace bullet_ccd::tools
