#include "tools/ccd_cli/text/batch_summary.h"
#include "tools/ccd_cli/commands/commands.h"
#include "tools/ccd_cli/files/mesh_pair.h"
#include "tools/support/progress_line.h"
#include "tools/support/stopwatch.h"
#include "tools/ccd_cli/files/query_file.h"
#include "tools/ccd_cli/run/query_run.h"
#include "tools/ccd_cli/text/result_text.h"
#include "tools/support/option_values.h"
#include "tools/support/text_file.h"

#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <stdexcept>

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

/// Rows of answers and bad rows in the order of the file.
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
        if (!atEnd)
        {
            text += resultRow(file.queries[k].id, answers[k], warm) + "\n";
        }
    }
    return text;
}

void runBatch(const BatchArguments& arguments)
{
    requireOtherFile(arguments.output, {arguments.fileA, arguments.fileB, arguments.queries});
    const QueryFile file = readQueries(arguments);
    requireWritable(arguments.output);
    const MeshPair meshes = loadMeshPair(arguments.fileA, arguments.fileB);
    const Stopwatch watch;
    std::vector<TimedAnswer> answers;
    {
        ProgressLine progress(file.queries.size() * static_cast<std::size_t>(arguments.run.repeat),
                              "queries");
        answers = runQueries(*meshes.treeA,
                             *meshes.treeB,
                             file.queries,
                             arguments.run,
                             [&](std::size_t done) { progress.show(done); });
    }
    const double wall = watch.seconds();
    writeWholeFile(arguments.output, tableOf(file, answers, arguments.run.warm));
    if (arguments.summary)
    {
        fmt::print("{}",
                   summaryText({.answers = answers,
                                .badRows = file.badRows.size(),
                                .warm = arguments.run.warm,
                                .loadSeconds = meshes.loadSeconds,
                                .buildSeconds = meshes.buildSeconds,
                                .wallSeconds = wall}));
    }
}

constexpr const char* kBatchFooter =
    "The first line of QUERIES names the columns, in any order, of one of two forms:\n"
    "  poses   id, and qw qx qy qz tx ty tz with each of a0_ a1_ b0_ b1_: A and B at t = 0 and\n"
    "          t = 1; origins move on straight lines, bodies turn along the shortest arc\n"
    "  twists  id, and the same with a0_ b0_, and vx vy vz wx wy wz with each of a_ b_:\n"
    "          velocity of the body's origin and angular velocity in world axes, per interval,\n"
    "          lengths in mesh units, angles in rad, any number of turns\n"
    "\n"
    "RESULTS has a row for every query: id,status,toi,gap,px,py,pz,nx,ny,nz,iterations,\n"
    "microseconds. status is separated, hit, overlapping, touching_leaving, touching_pressing,\n"
    "iteration_limit or bad_row. Without contact toi is 1, p and n are empty and gap is a lower\n"
    "bound of the distance; else p is the middle of the closest points in the world and n the\n"
    "normal from A to B. microseconds is the time of one query alone, without state of an earlier\n"
    "one; measure with --jobs 1. --warm asks the same query again at once; the library keeps no\n"
    "answers, so only the caches of the processor are warm. RESULTS appears when all is done,\n"
    "or not at all.\n"
    "\n"
    "A bad row is reported on stderr with its line and column, its status is bad_row, the others\n"
    "are answered and the exit code is 0; with --strict nothing is computed and it is 3.";

void addRunOptions(CLI::App& command, RunOptions& run)
{
    command.add_option("-j,--jobs", run.jobs, "threads, 0 for one a core; changes only the times")
        ->type_name("N")
        ->check(within(0, 1024))
        ->capture_default_str();
    command
        .add_option(
            "--repeat", run.repeat, "passes over all queries; the median of the times counts")
        ->type_name("K")
        ->check(within(1, 10'000))
        ->capture_default_str();
    command.add_flag(
        "--warm", run.warm, "time every query a second time: column warm_microseconds");
}
}  // namespace

void addBatchCommand(CLI::App& app)
{
    CLI::App* command = app.add_subcommand("batch", "a file of queries over the same two bodies");
    command->footer(kBatchFooter);
    const auto arguments = std::make_shared<BatchArguments>();
    command->add_option("A", arguments->fileA, "mesh of body A")->type_name("MESH")->required();
    command->add_option("B", arguments->fileB, "mesh of body B")->type_name("MESH")->required();
    command->add_option("QUERIES", arguments->queries, "motions, one row a query")
        ->type_name("CSV")
        ->required();
    command
        ->add_option("-o,--output", arguments->output, "RESULTS, one row for each row of QUERIES")
        ->type_name("CSV")
        ->required();
    addToiOptions(*command, arguments->run.toi);
    addRunOptions(*command, arguments->run);
    command->add_flag("--summary", arguments->summary, "print counts and times when done");
    command->add_flag("--strict", arguments->strict, "compute nothing if a row is bad");
    command->callback([arguments] { runBatch(*arguments); });
}
}  // namespace bullet_ccd::tools
