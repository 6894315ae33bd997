#include "grasp/planner/content_hash.h"
#include "grasp/planner/grasp_file.h"
#include "tools/grasp_cli/audit.h"
#include "tools/grasp_cli/catalogue.h"
#include "tools/grasp_cli/commands.h"
#include "tools/grasp_cli/text_table.h"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

struct CheckArguments
{
    std::string file;
    std::string hand;
    std::string object;
    double maxGap = 2e-4;
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

void requireSameContent(const fs::path& file, const std::string& now, const std::string& then)
{
    if (now != then)
    {
        throw std::runtime_error(fmt::format(
            "{}: content hash {} differs from {} that the grasps were planned with: restore the "
            "file or plan again",
            file.string(),
            now,
            then));
    }
}

/// Audits one grasp and adds it to table and summary.
void addGrasp(const grasp::HandModel& hand,
              const grasp::GraspObject& object,
              const grasp::Grasp& grasp,
              std::size_t rank,
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
    const grasp::GraspFileSource source = grasp::readGraspSource(arguments.file);
    const grasp::GraspRun& run = source.run;
    // An SRDF that is gone may have moved with its hand; the content hash tells another one.
    const LoadedHand hand =
        loadNamedHand(arguments.hand.empty() ? run.handFile.string() : arguments.hand,
                      fs::exists(run.srdfFile) ? std::optional(run.srdfFile) : std::nullopt);
    const LoadedObject object = loadNamedObject(
        arguments.object.empty() ? run.objectFile.string() : arguments.object, run.objectScale);
    requireSameContent(hand.file, grasp::contentHash(hand.hand), source.handHash);
    requireSameContent(object.file, grasp::contentHash(object.object), source.objectHash);
    const std::vector<grasp::Grasp> grasps = grasp::readGrasps(arguments.file, hand.hand);

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
    for (std::size_t k = 0; k < grasps.size(); ++k)
    {
        if (!grasps[k].positions.empty())
        {
            addGrasp(hand.hand, object.object, grasps[k], k + 1, arguments.maxGap, table, summary);
        }
    }
    fmt::print("{}\n", alignedText(table));
    fmt::print(
        "{} of {} grasps have a final posture; {} of them penetrate\n"
        "deepest penetration {:.4f} mm, largest gap of a contact {:.4f} mm, farthest contact "
        "point from the object {:.2g} mm\n",
        summary.audited,
        grasps.size(),
        summary.penetrating,
        1e3 * summary.deepest,
        1e3 * summary.largestGap,
        1e3 * summary.largestOffset);
    if (!object.object.watertight)
    {
        fmt::print("{} is not watertight: only its surface could be tested, not its inside\n",
                   object.object.name);
    }
    return summary.penetrating == 0 && summary.tooWide == 0 ? kFound : kNothingFound;
}
}  // namespace

void addCheckCommand(CLI::App& app, int& exitCode)
{
    auto* command = app.add_subcommand(
        "check", "measure penetration and contact gaps of planned grasps afresh");
    command->footer(
        "Loads hand and object that the file names and tests every final posture with methods "
        "that\n"
        "share no code with planning: triangle against triangle, vertices against the inside of a\n"
        "watertight object, contact points against all triangles. Exit code 1 if a posture "
        "penetrates\n"
        "or a contact is wider than --max-gap.");
    const auto arguments = std::make_shared<CheckArguments>();
    command->add_option("file", arguments->file, "grasps.jsonl that grasp plan wrote")
        ->type_name("FILE")
        ->required();
    command->add_option("--hand", arguments->hand, "where the hand is now, if it moved")
        ->type_name("HAND");
    command->add_option("--object", arguments->object, "where the object is now, if it moved")
        ->type_name("OBJECT");
    command->add_option("--max-gap", arguments->maxGap, "largest gap of a contact [m]")
        ->type_name("M")
        ->check(within(0.0, 1.0))
        ->capture_default_str();
    command->callback([arguments, &exitCode] { exitCode = check(*arguments); });
}
}  // namespace bullet_ccd::tools
