#include "benchmarks/grasp/grasp_table.h"

#include "benchmarks/support/table.h"
#include "grasp/formats/grasp_file.h"
#include "tools/grasp_cli/answers/audit.h"
#include "tools/grasp_cli/plan/output_folder.h"
#include "tools/grasp_cli/plan/plan_run.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

namespace bullet_ccd::benchmarks
{
namespace
{
using grasp::Grasp;
using nlohmann::json;
using tools::PlanRun;

/// What the criteria ask of a table.
constexpr double kMaxGap = 2e-4;         // [m]
constexpr double kContactsWanted = 3.0;  // in the mean, hands with three fingers or more

constexpr const char* kColumns =
    "hand:<24|object:<20|force closures:>14|of:>4|best epsilon:>12.4f|contacts:>8.1f|links:>5.1f|"
    "fewest fingers:>14|postures:>8|penetrating:>11|deepest [mm]:>12.4f|largest gap [mm]:>16.4f|"
    "seconds:>7.1f|rejected:<1";

/// Means of contacts and links, and the fewest fingers, are over the force closures; penetration
/// and gaps over all final postures, by the independent check.
json rowOf(const PlanRun& run)
{
    const grasp::HandModel& hand = run.hand.hand;
    const std::size_t closures = tools::forceClosures(run.grasps);
    int postures = 0;
    int penetrating = 0;
    double deepest = 0.0;  // [m]
    double gap = 0.0;      // [m]
    double epsilon = 0.0;
    double contacts = 0.0;
    double links = 0.0;
    int fingers = static_cast<int>(hand.fingers.size());
    for (const Grasp& g : run.grasps)
    {
        if (g.positions.empty())
        {
            continue;
        }
        const tools::GraspAudit audit = tools::auditGrasp(hand, run.object.object, g);
        ++postures;
        penetrating += audit.penetration.clean() ? 0 : 1;
        deepest = std::max(deepest, audit.penetration.deepest);
        gap = std::max({gap, audit.largestGap, audit.largestOffset});
        if (g.reject == grasp::RejectReason::None)
        {
            epsilon = std::max(epsilon, g.quality.epsilon);
            contacts += static_cast<double>(g.contacts.size());
            links += audit.links;
            fingers = std::min(fingers, audit.fingers);
        }
    }
    json row{{"hand", run.hand.file.stem().string()},
             {"object", run.object.object.name},
             {"fingers", hand.fingers.size()},
             {"force closures", closures},
             {"of", run.grasps.size()},
             {"postures", postures},
             {"penetrating", penetrating},
             {"deepest [mm]", 1e3 * deepest},
             {"largest gap [mm]", 1e3 * gap},
             {"seconds", run.seconds},
             {"rejected", tools::rejectionCounts(run.grasps)}};
    if (closures > 0)
    {
        const auto count = static_cast<double>(closures);
        row.update({{"best epsilon", epsilon},
                    {"contacts", contacts / count},
                    {"links", links / count},
                    {"fewest fingers", fingers}});
    }
    return row;
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

Verdicts criteria(const std::vector<json>& rows)
{
    std::map<std::string, std::vector<json>> byHand;
    int penetrating = 0;
    double gap = 0.0;  // [mm]
    for (const json& row : rows)
    {
        byHand[row["hand"].get<std::string>()].push_back(row);
        penetrating += row["penetrating"].get<int>();
        gap = std::max(gap, row["largest gap [mm]"].get<double>());
    }
    std::size_t goodHands = 0;
    Verdicts verdicts;
    for (const auto& [hand, ofHand] : byHand)
    {
        std::size_t objects = 0;
        double grasps = 0.0;
        double contacts = 0.0;
        double links = 0.0;
        const int fingers = ofHand.front()["fingers"];
        int fewest = fingers;
        for (const json& row : ofHand)
        {
            const double count = row["force closures"];
            if (count > 0.0)
            {
                ++objects;
                grasps += count;
                contacts += count * row["contacts"].get<double>();
                links += count * row["links"].get<double>();
                fewest = std::min(fewest, row["fewest fingers"].get<int>());
            }
        }
        // Four of six objects, and the same share of other numbers.
        goodHands += 3 * objects >= 2 * ofHand.size() ? 1U : 0U;
        const bool holds =
            grasps > 0.0 && (fingers < 3 ? fewest >= 2 : contacts / grasps >= kContactsWanted);
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
    verdicts.add(gap <= 1e3 * kMaxGap, fmt::format("largest gap of a contact {:.4f} mm", gap));
    return verdicts;
}
}  // namespace

bool tableGrasps(const TableOptions& options)
{
    // Everything is resolved before anything is planned: a misspelt name must not cost an hour.
    for (const std::string& hand : options.hands)
    {
        static_cast<void>(tools::resolveHand(hand));
    }
    for (const std::string& object : options.objects)
    {
        static_cast<void>(tools::resolveObject(object));
    }
    std::optional<tools::OutputFolder> output;
    if (!options.output.empty())
    {
        output.emplace(options.output);
    }
    const Table table(kColumns);
    std::vector<json> rows;
    for (const std::string& hand : options.hands)
    {
        for (const std::string& object : options.objects)
        {
            PlanRun run{.hand = tools::loadNamedHand(hand),
                        .object = tools::loadNamedObject(object, options.objectScale)};
            tools::requireFingers(run.hand, options.planner.closing);
            tools::runPlan(run, options.planner, options.quiet);
            rows.push_back(rowOf(run));
            table.print(rows.back());
            if (output)
            {
                std::ofstream out(
                    output->stage(fmt::format("{}_{}.jsonl",
                                              rows.back()["hand"].get<std::string>(),
                                              rows.back()["object"].get<std::string>())));
                grasp::writeGrasps(out,
                                   {.handFile = run.hand.file,
                                    .srdfFile = run.hand.hand.srdfFile,
                                    .objectFile = run.object.file,
                                    .objectScale = options.objectScale,
                                    .options = options.planner},
                                   run.hand.hand,
                                   run.object.object,
                                   run.grasps);
            }
        }
    }
    const Verdicts verdicts = criteria(rows);
    fmt::print("\n{}", verdicts.text);
    if (output)
    {
        tools::TextTable text{.header = table.heads(), .rows = {}};
        for (const json& row : rows)
        {
            text.rows.push_back(table.cells(row));
        }
        std::ofstream(output->stage("table.csv")) << tools::csvText(text);
        std::ofstream(output->stage("table.md")) << tools::markdownText(text);
        output->commit();
        fmt::print("\nwritten: {} (table.csv, table.md, one .jsonl per row)\n",
                   output->folder().string());
    }
    return verdicts.allHold;
}
}  // namespace bullet_ccd::benchmarks
