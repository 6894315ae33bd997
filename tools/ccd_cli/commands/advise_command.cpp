#include "bullet_ccd/reduce/accuracy_costs.h"
#include "tools/ccd_cli/commands/commands.h"
#include "tools/ccd_cli/files/mesh_pair.h"
#include "tools/support/command_line.h"
#include "tools/support/option_values.h"
#include "tools/support/progress_line.h"
#include "tools/support/stop_request.h"
#include "tools/support/text_file.h"
#include "tools/support/text_table.h"

#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
struct AdviseArguments
{
    std::string fileA;
    std::string fileB;
    std::string output;
    double accuracy = 0.0;
    double microseconds = 0.0;
    double timeLimit = 50.0;
};

std::string tableOf(const std::vector<AccuracyCost>& rows)
{
    TextTable table{.header = {"accuracy",
                               "triangles A",
                               "triangles B",
                               "MB",
                               "ms reduce",
                               "ms build",
                               "us query",
                               "contacts",
                               "largest gap",
                               "broken"},
                    .rows = {}};
    for (const AccuracyCost& row : rows)
    {
        table.rows.push_back(
            {row.accuracy > 0.0 ? fmt::format("{:g}", row.accuracy) : "full meshes",
             std::to_string(row.trianglesA),
             std::to_string(row.trianglesB),
             fmt::format("{:.2f}", 1e-6 * row.bytes),
             fmt::format("{:.1f}", 1e3 * row.reduceSeconds),
             fmt::format("{:.2f}", 1e3 * row.buildSeconds),
             fmt::format("{:.1f}", row.microseconds),
             std::to_string(row.contacts),
             fmt::format("{:.3g}", row.largestGap),
             std::to_string(row.broken)});
    }
    return alignedText(table);
}

/// The cheapest row that keeps the accuracy, or the most accurate one within the time.
const AccuracyCost* chosen(const std::vector<AccuracyCost>& rows, const AdviseArguments& arguments)
{
    const AccuracyCost* best = nullptr;
    for (const AccuracyCost& row : rows)
    {
        if (row.accuracy == 0.0 || row.broken > 0)
        {
            continue;
        }
        if (arguments.accuracy > 0.0 && row.accuracy <= arguments.accuracy)
        {
            best = &row;  // the rows become coarser
        }
        if (arguments.microseconds > 0.0 && row.microseconds <= arguments.microseconds && !best)
        {
            best = &row;
        }
    }
    return best;
}

std::string yamlOf(const AccuracyCost& row, const AdviseArguments& arguments)
{
    return fmt::format(
        "# bullet-ccd reduce A --kind mesh --accuracy {1}, likewise B; then queries of\n"
        "# the models with this minimum separation and tolerance.\n"
        "mesh_a: {4}\n"
        "mesh_b: {5}\n"
        "accuracy: {0}\n"
        "model_accuracy: {1}\n"
        "minimum_separation: {2}\n"
        "tolerance: {3}\n"
        "triangles: [{6}, {7}]\n",
        row.accuracy,
        row.modelAccuracy,
        row.minimumSeparation,
        row.tolerance,
        arguments.fileA,
        arguments.fileB,
        row.trianglesA,
        row.trianglesB);
}

int runAdvise(AdviseArguments arguments)
{
    if (arguments.fileB.empty())
    {
        arguments.fileB = arguments.fileA;
    }
    if (!arguments.output.empty())
    {
        requireOtherFile(arguments.output, {arguments.fileA, arguments.fileB});
        requireWritable(arguments.output);
        if (arguments.accuracy == 0.0 && arguments.microseconds == 0.0)
        {
            throw CLI::ValidationError("--output", "needs --accuracy or --microseconds");
        }
    }
    const MeshPair meshes = loadMeshPair(arguments.fileA, arguments.fileB);
    const StopRequest stop(arguments.timeLimit);
    std::vector<AccuracyCost> rows;
    std::size_t total = 0;
    {
        ProgressLine progress(8, "accuracies");
        rows = measureAccuracies(*meshes.treeA,
                                 *meshes.treeB,
                                 [&](std::size_t done, std::size_t all)
                                 {
                                     total = all;
                                     progress.show(done);
                                     return !stop.isDue();
                                 });
    }
    fmt::print("{}", tableOf(rows));
    int exitCode = kDone;
    if (arguments.accuracy > 0.0 || arguments.microseconds > 0.0)
    {
        if (const AccuracyCost* row = chosen(rows, arguments))
        {
            const std::string yaml = yamlOf(*row, arguments);
            fmt::print("\n{}", yaml);
            if (!arguments.output.empty())
            {
                writeWholeFile(arguments.output, yaml);
            }
        }
        else
        {
            fmt::print(stderr,
                       "bullet-ccd advise: none of these accuracies does: allow more, or take the "
                       "full meshes\n");
            exitCode = kNothingFound;
        }
    }
    return stop.isDue() ? stop.finish("bullet-ccd advise", rows.size(), total, "rows", exitCode)
                        : exitCode;
}
}  // namespace

void addAdviseCommand(CLI::App& app, int& exitCode)
{
    CLI::App* command = app.add_subcommand(
        "advise",
        "Measures on two bodies what an accuracy costs, and says which settings keep it.");
    command->footer(
        "With an accuracy b, every reported contact has a gap of the full meshes above 0 and at "
        "most b, and none is missed: meshes are reduced to b/5 each, and queries keep a minimum "
        "separation of 2b/5 with a tolerance of b/5. The same 60 random motions are asked for "
        "every "
        "accuracy, with models and full meshes. The table has the triangles that are left, the "
        "memory of the hierarchies, the times for making the models, for building and for a query "
        "(median), the largest gap of the full meshes at a contact, and how many contacts broke "
        "the "
        "promise, which must be 0.\n"
        "\n"
        "Exit codes: 0 if everything was measured, 1 if no accuracy does what was asked, 2 for "
        "wrong options, 3 for bad input, 130 after Ctrl-C, which keeps the rows that were done.\n"
        "\n"
        "Example:\n"
        "  bullet-ccd advise mug.obj shelf.obj --accuracy 1e-3 -o advice.yaml");
    const auto arguments = std::make_shared<AdviseArguments>();
    command->add_option("A", arguments->fileA, "The mesh of body A.")
        ->type_name("MESH")
        ->required();
    command->add_option("B", arguments->fileB, "The mesh of body B; without it, A again.")
        ->type_name("MESH");
    CLI::Option* accuracy =
        command
            ->add_option("--accuracy",
                         arguments->accuracy,
                         "Choose the cheapest settings that keep it [unit of the meshes].")
            ->type_name("LENGTH")
            ->check(within(1e-300, 1e300));
    command
        ->add_option("--microseconds",
                     arguments->microseconds,
                     "Choose the most accurate settings whose median query takes no longer.")
        ->type_name("T")
        ->check(within(1e-300, 1e300))
        ->excludes(accuracy);
    command->add_option("-o,--output", arguments->output, "Where to write the chosen settings.")
        ->type_name("YAML");
    addTimeLimitOption(*command, arguments->timeLimit, "Begin no further row");
    command->callback([arguments, &exitCode] { exitCode = runAdvise(*arguments); });
}
}  // namespace bullet_ccd::tools
