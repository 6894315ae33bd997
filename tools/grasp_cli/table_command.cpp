#include "grasp/formats/grasp_file.h"
#include "tools/grasp_cli/audit.h"
#include "tools/grasp_cli/commands.h"
#include "tools/grasp_cli/finger_option.h"
#include "tools/grasp_cli/input_options.h"
#include "tools/grasp_cli/output_folder.h"
#include "tools/grasp_cli/plan_run.h"
#include "tools/grasp_cli/text_table.h"

#include <algorithm>
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

/// What the criteria ask of a table.
constexpr double kMaxGap = 2e-4;         // [m]
constexpr double kContactsWanted = 3.0;  // in the mean, hands with three fingers or more

struct TableArguments
{
    std::vector<std::string> hands;
    std::vector<std::string> objects;
    double objectScale = 1.0;
    std::string output;
    bool quiet = false;
    grasp::PlannerOptions options;
};

/// One hand with one object.
struct TableRow
{
    std::string hand;
    std::string object;
    std::size_t fingers = 0;
    std::size_t candidates = 0;
    std::size_t forceClosures = 0;
    double bestEpsilon = 0.0;
    double contacts = 0.0;        ///< mean over the force closures
    double links = 0.0;           ///< same, links in contact
    int fewestFingers = 0;        ///< in contact, over the force closures
    std::size_t postures = 0;     ///< candidates that were closed
    std::size_t penetrating = 0;  ///< of these
    double deepest = 0.0;         ///< over all final postures [m]
    double largestGap = 0.0;      ///< [m]
    double seconds = 0.0;
    std::string rejected;
};

TableRow rowOf(const PlanRun& run)
{
    const grasp::HandModel& hand = run.hand.hand;
    TableRow row{.hand = run.hand.file.stem().string(),
                 .object = run.object.object.name,
                 .fingers = hand.fingers.size(),
                 .candidates = run.grasps.size(),
                 .forceClosures = forceClosures(run.grasps),
                 .seconds = run.seconds,
                 .rejected = rejectionCounts(run.grasps)};
    row.fewestFingers = static_cast<int>(row.fingers);
    for (const Grasp& g : run.grasps)
    {
        if (g.positions.empty())
        {
            continue;
        }
        const GraspAudit audit = auditGrasp(hand, run.object.object, g);
        ++row.postures;
        row.penetrating += audit.penetration.clean() ? 0U : 1U;
        row.deepest = std::max(row.deepest, audit.penetration.deepest);
        row.largestGap = std::max({row.largestGap, audit.largestGap, audit.largestOffset});
        if (g.reject == grasp::RejectReason::None)
        {
            const auto count = static_cast<double>(row.forceClosures);
            row.bestEpsilon = std::max(row.bestEpsilon, g.quality.epsilon);
            row.contacts += static_cast<double>(g.contacts.size()) / count;
            row.links += static_cast<double>(audit.links) / count;
            row.fewestFingers = std::min(row.fewestFingers, audit.fingers);
        }
    }
    return row;
}

TextTable textOf(const std::vector<TableRow>& rows)
{
    TextTable table{.header = {"hand",
                               "object",
                               "force closures",
                               "of",
                               "best epsilon",
                               "contacts",
                               "links",
                               "fewest fingers",
                               "postures",
                               "penetrating",
                               "deepest [mm]",
                               "largest gap [mm]",
                               "seconds",
                               "rejected"},
                    .rows = {}};
    for (const TableRow& row : rows)
    {
        const bool found = row.forceClosures > 0;
        table.rows.push_back({row.hand,
                              row.object,
                              fmt::format("{}", row.forceClosures),
                              fmt::format("{}", row.candidates),
                              found ? fmt::format("{:.4f}", row.bestEpsilon) : "-",
                              found ? fmt::format("{:.1f}", row.contacts) : "-",
                              found ? fmt::format("{:.1f}", row.links) : "-",
                              found ? fmt::format("{}", row.fewestFingers) : "-",
                              fmt::format("{}", row.postures),
                              fmt::format("{}", row.penetrating),
                              fmt::format("{:.4f}", 1e3 * row.deepest),
                              fmt::format("{:.4f}", 1e3 * row.largestGap),
                              fmt::format("{:.1f}", row.seconds),
                              row.rejected});
    }
    return table;
}

/// The criteria, one line each, and whether all of them hold.
struct Verdicts
{
    std::string text;
    bool allHold = true;

    void add(bool holds, const std::string& what)
    {
        text += fmt::format("{}  {}\n", holds ? "pass" : "FAIL", what);
        allHold = allHold && holds;
    }
};

