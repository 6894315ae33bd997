#include "tools/support/csv_table.h"
#include "tools/support/obstacles/obstacle_scene.h"

#include <fmt/format.h>
#include <optional>

namespace bullet_ccd::tools
{
namespace
{
/// Columns of a scene.
struct SceneColumns
{
    std::size_t mesh = 0;
    std::optional<std::size_t> name;
    std::optional<std::size_t> scale;
    std::optional<PoseColumns> pose;
};

SceneColumns columnsOf(const CsvTable& table)
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
    return {.mesh = *mesh,
            .name = table.find("name"),
            .scale = table.find("scale"),
            .pose = poseColumns(table, "")};
}

PlacedMesh placedMesh(const CsvTable& table, const CsvRow& row, const SceneColumns& columns)
{
    const std::string& mesh = row.cells[columns.mesh];
    if (mesh.empty())
    {
        table.fail(row, columns.mesh, "no value: name a mesh file");
    }
    const double scale = columns.scale ? table.number(row, *columns.scale) : 1.0;
    if (!(scale > 0.0))
    {
        table.fail(row, *columns.scale, fmt::format("{} is not above 0: write a factor", scale));
    }
    const bool hasName = columns.name && !row.cells[*columns.name].empty();
    const std::filesystem::path file = table.path.parent_path() / mesh;
    return {
        .mesh = file,
        .name = hasName ? row.cells[*columns.name] : file.filename().string(),
        .scale = scale,
        .X_WO = columns.pose ? poseOf(table, row, *columns.pose) : Eigen::Isometry3d::Identity(),
        .where = fmt::format("{}:{}: mesh: ", table.path.string(), row.line)};
}
}  // namespace

std::vector<PlacedMesh> readCsvScene(const std::filesystem::path& path)
{
    const CsvTable table = readCsvTable(path, "give a mesh, or a scene in CSV or YAML");
    const SceneColumns columns = columnsOf(table);
    std::vector<PlacedMesh> scene;
    for (const CsvRow& row : table.rows)
    {
        scene.push_back(placedMesh(table, row, columns));
    }
    return scene;
}
}  // namespace bullet_ccd::tools
