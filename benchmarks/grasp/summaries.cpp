#include "benchmarks/grasp/closing_verdict.h"
#include "benchmarks/grasp/judged_rows.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

namespace bullet_ccd::benchmarks
{
namespace
{
using nlohmann::json;
using Rows = std::vector<json>;

constexpr double kAlikeShare = 0.95;  // of a hand's closings
constexpr double kFewClosings = 100;  // one that touches or not would decide the share of fewer

std::map<std::string, Rows> groupedBy(const char* key, const Rows& rows)
{
    std::map<std::string, Rows> groups;
    for (const json& row : rows)
    {
        groups[row[key].get<std::string>()].push_back(row);
    }
    return groups;
}

/// One entry per row.
std::vector<double> numbersOf(const Rows& rows, const char* key)
{
    std::vector<double> numbers;
    for (const json& row : rows)
    {
        numbers.push_back(row[key].get<double>());
    }
    return numbers;
}

double totalOf(const Rows& rows, const char* key)
{
    return sumOf(numbersOf(rows, key));
}

double largestOf(const Rows& rows, const char* key)
{
    return std::ranges::max(numbersOf(rows, key));
}

/// Sums of the numbers that stand below the key, such as those of the verdicts or of the reasons.
std::map<std::string, int> countsOf(const Rows& rows, const char* key)
{
    std::map<std::string, int> counts;
    for (const json& row : rows)
    {
        for (const auto& [name, number] : row[key].items())
        {
            counts[name] += number.get<int>();
        }
    }
    return counts;
}

/// Of one hand, or of all.
json closingTotals(const std::string& hand, const Rows& rows)
{
    std::map<std::string, int> verdicts = countsOf(rows, "verdicts");
    const auto of = [&](ClosingVerdict verdict) { return verdicts[toString(verdict)]; };
    const double closings = totalOf(rows, "closings");
    const double alike = closings == 0.0 ? 1.0 : of(ClosingVerdict::Alike) / closings;
    const double gap = largestOf(rows, "largest_gap_m");
    const double inside = totalOf(rows, "inside");
    const bool isGood = inside == 0.0 && gap <= largestOf(rows, "allowed_gap_m") &&
                        of(ClosingVerdict::FirstPasses) == 0 &&
                        of(ClosingVerdict::Unexplained) == 0 &&
                        (alike >= kAlikeShare || closings < kFewClosings);
    return {{"hand", hand},
            {"objects", rows.size()},
            {"closings", closings},
            {"alike", 100.0 * alike},
            {"touches", of(ClosingVerdict::Touches)},
            {"other", of(ClosingVerdict::OtherPasses)},
            {"ours", of(ClosingVerdict::FirstPasses)},
            {"unexplained", of(ClosingVerdict::Unexplained)},
            {"inside", inside},
            {"otherInside", totalOf(rows, "reference_inside")},
            {"gap", 1e3 * gap},
            {"difference", largestOf(rows, "largest_difference_rad")},
            {"ms", 1e3 * totalOf(rows, "seconds") / std::max(1.0, closings)},
            {"judged", isGood ? "pass" : "FAIL"}};
}

/// The objects that a hand does not hold, by the reason that rejected most of their candidates.
void printNotHeld(const std::string& hand, const Rows& rows)
{
    std::map<std::string, std::vector<std::string>> objects;
    for (const json& row : rows)
    {
        const std::map<std::string, int> rejected = countsOf({row}, "rejected");
        if (row["force_closures"] == 0 && !rejected.empty())
        {
            const auto most = std::ranges::max_element(
                rejected, {}, [](const auto& entry) { return entry.second; });
            objects[most->first].push_back(row["object"].get<std::string>());
        }
    }
    for (const auto& [reason, names] : objects)
    {
        fmt::print("{} does not hold {}, mostly {}: {}\n",
                   hand,
                   names.size(),
                   reason,
                   fmt::join(names, ", "));
    }
}

std::ptrdiff_t heldOf(const Rows& rows)
{
    return std::ranges::count_if(rows, [](const json& row) { return row["force_closures"] > 0; });
}

/// Force closures, in percent of the candidates.
double rateOf(const Rows& plans)
{
    return 100.0 * totalOf(plans, "force_closures") / std::max(1.0, totalOf(plans, "candidates"));
}

/// Force closures over the same number of candidates of one object, with and without its SRDF.
using Closures = std::pair<double, double>;

/// Of one hand; objects that were seen once only are left out.
std::vector<Closures> byObject(const Rows& with, const Rows& without)
{
    std::vector<Closures> closures;
    for (const json& row : with)
    {
        for (const json& other : without)
        {
            if (other["object"] == row["object"])
            {
                closures.emplace_back(row["force_closures"], other["force_closures"]);
            }
        }
    }
    return closures;
}

/// Of the sums, without over with.
double ratioOf(const std::vector<Closures>& closures)
{
    double with = 0.0;
    double without = 0.0;
    for (const auto& [first, second] : closures)
    {
        with += first;
        without += second;
    }
    return without == with ? 1.0 : without / with;
}

/// What the middle 95 % of the ratios are between when the objects are drawn anew.
std::pair<double, double> intervalOf(const std::vector<Closures>& closures)
{
    constexpr std::size_t kDraws = 2'000;
    reference::Random random(1);
    std::vector<double> ratios;
    for (std::size_t k = 0; k < kDraws; ++k)
    {
        std::vector<Closures> drawn = closures;
        for (Closures& one : drawn)
        {
            const int which = random.integer(0, static_cast<int>(closures.size()) - 1);
            one = closures[static_cast<std::size_t>(which)];
        }
        ratios.push_back(ratioOf(drawn));
    }
    std::ranges::sort(ratios);
    return {ratios[kDraws / 40], ratios[kDraws - kDraws / 40 - 1]};
}
}  // namespace

bool summarizeClosings(const Rows& rows)
{
    const Table table(
        "hand:<24|objects:>7|closings:>8.0f|alike [%]=alike:>9.2f|only touch=touches:>10|"
        "reference passes=other:>16|ours passes=ours:>11|unexplained:>11|"
        "ours inside=inside:>11.0f|reference inside=otherInside:>16.0f|"
        "largest gap [mm]=gap:>16.4f|largest difference [rad]=difference:>24.4f|"
        "ours [ms]=ms:>9.2f|judged:<6");
    bool isGood = true;
    for (const auto& [hand, ofHand] : groupedBy("hand", rows))
    {
        const json totals = closingTotals(hand, ofHand);
        isGood = isGood && totals["judged"] == "pass";
        table.print(totals);
    }
    table.print(closingTotals("all", rows));
    for (const json& row : rows)
    {
        for (const json& number : row["unexplained"])
        {
            fmt::print("unexplained: {} x {}, candidate {}\n",
                       row["hand"].get<std::string>(),
                       row["object"].get<std::string>(),
                       number.get<int>());
        }
    }
    return isGood;
}

bool summarizePlans(const Rows& rows)
{
    const Table table(
        "hand:<24|objects:>7|held:>5|force closures [%]=closures:>18.1f|"
        "median best epsilon=median:>19.4f|best epsilon=best:>12.4f|mean [s]=mean:>8.2f|"
        "longest [s]=longest:>11.2f");
    for (const auto& [hand, ofHand] : groupedBy("hand", rows))
    {
        table.print({{"hand", hand},
                     {"objects", ofHand.size()},
                     {"held", heldOf(ofHand)},
                     {"closures", rateOf(ofHand)},
                     {"median", medianOf(numbersOf(ofHand, "best_epsilon"))},
                     {"best", largestOf(ofHand, "best_epsilon")},
                     {"mean", meanOf(numbersOf(ofHand, "seconds"))},
                     {"longest", largestOf(ofHand, "seconds")}});
    }
    for (const auto& [hand, ofHand] : groupedBy("hand", rows))
    {
        printNotHeld(hand, ofHand);
    }
    const std::map<std::string, Rows> objects = groupedBy("object", rows);
    const auto held = std::ranges::count_if(
        objects, [](const auto& object) { return heldOf(object.second) > 0; });
    fmt::print("{} of {} objects are held by at least one hand\n", held, objects.size());
    return held > 0;
}

bool summarizeThumbed(const Rows& rows)
{
    static_cast<void>(summarizePlans(rows));
    std::vector<double> rates;  // [%]
    for (const auto& [hand, ofHand] : groupedBy("hand", rows))
    {
        rates.push_back(rateOf(ofHand));
    }
    const std::ptrdiff_t held = heldOf(rows);
    const bool isGood = meanOf(rates) >= 60.0 && 10 * held >= 9 * std::ssize(rows);
    fmt::print("mean of the hands: {:.1f} % force closures; ", meanOf(rates));
    fmt::print("{} of {} pairs held: {}\n", held, rows.size(), isGood ? "pass" : "FAIL");
    return isGood;
}

bool summarizeInference(const Rows& rows)
{
    constexpr double kInferred = 0.9;  // least share of the SRDF's rate
    constexpr double kInMean = 0.95;   // the same of all hands
    constexpr double kShipped = 0.97;  // least share of the inferred rate
    const Table table(
        "hand:<24|objects:>7|with SRDF [%]=with:>13.1f|without [%]=without:>11.1f|"
        "ratio:>14.2f|from:>6.2f|to:>6.2f|held with=heldWith:>9|"
        "held without=heldWithout:>12|judged:<16");
    std::map<std::string, Rows> hands = groupedBy("hand", rows);
    bool isGood = !hands.empty();
    std::vector<double> ratios;
    for (const auto& [hand, with] : hands)
    {
        if (hand.ends_with(kWithoutSrdf))
        {
            continue;
        }
        const Rows& without = hands.at(hand + kWithoutSrdf);
        const std::vector<Closures> closures = byObject(with, without);
        const double ratio = ratios.emplace_back(ratioOf(closures));
        const auto [from, to] = intervalOf(closures);
        const bool isInferred = ratio >= kInferred;
        const bool isShipped = ratio * kShipped <= 1.0;
        isGood = isGood && isInferred && isShipped;
        table.print({{"hand", hand},
                     {"objects", closures.size()},
                     {"with", rateOf(with)},
                     {"without", rateOf(without)},
                     {"ratio", ratio},
                     {"from", from},
                     {"to", to},
                     {"heldWith", heldOf(with)},
                     {"heldWithout", heldOf(without)},
                     {"judged",
                      !isInferred  ? "FAIL: inference"
                      : !isShipped ? "FAIL: SRDF"
                                   : "pass"}});
    }
    const double mean = meanOf(ratios);
    fmt::print("mean of the ratios: {:.2f}, {}\n", mean, mean >= kInMean ? "pass" : "FAIL");
    return isGood && mean >= kInMean;
}
}  // namespace bullet_ccd::benchmarks
