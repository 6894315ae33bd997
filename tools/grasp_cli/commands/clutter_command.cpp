#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/report/grasp_picture.h"
#include "grasp/sim/settle.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/inputs/catalogue.h"
#include "tools/grasp_cli/inputs/task_scene.h"
#include "tools/grasp_cli/plan/output_folder.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
struct ClutterArguments
{
    std::vector<std::string> objects{"apple",
                                     "mug",
                                     "can",
                                     "box",
                                     "glass",
                                     "bottle",
                                     "ball",
                                     "soap_dispenser",
                                     "wine_glass",
                                     "jug"};
    int count = 12;
    double rim = 0.0;  // height [m]
    std::string output;
    grasp::ClutterOptions options{.from = {0.35, -0.55}, .to = {0.8, 0.1}};
};

/// What stands there: its name, its extents and its middle, W [m].
struct Box
{
    const char* name;
    Eigen::Vector3d extents;
    Eigen::Vector3d center;
};

/// A table, and on it a rim around what is let go, if it has a height.
std::vector<Box> boxesOf(const ClutterArguments& a)
{
    std::vector<Box> boxes{{"table", {0.9, 1.3, 0.04}, {0.62, 0.0, -0.02}}};
    if (a.rim > 0.0)
    {
        constexpr double kThick = 0.01;
        constexpr double kAway = 0.06;  // of the middles of the outermost objects
        const Eigen::Vector2d middle = 0.5 * (a.options.from + a.options.to);
        const Eigen::Vector2d half =
            0.5 * (a.options.to - a.options.from) + Eigen::Vector2d::Constant(kAway);
        const double z = 0.5 * a.rim + 1e-3;
        const Eigen::Vector3d along(2.0 * (half.x() + kThick), kThick, a.rim);
        const Eigen::Vector3d across(kThick, 2.0 * half.y(), a.rim);
        const double x = half.x() + 0.5 * kThick;
        const double y = half.y() + 0.5 * kThick;
        boxes.push_back({"left rim", along, {middle.x(), middle.y() + y, z}});
        boxes.push_back({"right rim", along, {middle.x(), middle.y() - y, z}});
        boxes.push_back({"near rim", across, {middle.x() - x, middle.y(), z}});
        boxes.push_back({"far rim", across, {middle.x() + x, middle.y(), z}});
    }
    return boxes;
}

/// The scene, with a free target at the left.
void writeScene(std::ostream& out,
                const ClutterArguments& a,
                const std::vector<Box>& boxes,
                const std::vector<std::string>& meshes,
                const std::vector<std::string>& names,
                const grasp::SettledObjects& settled)
{
    out << fmt::format("# {} objects on a table: grasp task clutter --count {} --seed {}{}\n",
                       meshes.size(),
                       a.count,
                       a.options.seed,
                       a.rim > 0.0 ? fmt::format(" --rim {}", a.rim) : "")
        << "robot:\n"
           "  start: {shoulder_bend_joint: -0.3, elbow_joint: -1.6, wrist_bend_joint: 1.2}\n"
           "obstacles:\n";
    for (const Box& box : boxes)
    {
        const Eigen::Vector3d& e = box.extents;
        const Eigen::Vector3d& c = box.center;
        out << fmt::format(
            "  - {{name: {}, box: [{:g}, {:g}, {:g}], position: [{:g}, {:g}, {:g}]}}\n",
            box.name,
            e.x(),
            e.y(),
            e.z(),
            c.x(),
            c.y(),
            c.z());
    }
    out << "objects:\n";
    for (std::size_t i = 0; i < meshes.size(); ++i)
    {
        const Eigen::Vector3d p = settled.X_WO[i].translation();
        const Eigen::Quaterniond q(settled.X_WO[i].linear());
        out << fmt::format(
            "  - {{mesh: {}, name: {}, position: [{:.6f}, {:.6f}, {:.6f}], quaternion: [{:.9f}, "
            "{:.9f}, {:.9f}, {:.9f}]}}\n",
            meshes[i],
            names[i],
            p.x(),
            p.y(),
            p.z(),
            q.w(),
            q.x(),
            q.y(),
            q.z());
    }
    out << "target: {position: [0.5, 0.35, 0], size: [0.2, 0.2]}\n";
}

