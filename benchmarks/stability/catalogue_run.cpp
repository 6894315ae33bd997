#include "benchmarks/stability/catalogue_run.h"

#include "benchmarks/peers/bullet_peer.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/reference/catalogue/catalogue.h"
#include "benchmarks/reference/catalogue/relations.h"
#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/stability/catalogue_methods.h"
#include "benchmarks/support/sandbox.h"
#include "benchmarks/support/table.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;
using nlohmann::json;

/// What a code that is asked for a time may be early, and rounding of its times.
constexpr double kAllowedTime = 1e-4;
constexpr double kLate = 1e-9;
/// Variants of a case that may time out; the rest is not asked then.
constexpr int kPatience = 2;

RightTimes rightTimes(const CaseAnswer& exact, double rounding, bool isOurs)
{
    RightTimes right = rightTimes(exact, exact.finest(), rounding);
    if (!isOurs)
    {
        right.earliest = std::min(right.earliest, *exact.time - kAllowedTime);
        right.latest = std::max(right.latest, *exact.time + kLate + leadTime(exact, rounding));
    }
    return right;
}

std::string verdictOf(const Sandboxed<PeerAnswer>& asked,
                      const CaseAnswer& exact,
                      double rounding,
                      bool isOurs)
{
    const auto& [outcome, time, pairs] = asked.answer;
    if (asked.end != SandboxEnd::Answered)
    {
        return asked.end == SandboxEnd::Crashed ? "crashed" : "timed out";
    }
    if (outcome == PeerOutcome::GaveUp)
    {
        return "gave up";
    }
    if (!exact.time)
    {
        const bool isFalse =
            outcome == PeerOutcome::Contact && exact.clearance > 1.001 * exact.finest();
        return isFalse ? "false contact" : "pass";
    }
    if (outcome == PeerOutcome::Free)
    {
        return "missed";
    }
    const RightTimes right = rightTimes(exact, rounding, isOurs);
    if (!(time <= right.latest))  // not a number is late
    {
        return "late";
    }
    return time < right.earliest ? "inaccurate" : "pass";
}

/// The legs one after the other, until one has an answer.
template <typename Case>
PeerAnswer answerLegs(const Method<Case>& method, const Variant<Case>& variant)
{
    PeerAnswer sum;
    for (const Leg<Case>& leg : variant.legs)
    {
        const PeerAnswer answer = method.run(leg.tested);
        sum.pairs += answer.pairs;
        sum.outcome = answer.outcome;
        sum.time = leg.begin + (leg.end - leg.begin) * answer.time;
        if (answer.outcome != PeerOutcome::Free)
        {
            break;
        }
    }
    return sum;
}

/// A case that starts within the tolerance has no window; what is reported has to be that near, by
/// brute force.
bool isNear(const RigidCase& tested, double t)
{
    return oracleDistanceAt(oracleBody(tested.scene.meshA, tested.scene.motionA),
                            oracleBody(tested.scene.meshB, tested.scene.motionB),
                            t) <= 1.001 * tested.answer.finest() + roundingOf(tested);
}

/// No chain starts within the tolerance.
bool isNear(const ArticulatedCase&, double)
{
    return true;
}

template <typename Case>
struct AskedVariant
{
    Relation relation;
    Variant<Case> variant;
};

template <typename Case>
std::vector<AskedVariant<Case>> variantsToAsk(const Case& tested, const CatalogueOptions& options)
{
    std::vector<AskedVariant<Case>> asked;
    for (const Relation relation : kRelations)
    {
        for (Variant<Case>& variant : variantsOf(tested, relation))
        {
            asked.push_back({relation, std::move(variant)});
            if (options.firstVariantOnly)
            {
                break;
            }
        }
    }
    return asked;
}

/// Adds to `relations`, by name: variants that were asked, that kept their answers, and those lost;
/// of ours the largest shift of a time, in parts of what is right.
template <typename Case>
void runRelations(const Case& tested,
                  const Method<Case>& method,
                  double timeAsItIs,
                  const std::vector<AskedVariant<Case>>& asked,
                  double limit,
                  json& relations)
{
    const bool isOurs = method.owner == "ours";
    const auto answers = sandboxedAnswers<PeerAnswer>(
        asked.size(),
        {.seconds = limit, .patience = kPatience},
        [&](std::size_t i) { return answerLegs(method, asked[i].variant); });
    for (std::size_t i = 0; i < answers.size(); ++i)
    {
        const Variant<Case>& variant = asked[i].variant;
        double rounding = 0.0;
        for (const Leg<Case>& leg : variant.legs)
        {
            rounding = std::max(rounding, roundingOf(leg.tested));
        }
        json& count = relations[nameOf(asked[i].relation)];
        if (count.is_null())
        {
            count = {{"asked", 0}, {"kept", 0}, {"largestShift", 0.0}, {"lost", json::array()}};
        }
        const auto increase = [&count](const char* name)
        { count[name] = count[name].get<int>() + 1; };
        increase("asked");
        const std::string verdict = verdictOf(answers[i], variant.answer, rounding, isOurs);
        if (verdict != "pass")
        {
            count["lost"].push_back(
                {{"id", tested.id}, {"variant", variant.name}, {"verdict", verdict}});
            continue;
        }
        increase("kept");
        if (isOurs && variant.answer.time && !variant.answer.startsTouching)
        {
            const double window =
                *variant.answer.time - rightTimes(variant.answer, rounding, true).earliest;
            count["largestShift"] =
                std::max(count["largestShift"].get<double>(),
                         std::abs(answers[i].answer.time - timeAsItIs) / window);
        }
    }
}

