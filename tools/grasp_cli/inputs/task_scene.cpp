#include "tools/grasp_cli/inputs/task_scene.h"

#include "bullet_ccd/io/mesh_file.h"
#include "grasp/report/grasp_picture.h"
#include "tools/grasp_cli/inputs/catalogue.h"
#include "tools/support/text_table.h"
#include "tools/support/yaml_file.h"
#include "tools/support/yaml_pose.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

class TaskSceneReader
{
public:
    explicit TaskSceneReader(const fs::path& path) : m_file(path) {}

    [[nodiscard]] TaskScene read()
    {
        const YAML::Node file = m_file.load("give a scene in YAML");
        if (!file.IsMap())
        {
            m_file.fail(file, "", "not a map: write objects: and target:");
        }
        m_file.checkKeys(file, {"robot", "obstacles", "objects", "target"});
        TaskScene scene;
        scene.file = m_file.path();
        if (const YAML::Node robot = file["robot"]; robot.IsDefined())
        {
            readRobot(robot, scene);
        }
        scene.obstacles = bodiesOf(file, "obstacles");
        scene.objects = bodiesOf(file, "objects");
        if (scene.objects.empty())
        {
            m_file.fail(file,
                        "objects: ",
                        "there is none: write an item for each object that can be taken");
        }
        const YAML::Node target = file["target"];
        if (!target.IsDefined() || !target.IsMap())
        {
            m_file.fail(file, "target: ", "no map: write position: [x, y, z] and size: [x, y]");
        }
        m_file.checkKeys(target, {"position", "size"});
        scene.targetCenter = vectorOf<3>(target, "position");
        scene.targetSize = vectorOf<2>(target, "size");
        if (scene.targetSize.minCoeff() < 0.0)
        {
            m_file.fail(target["size"], "size: ", "a number is negative: write two lengths");
        }
        return scene;
    }

private:
    template <int N>
    [[nodiscard]] Eigen::Matrix<double, N, 1> vectorOf(const YAML::Node& map,
                                                       const std::string& key) const
    {
        if (!map[key].IsDefined())
        {
            m_file.fail(map, key + ": ", fmt::format("no such key: write {} numbers [m]", N));
        }
        const std::vector<double> numbers = m_file.numbersOf(map[key], key, N);
        return Eigen::Map<const Eigen::Matrix<double, N, 1>>(numbers.data());
    }

    void readRobot(const YAML::Node& robot, TaskScene& scene) const
    {
        if (!robot.IsMap())
        {
            m_file.fail(robot, "robot: ", "not a map: write position: or start:");
        }
        m_file.checkKeys(robot, {"position", "quaternion", "rpy", "start"});
        scene.X_WR = yamlPose(m_file, robot);
        const YAML::Node start = robot["start"];
        if (start.IsDefined() && !start.IsMap())
        {
            m_file.fail(start, "start: ", "not a map: write JOINT: POSITION for each joint");
        }
        for (const auto& joint : start)
        {
            const auto name = joint.first.as<std::string>();
            scene.start.emplace_back(name, m_file.numberOf(joint.second, name));
        }
    }

    [[nodiscard]] std::vector<TaskBody> bodiesOf(const YAML::Node& file, const std::string& key)
    {
        std::vector<TaskBody> bodies;
        const YAML::Node list = file[key];
        if (!list.IsDefined())
        {
            return bodies;
        }
        if (!list.IsSequence())
        {
            m_file.fail(list, key + ": ", "no list: write an item for each body");
        }
        for (const YAML::Node& node : list)
        {
            bodies.push_back(bodyOf(node));
            if (!m_names.emplace(bodies.back().name, 0).second)
            {
                m_file.fail(node,
                            "name: ",
                            bodies.back().name + " is there already: write a name for each body");
            }
        }
        return bodies;
    }

