/// A seeded part of the soak: random and adversarial queries, every answer judged by proof or
/// counterexample. benchmarks/run soak rigid runs a million of them.
#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/reference/queries/soak_tally.h"
#include "tests/support/test_data.h"
#include "tests/support/test_parameters.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
const std::uint64_t kQueries = longTests() ? 1260 : 420;  // of each family

class RigidToiSoak : public testing::TestWithParam<int>
{
};

TEST_P(RigidToiSoak, IsNeverLateNeverMissesAndNeverInventsAContact)
{
    const auto family = static_cast<std::uint64_t>(GetParam());
    SoakTally tally;
    for (std::uint64_t i = 0; i < kQueries; ++i)
    {
        const std::uint64_t seed = family + kSoakFamilies * i;
        const SoakQuery query = soakQuery(seed);
        ASSERT_EQ(static_cast<std::uint64_t>(query.family), family);
        const SoakOutcome outcome = runSoakQuery(query);
        tally.add(outcome.result.status, outcome.judgement.verdict);
        const Verdict verdict = outcome.judgement.verdict;
        EXPECT_TRUE(verdict == Verdict::Right || verdict == Verdict::Undecided)
            << outcome.judgement.text() << ", " << nameOf(query.options.strategy)
            << "\n  benchmarks/run soak rigid --seed " << seed << " --count 1 --verbose";
        ASSERT_LT(tally.wrong(), 5) << "and so on";
    }
    const std::vector<std::string> name{nameOf(static_cast<SoakFamily>(family))};
    EXPECT_EQ(vacuity({&tally, 1}, name, {}), "");
}

/// Queries that were once answered wrongly: gaps of slivers, gaps that were not the distance, the
/// time at which a search gave up, touching starts, hits where a step stalled.
TEST(RigidToiSoakCorpus, AnswersTheQueriesThatOnceFailed)
{
    for (const std::uint64_t seed : {193,
                                     385,
                                     1617,
                                     1960,
                                     2896,
                                     3518,
                                     446,
                                     1255,
                                     68179,
                                     97059,
                                     114723,
                                     121395,
                                     123491,
                                     222339,
                                     331347,
                                     781182,
                                     783582,
                                     805159})
    {
        const SoakQuery query = soakQuery(seed);
        const SoakOutcome outcome = runSoakQuery(query);
        EXPECT_EQ(outcome.judgement.verdict, Verdict::Right)
            << seed << ", " << nameOf(query.family) << ": " << outcome.judgement.text();
    }
}

INSTANTIATE_TEST_SUITE_P(Families,
                         RigidToiSoak,
                         testing::Range(0, static_cast<int>(kSoakFamilies)),
                         [](const auto& tested)
                         { return withoutDashes(nameOf(static_cast<SoakFamily>(tested.param))); });
}  // namespace
}  // namespace bullet_ccd::tests
