/// Random queries, one per seed: rigid ones judged by proof or counterexample, chains by brute
/// force.
#include "benchmarks/reference/queries/soak_queries.h"

#include "benchmarks/reference/queries/chain_queries.h"
#include "benchmarks/reference/queries/convex_queries.h"
#include "benchmarks/soak/soak.h"

#include <algorithm>
#include <thread>

namespace
{
using namespace bullet_ccd::benchmarks;
using namespace bullet_ccd::reference;

template <typename Query, typename Outcome>
SoakAnswer answerOf(const Query& query, const Outcome& outcome, double gap)
{
    return {.family = static_cast<std::size_t>(query.family),
            .status = outcome.result.status,
            .time = outcome.result.time,
            .gap = gap,
            .judgement = outcome.judgement};
}

SoakSubject rigidSoak()
{
    return {.program = "benchmarks/run soak rigid",
            .families = soakFamilyNames(),
            .round = 480,
            .ask =
                [](std::uint64_t seed)
            {
                const SoakQuery query = soakQuery(seed);
                const SoakOutcome outcome = runSoakQuery(query);
                return answerOf(query, outcome, outcome.result.gap);
            },
            .print = [](std::ostream& out, std::uint64_t seed) { print(out, soakQuery(seed)); }};
}

SoakSubject convexSoak()
{
    return {.program = "benchmarks/run soak convex",
            .families = convexFamilyNames(),
            .round = 480,
            .ask =
                [](std::uint64_t seed)
            {
                const ConvexQueryCase query = convexQuery(seed);
                const bullet_ccd::ToiResult result =
                    convexToi(query.body(0), query.body(1), query.options);
                return SoakAnswer{.family = static_cast<std::size_t>(query.family),
                                  .status = result.status,
                                  .time = result.time,
                                  .gap = result.gap,
                                  .judgement = judgeConvex(query, result)};
            },
            .print = [](std::ostream& out, std::uint64_t seed) { print(out, convexQuery(seed)); }};
}

SoakSubject chainSoak()
{
    return {.program = "benchmarks/run soak articulated",
            .families = chainFamilyNames(),
            .round = kChainRound,
            .shares = kChainShares,
            .ask =
                [](std::uint64_t seed)
            {
                const ChainQuery query = chainQuery(seed);
                const ChainOutcome outcome = runChainQuery(query);
                const auto& contacts = outcome.result.contacts;
                return answerOf(query, outcome, contacts.empty() ? 0.0 : contacts.front().gap);
            },
            .print = [](std::ostream& out, std::uint64_t seed) { print(out, chainQuery(seed)); }};
}
}  // namespace

int main(int argc, char** argv)
{
    const int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    return runProgram(
        argc,
        argv,
        {.name = "soak_queries",
         .about = "Random queries, every answer judged.",
         .options = {},
         .verbs = {soakProgram("rigid",
                               "random and adversarial pairs, by proof or counterexample",
                               {.count = 1'000'000,
                                .quickCount = 20'000,
                                .jobs = jobs,
                                .checkpoint = "soak_rigid.checkpoint"},
                               [](bool) { return rigidSoak(); }),
                   soakProgram("convex",
                               "exact convex shapes, by proof or counterexample on triangles",
                               {.count = 1'000'000,
                                .quickCount = 20'000,
                                .jobs = jobs,
                                .checkpoint = "soak_convex.checkpoint"},
                               [](bool) { return convexSoak(); }),
                   soakProgram("articulated",
                               "chains of two to ten joints among obstacles, by brute force",
                               {.count = 100'000,
                                .quickCount = 2'000,
                                .jobs = jobs,
                                .checkpoint = "soak_articulated.checkpoint"},
                               [](bool) { return chainSoak(); })}});
}