    [[nodiscard]] TaskBody bodyOf(const YAML::Node& node)
    {
        if (!node.IsMap())
        {
            m_file.fail(node, "", "an item is not a map: write - mesh: NAME or - box: [x, y, z]");
        }
        m_file.checkKeys(node, {"mesh", "box", "name", "scale", "position", "quaternion", "rpy"});
        if (node["mesh"].IsDefined() == node["box"].IsDefined())
        {
            m_file.fail(node, "mesh: ", "the item needs a mesh or a box, and not both");
        }
        TaskBody body;
        body.X_WO = yamlPose(m_file, node);
        if (node["box"].IsDefined())
        {
            const Eigen::Vector3d extents = vectorOf<3>(node, "box");
            if (!(extents.minCoeff() > 0.0) || node["scale"].IsDefined())
            {
                m_file.fail(node["box"], "box: ", "three extents above 0 are needed, and no scale");
            }
            body.name = "box";
            body.tree = std::make_shared<const SsvTree>(buildSsvTree(makeBox(0.5 * extents)));
        }
        else
        {
            readMesh(node, body);
        }
        if (node["name"].IsDefined())
        {
            body.name = m_file.textOf(node["name"], "name");
        }
        return body;
    }

    void readMesh(const YAML::Node& node, TaskBody& body)
    {
        const std::string text = m_file.textOf(node["mesh"], "mesh");
        const double scale =
            node["scale"].IsDefined() ? m_file.numberOf(node["scale"], "scale") : 1.0;
        if (!(scale > 0.0))
        {
            m_file.fail(
                node["scale"], "scale: ", fmt::format("{} is not above 0: write a factor", scale));
        }
        try
        {
            const fs::path beside = m_file.path().parent_path() / text;
            const fs::path file = fs::is_regular_file(beside) ? beside : resolveObject(text);
            body.name = file.stem().string();
            std::shared_ptr<const SsvTree>& tree = m_trees[{file.string(), scale}];
            if (tree == nullptr)
            {
                tree = std::make_shared<const SsvTree>(
                    buildSsvTree(loadMeshFile(file, {.scale = scale}).mesh));
            }
            body.tree = tree;
        }
        catch (const std::runtime_error& error)
        {
            m_file.fail(node["mesh"], "mesh: ", error.what());
        }
    }

    YamlFile m_file;
    std::map<std::string, int> m_names;
    std::map<std::pair<std::string, double>, std::shared_ptr<const SsvTree>> m_trees;
};

fs::path resolved(const std::string& nameOrPath,
                  const char* folder,
                  const std::string& ending,
                  const char* what)
{
    const fs::path place = shareFolder() / "robots" / folder;
    const fs::path shipped = place / (nameOrPath + ending);
    if (fs::is_regular_file(nameOrPath) || !fs::is_regular_file(shipped))
    {
        if (!fs::is_regular_file(nameOrPath))
        {
            std::vector<std::string> known;
            std::error_code error;
            for (const auto& entry : fs::directory_iterator(place, error))
            {
                known.push_back(entry.path().stem().string());
            }
            std::ranges::sort(known);
            throw std::runtime_error(fmt::format("{} \"{}\": neither a file nor one that ships: {}",
                                                 what,
                                                 nameOrPath,
                                                 joined(known, ", ")));
        }
        return nameOrPath;
    }
    return shipped;
}
}  // namespace

TaskScene readTaskScene(const fs::path& path)
{
    return TaskSceneReader(path).read();
}

fs::path resolveScene(const std::string& nameOrPath)
{
    return resolved(nameOrPath, "scenes", ".yaml", "scene");
}

fs::path resolveArm(const std::string& nameOrPath)
{
    return resolved(nameOrPath, "arms", ".urdf", "arm");
}

void drawScene(const TaskScene& scene, const std::filesystem::path& file)
{
    const auto bodiesOf = [](const std::vector<TaskBody>& bodies)
    {
        std::vector<RigidBody> rigid;
        for (const TaskBody& body : bodies)
        {
            rigid.push_back({.tree = body.tree.get(), .motion = restAt(body.X_WO)});
        }
        return rigid;
    };
    const std::vector<RigidBody> objects = bodiesOf(scene.objects);
    const std::vector<RigidBody> obstacles = bodiesOf(scene.obstacles);
    grasp::drawBodies(objects, {.width = 1600, .height = 560, .obstacles = obstacles}, file);
}
}  // namespace bullet_ccd::tools
