#include "tools/grasp_cli/plan/plan_outputs.h"

#include "grasp/formats/isaac_grasp_file.h"
#include "grasp/report/grasp_model.h"
#include "grasp/report/grasp_picture.h"
#include "grasp/report/viewer_page.h"
#include "tools/grasp_cli/inputs/catalogue.h"
#include "tools/support/obstacles/needed_picture.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using grasp::Grasp;
using grasp::RejectReason;

constexpr const char* kRecords = "grasps.jsonl";
constexpr const char* kIsaac = "grasps.isaac.yaml";
constexpr const char* kReport = "report.html";
constexpr const char* kNeeded = "needed.json";
constexpr const char* kNeededPicture = "needed.ply";
constexpr const char* kPicture = "png";
constexpr const char* kModel = "glb";

std::string drawingName(std::size_t rank, const char* extension)
{
    return fmt::format("grasp_{:02}.{}", rank, extension);
}

/// The first `count` grasps that have a final posture; these rank before all others.
std::size_t worthDrawing(const std::vector<Grasp>& grasps, int count)
{
    std::size_t found = 0;
    while (found < grasps.size() && found < static_cast<std::size_t>(count) &&
           (grasps[found].reject == RejectReason::None ||
            grasps[found].reject == RejectReason::NoForceClosure))
    {
        ++found;
    }
    return found;
}

/// Drawings of an earlier run that this one does not replace would be mistaken for its own.
void removeStale(const fs::path& folder, std::size_t drawn, const char* extension)
{
    for (std::size_t rank = drawn + 1; fs::exists(folder / drawingName(rank, extension)); ++rank)
    {
        fs::remove(folder / drawingName(rank, extension));
    }
}

/// Stages a file and fills it by `write`.
void stageText(OutputFolder& output,
               const std::string& name,
               const std::function<void(std::ostream&)>& write)
{
    const fs::path file = output.stage(name);
    std::ofstream out(file);
    write(out);
    out.close();
    if (!out)
    {
        throw std::runtime_error(
            fmt::format("{}: cannot be written: is the disk full?", file.string()));
    }
}

void addRange(std::vector<std::string>& lines,
              const fs::path& folder,
              std::size_t drawn,
              const char* extension)
{
    if (drawn > 0)
    {
        lines.push_back((folder / drawingName(1, extension)).string() +
                        (drawn > 1 ? " .. " + drawingName(drawn, extension) : ""));
    }
}

/// As one word of a shell.
std::string shellWord(const std::string& text)
{
    constexpr const char* kPlain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+:,@%";
    if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos)
    {
        return text;
    }
    std::string quoted = "'";
    for (const char letter : text)
    {
        quoted += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
    }
    return quoted + "'";
}

/// Closes the hand as the run did, once a pose and a preshape follow.
std::string closeCommand(const grasp::GraspRun& run, const std::vector<std::string>& scene)
{
    const grasp::PlannerOptions defaults;
    const grasp::PlannerOptions& options = run.options;
    std::string command = "grasp close --hand " + shellWord(run.handFile.string());
    const auto add = [&command](const char* name, const std::string& value)
    { command += fmt::format(" {} {}", name, shellWord(value)); };
    if (!run.srdfFile.empty())
    {
        add("--srdf", run.srdfFile.string());
    }
    add("--object", run.objectFile.string());
    if (run.objectScale != 1.0)
    {
        add("--object-scale", fmt::format("{}", run.objectScale));
    }
    for (const std::string& file : scene)
    {
        add("--scene", file);
    }
    if (options.engine != defaults.engine)
    {
        add("--engine", toString(options.engine));
    }
    if (options.closing.tolerance != defaults.closing.tolerance)
    {
        add("--accuracy", fmt::format("{}", options.closing.tolerance));
    }
    if (options.closing.order != defaults.closing.order)
    {
        const std::vector<std::string>& first = options.closing.firstFingers;
        add("--fingers", first.empty() ? toString(options.closing.order) : joined(first, ","));
    }
    for (const auto& [joint, ratio] : options.closing.speeds)
    {
        add("--closing-speeds", fmt::format("{}={}", joint, ratio));
    }
    if (options.friction != defaults.friction)
    {
        add("--friction", fmt::format("{}", options.friction));
    }
    if (options.coneEdges != defaults.coneEdges)
    {
        add("--cone-edges", fmt::format("{}", options.coneEdges));
    }
    if (options.forceClosureThreshold != defaults.forceClosureThreshold)
    {
        add("--min-epsilon", fmt::format("{}", options.forceClosureThreshold));
    }
    if (options.mass)
    {
        add("--mass", fmt::format("{}", *options.mass));
    }
    return command;
}

