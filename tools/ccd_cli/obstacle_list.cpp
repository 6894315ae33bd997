#include "tools/ccd_cli/obstacle_list.h"

#include "bullet_ccd/io/mesh_file.h"
#include "tools/ccd_cli/csv_table.h"
#include "tools/ccd_cli/pose_columns.h"

#include <filesystem>
#include <fmt/format.h>
#include <map>
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
        if (file.extension() == ".csv")
        {
            addScene(readCsvTable(file, "give a mesh, or a scene in CSV"));
            return;
        }
        m_obstacles.push_back({.name = file.filename().string(), .tree = treeOf(file, 1.0)});
    }

    [[nodiscard]] std::vector<Obstacle> take() { return std::move(m_obstacles); }

private:
    void addScene(const CsvTable& table)
    {
        for (const std::string& name : table.names)
        {
            if (name != "mesh" && name != "name" && name != "scale" && !isPoseColumn(name, ""))
            {
                table.failNames(name +
                                ": no such column in a scene: use mesh, name, scale, qw, qx, qy, "
                                "qz, tx, ty, tz");
            }
        }
        const std::optional<std::size_t> mesh = table.find("mesh");
        if (!mesh)
        {
            table.failNames("no column mesh: name the file of each obstacle");
        }
        const std::optional<PoseColumns> pose = poseColumns(table, "");
        for (const CsvRow& row : table.rows)
        {
            addRow(table, row, *mesh, pose);
        }
    }

    void addRow(const CsvTable& table,
                const CsvRow& row,
                std::size_t mesh,
                const std::optional<PoseColumns>& pose)
    {
        if (row.cells[mesh].empty())
        {
            table.fail(row, mesh, "no value: name a mesh file");
        }
        const std::optional<std::size_t> name = table.find("name");
        const std::optional<std::size_t> scale = table.find("scale");
        const fs::path file = table.path.parent_path() / row.cells[mesh];
        const double factor = scale ? table.number(row, *scale) : 1.0;
        if (!(factor > 0.0))
        {
            table.fail(row, *scale, fmt::format("{} is not above 0: write a factor", factor));
        }
        m_obstacles.push_back(
            {.name =
                 name && !row.cells[*name].empty() ? row.cells[*name] : file.filename().string(),
             .tree = treeOf(file, factor),
             .X_WO = pose ? poseOf(table, row, *pose) : Eigen::Isometry3d::Identity()});
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
