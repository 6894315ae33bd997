#include "tools/grasp_cli/bench_summary.h"

#include "tools/grasp_cli/closing_verdict.h"
#include "tools/grasp_cli/text_table.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>

namespace bullet_ccd::tools
{
namespace
{
using nlohmann::json;

constexpr double kMaxBenchGap = 1e-4;  // [m]
constexpr double kAlikeShare = 0.95;   // of a hand's closings, against the simulation

double medianOf(std::vector<double> values)
{
    if (values.empty())
    {
        return 0.0;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

std::map<std::string, std::vector<const json*>> byHand(const std::vector<json>& rows)
{
    std::map<std::string, std::vector<const json*>> hands;
    for (const json& row : rows)
    {
        hands[row["hand"].get<std::string>()].push_back(&row);
    }
    return hands;
}

/// Of one hand, or of all.
struct ClosingTotals
{
    std::size_t objects = 0;
    int closings = 0;
    std::array<int, kClosingVerdicts> verdicts{};
    int inside = 0;
    int referenceInside = 0;
    double gap = 0.0;
    double difference = 0.0;
    double seconds = 0.0;

    void add(const json& row)
    {
        ++objects;
        closings += row["closings"].get<int>();
        inside += row["inside"].get<int>();
        referenceInside += row["reference_inside"].get<int>();
        gap = std::max(gap, row["largest_gap_m"].get<double>());
        difference = std::max(difference, row["largest_difference_rad"].get<double>());
        seconds += row["seconds"].get<double>();
        for (int i = 0; i < kClosingVerdicts; ++i)
        {
            verdicts[static_cast<std::size_t>(i)] +=
                row["verdicts"][toString(static_cast<ClosingVerdict>(i))].get<int>();
        }
    }
    [[nodiscard]] int of(ClosingVerdict verdict) const
    {
        return verdicts[static_cast<std::size_t>(verdict)];
    }
    [[nodiscard]] double alike() const
    {
        return closings == 0 ? 1.0 : static_cast<double>(of(ClosingVerdict::Alike)) / closings;
    }
    [[nodiscard]] bool good() const
    {
        return inside == 0 && gap <= kMaxBenchGap && of(ClosingVerdict::FirstPasses) == 0 &&
               of(ClosingVerdict::Unexplained) == 0 && alike() >= kAlikeShare;
    }
    [[nodiscard]] std::vector<std::string> cells(const std::string& name) const
    {
        return {name,
                fmt::format("{}", objects),
                fmt::format("{}", closings),
                fmt::format("{:.2f}", 100.0 * alike()),
                fmt::format("{}", of(ClosingVerdict::Touches)),
                fmt::format("{}", of(ClosingVerdict::OtherPasses)),
                fmt::format("{}", of(ClosingVerdict::FirstPasses)),
                fmt::format("{}", of(ClosingVerdict::Unexplained)),
                fmt::format("{}", inside),
                fmt::format("{}", referenceInside),
                fmt::format("{:.4f}", 1e3 * gap),
                fmt::format("{:.4f}", difference),
                fmt::format("{:.2f}", closings == 0 ? 0.0 : 1e3 * seconds / closings),
                good() ? "pass" : "FAIL"};
    }
};
}  // namespace

BenchSummary summarizeClosings(const std::vector<json>& rows)
{
    BenchSummary summary;
    TextTable table{.header = {"hand",
                               "objects",
                               "closings",
                               "alike [%]",
                               "only touch",
                               "reference passes",
                               "ours passes",
                               "unexplained",
                               "ours inside",
                               "reference inside",
                               "largest gap [mm]",
                               "largest difference [rad]",
                               "ours [ms]",
                               "judged"},
                    .rows = {}};
    ClosingTotals all;
    for (const auto& [hand, ofHand] : byHand(rows))
    {
        ClosingTotals totals;
        for (const json* row : ofHand)
        {
            totals.add(*row);
            all.add(*row);
        }
        summary.good = summary.good && totals.good();
        table.rows.push_back(totals.cells(hand));
    }
    table.rows.push_back(all.cells("all"));
    summary.text = alignedText(table);
    for (const json& row : rows)
    {
        for (const json& number : row["unexplained"])
        {
            summary.text += fmt::format("unexplained: {} x {}, candidate {}\n",
                                        row["hand"].get<std::string>(),
                                        row["object"].get<std::string>(),
                                        number.get<int>());
        }
    }
    return summary;
}

namespace
{
/// The objects that a hand does not hold, by the reason that rejected most of their candidates.
std::string notHeldBy(const std::string& hand, const std::vector<const json*>& rows)
{
    std::map<std::string, std::vector<std::string>> objects;
    for (const json* row : rows)
    {
        const json& rejected = (*row)["rejected"];
        if ((*row)["force_closures"].get<int>() == 0 && !rejected.empty())
        {
            std::string most = rejected.begin().key();
            for (const auto& [reason, number] : rejected.items())
            {
                most = number.get<int>() > rejected[most].get<int>() ? reason : most;
            }
            objects[most].push_back((*row)["object"].get<std::string>());
        }
    }
    std::string text;
    for (const auto& [reason, names] : objects)
    {
        text += fmt::format("{} does not hold {}, mostly {}: {}\n",
                            hand,
                            names.size(),
                            reason,
                            joined(names, ", "));
    }
    return text;
}

/// All that is known of an object that no hand holds.
std::string lineOf(const std::string& object, const std::vector<const json*>& rows)
{
    std::map<std::string, int> reasons;
    int candidates = 0;
    double best = 0.0;
    for (const json* row : rows)
    {
        candidates += (*row)["candidates"].get<int>();
        best = std::max(best, (*row)["best_epsilon"].get<double>());
        for (const auto& [reason, number] : (*row)["rejected"].items())
        {
            reasons[reason] += number.get<int>();
        }
    }
    std::vector<std::string> texts;
    for (const auto& [reason, number] : reasons)
    {
        texts.push_back(fmt::format("{} {}", number, reason));
    }
    return fmt::format("no hand holds {}: best epsilon {:.4f}; of {} candidates {}\n",
                       object,
                       best,
                       candidates,
                       joined(texts, ", "));
}
}  // namespace

BenchSummary summarizePlans(const std::vector<json>& rows)
{
    BenchSummary summary;
    TextTable table{.header = {"hand",
                               "objects",
                               "held",
                               "force closures [%]",
                               "median best epsilon",
                               "best epsilon",
                               "mean [s]",
                               "longest [s]"},
                    .rows = {}};
    std::map<std::string, std::vector<const json*>> objects;
    std::map<std::string, bool> held;
    for (const json& row : rows)
    {
        const std::string object = row["object"].get<std::string>();
        objects[object].push_back(&row);
        held[object] = held[object] || row["force_closures"].get<int>() > 0;
    }
    std::string notHeld;
    for (const auto& [hand, ofHand] : byHand(rows))
    {
        notHeld += notHeldBy(hand, ofHand);
        int heldObjects = 0;
        double closures = 0.0;
        double candidates = 0.0;
        double seconds = 0.0;
        double longest = 0.0;
        std::vector<double> epsilons;
        for (const json* row : ofHand)
        {
            const int found = (*row)["force_closures"].get<int>();
            heldObjects += found > 0 ? 1 : 0;
            closures += found;
            candidates += (*row)["candidates"].get<double>();
            seconds += (*row)["seconds"].get<double>();
            longest = std::max(longest, (*row)["seconds"].get<double>());
            epsilons.push_back((*row)["best_epsilon"].get<double>());
        }
        table.rows.push_back(
            {hand,
             fmt::format("{}", ofHand.size()),
             fmt::format("{}", heldObjects),
             fmt::format("{:.1f}", 100.0 * closures / std::max(1.0, candidates)),
             fmt::format("{:.4f}", medianOf(epsilons)),
             fmt::format("{:.4f}", *std::max_element(epsilons.begin(), epsilons.end())),
             fmt::format("{:.2f}", seconds / static_cast<double>(ofHand.size())),
             fmt::format("{:.2f}", longest)});
    }
    const auto count =
        std::count_if(held.begin(), held.end(), [](const auto& object) { return object.second; });
    summary.text = fmt::format("{}\n{}\n{} of {} objects are held by at least one hand\n",
                               alignedText(table),
                               notHeld,
                               count,
                               held.size());
    for (const auto& [object, isHeld] : held)
    {
        if (!isHeld)
        {
            summary.text += lineOf(object, objects[object]);
        }
    }
    summary.good = count > 0;
    return summary;
}
}  // namespace bullet_ccd::tools
