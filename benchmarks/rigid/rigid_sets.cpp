#include "benchmarks/rigid/rigid_sets.h"

#include "benchmarks/rigid/rigid_meshes.h"
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tools/support/csv_table.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <functional>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
namespace fs = std::filesystem;

/// Vertices of the bunny's file are rounded to single precision; so are those of its references'
/// mesh, but in another way.
constexpr double kBunnyRounding = 1e-5;

/// Of families with a resolution, smallest first.
constexpr std::array kKnotSizes{
    "knot_1k", "knot_4k", "knot_16k", "knot_64k", "knot_256k", "knot_1m"};
constexpr std::array kSphereSizes{
    "sphere_1k", "sphere_5k", "sphere_20k", "sphere_80k", "sphere_320k", "sphere_1m"};

/// Place in the family; none if the mesh is not of it.
std::optional<int> sizeIn(const std::array<const char*, 6>& family, const std::string& mesh)
{
    const auto* found = std::ranges::find(family, mesh);
    return found == family.end() ? std::nullopt
                                 : std::optional(static_cast<int>(found - family.begin()));
}

/// Half-extents, with proportions that keep its faces' corners off each other's grids.
const Eigen::Vector3d kFlatBox(60.0, 45.0, 33.0);

/// A thin box with so many cells along its length and its width.
TriangleMesh makePlate(int cells)
{
    return makeGridBox({cells, cells, 1}, {60.0, 60.0, 0.1});
}

TriangleMesh makeMesh(const std::string& name, const fs::path& dataFolder)
{
    if (const std::optional<int> size = sizeIn(kKnotSizes, name))
    {
        return makeKnotTube(64 << *size, 8 << *size);
    }
    if (const std::optional<int> size = sizeIn(kSphereSizes, name))
    {
        return makeBumpySphere(3 + *size, 80.0, 0.15);
    }
    const std::map<std::string, std::function<TriangleMesh()>> others{
        {"bunny",
         [&] { return loadMeshFile(dataFolder / "motions/c2a_torusknot/bunny_noholes.ply").mesh; }},
        {"finger", makeFinger},
        {"plate", [] { return makePlate(15); }},
        {"box",
         [] {
             return makeBox({1.0, 0.6, 0.3});
         }},
        {"flat_plate_1k", [] { return makePlate(15); }},
        {"flat_plate_10k", [] { return makePlate(49); }},
        {"flat_plate_100k", [] { return makePlate(157); }},
        {"flat_box_1k",
         [] {
             return makeGridBox({9, 9, 9}, kFlatBox);
         }},
        {"flat_box_10k",
         [] {
             return makeGridBox({29, 29, 29}, kFlatBox);
         }},
        {"flat_box_100k",
         [] {
             return makeGridBox({91, 91, 91}, kFlatBox);
         }},
        {"flat_cylinder_1k", [] { return makeRingedCylinder(40.0, 100.0, 24, 4, 14); }},
        {"flat_cylinder_10k", [] { return makeRingedCylinder(40.0, 100.0, 72, 14, 42); }},
        {"flat_cylinder_100k", [] { return makeRingedCylinder(40.0, 100.0, 228, 40, 140); }},
        {"torus", [] { return makeTorus(80.0, 24.0, 128, 32); }},
        {"gear_20", [] { return makeGear(20, kGearBacklash, 6.0, 16); }},
        {"gear_30", [] { return makeGear(30, kGearBacklash, 6.0, 16); }},
        {"ball", [] { return makeSphere(kBall, 5); }},
        {"shell_02", [] { return makeSphere(kBall * (1.0 + 2e-4 + 0.002), 5); }},
        {"shell_2", [] { return makeSphere(kBall * (1.0 + 2e-4 + 0.02), 5); }},
        {"bolt", [] { return makeThread(kBolt, kThread, kPitch, false); }},
        {"nut", [] { return makeThread(kBolt + kNutClearance, kThread, kPitch, true); }},
        {"comb",
         [] {
             return makeComb(12, kCombPitch, {30.0, 20.0, kBlade});
         }},
        {"link", [] { return makeTorus(40.0, 8.0, 96, 32); }},
        {"cylinder", [] { return makeCylinder(15.0, 225.0, 64); }},
        {"hull42", [] { return makeSphere(1.0, 1); }},
        {"hull162", [] { return makeSphere(1.0, 2); }}};
    const auto found = others.find(name);
    require(found != others.end(),
            "mesh '" + name + "' is unknown: see benchmarks/rigid/rigid_sets.cpp");
    return found->second();
}

