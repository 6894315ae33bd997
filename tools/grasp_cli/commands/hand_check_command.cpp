#include "grasp/hand/sampled_pairs.h"
#include "grasp/hand/srdf_file.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/inputs/catalogue.h"
#include "tools/support/text_file.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <set>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using grasp::HandModel;
using grasp::PairFinding;
using grasp::SampledPair;

constexpr std::array kDisabling{
    PairFinding::Adjacent, PairFinding::Default, PairFinding::Always, PairFinding::Never};

struct HandCheckArguments
{
    std::string hand;
    std::string srdf;
    std::string output;
    std::vector<std::string> reasons;
    grasp::PairSampling sampling;
};

double percentOf(const SampledPair& pair)
{
    return 100.0 * pair.overlaps / pair.samples;
}

/// Pairs by link names, the smaller name first.
using NamedPairs = std::set<std::pair<std::string, std::string>>;

NamedPairs disabledIn(const fs::path& srdf)
{
    NamedPairs pairs;
    if (!srdf.empty())
    {
        for (const auto& [first, second] : grasp::readSrdf(srdf).disabledPairs)
        {
            pairs.insert(std::minmax(first, second));
        }
    }
    return pairs;
}

bool isIn(const NamedPairs& names, const HandModel& hand, const SampledPair& pair)
{
    const std::string first = linkName(hand, pair.first);
    const std::string second = linkName(hand, pair.second);
    return names.contains(std::minmax(first, second));
}

/// All pairs that can overlap; the rest is only counted.
TextTable pairTable(const HandModel& hand,
                    const std::vector<SampledPair>& pairs,
                    const NamedPairs& disabled)
{
    TextTable table{.header = {"link", "other link", "found", "overlaps [%]", "SRDF"}, .rows = {}};
    for (const SampledPair& pair : pairs)
    {
        if (pair.finding != PairFinding::Never)
        {
            table.rows.push_back({linkName(hand, pair.first),
                                  linkName(hand, pair.second),
                                  nameOf(pair.finding),
                                  fmt::format("{:.2f}", percentOf(pair)),
                                  isIn(disabled, hand, pair) ? "disabled" : "tested"});
        }
    }
    return table;
}

void printCounts(const std::vector<SampledPair>& pairs)
{
    std::vector<std::string> counts;
    for (const PairFinding finding : {PairFinding::Adjacent,
                                      PairFinding::Default,
                                      PairFinding::Always,
                                      PairFinding::Never,
                                      PairFinding::Sometimes})
    {
        const auto count =
            std::count_if(pairs.begin(),
                          pairs.end(),
                          [&](const SampledPair& pair) { return pair.finding == finding; });
        counts.push_back(fmt::format("{} {}", count, nameOf(finding)));
    }
    fmt::print("\n{} pairs of links: {}\n", pairs.size(), joined(counts, ", "));
}

/// Where an SRDF that disables pairs and the samples contradict each other; true if nowhere.
bool agrees(const HandModel& hand,
            const std::vector<SampledPair>& pairs,
            const NamedPairs& disabled)
{
    std::vector<std::string> overlooked;
    std::vector<std::string> useless;
    for (const SampledPair& pair : pairs)
    {
        const bool isDisabled = isIn(disabled, hand, pair);
        const std::string text = fmt::format("{} - {} ({:.2f} %)",
                                             linkName(hand, pair.first),
                                             linkName(hand, pair.second),
                                             percentOf(pair));
        if (isDisabled && pair.finding == PairFinding::Sometimes)
        {
            overlooked.push_back(text);
        }
        if (!isDisabled &&
            (pair.finding == PairFinding::Default || pair.finding == PairFinding::Always))
        {
            useless.push_back(text);
        }
    }
    const std::string file = hand.srdfFile.string();
    if (!overlooked.empty())
    {
        fmt::print("FAIL  {}: disables pairs that overlap in some configurations only: {}\n",
                   file,
                   joined(overlooked, ", "));
    }
    if (!useless.empty())
    {
        fmt::print("FAIL  {}: does not disable pairs that overlap at rest or always: {}\n",
                   file,
                   joined(useless, ", "));
    }
    return overlooked.empty() && useless.empty();
}

std::vector<SampledPair> proposed(const std::vector<SampledPair>& pairs,
                                  const std::vector<std::string>& reasons)
{
    std::vector<SampledPair> chosen;
    std::copy_if(pairs.begin(),
                 pairs.end(),
                 std::back_inserter(chosen),
                 [&](const SampledPair& pair)
                 {
                     return pair.canBeDisabled() &&
                            std::find(reasons.begin(), reasons.end(), nameOf(pair.finding)) !=
                                reasons.end();
                 });
    return chosen;
}

