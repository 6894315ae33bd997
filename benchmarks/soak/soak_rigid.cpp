/// Random and adversarial rigid queries, every answer judged by proof or counterexample.
#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/soak/soak.h"

#include <CLI/CLI.hpp>
#include <thread>

namespace
{
using namespace bullet_ccd::benchmarks;
using namespace bullet_ccd::reference;

SoakAnswer ask(std::uint64_t seed)
{
    const SoakQuery query = soakQuery(seed);
    const SoakOutcome outcome = runSoakQuery(query);
    return {.family = static_cast<std::size_t>(query.family),
            .status = outcome.result.status,
            .time = outcome.result.time,
            .gap = outcome.result.gap,
            .judgement = outcome.judgement};
}
}  // namespace

int main(int argc, char** argv)
{
    CLI::App app{
        "Random and adversarial rigid queries, every answer judged by proof or counterexample. "
        "Exit code 1 on any wrong answer, 2 if the run proves little, 3 if it could not be run."};
    SoakOptions options{.count = 1'000'000,
                        .quickCount = 20'000,
                        .jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency())),
                        .checkpoint = "soak_rigid.checkpoint"};
    addSoakOptions(app, options);
    CLI11_PARSE(app, argc, argv);
    return runSoak(
        {.program = "benchmarks/run soak rigid",
         .families = soakFamilyNames(),
         .round = 480,
         .ask = ask,
         .print = [](std::ostream& out, std::uint64_t seed) { print(out, soakQuery(seed)); }},
        options);
}
