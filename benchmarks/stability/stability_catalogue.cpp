/// Every case of the stability catalogue through this library, FCL and Bullet; prints Markdown
/// tables of verdicts, or writes JSON for benchmarks/run stability.
#include "benchmarks/reference/catalogue/catalogue.h"
#include "benchmarks/stability/catalogue_run.h"
#include "benchmarks/support/report.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace
{
using namespace bullet_ccd::benchmarks;
using namespace bullet_ccd::reference;
using nlohmann::json;

/// A line per case, a column per method of the kind; sums.
std::string markdownOf(const json& table, const std::string& kind)
{
    std::string text = "| case | exact |";
    std::string line = "|---|--:|";
    for (const json& method : table["methods"])
    {
        if (method["kind"] == kind)
        {
            text += fmt::format(" {} |", method["name"].get<std::string>());
            line += "---|";
        }
    }
    text += "\n" + line + "\n";
    std::vector<std::map<std::string, int>> sums;
    for (const json& row : table["cases"])
    {
        if (row["kind"] != kind)
        {
            continue;
        }
        text += fmt::format(
            "| {} | {} |",
            row["id"].get<std::string>(),
            row["time"].is_null() ? "none" : fmt::format("{:.9g}", row["time"].get<double>()));
        sums.resize(row["answers"].size());
        for (std::size_t i = 0; i < row["answers"].size(); ++i)
        {
            const json& answer = row["answers"][i];
            const auto verdict = answer["verdict"].get<std::string>();
            const bool hasError =
                (verdict == "late" || verdict == "inaccurate") && answer["error"].is_number();
            text += fmt::format(
                " {}{} |",
                answer.contains("note") ? "-" : verdict,
                hasError ? fmt::format(" {:.1e}", std::abs(answer["error"].get<double>())) : "");
            ++sums[i][verdict];
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
    return sums.empty() ? "" : text + "\n\n";
}

/// Cases that a strategy of this library does not get right.
int failuresOfOurs(const json& table)
{
    int failures = 0;
    for (const json& row : table["cases"])
    {
        for (const json& answer : row["answers"])
        {
            const auto isOurs = [&](const json& method)
            {
                return method["owner"] == "ours" && method["kind"] == row["kind"] &&
                       method["name"] == answer["method"];
            };
            if (answer["verdict"] != "pass" &&
                std::ranges::any_of(table["methods"].begin(), table["methods"].end(), isOurs))
            {
                fmt::print(stderr,
                           "{}: {}: {}\n",
                           row["id"].get<std::string>(),
                           answer["method"].get<std::string>(),
                           answer["verdict"].get<std::string>());
                ++failures;
            }
        }
    }
    return failures;
}

int run(const CatalogueOptions& options, const std::string& output)
{
    const json table = runCatalogue(options);
    if (table["cases"].empty())
    {
        throw std::invalid_argument("--only " + options.only + ": no such case: see --list");
    }
    if (output.empty())
    {
        fmt::print("{}{}", markdownOf(table, "rigid"), markdownOf(table, "articulated"));
    }
    else
    {
        writeReport(output, table);
    }
    return failuresOfOurs(table) == 0 ? 0 : 1;
}
}  // namespace

int main(int argc, char** argv)
{
    CLI::App app{
        "The cases of the stability catalogue through this library, FCL 0.7 and Bullet: Markdown "
        "tables of verdicts, or JSON.\n"
        "pass: not late, and early by at most the case's tolerance, for peers by 1e-4 of the "
        "motion if that is more; -: not applicable. The exit code is 1 if this library fails a "
        "case."};
    CatalogueOptions options;
    std::string output;
    bool list = false;
    bool quick = false;
    app.add_option("-o,--output", output, "JSON file to write, with the relations");
    app.add_option("--limit", options.limit, "seconds of processor time that a case may take")
        ->check(CLI::Range(0.01, 600.0))
        ->capture_default_str();
    app.add_option("--only", options.only, "one case, by its id");
    app.add_flag("--quick", quick, "one variant of each relation, seconds instead of minutes");
    app.add_flag("--list", list, "rows of the catalogue and where they are tested");
    CLI11_PARSE(app, argc, argv);
    try
    {
        if (list)
        {
            fmt::print("{}", catalogueTable());
            return 0;
        }
        options.relations = !output.empty();
        if (options.relations && isatty(STDERR_FILENO) != 0)
        {
            options.progress = [](const std::string& id, std::size_t number, std::size_t count)
            { fmt::print(stderr, "\r{} of {}: {:<6}", number + 1, count, id); };
        }
        options.firstVariantOnly = quick;
        options.variantLimit = quick ? 2.0 : options.variantLimit;
        return run(options, output);
    }
    catch (const std::exception& error)
    {
        fmt::print(stderr, "stability_catalogue: {}\n", error.what());
        return 3;
    }
}