int check(const HandCheckArguments& arguments)
{
    const LoadedHand loaded = loadNamedHand(arguments.hand, arguments.srdf);
    const HandModel& hand = loaded.hand;
    if (!arguments.output.empty())
    {
        requireOtherFile(arguments.output, {loaded.file.string(), hand.srdfFile.string()});
        requireWritable(arguments.output);
    }
    const std::vector<SampledPair> pairs =
        grasp::samplePairs(hand.robot.tree, hand.linkTrees, arguments.sampling);
    const NamedPairs disabled = disabledIn(hand.srdfFile);
    fmt::print("{} ({}), disabled pairs from {}; {} samples from seed {}\n\n{}",
               hand.robot.name,
               loaded.file.string(),
               disabled.empty() ? "nowhere" : hand.srdfFile.string(),
               arguments.sampling.samples,
               arguments.sampling.seed,
               alignedText(pairTable(hand, pairs, disabled)));
    printCounts(pairs);
    const bool good = disabled.empty() || agrees(hand, pairs, disabled);
    const std::string srdf = grasp::disabledPairsSrdf(
        hand.robot.name, hand.robot.tree, proposed(pairs, arguments.reasons));
    if (arguments.output.empty())
    {
        fmt::print("\n{}", srdf);
    }
    else
    {
        writeWholeFile(arguments.output, srdf);
        fmt::print("wrote {}\n", arguments.output);
    }
    return good ? kDone : kNothingFound;
}

std::vector<std::string> reasonNames()
{
    std::vector<std::string> names;
    for (const PairFinding finding : kDisabling)
    {
        names.emplace_back(nameOf(finding));
    }
    return names;
}
}  // namespace

void addHandCheckCommand(CLI::App& hand, int& exitCode)
{
    auto* command = hand.add_subcommand(
        "check",
        "Finds by sampling the pairs of links that need not be tested against each other.");
    command->footer(
        "Tries random joint positions within the limits, sorts the pairs of links, and prints an "
        "SRDF that disables all kinds but the last:\n"
        "  Adjacent   are joined, with no other geometry between them\n"
        "  Default    overlap at rest: all joints at 0, or at the limit next to it\n"
        "  Always     overlap in at least 95 % of the samples\n"
        "  Never      overlap in no sample, so that they are likely never to meet\n"
        "  Sometimes  have to be tested\n"
        "bullet-ccd exempts joined links about their joint by itself. Leave out Adjacent to have "
        "the rest of them tested.\n"
        "\n"
        "Exit codes: 0 if the samples do not contradict the SRDF of the hand; 1 if it disables "
        "pairs "
        "that overlap in some samples only, or does not disable pairs that overlap at rest or "
        "always; "
        "2 for wrong options, 3 for bad input.\n"
        "\n"
        "Example:\n"
        "  grasp hand check my_hand.urdf --samples 10000 --write-srdf my_hand.srdf");
    const auto arguments = std::make_shared<HandCheckArguments>();
    arguments->reasons = reasonNames();
    command
        ->add_option("hand",
                     arguments->hand,
                     "A URDF, xacro or MJCF file, or the name of a hand that ships.")
        ->type_name("HAND")
        ->required();
    command
        ->add_option("--srdf",
                     arguments->srdf,
                     "The SRDF whose disabled pairs are checked. Default: as in grasp plan.")
        ->type_name("FILE");
    command
        ->add_option(
            "--samples", arguments->sampling.samples, "How many random configurations to try.")
        ->type_name("N")
        ->check(within(1, 100'000'000))
        ->capture_default_str();
    command
        ->add_option(
            "--seed", arguments->sampling.seed, "Where the sequence of configurations starts.")
        ->type_name("S")
        ->check(wholeNumber())
        ->capture_default_str();
    command
        ->add_option("--reasons",
                     arguments->reasons,
                     "Which kinds of pairs to disable, with commas between.")
        ->type_name("NAMES")
        ->delimiter(',')
        ->check(oneOf(reasonNames()))
        ->default_str(joined(reasonNames(), ","));
    command
        ->add_option(
            "--write-srdf", arguments->output, "Write the SRDF to a file instead of printing it.")
        ->type_name("FILE");
    command->callback([arguments, &exitCode] { exitCode = check(*arguments); });
}
}  // namespace bullet_ccd::tools
