#include "tools/support/yaml_pose.h"

#include "tools/support/pose_text.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
Eigen::Quaterniond turnOf(const std::vector<double>& rpy)
{
    return Eigen::AngleAxisd(rpy[2], Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(rpy[1], Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(rpy[0], Eigen::Vector3d::UnitX());
}
}  // namespace

Eigen::Isometry3d yamlPose(const YamlFile& file, const YAML::Node& node)
{
    const YAML::Node position = node["position"];
    const YAML::Node quaternion = node["quaternion"];
    const YAML::Node rpy = node["rpy"];
    std::array<double, 7> values{1.0};
    if (position.IsDefined())
    {
        std::ranges::copy(file.numbersOf(position, "position", 3), values.begin() + 4);
    }
    if (quaternion.IsDefined() && rpy.IsDefined())
    {
        file.fail(rpy, "rpy: ", "there is a quaternion too: give one of them");
    }
    if (rpy.IsDefined())
    {
        const Eigen::Quaterniond q = turnOf(file.numbersOf(rpy, "rpy", 3));
        std::ranges::copy(std::array{q.w(), q.x(), q.y(), q.z()}, values.begin());
    }
    if (quaternion.IsDefined())
    {
        std::ranges::copy(file.numbersOf(quaternion, "quaternion", 4), values.begin());
    }
    try
    {
        return poseFrom(values);
    }
    catch (const std::invalid_argument& error)
    {
        file.fail(quaternion, "quaternion: ", error.what());
    }
}
}  // namespace bullet_ccd::tools
