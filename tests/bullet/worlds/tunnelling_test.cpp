#include "benchmarks/reference/bullet/tunnelling.h"

#include <gtest/gtest.h>

#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// Phases of a row that run here, of 50 in the whole table (benchmarks/run bullet-table).
constexpr int kPhases[] = {3, 28};

struct Count
{
    int runs = 0;
    int through = 0;
};

/// Half of the settings, others for each phase.
template <typename Judge>
Count runSlice(const TunnellingRow& row, Kind kind, const Judge& judge)
{
    Count count;
    for (std::size_t i = 0; i < row.settings.size(); ++i)
    {
        const int phase = kPhases[i % std::size(kPhases)];
        const RunOutcome outcome = row.run(kind, row.settings[i], phase / 50.0);
        ++count.runs;
        count.through += outcome.through ? 1 : 0;
        judge(outcome,
              row.name + ", speed " + std::to_string(row.settings[i].speed) + ", phase " +
                  std::to_string(phase));
    }
    return count;
}
}  // namespace

TEST(Tunnelling, StockWorldsLoseWhatIsFast)
{
    Count stock;
    Count stockCcd;
    for (const TunnellingRow& row : tunnellingRows())
    {
        const auto ignore = [](const RunOutcome&, const std::string&) {};
        const Count plain = runSlice(row, Kind::Stock, ignore);
        const Count ccd = runSlice(row, Kind::StockCcd, ignore);
        stock.runs += plain.runs;
        stock.through += plain.through;
        stockCcd.through += ccd.through;
    }
    // The control: without these losses the test below would prove nothing.
    EXPECT_GT(stock.through, stock.runs / 2);
    EXPECT_GT(stockCcd.through, stock.runs / 4);
}

class EveryRow : public testing::TestWithParam<Kind>
{
};

TEST_P(EveryRow, LetsNothingThroughAndStopsNothingInTheAir)
{
    for (const TunnellingRow& row : tunnellingRows())
    {
        runSlice(row,
                 GetParam(),
                 [](const RunOutcome& outcome, const std::string& where)
                 {
                     EXPECT_FALSE(outcome.through) << where;
                     EXPECT_FALSE(isGhostStop(outcome)) << where << ": " << outcome.closest;
                 });
    }
}

INSTANTIATE_TEST_SUITE_P(Tunnelling,
                         EveryRow,
                         testing::ValuesIn(kOurKinds),
                         [](const testing::TestParamInfo<Kind>& test)
                         { return std::string(codeOf(test.param)); });
}  // namespace bullet_ccd::tests
