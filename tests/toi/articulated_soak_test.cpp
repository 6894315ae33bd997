/// A seeded part of the soak of random chains, every answer judged by brute force.
/// benchmarks/run soak articulated runs a hundred thousand of them.
#include "benchmarks/reference/queries/chain_queries.h"
#include "benchmarks/reference/queries/soak_tally.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "tests/support/test_data.h"
#include "tests/support/test_parameters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
const std::uint64_t kChains = longTests() ? 216 : 72;  // of each family

class ArticulatedToiSoak : public testing::TestWithParam<int>
{
};

TEST_P(ArticulatedToiSoak, IsNeverLateNeverMissesAndNeverInventsAContact)
{
    const auto family = static_cast<std::uint64_t>(GetParam());
    SoakTally tally;
    int selfHits = 0;
    for (std::uint64_t i = 0; i < kChains; ++i)
    {
        const std::uint64_t seed = family + kChainFamilies * i;
        const ChainQuery query = chainQuery(seed);
        ASSERT_EQ(static_cast<std::uint64_t>(query.family), family);
        const ChainOutcome outcome = runChainQuery(query);
        tally.add(outcome.result.status, outcome.judgement.verdict);
        selfHits += std::any_of(outcome.result.contacts.begin(),
                                outcome.result.contacts.end(),
                                [](const LinkContact& c) { return c.otherLink != kNone; })
                        ? 1
                        : 0;
        EXPECT_EQ(outcome.judgement.verdict, Verdict::Right)
            << outcome.judgement.text() << "\n  benchmarks/run soak articulated --seed " << seed
            << " --count 1 --verbose";
        ASSERT_LT(tally.wrong(), 5) << "and so on";
    }
    const std::vector<std::string> name{nameOf(static_cast<ChainFamily>(family))};
    EXPECT_EQ(vacuity({&tally, 1}, name, kChainShares), "");
    if (static_cast<ChainFamily>(family) == ChainFamily::SelfCollision)
    {
        EXPECT_EQ(selfHits, tally.hits + tally.overlapping);
    }
}

/// The same chains on paths of second to fifth degree, all families in turn.
TEST(ArticulatedToiSoakOfCurves, IsNeverLateNeverMissesAndNeverInventsAContact)
{
    const std::uint64_t count = longTests() ? 5000 : 40;
    SoakTally tally;
    for (std::uint64_t seed = 0; seed < count; ++seed)
    {
        ChainQuery query = chainQuery(seed);
        Random random(seed);
        addRandomCurves(random, 2.0, query.scene.motion);
        const ChainOutcome outcome = runChainQuery(query);
        tally.add(outcome.result.status, outcome.judgement.verdict);
        EXPECT_EQ(outcome.judgement.verdict, Verdict::Right)
            << outcome.judgement.text() << "\n  seed " << seed;
        ASSERT_LT(tally.wrong(), 5) << "and so on";
    }
    EXPECT_EQ(vacuity({&tally, 1}, std::vector<std::string>{"curves"}, kChainShares), "");
}

INSTANTIATE_TEST_SUITE_P(Families,
                         ArticulatedToiSoak,
                         testing::Range(0, static_cast<int>(kChainFamilies)),
                         [](const auto& tested)
                         { return withoutDashes(nameOf(static_cast<ChainFamily>(tested.param))); });
}  // namespace
}  // namespace bullet_ccd::tests
