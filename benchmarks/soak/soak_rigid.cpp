/// Random and adversarial rigid queries, every answer judged by proof or counterexample. Exit code
/// 1 on any wrong answer, 2 if the run proves little, 3 if it could not be run.
#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/soak/soak_program.h"

namespace
{
using namespace bullet_ccd::tests;

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
    return soakProgram(
        {.program = "soak_rigid",
         .description = "Random and adversarial rigid queries, every answer judged "
                        "by proof or counterexample.",
         .families = soakFamilyNames(),
         .round = 480,
         .shares = {},
         .count = 1'000'000,
         .ask = ask,
         .print = [](std::ostream& out, std::uint64_t seed) { print(out, soakQuery(seed)); }},
        argc,
        argv);
}
