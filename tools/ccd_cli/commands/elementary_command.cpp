#include "tools/ccd_cli/commands/commands.h"
#include "tools/ccd_cli/files/elementary_file.h"
#include "tools/ccd_cli/run/query_run.h"
#include "tools/support/command_line.h"
#include "tools/support/option_values.h"
#include "tools/support/stop_request.h"
#include "tools/support/stopwatch.h"
#include "tools/support/text_file.h"

#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
struct ElementaryArguments
{
    std::vector<std::string> queries;
    std::string output;
    ElementaryOptions options;
    bool edgeEdge = false;
    bool vertexFace = false;
    bool summary = false;
    int repeat = 1;
};

struct ElementaryAnswer
{
    bool hit = false;
    double time = 1.0;
    double microseconds = 0.0;
};

std::vector<ElementaryQuery> readAll(const ElementaryArguments& arguments)
{
    std::optional<ElementaryKind> kind;
    if (arguments.edgeEdge || arguments.vertexFace)
    {
        kind = arguments.edgeEdge ? ElementaryKind::EdgeEdge : ElementaryKind::VertexFace;
    }
    std::vector<ElementaryQuery> all;
    for (const std::string& path : arguments.queries)
    {
        for (const std::filesystem::path& file : elementaryFiles(path))
        {
            requireOtherFile(arguments.output, {file.string()});
            std::vector<ElementaryQuery> queries = readElementaryFile(file, kind);
            std::ranges::move(queries, std::back_inserter(all));
        }
    }
    return all;
}

/// What gave up without an answer counts as a hit: it is not known to be apart.
ElementaryAnswer answerOf(const ElementaryPair& pair, const ElementaryOptions& options)
{
    const Stopwatch watch;
    const ElementaryResult result = elementaryToi(pair, options);
    const double seconds = watch.seconds();
    return {.hit = isContact(result.status) || result.status == ToiStatus::IterationLimit,
            .time = result.time,
            .microseconds = 1e6 * seconds};
}

std::string elementarySummary(const std::vector<ElementaryQuery>& queries,
                              const std::vector<ElementaryAnswer>& answers,
                              double minimumSeparation,
                              double slowestCall)
{
    std::size_t hits = 0;
    std::size_t known = 0;
    std::size_t touching = 0;
    std::size_t missed = 0;
    std::size_t wrong = 0;
    std::vector<double> times;
    for (std::size_t i = 0; i < queries.size(); ++i)
    {
        const bool touches = queries[i].touches.value_or(false);
        const bool isKnown = queries[i].touches.has_value();
        hits += answers[i].hit ? 1 : 0;
        known += isKnown ? 1 : 0;
        touching += touches ? 1 : 0;
        missed += touches && !answers[i].hit ? 1 : 0;
        wrong += isKnown && !touches && answers[i].hit ? 1 : 0;
        times.push_back(answers[i].microseconds);
    }
    std::string text = fmt::format("queries: {}\nhits: {}\n", queries.size(), hits);
    if (known > 0)
    {
        text += fmt::format(
            "with a truth: {}, of which {} touch\nmissed: {}\nfalse: {}{}\n",
            known,
            touching,
            missed,
            wrong,
            minimumSeparation > 0.0 ? " (the truth knows what touches, not what comes near)" : "");
    }
    const double sum = std::accumulate(times.begin(), times.end(), 0.0);
    return text + fmt::format(
                      "microseconds: mean {:.3f}, median {:.3f}, p95 {:.3f}, max {:.3f}\n"
                      "slowest single call: {:.3f} (the machine interrupts some; with "
                      "--repeat the times above are medians)\n",
                      sum / static_cast<double>(times.size()),
                      quantile(times, 0.5),
                      quantile(times, 0.95),
                      *std::ranges::max_element(times),
                      slowestCall);
}

