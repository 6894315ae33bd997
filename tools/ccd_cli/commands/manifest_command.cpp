#include "tools/ccd_cli/commands/commands.h"
#include "tools/support/command_line.h"
#include "tools/support/obstacles/scene_manifest.h"
#include "tools/support/progress_line.h"
#include "tools/support/text_file.h"

#include <fmt/format.h>
#include <memory>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

struct ManifestArguments
{
    std::string scene;
    std::string output;
};

int writeManifest(const ManifestArguments& arguments)
{
    if (!isScene(arguments.scene))
    {
        throw std::runtime_error(arguments.scene +
                                 ": not a scene: name a .csv, .yaml or .yml file of obstacles");
    }
    requireOtherFile(arguments.output, {arguments.scene});
    requireWritable(arguments.output);
    std::optional<ProgressLine> progress;
    const std::string text = manifestText(arguments.scene,
                                          fs::path(arguments.output).parent_path(),
                                          [&](std::size_t done, std::size_t all)
                                          {
                                              if (!progress)
                                              {
                                                  progress.emplace(all, "obstacles");
                                              }
                                              progress->show(done);
                                          });
    progress.reset();
    writeWholeFile(arguments.output, text);
    return kDone;
}
}  // namespace

void addManifestCommand(CLI::App& app, int& exitCode)
{
    CLI::App* command = app.add_subcommand(
        "manifest", "Notes the boxes of a scene's meshes, so that only those in reach are loaded.");
    command->footer(
        "The manifest is a scene in CSV, with the box and the number of triangles of every mesh, "
        "the size of its file and a hash. Give it wherever a scene is taken: 'bullet-ccd "
        "articulated' and 'grasp close' load only the meshes whose boxes the motion meets; other "
        "verbs load all. A mesh that has changed since is refused: a loaded one by its hash, the "
        "others by size and, where they are newer than the manifest, by their hash. Make the "
        "manifest again then.\n"
        "\n"
        "Exit codes: 0 if the manifest was written, 2 for wrong options, 3 for bad input.\n"
        "\n"
        "Example:\n"
        "  bullet-ccd manifest shelf.yaml -o shelf.csv\n"
        "  bullet-ccd articulated arm.urdf --from start.csv --to goal.csv --obstacles shelf.csv");
    const auto arguments = std::make_shared<ManifestArguments>();
    command->add_option("SCENE", arguments->scene, "The scene: CSV or YAML.")
        ->type_name("SCENE")
        ->required();
    command->add_option("-o,--output", arguments->output, "Where to write the manifest.")
        ->type_name("CSV")
        ->required()
        ->check(
            [](const std::string& file)
            {
                return fs::path(file).extension() == ".csv"
                           ? std::string()
                           : file + ": the manifest is a scene in CSV: end its name in .csv";
            });
    command->callback([arguments, &exitCode] { exitCode = writeManifest(*arguments); });
}
}  // namespace bullet_ccd::tools
