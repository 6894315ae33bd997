#include "benchmarks/stability/catalogue_text.h"

#include "benchmarks/reference/catalogue/catalogue.h"
#include "benchmarks/reference/catalogue/relations.h"

#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace bullet_ccd::tests
{
namespace
{
using nlohmann::json;

/// Not a number has no JSON.
json number(double value)
{
    return std::isfinite(value) ? json(value) : json(nullptr);
}

json toJson(const JudgedAnswer& judged, const MethodRow& method)
{
    json answer{{"method", method.name},
                {"verdict", nameOf(judged.verdict)},
                {"seconds", judged.answer.seconds},
                {"pairs", judged.answer.pairs}};
    if (judged.answer.outcome == PeerOutcome::Contact)
    {
        answer["time"] = number(judged.answer.time);
        answer["error"] = number(judged.error);
    }
    if (!judged.note.empty())
    {
        answer["note"] = judged.note;
    }
    return answer;
}

json toJson(const CaseRow& row, const std::vector<MethodRow>& methods)
{
    json answers = json::array();
    for (std::size_t i = 0; i < methods.size(); ++i)
    {
        answers.push_back(toJson(row.answers[i], methods[i]));
    }
    return {{"id", row.id},
            {"kind", row.kind},
            {"group", row.id.substr(0, 1)},
            {"groupTitle", groupTitle(row.id)},
            {"title", row.title},
            {"time", row.exact.time ? json(*row.exact.time) : json(nullptr)},
            {"clearance", row.exact.clearance},
            {"closingSpeed", row.exact.closingSpeed},
            {"tolerance", row.exact.finest()},
            {"rounding", row.rounding},
            {"answers", answers}};
}

json toJson(const MethodRow& method, const std::string& kind)
{
    json relations = json::object();
    for (const auto& [name, count] : method.relations)
    {
        json lost = json::array();
        for (const LostVariant& one : count.lost)
        {
            lost.push_back(
                {{"id", one.id}, {"variant", one.variant}, {"verdict", nameOf(one.verdict)}});
        }
        relations[name] = {{"asked", count.asked},
                           {"kept", count.kept},
                           {"largestShift", count.largestShift},
                           {"lost", lost}};
    }
    return {{"name", method.name},
            {"owner", method.owner},
            {"setting", method.setting},
            {"kind", kind},
            {"relations", relations}};
}
}  // namespace

json toJson(std::span<const CatalogueTable> tables, const CatalogueOptions& options)
{
    json methods = json::array();
    json cases = json::array();
    for (const CatalogueTable& table : tables)
    {
        for (const MethodRow& method : table.methods)
        {
            methods.push_back(toJson(method, table.kind));
        }
        for (const CaseRow& row : table.cases)
        {
            cases.push_back(toJson(row, table.methods));
        }
    }
    json relations = json::array();
    for (const Relation relation : kRelations)
    {
        relations.push_back(nameOf(relation));
    }
    json elsewhere = json::array();
    for (const CatalogueRow& row : catalogueRows())
    {
        if (!row.tested.empty())
        {
            elsewhere.push_back({{"id", row.id},
                                 {"groupTitle", groupTitle(row.id)},
                                 {"title", row.title},
                                 {"tested", row.tested}});
        }
    }
    return {{"family", "catalogue"},
            {"title", "Contact times with exact answers, where known methods fail"},
            {"compiler", BULLET_CCD_COMPILER},
            {"flags", BULLET_CCD_FLAGS},
            {"limit", options.limit},
            {"variantLimit", options.variantLimit},
            {"peers", {hasFcl() ? "FCL" : "", hasBullet() ? "Bullet in double precision" : ""}},
            {"defaultIterations", ToiOptions{}.maxIterations},
            {"relations", relations},
            {"methods", methods},
            {"cases", cases},
            {"elsewhere", elsewhere}};
}

std::string toMarkdown(const CatalogueTable& table)
{
    std::string text = "| case | exact |";
    std::string line = "|---|--:|";
    for (const MethodRow& method : table.methods)
    {
        text += fmt::format(" {} |", method.name);
        line += "---|";
    }
    text += "\n" + line + "\n";
    std::vector<std::map<std::string, int>> sums(table.methods.size());
    for (const CaseRow& row : table.cases)
    {
        text += fmt::format("| {} | {} |",
                            row.id,
                            row.exact.time ? fmt::format("{:.9g}", *row.exact.time) : "none");
        for (std::size_t i = 0; i < row.answers.size(); ++i)
        {
            const JudgedAnswer& judged = row.answers[i];
            const bool hasError =
                judged.verdict == CaseVerdict::Late || judged.verdict == CaseVerdict::Inaccurate;
            text += fmt::format(" {}{} |",
                                judged.note.empty() ? nameOf(judged.verdict) : "-",
                                hasError ? fmt::format(" {:.1e}", std::abs(judged.error)) : "");
            ++sums[i][nameOf(judged.verdict)];
        }
        text += "\n";
    }
    text += "| **sum** | |";
    for (const std::map<std::string, int>& sum : sums)
    {
        std::string cell;
        for (const auto& [verdict, count] : sum)
        {
            cell += fmt::format("{}{} {}", cell.empty() ? " " : ", ", count, verdict);
        }
        text += cell + " |";
    }
    return text + "\n";
}
}  // namespace bullet_ccd::tests
