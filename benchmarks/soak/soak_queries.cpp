/// Random queries, one per seed: rigid ones judged by proof or counterexample, chains by brute
/// force.
#include "benchmarks/reference/queries/soak_queries.h"

#include "benchmarks/reference/queries/accuracy_queries.h"
#include "benchmarks/reference/queries/chain_queries.h"
#include "benchmarks/reference/queries/convex_queries.h"
#include "benchmarks/reference/queries/trajectory_queries.h"
#include "benchmarks/soak/soak.h"

#include <algorithm>
#include <iterator>
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

/// By turns detailed meshes, adversarial pairs and chains, all of which any gap within the
/// tolerance will do for.
SoakSubject accuracySoak()
{
    std::vector<std::string> families = accuracySizes();
    const std::size_t sizes = families.size();
    std::ranges::copy(soakFamilyNames(), std::back_inserter(families));
    std::ranges::copy(chainFamilyNames(), std::back_inserter(families));
    return {.program = "benchmarks/run soak accuracy",
            .families = families,
            .round = 1440,
            .shares = {.leastHits = 0, .leastFree = 0, .mostOverlapping = 100},
            .ask =
                [sizes](std::uint64_t seed)
            {
                SoakAnswer answer;
                if (seed % 3 == 0)
                {
                    const AccuracyQuery query = accuracyQuery(seed / 3);
                    const AccuracyOutcome outcome = runAccuracyQuery(query);
                    return SoakAnswer{.family = query.sizeA,
                                      .status = outcome.result.status,
                                      .time = outcome.result.time,
                                      .gap = outcome.result.gap,
                                      .judgement = outcome.judgement};
                }
                if (seed % 3 == 1)
                {
                    SoakQuery query = soakQuery(seed / 3);
                    query.options.anyWithin = true;
                    const SoakOutcome outcome = runSoakQuery(query);
                    answer = answerOf(query, outcome, outcome.result.gap);
                    answer.family += sizes;
                    return answer;
                }
                ChainQuery query = chainQuery(seed / 3);
                query.options.toi.anyWithin = true;
                const ChainOutcome outcome = runChainQuery(query);
                const auto& contacts = outcome.result.contacts;
                answer = answerOf(query, outcome, contacts.empty() ? 0.0 : contacts.front().gap);
                answer.family += sizes + kSoakFamilies;
                return answer;
            },
            .print =
                [](std::ostream& out, std::uint64_t seed)
            {
                seed % 3 == 0   ? print(out, accuracyQuery(seed / 3))
                : seed % 3 == 1 ? print(out, soakQuery(seed / 3))
                                : print(out, chainQuery(seed / 3));
            }};
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

SoakSubject trajectorySoak()
{
    return {
        .program = "benchmarks/run soak trajectories",
        .families = trajectoryKindNames(),
        .round = kTrajectoryRound,
        .shares = kChainShares,
        .ask =
            [](std::uint64_t seed)
        {
            const TrajectoryQuery query = trajectoryQuery(seed);
            return answerOf(query, runTrajectoryQuery(query), 0.0);
        },
        .print = [](std::ostream& out, std::uint64_t seed) { print(out, trajectoryQuery(seed)); }};
}
}  // namespace

int main(int argc, char** argv)
{
    Program program{
        .name = "soak_queries", .about = "Random queries, every answer judged.", .options = {}};
    const int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    const auto add = [&](const std::string& name, int count, int quick, auto subject, auto about)
    {
        const std::string checkpoint = "soak_" + name + ".checkpoint";
        program.verbs.push_back(soakProgram(
            name, about, {count, quick, jobs, checkpoint}, [=](bool) { return subject(); }));
    };
    add("rigid", 1'000'000, 20'000, rigidSoak, "adversarial pairs, by proof or counterexample");
    add("accuracy", 100'000, 1'440, accuracySoak, "any gap within an accuracy, on full meshes");
    add("convex", 1'000'000, 20'000, convexSoak, "exact convex shapes, by proof on triangles");
    add("articulated", 100'000, 2'000, chainSoak, "chains of joints, by brute force");
    add("trajectories", 100'000, 720, trajectorySoak, "trajectories of chains, the same");
    return runProgram(argc, argv, program);
}
