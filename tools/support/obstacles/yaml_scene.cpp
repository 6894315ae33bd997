#include "tools/support/obstacles/obstacle_scene.h"
#include "tools/support/obstacles/share_folder.h"
#include "tools/support/yaml_file.h"
#include "tools/support/yaml_pose.h"

#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
/// One file; every error names the line of what is wrong.
class YamlScene
{
public:
    explicit YamlScene(const std::filesystem::path& path) : m_file(path) {}

    [[nodiscard]] std::vector<PlacedMesh> read() const
    {
        const YAML::Node file = m_file.load("give a mesh, or a scene in CSV or YAML");
        if (!file.IsMap())
        {
            m_file.fail(file, "", "not a map: write obstacles: and a list below it");
        }
        m_file.checkKeys(file, {"obstacles", "accuracy", "objects", "robot", "target"});
        const YAML::Node list = file["obstacles"];
        if (!list.IsDefined() || !list.IsSequence())
        {
            m_file.fail(list.IsDefined() ? list : file,
                        "obstacles: ",
                        "no list: write an item, - mesh: FILE, for each obstacle");
        }
        std::vector<PlacedMesh> scene;
        for (const YAML::Node& obstacle : list)
        {
            scene.push_back(placedMesh(obstacle));
        }
        if (const YAML::Node objects = file["objects"]; objects.IsDefined())
        {
            for (const YAML::Node& object : objects)
            {
                scene.push_back(placedMesh(object));
            }
        }
        return scene;
    }

    [[nodiscard]] std::optional<double> accuracy() const
    {
        const YAML::Node file = m_file.load("give a mesh, or a scene in CSV or YAML");
        const YAML::Node node =
            file.IsMap() ? file["accuracy"] : YAML::Node(YAML::NodeType::Undefined);
        if (!node.IsDefined())
        {
            return std::nullopt;
        }
        const double accuracy = m_file.numberOf(node, "accuracy");
        if (!(accuracy > 0.0))
        {
            m_file.fail(node,
                        "accuracy: ",
                        fmt::format("{} is not above 0: write a length such as 1e-3", accuracy));
        }
        return accuracy;
    }

private:
    [[nodiscard]] PlacedMesh placedMesh(const YAML::Node& node) const
    {
        if (!node.IsMap())
        {
            m_file.fail(node, "obstacles: ", "an item is not a map: write - mesh: FILE");
        }
        m_file.checkKeys(node, {"mesh", "box", "name", "scale", "position", "quaternion", "rpy"});
        const YAML::Node mesh = node["mesh"];
        const YAML::Node box = node["box"];
        if (mesh.IsDefined() == box.IsDefined())
        {
            m_file.fail(node,
                        "mesh: ",
                        box.IsDefined() ? "the item has a box, too: drop one of them"
                                        : "no such key in the item: name the file of the obstacle");
        }
        PlacedMesh placed;
        placed.X_WO = yamlPose(m_file, node);
        if (box.IsDefined())
        {
            const std::vector<double> extents = m_file.numbersOf(box, "box", 3);
            placed.box = Eigen::Vector3d(extents[0], extents[1], extents[2]);
            placed.name = "box";
            placed.where = m_file.place(box) + "box: ";
            if (!(placed.box->minCoeff() > 0.0) || node["scale"].IsDefined())
            {
                m_file.fail(box, "box: ", "three extents above 0 are needed, and no scale");
            }
        }
        else
        {
            placeMesh(m_file.textOf(mesh, "mesh"), placed);
            placed.where = m_file.place(mesh) + "mesh: ";
        }
        if (const YAML::Node name = node["name"]; name.IsDefined())
        {
            placed.name = m_file.textOf(name, "name");
        }
        if (const YAML::Node scale = node["scale"]; scale.IsDefined())
        {
            placed.scale = m_file.numberOf(scale, "scale");
            if (!(placed.scale > 0.0))
            {
                m_file.fail(scale,
                            "scale: ",
                            fmt::format("{} is not above 0: write a factor", placed.scale));
            }
        }
        return placed;
    }

    /// A file beside the scene, or an object that ships.
    void placeMesh(const std::string& text, PlacedMesh& placed) const
    {
        placed.mesh = m_file.path().parent_path() / text;
        placed.name = placed.mesh.filename().string();
        const std::filesystem::path shipped = shareFolder() / "objects" / (text + ".obj");
        if (!std::filesystem::is_regular_file(placed.mesh) &&
            std::filesystem::is_regular_file(shipped))
        {
            placed.mesh = shipped;
            placed.name = text;
        }
    }

    YamlFile m_file;
};
}  // namespace

std::vector<PlacedMesh> readYamlScene(const std::filesystem::path& path)
{
    return YamlScene(path).read();
}

std::optional<double> accuracyOf(std::span<const std::string> files, std::optional<double> stated)
{
    std::optional<double> found;
    for (const std::string& file : files)
    {
        const std::string ending = std::filesystem::path(file).extension().string();
        if (ending != ".yaml" && ending != ".yml")
        {
            continue;
        }
        const std::optional<double> accuracy = YamlScene(file).accuracy();
        found = accuracy ? accuracy : found;
        if (accuracy && stated && *accuracy != *stated)
        {
            throw std::runtime_error(
                fmt::format("{}: accuracy: {} is not the {} that was stated elsewhere, and a scene "
                            "has one: drop one of them",
                            file,
                            *accuracy,
                            *stated));
        }
        stated = accuracy ? accuracy : stated;
    }
    return found;
}
}  // namespace bullet_ccd::tools
