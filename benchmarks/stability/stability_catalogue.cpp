/// Every case of the stability catalogue through this library, FCL and Bullet; prints Markdown
/// tables of verdicts, or writes JSON for benchmarks/run stability.
#include "benchmarks/reference/catalogue/catalogue.h"
#include "benchmarks/stability/catalogue_text.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <unistd.h>

namespace
{
using namespace bullet_ccd::tests;

void writeFile(const std::string& path, const std::string& text)
{
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file)
    {
        throw std::runtime_error(path + ": cannot be written: check the folder and its space");
    }
}

/// Cases that a strategy of this library does not get right.
int failuresOfOurs(const CatalogueTable& table)
{
    int failures = 0;
    for (const CaseRow& row : table.cases)
    {
        for (std::size_t i = 0; i < row.answers.size(); ++i)
        {
            if (table.methods[i].owner == "ours" && row.answers[i].verdict != CaseVerdict::Pass)
            {
                std::fprintf(stderr,
                             "%s: %s: %s\n",
                             row.id.c_str(),
                             table.methods[i].name.c_str(),
                             nameOf(row.answers[i].verdict));
                ++failures;
            }
        }
    }
    return failures;
}

int run(const CatalogueOptions& options, const std::string& output)
{
    for (const auto& [name, present] :
         {std::pair{"FCL", hasFcl()}, std::pair{"Bullet (double precision)", hasBullet()}})
    {
        if (!present)
        {
            std::fprintf(stderr, "stability_catalogue: built without %s\n", name);
        }
    }
    const std::array<CatalogueTable, 2> tables{runRigidCatalogue(options),
                                               runArticulatedCatalogue(options)};
    if (std::all_of(tables.begin(),
                    tables.end(),
                    [](const CatalogueTable& table) { return table.cases.empty(); }))
    {
        throw std::invalid_argument("--only " + options.only + ": no such case: see --list");
    }
    int failures = 0;
    for (const CatalogueTable& table : tables)
    {
        if (output.empty() && !table.cases.empty())
        {
            std::fputs((toMarkdown(table) + "\n").c_str(), stdout);
        }
        failures += failuresOfOurs(table);
    }
    if (!output.empty())
    {
        writeFile(output, toJson(tables, options).dump(1) + "\n");
    }
    return failures == 0 ? 0 : 1;
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
            std::fputs(catalogueTable().c_str(), stdout);
            return 0;
        }
        options.relations = !output.empty();
        if (options.relations && isatty(STDERR_FILENO) != 0)
        {
            options.progress = [](const std::string& id, std::size_t number, std::size_t count)
            { std::fprintf(stderr, "\r%zu of %zu: %-6s", number + 1, count, id.c_str()); };
        }
        options.firstVariantOnly = quick;
        options.variantLimit = quick ? 2.0 : options.variantLimit;
        return run(options, output);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "stability_catalogue: %s\n", error.what());
        return 3;
    }
}
