#include "tools/support/obstacles/obstacle_list.h"

#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tools/support/obstacles/scene_manifest.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

/// The box of a mesh, at rest in W.
Eigen::AlignedBox3d boxInWorld(const PlacedMesh& placed)
{
    Eigen::AlignedBox3d box = placed.facts->box.transformed(placed.X_WO);
    const Eigen::Vector3d rounding =
        1e-14 * (placed.facts->box.sizes().norm() + box.min().norm() + box.max().norm()) *
        Eigen::Vector3d::Ones();
    return {box.min() - rounding, box.max() + rounding};
}

class ObstacleReader
{
public:
    /// @param reach  null: everything is in reach
    explicit ObstacleReader(const std::span<const Eigen::AlignedBox3d>* reach) : m_reach(reach) {}

    void add(const fs::path& file)
    {
        if (!isScene(file))
        {
            m_list.inReach.push_back({.name = file.filename().string(), .tree = treeOf(file, 1.0)});
            return;
        }
        for (const PlacedMesh& placed : readScene(file))
        {
            addPlaced(placed, file);
        }
    }

    [[nodiscard]] ObstacleList take()
    {
        for (const auto& [mesh, triangles] : m_unread)
        {
            m_list.trianglesOutOfReach += m_trees.contains(mesh) ? 0 : triangles;
        }
        return std::move(m_list);
    }

private:
    void addPlaced(const PlacedMesh& placed, const fs::path& scene)
    {
        if (placed.facts)
        {
            const bool isInReach = reaches(placed);
            checkFacts(placed, scene, isInReach);
            if (!isInReach)
            {
                ++m_list.outOfReach;
                m_unread[{placed.mesh.string(), placed.scale}] = placed.facts->triangles;
                return;
            }
        }
        try
        {
            m_list.inReach.push_back(
                {.name = placed.name,
                 .tree = placed.box ? boxOf(*placed.box) : treeOf(placed.mesh, placed.scale),
                 .X_WO = placed.X_WO});
        }
        catch (const std::runtime_error& error)
        {
            throw std::runtime_error(placed.where + error.what());
        }
    }

    [[nodiscard]] bool reaches(const PlacedMesh& placed) const
    {
        const Eigen::AlignedBox3d box = boxInWorld(placed);
        return m_reach == nullptr ||
               std::any_of(m_reach->begin(),
                           m_reach->end(),
                           [&](const Eigen::AlignedBox3d& swept) { return swept.intersects(box); });
    }

    static std::shared_ptr<const SsvTree> boxOf(const Eigen::Vector3d& extents)
    {
        return std::make_shared<const SsvTree>(buildSsvTree(makeBox(0.5 * extents)));
    }

    std::shared_ptr<const SsvTree> treeOf(const fs::path& file, double scale)
    {
        std::shared_ptr<const SsvTree>& tree = m_trees[{file.string(), scale}];
        if (tree == nullptr)
        {
            tree = std::make_shared<const SsvTree>(
                buildSsvTreeAsNeeded(loadMeshFile(file, {.scale = scale}).mesh));
        }
        return tree;
    }

    const std::span<const Eigen::AlignedBox3d>* m_reach;
    using FileAndScale = std::pair<std::string, double>;

    std::map<FileAndScale, std::shared_ptr<const SsvTree>> m_trees;
    std::map<FileAndScale, std::size_t> m_unread;  ///< triangles of what was out of reach
    ObstacleList m_list;
};

ObstacleList load(std::span<const std::string> files,
                  const std::span<const Eigen::AlignedBox3d>* reach)
{
    ObstacleReader reader(reach);
    for (const std::string& file : files)
    {
        reader.add(file);
    }
    return reader.take();
}
}  // namespace

std::vector<Obstacle> loadObstacles(std::span<const std::string> files)
{
    return load(files, nullptr).inReach;
}

ObstacleList loadObstaclesWithin(std::span<const std::string> files,
                                 std::span<const Eigen::AlignedBox3d> reach)
{
    return load(files, &reach);
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
