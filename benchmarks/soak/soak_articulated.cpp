/// Random chains of two to ten joints among obstacles, every answer of articulatedToi judged by
/// brute force.
#include "benchmarks/reference/queries/chain_queries.h"
#include "benchmarks/soak/soak.h"

#include <CLI/CLI.hpp>
#include <thread>

namespace
{
using namespace bullet_ccd::benchmarks;
using namespace bullet_ccd::reference;

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
    CLI::App app{
        "Random chains of two to ten joints among obstacles, every answer judged by brute force. "
        "Exit code 1 on any wrong answer, 2 if the run proves little, 3 if it could not be run."};
    SoakOptions options{.count = 100'000,
                        .quickCount = 2'000,
                        .jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency())),
                        .checkpoint = "soak_articulated.checkpoint"};
    addSoakOptions(app, options);
    CLI11_PARSE(app, argc, argv);
    return runSoak(
        {.program = "benchmarks/run soak articulated",
         .families = chainFamilyNames(),
         .round = kChainRound,
         .shares = kChainShares,
         .ask = ask,
         .print = [](std::ostream& out, std::uint64_t seed) { print(out, chainQuery(seed)); }},
        options);
}
