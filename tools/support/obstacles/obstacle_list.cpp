#include "tools/support/obstacles/obstacle_list.h"

#include "bullet_ccd/io/mesh_file.h"
#include "tools/support/obstacles/obstacle_scene.h"

#include <filesystem>
#include <map>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

class ObstacleReader
{
public:
    void add(const fs::path& file)
    {
        const std::string kind = file.extension().string();
        if (kind == ".csv")
        {
            addScene(readCsvScene(file));
        }
        else if (kind == ".yaml" || kind == ".yml")
        {
            addScene(readYamlScene(file));
        }
        else
        {
            m_obstacles.push_back({.name = file.filename().string(), .tree = treeOf(file, 1.0)});
        }
    }

    [[nodiscard]] std::vector<Obstacle> take() { return std::move(m_obstacles); }

private:
    void addScene(const std::vector<PlacedMesh>& scene)
    {
        for (const PlacedMesh& placed : scene)
        {
            try
            {
                m_obstacles.push_back({.name = placed.name,
                                       .tree = treeOf(placed.mesh, placed.scale),
                                       .X_WO = placed.X_WO});
            }
            catch (const std::runtime_error& error)
            {
                throw std::runtime_error(placed.where + error.what());
            }
        }
    }

    std::shared_ptr<const SsvTree> treeOf(const fs::path& file, double scale)
    {
        std::shared_ptr<const SsvTree>& tree = m_trees[{file.string(), scale}];
        if (tree == nullptr)
        {
            tree = std::make_shared<const SsvTree>(
                buildSsvTree(loadMeshFile(file, {.scale = scale}).mesh));
        }
        return tree;
    }

    std::map<std::pair<std::string, double>, std::shared_ptr<const SsvTree>> m_trees;
    std::vector<Obstacle> m_obstacles;
};
}  // namespace

std::vector<Obstacle> loadObstacles(std::span<const std::string> files)
{
    ObstacleReader reader;
    for (const std::string& file : files)
    {
        reader.add(file);
    }
    return reader.take();
}

std::vector<RigidBody> bodiesOf(std::span<const Obstacle> obstacles)
{
    std::vector<RigidBody> bodies;
    for (const Obstacle& obstacle : obstacles)
    {
        bodies.push_back({.tree = obstacle.tree.get(), .motion = restAt(obstacle.X_WO)});
    }
    return bodies;
}
}  // namespace bullet_ccd::tools
