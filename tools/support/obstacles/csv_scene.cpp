#include "tools/support/csv_table.h"
#include "tools/support/obstacles/obstacle_scene.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <fmt/format.h>
#include <optional>

namespace bullet_ccd::tools
{
namespace
{
/// What a manifest has beside a scene.
constexpr std::array<const char*, 9> kFactNames{
    "triangles", "low_x", "low_y", "low_z", "high_x", "high_y", "high_z", "bytes", "hash"};
using FactColumns = std::array<std::size_t, kFactNames.size()>;

/// Columns of a scene.
struct SceneColumns
{
    std::size_t mesh = 0;
    std::optional<std::size_t> name;
    std::optional<std::size_t> scale;
    std::optional<PoseColumns> pose;
    std::optional<FactColumns> facts;
};

std::optional<FactColumns> factColumns(const CsvTable& table)
{
    FactColumns columns{};
    std::size_t found = 0;
    for (std::size_t k = 0; k < kFactNames.size(); ++k)
    {
        if (const std::optional<std::size_t> column = table.find(kFactNames[k]))
        {
            columns[k] = *column;
            ++found;
        }
    }
    if (found != 0 && found != kFactNames.size())
    {
        table.failNames("only some columns of a manifest: make it again by bullet-ccd manifest");
    }
    return found == 0 ? std::nullopt : std::optional(columns);
}

SceneColumns columnsOf(const CsvTable& table)
{
    for (const std::string& name : table.names)
    {
        const bool isFact =
            std::find(kFactNames.begin(), kFactNames.end(), name) != kFactNames.end();
        if (name != "mesh" && name != "name" && name != "scale" && !isPoseColumn(name, "") &&
            !isFact)
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
            .pose = poseColumns(table, ""),
            .facts = factColumns(table)};
}

/// A whole number, exact whatever its size.
std::uint64_t countOf(const CsvTable& table, const CsvRow& row, std::size_t column, int base)
{
    const std::string& cell = row.cells[column];
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value, base);
    if (cell.empty() || error != std::errc() || end != cell.data() + cell.size())
    {
        table.fail(row,
                   column,
                   fmt::format("\"{}\" is no whole number: make the manifest again by bullet-ccd "
                               "manifest",
                               cell));
    }
    return value;
}

MeshFacts factsOf(const CsvTable& table, const CsvRow& row, const FactColumns& columns)
{
    const auto corner = [&](std::size_t first)
    {
        return Eigen::Vector3d(table.number(row, columns[first]),
                               table.number(row, columns[first + 1]),
                               table.number(row, columns[first + 2]));
    };
    const MeshFacts facts{.box = {corner(1), corner(4)},
                          .triangles = countOf(table, row, columns[0], 10),
                          .bytes = countOf(table, row, columns[7], 10),
                          .hash = countOf(table, row, columns[8], 16)};
    if (facts.box.isEmpty())
    {
        table.fail(row,
                   columns[1],
                   "the low corner is above the high one: make the manifest again by bullet-ccd "
                   "manifest");
    }
    return facts;
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
        .where = fmt::format("{}:{}: mesh: ", table.path.string(), row.line),
        .facts = columns.facts ? std::optional(factsOf(table, row, *columns.facts)) : std::nullopt};
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

bool isScene(const std::filesystem::path& path)
{
    const std::string kind = path.extension().string();
    return kind == ".csv" || kind == ".yaml" || kind == ".yml";
}

std::vector<PlacedMesh> readScene(const std::filesystem::path& path)
{
    return path.extension() == ".csv" ? readCsvScene(path) : readYamlScene(path);
}
}  // namespace bullet_ccd::tools
