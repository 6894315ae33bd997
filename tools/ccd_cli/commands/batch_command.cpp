#include "tools/ccd_cli/commands/commands.h"
#include "tools/ccd_cli/files/mesh_pair.h"
#include "tools/ccd_cli/files/query_file.h"
#include "tools/ccd_cli/run/query_run.h"
#include "tools/ccd_cli/text/batch_summary.h"
#include "tools/ccd_cli/text/result_text.h"
#include "tools/support/command_line.h"
#include "tools/support/option_values.h"
#include "tools/support/progress_line.h"
#include "tools/support/stop_request.h"
#include "tools/support/stopwatch.h"
#include "tools/support/text_file.h"

#include <array>
#include <atomic>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
struct BatchArguments
{
    std::string fileA;
    std::string fileB;
    std::string queries;
    std::string output;
    RunOptions run;
    bool summary = false;
    bool strict = false;
    double timeLimit = 0.0;
};

QueryFile readQueries(const BatchArguments& arguments)
{
    QueryFile file = readQueryFile(arguments.queries);
    for (const BadRow& row : file.badRows)
    {
        fmt::print(stderr, "bullet-ccd: {}\n", row.message);
    }
    if (arguments.strict && !file.badRows.empty())
    {
        throw std::runtime_error(
            fmt::format("{}: {} bad row{}, nothing was computed: repair them or leave out --strict",
                        arguments.queries,
                        file.badRows.size(),
                        file.badRows.size() == 1 ? "" : "s"));
    }
    return file;
}

/// Rows of answers and bad rows in the order of the file; queries without an answer have none.
std::string tableOf(const QueryFile& file, const std::vector<TimedAnswer>& answers, bool warm)
{
    std::string text = resultHeader(warm) + "\n";
    std::size_t bad = 0;
    for (std::size_t k = 0; k <= file.queries.size(); ++k)
    {
        const bool atEnd = k == file.queries.size();
        while (bad < file.badRows.size() &&
               (atEnd || file.badRows[bad].line < file.queries[k].line))
        {
            text += badResultRow(file.badRows[bad++].id, warm) + "\n";
        }
        if (!atEnd && answers[k].isThere)
        {
            text += resultRow(file.queries[k].id, answers[k], warm) + "\n";
        }
    }
    return text;
}

/// Nothing without an accuracy.
std::optional<ModelShare> neededOf(const std::vector<ModelUse>& uses, const MeshPair& meshes)
{
    return uses.empty() ? std::nullopt
                        : std::optional<ModelShare>(
                              {uses, std::array{meshes.treeA.get(), meshes.treeB.get()}});
}

int runBatch(const BatchArguments& arguments)
{
    requireOtherFile(arguments.output, {arguments.fileA, arguments.fileB, arguments.queries});
    const QueryFile file = readQueries(arguments);
    requireWritable(arguments.output);
    const MeshPair meshes = loadMeshPair(arguments.fileA, arguments.fileB);
    checkAccuracy(arguments.run.toi, meshes.treeA->mesh());
    checkAccuracy(arguments.run.toi, meshes.treeB->mesh());
    const Stopwatch watch;
    const StopRequest stop(arguments.timeLimit);
    const std::size_t total = file.queries.size() * static_cast<std::size_t>(arguments.run.repeat);
    std::atomic<std::size_t> count = 0;
    std::vector<TimedAnswer> answers;
    RunOptions options = arguments.run;
    options.toi.stop = stop.condition();
    std::vector<ModelUse> uses;
    if (options.toi.anyWithin && arguments.summary)
    {
        options.uses = &uses;
    }
    {
        ProgressLine progress(total, "queries");
        answers = runQueries(*meshes.treeA,
                             *meshes.treeB,
                             file.queries,
                             options,
                             [&](std::size_t done)
                             {
                                 ++count;
                                 progress.show(done);
                                 return !stop.isDue();
                             });
    }
    const double wall = watch.seconds();
    writeWholeFile(arguments.output, tableOf(file, answers, arguments.run.warm));
    if (arguments.summary)
    {
        std::erase_if(answers, [](const TimedAnswer& answer) { return !answer.isThere; });
        fmt::print("{}",
                   summaryText({.answers = answers,
                                .badRows = file.badRows.size(),
                                .warm = arguments.run.warm,
                                .loadSeconds = meshes.loadSeconds,
                                .buildSeconds = meshes.buildSeconds,
                                .wallSeconds = wall,
                                .needed = neededOf(uses, meshes)}));
    }
    return stop.finish("bullet-ccd batch", count, total, "queries", kDone);
}