int runElementary(const ElementaryArguments& arguments)
{
    const StopRequest stop;
    const std::vector<ElementaryQuery> queries = readAll(arguments);
    requireWritable(arguments.output);
    std::vector<std::vector<double>> times(queries.size());
    std::vector<ElementaryAnswer> answers;
    double slowestCall = 0.0;
    for (int pass = 0; pass < arguments.repeat; ++pass)
    {
        for (std::size_t i = 0; i < queries.size() && !(pass == 0 && stop.isDue()); ++i)
        {
            const ElementaryAnswer answer = answerOf(queries[i].pair, arguments.options);
            if (pass == 0)
            {
                answers.push_back(answer);
            }
            times[i].push_back(answer.microseconds);
            slowestCall = std::max(slowestCall, answer.microseconds);
        }
        if (stop.isDue())
        {
            break;
        }
    }
    std::string table = "query,hit,toi,microseconds\n";
    for (std::size_t i = 0; i < answers.size(); ++i)
    {
        answers[i].microseconds = quantile(times[i], 0.5);
        table += fmt::format("{},{},{},{:.3f}\n",
                             i,
                             answers[i].hit ? 1 : 0,
                             answers[i].time,
                             answers[i].microseconds);
    }
    writeWholeFile(arguments.output, table);
    if (arguments.summary && answers.size() == queries.size())
    {
        fmt::print(
            "{}",
            elementarySummary(queries, answers, arguments.options.minimumSeparation, slowestCall));
    }
    return stop.finish("bullet-ccd elementary", answers.size(), queries.size(), "queries", kDone);
}

constexpr const char* kElementaryFooter =
    "QUERIES has no header and eight lines per query: the four vertices at t = 0, then at t = 1. "
    "These are the vertex and the three corners of the face, or the ends of one edge and those of "
    "the other. Each line is x_num,x_den,y_num,y_den,z_num,z_den,truth: whole numbers of any "
    "length, and 1 if the features touch, else 0; the truth may be left out. Vertices move on "
    "straight lines. The kind is that of the folder of the file, edge-edge or vertex-face, unless "
    "an "
    "option says it. For a folder, all files in such folders below it are read, in the order of "
    "their names.\n"
    "\n"
    "RESULTS has the columns query, hit, toi, microseconds, and one row per query, counted from 0 "
    "over all files in order. toi is a time before which there is certainly no contact, 1 without "
    "one. microseconds is the wall time of one call of elementaryToi().\n"
    "\n"
    "No contact is ever missed. Without --exact, a hit may be a pair that comes close but does not "
    "touch: within the tolerance, or with --decide nearly within the rounding of double "
    "precision.\n"
    "\n"
    "Exit codes: 0 if everything was answered, 2 for wrong options, 3 for bad input, 130 after "
    "Ctrl-C.\n"
    "\n"
    "Example:\n"
    "  bullet-ccd elementary edge-edge/data.csv --exact -o results.csv --summary";

void addElementaryFlags(CLI::App& command, ElementaryArguments& arguments)
{
    CLI::Option* edges = command.add_flag(
        "--edge-edge", arguments.edgeEdge, "All queries are of two edges, whatever the folder.");
    command
        .add_flag("--vertex-face",
                  arguments.vertexFace,
                  "All queries are of a vertex and a face, whatever the folder.")
        ->excludes(edges);
    addDepthOptions(command, arguments.options.depth);
    command.add_flag("--summary",
                     arguments.summary,
                     "Print counts and times, and how many answers differ from the truth.");
    command
        .add_option("--repeat",
                    arguments.repeat,
                    "How often to pass over all queries. The time of a query is its median.")
        ->type_name("K")
        ->check(within(1, 10'000))
        ->capture_default_str();
}
}  // namespace

void addElementaryCommand(CLI::App& app, int& exitCode)
{
    CLI::App* command = app.add_subcommand(
        "elementary",
        "Answers a file of queries of two features (a vertex and a face, or two edges).");
    command->footer(kElementaryFooter);
    const auto arguments = std::make_shared<ElementaryArguments>();
    command
        ->add_option("QUERIES", arguments->queries, "Files of queries, or folders of such files.")
        ->type_name("CSV")
        ->required();
    command
        ->add_option("-o,--output", arguments->output, "Where to write RESULTS, one row per query.")
        ->type_name("CSV")
        ->required();
    addDistanceOptions(
        *command, arguments->options.tolerance, arguments->options.minimumSeparation);
    addElementaryFlags(*command, *arguments);
    command->callback([arguments, &exitCode] { exitCode = runElementary(*arguments); });
}
}  // namespace bullet_ccd::tools
