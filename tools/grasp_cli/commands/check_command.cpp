#include "tools/grasp_cli/answers/audit.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/options/input_options.h"
#include "tools/support/stop_request.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <fmt/format.h>

namespace bullet_ccd::tools
{
namespace
{
struct CheckArguments
{
    RecordArguments records;
    double maxGap = 2e-4;
    double timeLimit = 0.0;
};

/// Sums over all grasps of a file.
struct CheckSummary
{
    int audited = 0;
    int penetrating = 0;
    int tooWide = 0;
    double deepest = 0.0;
    double largestGap = 0.0;
    double largestOffset = 0.0;
};

/// Audits one grasp and adds it to table and summary.
void addGrasp(const grasp::HandModel& hand,
              const grasp::GraspObject& object,
              const grasp::Grasp& grasp,
              int rank,
              double maxGap,
              TextTable& table,
              CheckSummary& summary)
{
    const GraspAudit audit = auditGrasp(hand, object, grasp);
    const bool clean = audit.penetration.clean();
    const bool near = audit.largestGap <= maxGap && audit.largestOffset <= maxGap;
    ++summary.audited;
    summary.penetrating += clean ? 0 : 1;
    summary.tooWide += near ? 0 : 1;
    summary.deepest = std::max(summary.deepest, audit.penetration.deepest);
    summary.largestGap = std::max(summary.largestGap, audit.largestGap);
    summary.largestOffset = std::max(summary.largestOffset, audit.largestOffset);
    const std::string where =
        clean ? std::string()
              : hand.robot.tree.links[static_cast<std::size_t>(audit.penetration.link)].name;
    table.rows.push_back({fmt::format("{}", rank),
                          fmt::format("{}", grasp.candidate),
                          fmt::format("{:.4f}", grasp.quality.epsilon),
                          fmt::format("{}", grasp.contacts.size()),
                          fmt::format("{}", audit.links),
                          fmt::format("{}", audit.penetration.intersectingTriangles),
                          fmt::format("{}", audit.penetration.verticesInside),
                          fmt::format("{:.4f}", 1e3 * audit.penetration.deepest),
                          fmt::format("{:.4f}", 1e3 * audit.largestGap),
                          clean ? (near ? "ok" : "gap too wide") : "PENETRATES at " + where});
}

int check(const CheckArguments& arguments)
{
    const GraspRecords records = loadGraspRecords(arguments.records);
    const grasp::HandModel& hand = records.hand.hand;
    const grasp::GraspObject& object = records.object.object;
    const std::vector<grasp::Grasp>& grasps = records.grasps;

    TextTable table{.header = {"rank",
                               "candidate",
                               "epsilon",
                               "contacts",
                               "links",
                               "triangle pairs",
                               "vertices inside",
                               "deepest [mm]",
                               "gap [mm]",
                               "verdict"},
                    .rows = {}};
    CheckSummary summary;
    const StopRequest stop(arguments.timeLimit);
    std::size_t done = 0;
    for (; done < grasps.size() && !stop.isDue(); ++done)
    {
        if (!grasps[done].positions.empty())
        {
            addGrasp(
                hand, object, grasps[done], records.ranks[done], arguments.maxGap, table, summary);
        }
    }
    fmt::print("{}\n", alignedText(table));
    fmt::print(
        "{} of {} grasps have a final posture; {} of them penetrate\n"
        "deepest penetration {:.4f} mm, largest gap of a contact {:.4f} mm, farthest contact "
        "point from the object {:.2g} mm\n",
        summary.audited,
        done,
        summary.penetrating,
        1e3 * summary.deepest,
        1e3 * summary.largestGap,
        1e3 * summary.largestOffset);
    if (!object.watertight)
    {
        fmt::print("{} is not watertight: only its surface could be tested, not its inside\n",
                   object.name);
    }
    const bool isSound = done == grasps.size() && summary.penetrating == 0 && summary.tooWide == 0;
    return stop.finish("grasp check",
                       done,
                       grasps.size(),
                       "grasps",
                       records.exitCode(isSound ? kDone : kNothingFound));
}
}  // namespace

void addCheckCommand(CLI::App& app, int& exitCode)
{
    auto* command = app.add_subcommand(
        "check", "Measures penetration and contact gaps of planned grasps afresh.");
    command->footer(
        "Loads the hand and the object that the file names, and tests every final posture with "
        "methods that share no code with planning: triangles against triangles, vertices against "
        "the "
        "inside of a watertight object, and contact points against all triangles.\n"
        "\n"
        "Exit codes: 0 if no posture penetrates and no contact is wider than --max-gap, 1 if one "
        "does or is, or the time limit left some out, 130 after Ctrl-C, 2 for wrong options, 3 for "
        "bad input.\n"
        "\n"
        "Example:\n"
        "  grasp check out/grasps.jsonl --max-gap 1e-4");
    const auto arguments = std::make_shared<CheckArguments>();
    addRecordOptions(*command, arguments->records);
    command
        ->add_option("--max-gap", arguments->maxGap, "The largest gap that a contact may have [m].")
        ->type_name("M")
        ->check(within(0.0, 1.0))
        ->capture_default_str();
    addTimeLimitOption(*command, arguments->timeLimit, "Check no further grasp");
    command->callback([arguments, &exitCode] { exitCode = check(*arguments); });
}
}  // namespace bullet_ccd::tools
