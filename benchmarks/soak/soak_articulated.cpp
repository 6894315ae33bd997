/// Random chains of two to ten joints among obstacles, every answer of articulatedToi judged by
/// brute force. Exit code 1 on any wrong answer, 2 if the run proves little, 3 if it could not be
/// run.
#include "benchmarks/reference/queries/chain_queries.h"
#include "benchmarks/soak/soak_program.h"

namespace
{
using namespace bullet_ccd::tests;

SoakAnswer ask(std::uint64_t seed)
{
    const ChainQuery query = chainQuery(seed);
    const ChainOutcome outcome = runChainQuery(query);
    const bool touches = !outcome.result.contacts.empty();
    return {.family = static_cast<std::size_t>(query.family),
            .status = outcome.result.status,
            .time = outcome.result.time,
            .gap = touches ? outcome.result.contacts.front().gap : 0.0,
            .judgement = outcome.judgement};
}
}  // namespace

int main(int argc, char** argv)
{
    return soakProgram(
        {.program = "soak_articulated",
         .description = "Random chains of two to ten joints among obstacles, every "
                        "answer judged by brute force.",
         .families = chainFamilyNames(),
         .round = kChainRound,
         .shares = kChainShares,
         .count = 100'000,
         .ask = ask,
         .print = [](std::ostream& out, std::uint64_t seed) { print(out, chainQuery(seed)); }},
        argc,
        argv);
}
