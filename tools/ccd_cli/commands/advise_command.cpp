#include "bullet_ccd/reduce/accuracy_costs.h"
#include "tools/ccd_cli/commands/commands.h"
#include "tools/ccd_cli/files/mesh_pair.h"
#include "tools/support/command_line.h"
#include "tools/support/option_values.h"
#include "tools/support/progress_line.h"
#include "tools/support/stop_request.h"
#include "tools/support/text_file.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <array>
#include <cmath>
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
    std::string chart;
    double accuracy = 0.0;
    double microseconds = 0.0;
    double timeLimit = 50.0;
};

std::string tableOf(const std::vector<AccuracyCost>& rows)
{
    TextTable table{.header = {"accuracy",
                               "us warm",
                               "pairs",
                               "triangles seen",
                               "ms cold",
                               "built",
                               "models A",
                               "models B",
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
             fmt::format("{:.1f}", row.warmMicroseconds),
             fmt::format("{:.0f}", row.pairs),
             std::to_string(row.trianglesSeen),
             fmt::format("{:.2f}", row.coldMilliseconds),
             std::to_string(row.trianglesBuilt),
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

/// A quantity of every row, for a chart.
struct Line
{
    std::string name;
    double AccuracyCost::*value;
    std::string color;
};

/// A chart (SVG) of what the accuracies cost, each relative to what the full meshes cost, both axes
/// by powers of ten.
std::string chartOf(const std::vector<AccuracyCost>& rows)
{
    const std::array<Line, 4> lines{
        Line{"time of a warm query", &AccuracyCost::warmMicroseconds, "#1f6fb4"},
        Line{"pairs looked at", &AccuracyCost::pairs, "#2a9d5c"},
        Line{"time of a cold query", &AccuracyCost::coldMilliseconds, "#d1495b"},
        Line{"memory of smaller models", &AccuracyCost::bytes, "#8d6cab"}};
    constexpr double kLeft = 70.0;
    constexpr double kTop = 30.0;
    constexpr double kPerDecade = 110.0;
    constexpr double kHeight = 300.0;
    constexpr double kDecades = 3.0;  // of cost, from 1/100 to 10
    constexpr double kMost = 1.0;
    const auto across = [&](double accuracy)
    { return kLeft + kPerDecade * (6.0 + std::log10(accuracy)); };
    const auto down = [&](double share)
    {
        const double decades = kMost - std::clamp(std::log10(share), kMost - kDecades, kMost);
        return kTop + kHeight * decades / kDecades;
    };
    const double right = across(5e-3);
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" "
        "font-family=\"sans-serif\" font-size=\"12\">\n"
        "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        right + 200.0,
        kTop + kHeight + 60.0);
    const auto text = [&](double x, double y, const std::string& anchor, const std::string& words)
    {
        svg += fmt::format(
            "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor, words);
    };
    const auto rule = [&](double x1, double y1, double x2, double y2)
    {
        svg += fmt::format(
            "<path d=\"M{:.1f} {:.1f} L{:.1f} {:.1f}\" stroke=\"#cccccc\"/>\n", x1, y1, x2, y2);
    };
    for (const double share : {0.01, 0.1, 1.0, 10.0})
    {
        rule(kLeft, down(share), right, down(share));
        text(kLeft - 8.0, down(share) + 4.0, "end", fmt::format("{:g}", share));
    }
    for (const double accuracy : {1e-6, 1e-5, 1e-4, 1e-3})
    {
        rule(across(accuracy), kTop, across(accuracy), kTop + kHeight);
        text(across(accuracy), kTop + kHeight + 18.0, "middle", fmt::format("{:g}", accuracy));
    }
    text(0.5 * (kLeft + right), kTop + kHeight + 42.0, "middle", "accuracy [unit of the meshes]");
    text(kLeft, kTop - 10.0, "start", "cost, as a share of that of the full meshes");
    double label = kTop + 10.0;
    for (const Line& line : lines)
    {
        std::string points;
        for (std::size_t i = 1; i < rows.size(); ++i)
        {
            points += fmt::format("{:.1f},{:.1f} ",
                                  across(rows[i].accuracy),
                                  down(rows[i].*line.value / rows[0].*line.value));
        }
        svg += fmt::format(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n"
            "<path d=\"M{:.1f} {:.1f} h20\" stroke=\"{}\" stroke-width=\"2\"/>\n",
            points,
            line.color,
            right + 10.0,
            label - 4.0,
            line.color);
        text(right + 35.0, label, "start", line.name);
        label += 20.0;
    }
    return svg + "</svg>\n";
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
        if (arguments.microseconds > 0.0 && !best &&
            std::min(row.microseconds, row.warmMicroseconds) <= arguments.microseconds)
        {
            best = &row;
        }
    }
    return best;
}

std::string yamlOf(const AccuracyCost& row, const AdviseArguments& arguments)
{
    return fmt::format(
        "# Queries of the meshes with this accuracy: bullet-ccd toi A B --accuracy {0}\n"
        "mesh_a: {4}\n"
        "mesh_b: {5}\n"
        "accuracy: {0}\n"
        "# Or, for other programs: bullet-ccd reduce A --kind mesh --accuracy {1}, likewise B;\n"
        "# then queries of the models with this minimum separation and tolerance.\n"
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
    if (!arguments.chart.empty())
    {
        requireOtherFile(arguments.chart, {arguments.fileA, arguments.fileB, arguments.output});
        requireWritable(arguments.chart);
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
    if (!arguments.chart.empty())
    {
        writeWholeFile(arguments.chart, chartOf(rows));
    }
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
        "most b, and none is missed. The same 60 random motions are asked for every accuracy, in "
        "two ways. First with the full meshes and --accuracy b: the time of a query when all is "
        "built (median), the pairs that it looks at (mean), the triangles that all of them "
        "together look at, and the time of one query that begins with nothing built, with the "
        "triangles that are then built into hierarchies. Then with smaller models of b/5 each, a "
        "minimum separation of 2b/5 and a tolerance of b/5, for programs that know no accuracy: "
        "the triangles that are left, the memory of the hierarchies, the times for making the "
        "models, for building and for a query, the largest gap of the full meshes at a contact, "
        "and how many contacts broke the promise, which must be 0.\n"
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
    command
        ->add_option(
            "--chart", arguments->chart, "Where to draw time, pairs and memory over the accuracy.")
        ->type_name("SVG");
    addTimeLimitOption(*command, arguments->timeLimit, "Begin no further row");
    command->callback([arguments, &exitCode] { exitCode = runAdvise(*arguments); });
}
}  // namespace bullet_ccd::tools