Verdicts criteria(const std::vector<TableRow>& rows)
{
    std::map<std::string, std::vector<const TableRow*>> byHand;
    std::size_t penetrating = 0;
    double gap = 0.0;
    for (const TableRow& row : rows)
    {
        byHand[row.hand].push_back(&row);
        penetrating += row.penetrating;
        gap = std::max(gap, row.largestGap);
    }
    std::size_t goodHands = 0;
    Verdicts verdicts;
    for (const auto& [hand, ofHand] : byHand)
    {
        std::size_t objects = 0;
        double grasps = 0.0;
        double contacts = 0.0;
        double links = 0.0;
        int fewest = static_cast<int>(ofHand.front()->fingers);
        for (const TableRow* row : ofHand)
        {
            const auto count = static_cast<double>(row->forceClosures);
            objects += row->forceClosures > 0 ? 1U : 0U;
            grasps += count;
            contacts += count * row->contacts;
            links += count * row->links;
            fewest = row->forceClosures > 0 ? std::min(fewest, row->fewestFingers) : fewest;
        }
        // Four of six objects, and the same share of other numbers.
        goodHands += 3 * objects >= 2 * ofHand.size() ? 1U : 0U;
        const bool gripper = ofHand.front()->fingers < 3;
        const bool holds =
            grasps > 0.0 && (gripper ? fewest >= 2 : contacts / grasps >= kContactsWanted);
        verdicts.add(
            holds,
            fmt::format(
                "{}: force closure on {} of {} objects, {:.1f} contacts on {:.1f} links in the "
                "mean, at least {} fingers",
                hand,
                objects,
                ofHand.size(),
                contacts / std::max(1.0, grasps),
                links / std::max(1.0, grasps),
                fewest));
    }
    verdicts.add(4 * goodHands >= 3 * byHand.size(),
                 fmt::format("{} of {} hands find force closure on two thirds of the objects",
                             goodHands,
                             byHand.size()));
    verdicts.add(penetrating == 0, fmt::format("{} postures penetrate", penetrating));
    verdicts.add(gap <= kMaxGap, fmt::format("largest gap of a contact {:.4f} mm", 1e3 * gap));
    return verdicts;
}

void writeText(const fs::path& path, const std::string& text)
{
    std::ofstream out(path);
    out << text;
    out.close();
    if (!out)
    {
        throw std::runtime_error(
            fmt::format("{}: cannot be written: is the disk full?", path.string()));
    }
}

int table(const TableArguments& arguments)
{
    // Everything is resolved before anything is planned: a misspelt name must not cost an hour.
    for (const std::string& hand : arguments.hands)
    {
        static_cast<void>(resolveHand(hand));
    }
    for (const std::string& object : arguments.objects)
    {
        static_cast<void>(resolveObject(object));
    }
    std::optional<OutputFolder> output;
    if (!arguments.output.empty())
    {
        output.emplace(arguments.output);
    }
    std::vector<TableRow> rows;
    for (const std::string& hand : arguments.hands)
    {
        for (const std::string& object : arguments.objects)
        {
            PlanRun run{.hand = loadNamedHand(hand, std::nullopt),
                        .object = loadNamedObject(object, arguments.objectScale)};
            requireFingers(run.hand, arguments.options.closing);
            runPlan(run, arguments.options, arguments.quiet);
            rows.push_back(rowOf(run));
            if (output)
            {
                std::ofstream out(output->stage(
                    fmt::format("{}_{}.jsonl", rows.back().hand, rows.back().object)));
                grasp::writeGrasps(out,
                                   {.handFile = run.hand.file,
                                    .srdfFile = run.hand.hand.srdfFile,
                                    .objectFile = run.object.file,
                                    .objectScale = arguments.objectScale,
                                    .options = arguments.options},
                                   run.hand.hand,
                                   run.object.object,
                                   run.grasps);
            }
        }
    }
    const TextTable text = textOf(rows);
    const Verdicts verdicts = criteria(rows);
    fmt::print("{}\n{}", alignedText(text), verdicts.text);
    if (output)
    {
        writeText(output->stage("table.csv"), csvText(text));
        writeText(output->stage("table.md"), markdownText(text));
        output->commit();
        fmt::print("\nwritten: {} (table.csv, table.md, one .jsonl a row)\n",
                   output->folder().string());
    }
    return verdicts.allHold ? kFound : kNothingFound;
}
}  // namespace

void addTableCommand(CLI::App& app, int& exitCode)
{
    auto* command = app.add_subcommand("table", "plan every hand with every object and compare");
    const auto arguments = std::make_shared<TableArguments>();
    addInputOptions(*command, arguments->hands, arguments->objects, arguments->objectScale);
    addPlannerOptions(*command, arguments->options);
    addFingersOption(*command, arguments->options.closing);
    command->add_option("-o,--output", arguments->output, "folder for the table and all grasps")
        ->type_name("FOLDER")
        ->group("Output");
    command->add_flag("-q,--quiet", arguments->quiet, "no progress and no notes on stderr")
        ->group("Output");
    command->footer(
        "Contacts, links and fingers are means (fingers: the minimum) over the force closures;\n"
        "penetration and gaps are measured over all final postures by the independent check.\n"
        "\n"
        "Below the table each criterion is marked pass or FAIL; exit code 1 if any fails:\n"
        "  each hand finds a force closure; with three fingers or more, these have 3 contacts or\n"
        "  more in the mean; with fewer, two fingers or more touch in every one of them\n"
        "  three quarters of the hands find force closure on two thirds of the objects or more\n"
        "  no final posture penetrates the object\n"
        "  no contact is wider than 0.2 mm");
    command->callback([arguments, &exitCode] { exitCode = table(*arguments); });
}
}  // namespace bullet_ccd::tools
