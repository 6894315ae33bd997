/// Every case of the stability catalogue through this library, FCL and Bullet: tables of verdicts,
/// and JSON for benchmarks/run stability.
#include "benchmarks/reference/catalogue/catalogue.h"
#include "benchmarks/stability/catalogue_run.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    CatalogueOptions options;
    std::string output;
    bool list = false;
    bool quick = false;
    const auto run = [&]
    {
        if (list)
        {
            fmt::print("{}", bullet_ccd::reference::catalogueTable());
            return true;
        }
        options.relations = !output.empty();
        options.firstVariantOnly = quick;
        options.variantLimit = quick ? 2.0 : options.variantLimit;
        const nlohmann::json measured = runCatalogue(options);
        if (!output.empty())
        {
            writeReport(output, measured);
        }
        return measured["failures"].empty();
    };
    return runProgram(
        argc,
        argv,
        {.name = "stability_catalogue",
         .about = "The cases of the stability catalogue through this library, FCL and Bullet.\n"
                  "pass: not late, and early by at most the case's tolerance, for peers by 1e-4 of "
                  "the motion if that is more; -: not applicable. It fails if this library fails a "
                  "case.",
         .options = {{"-o,--output", &output, "JSON file to write, with the relations"},
                     {"--limit", &options.limit, "seconds of processor time that a case may take"},
                     {"--only", &options.only, "one case, by its id"},
                     {"--quick", &quick, "one variant of each relation, seconds in all"},
                     {"--list", &list, "rows of the catalogue and where they are tested"}},
         .run = run});
}