constexpr const char* kBatchFooter =
    "The first line of QUERIES names the columns, in any order, of one of two forms:\n"
    "  poses   id, and qw qx qy qz tx ty tz behind each of a0_ a1_ b0_ b1_: the poses\n"
    "          of A and B at t = 0 and t = 1. Origins move on straight lines, and\n"
    "          bodies turn along the shortest arc.\n"
    "  twists  id, the same behind a0_ b0_, and vx vy vz wx wy wz behind each of\n"
    "          a_ b_: the velocity of the origin and the angular velocity, in world\n"
    "          axes, per interval, in the unit of the meshes and in rad.\n"
    "\n"
    "RESULTS has one row per query, with the columns id, status, toi, gap, px, py, pz, nx, ny, nz, "
    "iterations, microseconds. The status is separated, hit, overlapping, touching_leaving, "
    "touching_pressing, iteration_limit, stopped or bad_row. With a contact, toi is its time, p is "
    "the "
    "middle "
    "of the closest points in the world, and n is the normal from A to B. Without one, toi is 1, p "
    "and n are empty, and gap is a lower bound of the distance. RESULTS appears at the end, or not "
    "at "
    "all. After Ctrl-C, or at the time limit, it has the rows of the queries that were answered "
    "and of those that were stopped in the middle, which are free until their toi. The last line "
    "on stderr says how many were answered.\n"
    "\n"
    "microseconds is the time of one query alone; nothing of an earlier query is used. Measure "
    "with "
    "--jobs 1.\n"
    "\n"
    "A row that is no query is reported on stderr with its line and column. It becomes a row "
    "bad_row, and the others are answered.\n"
    "\n"
    "Exit codes: 0 if RESULTS was written, 130 likewise after Ctrl-C, 2 for wrong options, 3 for "
    "bad input, with --strict for "
    "a bad row, too.\n"
    "\n"
    "Example:\n"
    "  bullet-ccd batch bunny.ply bunny.ply queries.csv -o results.csv --summary";

void addRunOptions(CLI::App& command, RunOptions& run)
{
    command
        .add_option(
            "-j,--jobs",
            run.jobs,
            "The number of threads; 0 takes one per core. It changes nothing but the times.")
        ->type_name("N")
        ->check(within(0, 1024))
        ->capture_default_str();
    command
        .add_option("--repeat",
                    run.repeat,
                    "How often to pass over all queries. The time of a query is its median.")
        ->type_name("K")
        ->check(within(1, 10'000))
        ->capture_default_str();
    command.add_flag("--warm",
                     run.warm,
                     "Ask every query again at once, and write that time to the column "
                     "warm_microseconds. The library keeps no answers, so only the caches of the "
                     "processor are warm.");
}
}  // namespace

void addBatchCommand(CLI::App& app, int& exitCode)
{
    CLI::App* command =
        app.add_subcommand("batch", "Answers a CSV file of queries about the same two bodies.");
    command->footer(kBatchFooter);
    const auto arguments = std::make_shared<BatchArguments>();
    addMeshes(*command, arguments->fileA, arguments->fileB);
    command->add_option("QUERIES", arguments->queries, "The motions, one query per row.")
        ->type_name("CSV")
        ->required();
    command
        ->add_option("-o,--output",
                     arguments->output,
                     "Where to write RESULTS, one row for each row of QUERIES.")
        ->type_name("CSV")
        ->required();
    addToiOptions(*command, arguments->run.toi);
    addRunOptions(*command, arguments->run);
    command->add_flag("--summary",
                      arguments->summary,
                      "Print counts and times when everything is done, and, with --accuracy, how "
                      "much of the meshes the "
                      "queries needed.");
    command->add_flag("--strict", arguments->strict, "Compute nothing if a row is bad.");
    addTimeLimitOption(*command, arguments->timeLimit, "Stop the queries");
    command->callback([arguments, &exitCode] { exitCode = runBatch(*arguments); });
}
}  // namespace bullet_ccd::tools
