#include "grasp/planner/grasp_file.h"
#include "grasp/report/grasp_picture.h"
#include "tools/ccd_cli/obstacle_list.h"
#include "tools/grasp_cli/catalogue.h"
#include "tools/grasp_cli/commands.h"
#include "tools/grasp_cli/output_folder.h"
#include "tools/grasp_cli/plan_run.h"
#include "tools/grasp_cli/text_table.h"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using grasp::Grasp;
using grasp::RejectReason;

struct PlanArguments
{
    std::string hand;
    std::string object;
    std::string srdf;
    double objectScale = 1.0;
    fs::path output = "out";
    int pictures = 5;
    bool quiet = false;
    std::vector<std::string> scene;
    grasp::PlannerOptions options;
};

std::string pictureName(std::size_t rank)
{
    return fmt::format("grasp_{:02}.png", rank);
}

/// The best grasps that have a final posture, in order of rank.
std::vector<std::size_t> worthDrawing(const std::vector<Grasp>& grasps, int pictures)
{
    std::vector<std::size_t> indices;
    for (std::size_t k = 0; k < grasps.size(); ++k)
    {
        const bool drawable = grasps[k].reject == RejectReason::None ||
                              grasps[k].reject == RejectReason::NoForceClosure;
        if (drawable && indices.size() < static_cast<std::size_t>(pictures))
        {
            indices.push_back(k);
        }
    }
    return indices;
}

/// Pictures of an earlier run that this one does not replace would be mistaken for its own.
void removeStalePictures(const fs::path& folder, std::size_t pictures)
{
    for (std::size_t rank = pictures + 1; fs::exists(folder / pictureName(rank)); ++rank)
    {
        fs::remove(folder / pictureName(rank));
    }
}

std::size_t writeOutputs(OutputFolder& output,
                         const grasp::GraspRun& run,
                         const grasp::HandModel& hand,
                         const grasp::GraspObject& object,
                         const std::vector<Grasp>& grasps,
                         int pictures)
{
    const fs::path records = output.stage("grasps.jsonl");
    std::ofstream out(records);
    grasp::writeGrasps(out, run, hand, object, grasps);
    out.close();
    if (!out)
    {
        throw std::runtime_error(
            fmt::format("{}: cannot be written: is the disk full?", records.string()));
    }
    std::vector<fs::path> files;
    for (const std::size_t index : worthDrawing(grasps, pictures))
    {
        files.push_back(output.stage(pictureName(index + 1)));
        grasp::drawGrasp(hand, object, grasps[index], {}, files.back());
    }
    grasp::writeReport(run, hand, object, grasps, files, output.stage("report.html"));
    output.commit();
    removeStalePictures(output.folder(), files.size());
    return files.size();
}

std::string bestGrasps(const std::vector<Grasp>& grasps, std::size_t rows)
{
    TextTable table{.header = {"rank",
                               "candidate",
                               "epsilon",
                               "volume",
                               "contacts",
                               "links",
                               "preshape",
                               "back off [mm]"},
                    .rows = {}};
    for (std::size_t k = 0; k < std::min(rows, grasps.size()); ++k)
    {
        const Grasp& g = grasps[k];
        if (g.reject != RejectReason::None)
        {
            break;
        }
        const double along = (g.X_WH.translation() - g.X_WStart.translation()).dot(g.approach_W);
        table.rows.push_back(
            {fmt::format("{}", k + 1),
             fmt::format("{}", g.candidate),
             fmt::format("{:.4f}", g.quality.epsilon),
             g.quality.volume > 0.0 ? fmt::format("{:.3g}", g.quality.volume) : "-",
             fmt::format("{}", g.contacts.size()),
             fmt::format("{}", linksInContact(g)),
             g.preshape,
             fmt::format("{:.1f}", 1e3 * std::max(0.0, g.approachDistance - along))});
    }
    return alignedText(table);
}

