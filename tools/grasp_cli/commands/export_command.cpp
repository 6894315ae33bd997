#include "bullet_ccd/math/replace_file.h"
#include "tools/grasp_cli/answers/mjcf_pieces.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/options/input_options.h"
#include "tools/grasp_cli/options/mass_option.h"
#include "tools/grasp_cli/options/squeeze_options.h"

#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

struct ExportArguments
{
    RecordArguments records;
    RecordChoice choice;
    std::string folder;
    SqueezeArguments squeeze;
    std::optional<double> mass;      ///< else that of the plan
    std::optional<double> friction;  ///< same
    grasp::MjcfOptions mjcf;
    ConvexPiecesOptions pieces;
};

int exportGrasps(const ExportArguments& arguments)
{
    const GraspRecords records = loadGraspRecords(arguments.records);
    const grasp::HandModel& hand = records.hand.hand;
    const grasp::GraspObject& object = records.object.object;
    grasp::MjcfOptions options = arguments.mjcf;
    options.mass = massOf(records, arguments.mass).mass;
    options.friction = arguments.friction.value_or(records.source.run.options.friction);
    SqueezeArguments squeezing = arguments.squeeze;
    squeezing.mass = options.mass;
    grasp::SqueezeOptions squeeze = squeezeOptionsOf(squeezing, options.friction, hand);
    squeeze.centerOfMass = object.centerOfMass;
    const std::vector<std::size_t> chosen =
        chosenGrasps(records, arguments.records, arguments.choice);

    const grasp::MjcfPieces pieces = piecesOf(hand, object, arguments.pieces);
    const fs::path folder = arguments.folder;
    grasp::writeMjcfMeshes(folder / "meshes", pieces);
    for (const std::size_t index : chosen)
    {
        const grasp::Grasp& grasp = records.grasps[index];
        const grasp::Squeeze found = grasp::squeezeOf(hand, grasp, squeeze);
        const fs::path file = folder / fmt::format("grasp_{:02}.xml", records.ranks[index]);
        std::ostringstream model;
        grasp::writeMjcf(model, hand, object, grasp, found, pieces, options);
        if (const std::error_code error = replaceFile(file, {model.str()}))
        {
            throw std::runtime_error(file.string() + ": " + error.message() +
                                     ": give a folder that can be written, with --output");
        }
        fmt::print(
            "{}{}\n", file.string(), found.exists() ? "" : ": without a squeeze: " + found.reason);
    }
    double bulge = 0.0;
    std::size_t count = 0;
    for (const ConvexPieces& link : pieces.links)
    {
        bulge = std::max(bulge, link.bulge);
        count += link.pieces.size();
    }
    fmt::print(
        "{} convex pieces of the hand bulge by up to {:.2f} mm (hollows inside of links, which "
        "they "
        "fill, count), {} of the object by {:.2f} mm\n",
        count,
        1e3 * bulge,
        pieces.object.pieces.size(),
        1e3 * pieces.object.bulge);
    return records.exitCode(chosen.empty() ? kNothingFound : kDone);
}
}  // namespace

void addExportCommand(CLI::App& app, int& exitCode)
{
    auto* command = app.add_subcommand(
        "export", "Writes planned grasps as models for MuJoCo (MJCF), with hand and object.");
    command->footer(
        "Each grasp becomes a file grasp_NN.xml, by its rank; all share the folder meshes. The "
        "world is the mesh frame of the object, which is free, and there is no gravity. The "
        "keyframe 'squeeze' has the closed posture and the targets by which the controllers press; "
        "'grasp' has the posture alone. MuJoCo takes the convex hull of every mesh, so hand and "
        "object are cut into convex pieces; they bulge by what the program prints.\n"
        "\n"
        "Exit codes: 0 if a grasp was written, 1 if there is none, 2 for wrong options, 3 for bad "
        "input.\n"
        "\n"
        "Example:\n"
        "  grasp export out/grasps.jsonl --rank 1 --mass 0.25 -o mjcf");
    const auto arguments = std::make_shared<ExportArguments>();
    addRecordOptions(*command, arguments->records);
    addChoiceOptions(*command, arguments->choice);
    command->add_option("-o,--output", arguments->folder, "The folder to write to.")
        ->type_name("FOLDER")
        ->required()
        ->group("Output");
    addRecordSqueezeOptions(*command, arguments->mass, arguments->friction, arguments->squeeze);
    command
        ->add_option("--torsion",
                     arguments->mjcf.torsion,
                     "The largest torsional moment of a contact over its normal force [m].")
        ->type_name("M")
        ->check(within(0.0, 1.0))
        ->capture_default_str()
        ->group("Model");
    command->add_option("--time-step", arguments->mjcf.timeStep, "Of the model [s].")
        ->type_name("S")
        ->check(within(1e-6, 0.1))
        ->capture_default_str()
        ->group("Model");
    command
        ->add_option("--accuracy",
                     arguments->pieces.accuracy,
                     "Cut until pieces bulge by no more than this [m].")
        ->type_name("M")
        ->check(within(1e-6, 1.0))
        ->capture_default_str()
        ->group("Model");
    command
        ->add_option("--pieces",
                     arguments->pieces.most,
                     "So many pieces of the object at the most; of each link a quarter of it.")
        ->type_name("N")
        ->check(within(1, 10000))
        ->capture_default_str()
        ->group("Model");
    command->callback([arguments, &exitCode] { exitCode = exportGrasps(*arguments); });
}
}  // namespace bullet_ccd::tools