int runClutter(const ClutterArguments& a)
{
    std::map<std::string, LoadedObject> loaded;
    std::map<std::string, int> used;
    std::vector<std::string> meshes;
    std::vector<std::string> names;
    std::vector<const grasp::GraspObject*> objects;
    for (int i = 0; i < a.count; ++i)
    {
        const std::string& mesh = a.objects[static_cast<std::size_t>(i) % a.objects.size()];
        auto found = loaded.find(mesh);
        if (found == loaded.end())
        {
            found = loaded.emplace(mesh, loadNamedObject(mesh, 1.0)).first;
        }
        const int turn = ++used[mesh];
        meshes.push_back(mesh);
        names.push_back(found->second.object.name + (turn > 1 ? fmt::format(" {}", turn) : ""));
        objects.push_back(&found->second.object);
    }
    const std::vector<Box> boxes = boxesOf(a);
    std::vector<SsvTree> trees;
    std::vector<RigidBody> obstacles;
    trees.reserve(boxes.size());
    for (const Box& box : boxes)
    {
        trees.push_back(buildSsvTree(makeBox(0.5 * box.extents)));
        obstacles.push_back(
            {.tree = &trees.back(),
             .motion = restAt(Eigen::Isometry3d(Eigen::Translation3d(box.center)))});
    }
    const grasp::SettledObjects settled = grasp::settle(objects, obstacles, a.options);
    std::ofstream out(a.output);
    writeScene(out, a, boxes, meshes, names, settled);
    out.close();
    if (!out)
    {
        throw std::runtime_error(a.output +
                                 ": cannot be written: give -o a file in a folder that "
                                 "exists");
    }
    const std::filesystem::path picture = std::filesystem::path(a.output).replace_extension(".png");
    drawScene(readTaskScene(a.output), picture);
    const bool areOn = std::ranges::all_of(
        settled.X_WO, [](const Eigen::Isometry3d& X_WO) { return X_WO.translation().z() > -0.1; });
    fmt::print("{} objects {} after {:.1f} s\nwritten:  {}, {}\n",
               objects.size(),
               !areOn           ? "have not all stayed on the table"
               : settled.atRest ? "are at rest"
                                : "still move",
               settled.seconds,
               a.output,
               picture.string());
    return settled.atRest && areOn ? kDone : kNothingFound;
}

struct SceneArguments
{
    std::vector<std::string> scenes;
    std::string output;
};

int runScene(const SceneArguments& a)
{
    OutputFolder output(a.output);
    std::vector<std::filesystem::path> pictures;
    std::vector<std::string> names;
    for (const std::string& name : a.scenes)
    {
        const TaskScene scene = readTaskScene(resolveScene(name));
        names.push_back(scene.file.stem().string() + ".png");
        pictures.push_back(output.stage(names.back()));
        drawScene(scene, pictures.back());
        fmt::print("{}: {} obstacles, {} objects\n",
                   scene.file.stem().string(),
                   scene.obstacles.size(),
                   scene.objects.size());
    }
    if (pictures.size() > 1)
    {
        names.emplace_back("scenes.png");
        grasp::joinPictures(pictures, 1, 2, output.stage(names.back()));
    }
    output.commit();
    fmt::print("written:  {} in {}\n", joined(names, ", "), a.output);
    return kDone;
}
}  // namespace

void addScene(CLI::App& task, int& exitCode)
{
    auto* command = task.add_subcommand("scene", "Draws scenes.");
    const auto a = std::make_shared<SceneArguments>();
    command->add_option("SCENES", a->scenes, "Scenes in YAML, or names of those that ship.")
        ->type_name("SCENE...")
        ->required();
    command->add_option("-o,--output", a->output, "A folder for SCENE.png, and scenes.png of all.")
        ->type_name("FOLDER")
        ->required();
    command->footer(
        "Each is seen from where the robot stands, and from above.\n"
        "\n"
        "Exit codes: 0, 2 for wrong options, 3 for bad input.\n"
        "\n"
        "Example:\n"
        "  grasp task scene table shelf bin -o out");
    command->callback([a, &exitCode] { exitCode = runScene(*a); });
}

void addClutter(CLI::App& task, int& exitCode)
{
    auto* command = task.add_subcommand(
        "clutter", "Makes a scene: objects let go above a table, where they come to rest.");
    const auto a = std::make_shared<ClutterArguments>();
    command
        ->add_option(
            "OBJECTS", a->objects, "Mesh files, or names of objects that ship, which take turns.")
        ->type_name("OBJECT...")
        ->capture_default_str();
    command->add_option("-n,--count", a->count, "How many objects.")
        ->type_name("N")
        ->check(within(1, 1000))
        ->capture_default_str();
    command->add_option("--seed", a->options.seed, "What places and turns are drawn from.")
        ->type_name("N")
        ->check(wholeNumber())
        ->capture_default_str();
    command
        ->add_option(
            "--rim", a->rim, "The height of a rim around the objects [m]; 0: there is none.")
        ->type_name("H")
        ->check(within(0.0, 1.0))
        ->capture_default_str();
    command
        ->add_option(
            "-o,--output",
            a->output,
            "The scene file to write (YAML); a picture of that name stands beside it (.png).")
        ->type_name("FILE")
        ->required();
    command->footer(
        "Objects stand upright, turned by chance, each at a place of its own while there is room "
        "on the right half of the table, else above the others, and fall in a Bullet world. The "
        "same options write the same bytes.\n"
        "\n"
        "Exit codes: 0 if all came to rest on the table, 1 if one still moves after 6 s or fell "
        "off, 2 for wrong options, 3 "
        "for bad input.\n"
        "\n"
        "Example:\n"
        "  grasp task clutter -n 20 --seed 3 -o clutter.yaml\n"
        "  grasp task pick-place clutter.yaml --arm seven_joint_arm --hand parallel_gripper");
    command->callback([a, &exitCode] { exitCode = runClutter(*a); });
}
}  // namespace bullet_ccd::tools
