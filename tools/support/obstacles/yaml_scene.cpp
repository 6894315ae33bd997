#include "bullet_ccd/io/nearest_name.h"
#include "tools/support/obstacles/obstacle_scene.h"
#include "tools/support/pose_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <yaml-cpp/yaml.h>

namespace bullet_ccd::tools
{
namespace
{
/// One file; every error names the line of what is wrong.
class YamlScene
{
public:
    explicit YamlScene(const std::filesystem::path& path) : m_path(path) {}

    [[nodiscard]] std::vector<PlacedMesh> read() const
    {
        const YAML::Node file = load();
        if (!file.IsMap())
        {
            fail(file, "", "not a map: write obstacles: and a list below it");
        }
        checkKeys(file, {"obstacles"});
        const YAML::Node list = file["obstacles"];
        if (!list.IsDefined() || !list.IsSequence())
        {
            fail(list.IsDefined() ? list : file,
                 "obstacles: ",
                 "no list: write an item, - mesh: FILE, for each obstacle");
        }
        std::vector<PlacedMesh> scene;
        for (const YAML::Node& obstacle : list)
        {
            scene.push_back(placedMesh(obstacle));
        }
        return scene;
    }

private:
    [[nodiscard]] YAML::Node load() const
    {
        try
        {
            return YAML::LoadFile(m_path.string());
        }
        catch (const YAML::BadFile&)
        {
            throw std::runtime_error(m_path.string() +
                                     ": cannot be read: give a mesh, or a scene in CSV or YAML");
        }
        catch (const YAML::ParserException& error)
        {
            throw std::runtime_error(fmt::format("{}:{}: not YAML: {}: correct the line",
                                                 m_path.string(),
                                                 error.mark.line + 1,
                                                 error.msg));
        }
    }

    [[nodiscard]] PlacedMesh placedMesh(const YAML::Node& node) const
    {
        if (!node.IsMap())
        {
            fail(node, "obstacles: ", "an item is not a map: write - mesh: FILE");
        }
        checkKeys(node, {"mesh", "name", "scale", "position", "quaternion", "rpy"});
        const YAML::Node mesh = node["mesh"];
        if (!mesh.IsDefined())
        {
            fail(node, "mesh: ", "no such key in the item: name the file of the obstacle");
        }
        const std::filesystem::path file = m_path.parent_path() / textOf(mesh, "mesh");
        PlacedMesh placed{.mesh = file,
                          .name = file.filename().string(),
                          .X_WO = poseOf(node),
                          .where = place(mesh) + "mesh: "};
        if (const YAML::Node name = node["name"]; name.IsDefined())
        {
            placed.name = textOf(name, "name");
        }
        if (const YAML::Node scale = node["scale"]; scale.IsDefined())
        {
            placed.scale = numberOf(scale, "scale");
            if (!(placed.scale > 0.0))
            {
                fail(scale,
                     "scale: ",
                     fmt::format("{} is not above 0: write a factor", placed.scale));
            }
        }
        return placed;
    }

    [[nodiscard]] Eigen::Isometry3d poseOf(const YAML::Node& node) const
    {
        const YAML::Node position = node["position"];
        const YAML::Node quaternion = node["quaternion"];
        const YAML::Node rpy = node["rpy"];
        std::array<double, 7> values{1.0};
        if (position.IsDefined())
        {
            std::ranges::copy(numbersOf<3>(position, "position"), values.begin() + 4);
        }
        if (quaternion.IsDefined() && rpy.IsDefined())
        {
            fail(rpy, "rpy: ", "there is a quaternion too: give one of them");
        }
        if (rpy.IsDefined())
        {
            const Eigen::Quaterniond q = turnOf(numbersOf<3>(rpy, "rpy"));
            std::ranges::copy(std::array{q.w(), q.x(), q.y(), q.z()}, values.begin());
        }
        if (quaternion.IsDefined())
        {
            std::ranges::copy(numbersOf<4>(quaternion, "quaternion"), values.begin());
        }
        try
        {
            return poseFrom(values);
        }
        catch (const std::invalid_argument& error)
        {
            fail(quaternion, "quaternion: ", error.what());
        }
    }

    static Eigen::Quaterniond turnOf(const std::array<double, 3>& rpy)
    {
        return Eigen::AngleAxisd(rpy[2], Eigen::Vector3d::UnitZ()) *
               Eigen::AngleAxisd(rpy[1], Eigen::Vector3d::UnitY()) *
               Eigen::AngleAxisd(rpy[0], Eigen::Vector3d::UnitX());
    }

    /// All keys are known, there once, and have a value.
    void checkKeys(const YAML::Node& map, const std::vector<std::string>& known) const
    {
        std::vector<std::string> seen;
        for (const auto& entry : map)
        {
            const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
            if (std::ranges::find(known, key) == known.end())
            {
                fail(entry.first,
                     key + ": ",
                     fmt::format("no such key: did you mean {}?", nearestName(key, known)));
            }
            if (std::ranges::find(seen, key) != seen.end())
            {
                fail(entry.first, key + ": ", "there twice: drop one");
            }
            if (entry.second.IsNull())
            {
                fail(entry.first, key + ": ", "no value: write one or drop the key");
            }
            seen.push_back(key);
        }
    }

    [[nodiscard]] std::string textOf(const YAML::Node& node, const std::string& key) const
    {
        if (!node.IsScalar() || node.Scalar().empty())
        {
            fail(node, key + ": ", "no value: write one word or a text in quotes");
        }
        return node.Scalar();
    }

    [[nodiscard]] double numberOf(const YAML::Node& node, const std::string& key) const
    {
        try
        {
            return numberFrom(textOf(node, key));
        }
        catch (const std::invalid_argument& error)
        {
            fail(node, key + ": ", error.what());
        }
    }

    template <std::size_t Count>
    [[nodiscard]] std::array<double, Count> numbersOf(const YAML::Node& node,
                                                      const std::string& key) const
    {
        if (!node.IsSequence() || node.size() != Count)
        {
            fail(
                node,
                key + ": ",
                fmt::format("not a list of {} numbers: write them in brackets, with commas between",
                            Count));
        }
        std::array<double, Count> numbers{};
        for (std::size_t k = 0; k < Count; ++k)
        {
            numbers[k] = numberOf(node[k], key);
        }
        return numbers;
    }

    [[nodiscard]] std::string place(const YAML::Node& node) const
    {
        return fmt::format("{}:{}: ", m_path.string(), std::max(node.Mark().line, 0) + 1);
    }

    [[noreturn]] void fail(const YAML::Node& node,
                           const std::string& key,
                           const std::string& what) const
    {
        throw std::runtime_error(place(node) + key + what);
    }

    std::filesystem::path m_path;
};
}  // namespace

std::vector<PlacedMesh> readYamlScene(const std::filesystem::path& path)
{
    return YamlScene(path).read();
}
}  // namespace bullet_ccd::tools