/// Stages the page in three dimensions if the viewer was built, else the page of pictures.
void stageReport(OutputFolder& output,
                 const grasp::GraspRun& run,
                 const grasp::HandModel& hand,
                 const grasp::GraspObject& object,
                 const std::vector<Grasp>& grasps,
                 const std::vector<fs::path>& pictures,
                 std::size_t models,
                 std::span<const RigidBody> obstacles,
                 const std::vector<std::string>& scene)
{
    const fs::path viewer = viewerFile();
    if (viewer.empty())
    {
        grasp::writeReport(run, hand, object, grasps, pictures, output.stage(kReport));
        return;
    }
    grasp::PageExtras extras{.obstacles = obstacles,
                             .command = closeCommand(run, scene),
                             .files = {kRecords, kIsaac},
                             .graspFiles = {}};
    extras.graspFiles.resize(std::max(pictures.size(), models));
    for (std::size_t k = 0; k < extras.graspFiles.size(); ++k)
    {
        if (k < pictures.size())
        {
            extras.graspFiles[k].push_back(drawingName(k + 1, kPicture));
        }
        if (k < models)
        {
            extras.graspFiles[k].push_back(drawingName(k + 1, kModel));
        }
    }
    writeViewerPage(run, hand, object, grasps, extras, viewer, output.stage(kReport));
}
/// What the closings needed, as JSON and drawn with the hand as the best grasp has it.
void stageNeeded(OutputFolder& output,
                 const grasp::GraspRun& run,
                 const grasp::HandModel& hand,
                 const grasp::GraspObject& object,
                 const std::vector<Grasp>& grasps,
                 const DrawingOptions& drawing)
{
    stageText(
        output,
        kNeeded,
        [&](std::ostream& out)
        {
            out << closingReport(
                *drawing.uses, run.options.closing.tolerance, hand, object, *drawing.obstacles);
        });
    std::vector<DrawnBody> bodies{{.tree = &object.tree}};
    if (!grasps.empty() && !grasps.front().positions.empty())
    {
        const std::vector<Eigen::Isometry3d> poses =
            linkPoses(hand.robot.tree, grasps.front().X_WH, grasps.front().positions);
        for (std::size_t link = 0; link < poses.size(); ++link)
        {
            bodies.push_back({.tree = hand.linkTrees[link], .X_WB = poses[link]});
        }
    }
    for (const Obstacle& obstacle : drawing.obstacles->inReach)
    {
        bodies.push_back({.tree = obstacle.tree.get(), .X_WB = obstacle.X_WO});
    }
    const std::vector<ModelUse> uses(drawing.uses->begin(), drawing.uses->end());
    writeNeededPicture(output.stage(kNeededPicture), uses, bodies);
}
}  // namespace

std::vector<std::string> writePlanOutputs(OutputFolder& output,
                                          const grasp::GraspRun& run,
                                          const grasp::HandModel& hand,
                                          const grasp::GraspObject& object,
                                          const std::vector<Grasp>& grasps,
                                          const DrawingOptions& drawing,
                                          std::span<const RigidBody> obstacles)
{
    stageText(output,
              kRecords,
              [&](std::ostream& out) { grasp::writeGrasps(out, run, hand, object, grasps); });
    stageText(output,
              kIsaac,
              [&](std::ostream& out) { grasp::writeIsaacGrasps(out, run, hand, object, grasps); });
    std::vector<fs::path> pictures;
    for (std::size_t k = 0; k < worthDrawing(grasps, drawing.pictures); ++k)
    {
        pictures.push_back(output.stage(drawingName(k + 1, kPicture)));
        grasp::drawGrasp(hand,
                         object,
                         grasps[k],
                         {.sweptBoxes = drawing.sweptBoxes, .obstacles = obstacles},
                         pictures.back());
    }
    const std::size_t models = worthDrawing(grasps, drawing.models.value_or(drawing.pictures));
    for (std::size_t k = 0; k < models; ++k)
    {
        grasp::writeGraspModel(hand,
                               object,
                               grasps[k],
                               run.options.friction,
                               output.stage(drawingName(k + 1, kModel)),
                               obstacles);
    }
    stageReport(output, run, hand, object, grasps, pictures, models, obstacles, drawing.scene);
    const bool saysNeeded = drawing.uses != nullptr && !drawing.uses->empty();
    if (saysNeeded)
    {
        stageNeeded(output, run, hand, object, grasps, drawing);
    }
    output.commit();
    const fs::path& folder = output.folder();
    removeStale(folder, pictures.size(), kPicture);
    removeStale(folder, models, kModel);

    std::vector<std::string> lines;
    for (const char* name : {kRecords, kIsaac, kReport})
    {
        lines.push_back((folder / name).string());
    }
    for (const char* name : {kNeeded, kNeededPicture})
    {
        saysNeeded ? lines.push_back((folder / name).string())
                   : static_cast<void>(fs::remove(folder / name));
    }
    addRange(lines, folder, pictures.size(), kPicture);
    addRange(lines, folder, models, kModel);
    return lines;
}
}  // namespace bullet_ccd::tools