void printSummary(const PlanArguments& arguments, const PlanRun& run, std::size_t pictures)
{
    constexpr std::size_t kRows = 10;
    const std::size_t found = forceClosures(run.grasps);
    fmt::print("{} x {}: {} of {} candidates are force closures (mu {:g}, epsilon >= {:g})\n",
               run.hand.hand.robot.name,
               run.object.object.name,
               found,
               run.grasps.size(),
               arguments.options.friction,
               arguments.options.forceClosureThreshold);
    if (found > 0)
    {
        fmt::print("\n{}", bestGrasps(run.grasps, kRows));
        if (found > kRows)
        {
            fmt::print("({} more in the files)\n", found - kRows);
        }
    }
    fmt::print("\n");
    if (const std::string rejected = rejectionCounts(run.grasps); !rejected.empty())
    {
        fmt::print("rejected: {}\n", rejected);
    }
    const fs::path folder = arguments.output;
    fmt::print("planned in {:.1f} s\nwritten:  {}\n          {}\n",
               run.seconds,
               (folder / "grasps.jsonl").string(),
               (folder / "report.html").string());
    if (pictures > 0)
    {
        fmt::print("          {}{}\n",
                   (folder / pictureName(1)).string(),
                   pictures > 1 ? " .. " + pictureName(pictures) : "");
    }
}

int plan(const PlanArguments& arguments)
{
    LoadedHand hand = loadNamedHand(
        arguments.hand,
        arguments.srdf.empty() ? std::nullopt : std::optional<fs::path>(arguments.srdf));
    LoadedObject object = loadNamedObject(arguments.object, arguments.objectScale);
    const std::vector<Obstacle> obstacles = loadObstacles(arguments.scene);
    if (!obstacles.empty() && arguments.options.engine == grasp::ClosingEngine::Simulated)
    {
        throw std::runtime_error(
            "--scene: the simulated engine closes on the object alone: use --engine kinematic");
    }
    OutputFolder output(arguments.output);
    const PlanRun run = runPlan(std::move(hand),
                                std::move(object),
                                arguments.options,
                                arguments.quiet,
                                bodiesOf(obstacles));
    const grasp::GraspRun description{.handFile = run.hand.file,
                                      .srdfFile = run.hand.hand.srdfFile,
                                      .objectFile = run.object.file,
                                      .objectScale = arguments.objectScale,
                                      .options = arguments.options};
    const std::size_t pictures = writeOutputs(
        output, description, run.hand.hand, run.object.object, run.grasps, arguments.pictures);
    printSummary(arguments, run, pictures);
    return forceClosures(run.grasps) > 0 ? kFound : kNothingFound;
}
}  // namespace

void addPlanCommand(CLI::App& app, int& exitCode)
{
    auto* command = app.add_subcommand("plan", "plan and rank grasps of one object by one hand");
    const auto arguments = std::make_shared<PlanArguments>();
    command->add_option("--hand", arguments->hand, "URDF file or name of a shipped hand")
        ->type_name("HAND")
        ->required()
        ->group("Input");
    command->add_option("--object", arguments->object, "mesh file or name of a shipped object")
        ->type_name("OBJECT")
        ->required()
        ->group("Input");
    command
        ->add_option("--srdf",
                     arguments->srdf,
                     "fingers and preshapes; default: the one beside the URDF,\n"
                     "else a shipped one for the robot's name, else inferred")
        ->type_name("FILE")
        ->group("Input");
    command->add_option("--object-scale", arguments->objectScale, "object units in metres")
        ->type_name("S")
        ->check(within(1e-9, 1e9))
        ->capture_default_str()
        ->group("Input");
    command
        ->add_option("--scene",
                     arguments->scene,
                     "obstacles in the object's frame: meshes, or scenes (CSV, YAML) of meshes\n"
                     "with poses; a grasp that touches one is rejected")
        ->type_name("FILE")
        ->group("Input");
    addPlannerOptions(*command, arguments->options);
    command
        ->add_option(
            "-o,--output", arguments->output, "folder; files in it are replaced at the end")
        ->type_name("FOLDER")
        ->capture_default_str()
        ->group("Output");
    command->add_option("--pictures", arguments->pictures, "draw the best K grasps")
        ->type_name("K")
        ->check(within(0, 99))
        ->capture_default_str()
        ->group("Output");
    command->add_flag("-q,--quiet", arguments->quiet, "no progress and no notes on stderr")
        ->group("Output");
    command->callback([arguments, &exitCode] { exitCode = plan(*arguments); });
}
}  // namespace bullet_ccd::tools