template <typename Case>
json askMethod(const Case& tested, const Method<Case>& method, double limit)
{
    json row{
        {"method", method.name}, {"verdict", "not applicable"}, {"seconds", 0.0}, {"pairs", 0}};
    if (const std::string note = method.notApplicable(tested); !note.empty())
    {
        row["note"] = note;
        return row;
    }
    const Sandboxed<PeerAnswer> asked = sandboxedAnswers<PeerAnswer>(
        1, {.seconds = limit}, [&](std::size_t) { return method.run(tested); })[0];
    std::string verdict =
        verdictOf(asked, tested.answer, roundingOf(tested), method.owner == "ours");
    const bool isContact = asked.answer.outcome == PeerOutcome::Contact;
    if (verdict == "pass" && tested.answer.startsTouching && tested.answer.time &&
        !isNear(tested, asked.answer.time))
    {
        verdict = "inaccurate";
    }
    row["verdict"] = verdict;
    row["seconds"] = asked.seconds;
    row["pairs"] = asked.answer.pairs;
    if (isContact)
    {
        // Not a number has no JSON.
        const double time = asked.answer.time;
        row["time"] = std::isfinite(time) ? json(time) : json(nullptr);
        row["error"] =
            !std::isfinite(time) ? json(nullptr) : json(time - tested.answer.time.value_or(time));
    }
    return row;
}

/// The verdict, with the error of the time if that is what is wrong.
std::string cellOf(const json& answer)
{
    const auto verdict = answer["verdict"].get<std::string>();
    const bool hasError =
        (verdict == "late" || verdict == "inaccurate") && answer["error"].is_number();
    return answer.contains("note") ? "-"
           : hasError ? fmt::format("{} {:.1e}", verdict, std::abs(answer["error"].get<double>()))
                      : verdict;
}

template <typename Case>
void run(const std::string& kind,
         const std::vector<Case>& cases,
         const std::vector<Method<Case>>& methods,
         const CatalogueOptions& options,
         json& table)
{
    std::vector<json> methodRows;
    std::string columns = "case=id:<6|exact=time:>12.9g";
    for (const Method<Case>& method : methods)
    {
        columns += fmt::format("|{}:<18", method.name);
        methodRows.push_back({{"name", method.name},
                              {"owner", method.owner},
                              {"setting", method.setting},
                              {"kind", kind},
                              {"relations", json::object()}});
    }
    const Table printed(columns);
    std::vector<std::map<std::string, int>> sums(methods.size());
    for (const Case& tested : cases)
    {
        if (!options.only.empty() && options.only != tested.id)
        {
            continue;
        }
        const CaseAnswer& exact = tested.answer;
        const auto variants =
            options.relations ? variantsToAsk(tested, options) : std::vector<AskedVariant<Case>>{};
        const json time = exact.time ? json(*exact.time) : json(nullptr);
        json line{{"id", tested.id}, {"time", time}};
        json answers = json::array();
        for (std::size_t i = 0; i < methods.size(); ++i)
        {
            answers.push_back(askMethod(tested, methods[i], options.limit));
            const auto verdict = answers.back()["verdict"].get<std::string>();
            ++sums[i][verdict];
            line[methods[i].name] = cellOf(answers.back());
            if (verdict != "pass" && methods[i].owner == "ours")
            {
                table["failures"].push_back(
                    fmt::format("{} ({}: {})", tested.id, methods[i].name, verdict));
            }
            if (verdict == "pass" && !variants.empty())
            {
                runRelations(tested,
                             methods[i],
                             answers.back().value("time", 1.0),
                             variants,
                             options.variantLimit,
                             methodRows[i]["relations"]);
            }
        }
        printed.print(line);
        table["cases"].push_back({{"id", tested.id},
                                  {"kind", kind},
                                  {"group", tested.id.substr(0, 1)},
                                  {"groupTitle", groupTitle(tested.id)},
                                  {"title", tested.title},
                                  {"time", time},
                                  {"clearance", exact.clearance},
                                  {"closingSpeed", exact.closingSpeed},
                                  {"tolerance", exact.finest()},
                                  {"rounding", roundingOf(tested)},
                                  {"answers", std::move(answers)}});
    }
    for (std::size_t i = 0; i < methods.size(); ++i)
    {
        table["methods"].push_back(std::move(methodRows[i]));
        std::string counts;
        for (const auto& [verdict, count] : sums[i])
        {
            counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, verdict);
        }
        fmt::print("{}: {}: {}\n", kind, methods[i].name, counts);
    }
}
}  // namespace

json runCatalogue(const CatalogueOptions& options)
{
    json table{{"family", "catalogue"},
               {"title", "Contact times with exact answers, where known methods fail"},
               {"limit", options.limit},
               {"variantLimit", options.variantLimit},
               {"peers", {"FCL", "Bullet in double precision"}},
               {"defaultIterations", ToiOptions{}.maxIterations},
               {"relations", json::array()},
               {"methods", json::array()},
               {"cases", json::array()},
               {"failures", json::array()},
               {"elsewhere", json::array()}};
    for (const Relation relation : kRelations)
    {
        table["relations"].push_back(nameOf(relation));
    }
    for (const CatalogueRow& row : catalogueRows())
    {
        if (!row.tested.empty())
        {
            table["elsewhere"].push_back({{"id", row.id},
                                          {"groupTitle", groupTitle(row.id)},
                                          {"title", row.title},
                                          {"tested", row.tested}});
        }
    }
    run("rigid", rigidCases(), rigidMethods(), options, table);
    run("articulated", articulatedCases(), articulatedMethods(), options, table);
    if (table["cases"].empty())
    {
        throw std::invalid_argument("--only " + options.only + ": no such case: see --list");
    }
    for (const json& failure : table["failures"])
    {
        fmt::print("FAILED: {}\n", failure.get<std::string>());
    }
    return table;
}
}  // namespace bullet_ccd::benchmarks