/// Throws std::runtime_error if there is none.
std::size_t columnOf(const tools::CsvTable& table, const std::string& name)
{
    const std::optional<std::size_t> column = table.find(name);
    if (!column)
    {
        table.failNames("column " + name + " is missing: is this a file of rigid_queries/?");
    }
    return *column;
}

tools::PoseColumns columnsOf(const tools::CsvTable& table, const std::string& prefix)
{
    static_cast<void>(columnOf(table, prefix + "qw"));
    return *tools::poseColumns(table, prefix);
}

constexpr const char* kRemedy = "name the data folder with --data";

/// "knot_64k" -> "knot": one file of poses serves all resolutions.
std::string posesOf(const std::string& set)
{
    const bool manySizes = set.starts_with("knot_") || set.starts_with("sphere_");
    return manySizes ? set.substr(0, set.find('_')) : set;
}

/// "convex_hull42_rot40" -> "hull42".
std::string meshOf(const std::string& set)
{
    if (set.starts_with("bunny_"))
    {
        return "bunny";
    }
    if (set.starts_with("convex_"))
    {
        const std::size_t begin = std::string("convex_").size();
        return set.substr(begin, set.find('_', begin) - begin);
    }
    return set;
}

RigidSet readSet(const std::string& name, MeshLibrary& meshes)
{
    RigidSet set{.name = name, .meshA = meshes.mesh(meshOf(name)), .meshB = {}};
    set.meshB = set.meshA;
    set.vertexRounding = name.starts_with("bunny_") ? kBunnyRounding : 0.0;
    const fs::path folder = meshes.dataFolder() / "rigid_queries";
    const tools::CsvTable poses =
        tools::readCsvTable(folder / "poses" / (posesOf(name) + ".csv"), kRemedy);
    for (const tools::CsvRow& row : poses.rows)
    {
        const auto pose = [&](const char* prefix)
        { return tools::poseOf(poses, row, columnsOf(poses, prefix)); };
        set.queries.push_back(
            {.id = static_cast<std::int32_t>(poses.number(row, columnOf(poses, "id"))),
             .motionA = motionBetween(pose("a0_"), pose("a1_")),
             .motionB = motionBetween(pose("b0_"), pose("b1_"))});
    }
    if (name.ends_with("_1m"))
    {
        return set;  // a size beyond the references
    }
    const tools::CsvTable references =
        tools::readCsvTable(folder / "reference" / (name + ".csv"), kRemedy);
    for (const tools::CsvRow& row : references.rows)
    {
        const auto number = [&](const char* column)
        { return references.number(row, columnOf(references, column)); };
        set.references.push_back({.hit = number("collide") != 0.0,
                                  .timeLow = number("toi_lo"),
                                  .time = number("toi"),
                                  .timeAtTolerance = number("toi_at_1e-4"),
                                  .closestDistance = number("closest_distance"),
                                  .speedBound = number("speed_bound")});
    }
    require(set.references.size() == set.queries.size(),
            "set '" + name + "': poses and references differ in number");
    return set;
}
}  // namespace

std::shared_ptr<const TriangleMesh> MeshLibrary::mesh(const std::string& name)
{
    std::shared_ptr<const TriangleMesh>& entry = m_meshes[name];
    if (!entry)
    {
        entry = std::make_shared<const TriangleMesh>(makeMesh(name, m_dataFolder));
    }
    return entry;
}

const std::vector<std::string>& fileSetNames()
{
    static const std::vector<std::string> kNames = []
    {
        std::vector<std::string> names{"bunny_ident", "bunny_ani", "plate"};
        names.insert(names.end(), kKnotSizes.begin(), kKnotSizes.end());
        names.insert(names.end(), kSphereSizes.begin(), kSphereSizes.end());
        for (const char* mesh : {"box", "hull42", "hull162"})
        {
            names.push_back(fmt::format("convex_{}_trans", mesh));
            names.push_back(fmt::format("convex_{}_rot40", mesh));
        }
        return names;
    }();
    return kNames;
}

RigidSet makeRigidSet(const std::string& name, MeshLibrary& meshes, std::uint64_t seedShift)
{
    if (std::ranges::count(fileSetNames(), name) > 0)
    {
        return readSet(name, meshes);
    }
    if (std::ranges::count(generatedSetNames(), name) > 0)
    {
        return generateSet(name, meshes, seedShift);
    }
    throw std::invalid_argument("set '" + name + "' is unknown: --list names all");
}
}  // namespace bullet_ccd::benchmarks
