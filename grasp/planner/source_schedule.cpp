#include "grasp/planner/source_schedule.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
/// What the sources are usually worth, relative to each other: of eight known hands on six
/// household objects, Sphere held most. Pinch has its part whatever it is worth.
constexpr std::array kUsualWorth{1.3, 1.0, 0.85, 1.0};
static_assert(kUsualWorth.size() == kMixedSources.size());
/// How much the best pair is preferred: a rate a tenth higher counts twenty times as much.
constexpr double kGreed = 32.0;
/// Trials that an expectation counts as, of a source or preshape and of a pair.
constexpr double kDoubt = 4.0;
constexpr double kDoubtOfPairs = 6.0;

/// Successes among trials; a rate begins at `before`, which counts as so many trials.
struct Rate
{
    double held = 0.0;
    double tried = 0.0;

    [[nodiscard]] double towards(double before, double trials) const
    {
        return (held + trials * before) / (tried + trials);
    }
};
}  // namespace

SourceSchedule::SourceSchedule(std::vector<std::size_t> preshapes, std::int64_t candidates)
    : m_preshapes(std::move(preshapes)),
      m_candidates(candidates),
      m_taken(kMixedSources.size() * m_preshapes.size(), 0),
      m_due(m_taken.size(), 0.0)
{
}

std::size_t SourceSchedule::pairOf(const ApproachTurn& turn) const
{
    const auto source = static_cast<std::size_t>(std::ranges::find(kMixedSources, turn.source) -
                                                 kMixedSources.begin());
    const auto preshape = static_cast<std::size_t>(std::ranges::find(m_preshapes, turn.preshape) -
                                                   m_preshapes.begin());
    return preshape * kMixedSources.size() + source;
}

std::vector<double> SourceSchedule::shares(const std::vector<char>& held) const
{
    const std::size_t sources = kMixedSources.size();
    std::vector<Rate> pairs(m_taken.size());
    std::vector<Rate> bySource(sources);
    std::vector<Rate> byPreshape(m_preshapes.size());
    Rate all;
    for (std::size_t number = 0; number < m_turns.size(); ++number)
    {
        const std::size_t pair = pairOf(m_turns[number]);
        const double success = held[number] != 0 ? 1.0 : 0.0;
        for (Rate* const rate :
             {&pairs[pair], &bySource[pair % sources], &byPreshape[pair / sources], &all})
        {
            rate->held += success;
            rate->tried += 1.0;
        }
    }
    // A coin's worth of doubt keeps rates off 0.
    const double overall = all.towards(0.5, 1.0);
    std::vector<double> weights(pairs.size());
    for (std::size_t pair = 0; pair < pairs.size(); ++pair)
    {
        const double ofSource = bySource[pair % sources].towards(
            std::min(1.0, kUsualWorth[pair % sources] * overall), kDoubt);
        const double ofPreshape = byPreshape[pair / sources].towards(overall, kDoubt);
        weights[pair] =
            pairs[pair].towards(std::min(1.0, ofSource * ofPreshape / overall), kDoubtOfPairs);
    }
    const double best = std::ranges::max(weights);
    for (double& weight : weights)
    {
        weight = std::pow(weight / best, kGreed);
    }
    // Pinches share out their part of the candidates among themselves, the others theirs.
    const auto groupOf = [&](std::size_t pair)
    { return kMixedSources[pair % sources] == ApproachSource::Pinch ? std::size_t{1} : 0; };
    std::array<double, 2> sums{};
    std::array<double, 2> counts{};
    for (std::size_t pair = 0; pair < weights.size(); ++pair)
    {
        sums[groupOf(pair)] += weights[pair];
        counts[groupOf(pair)] += 1.0;
    }
    constexpr std::array kParts{1.0 - kPinched, kPinched};
    for (std::size_t pair = 0; pair < weights.size(); ++pair)
    {
        const std::size_t group = groupOf(pair);
        weights[pair] =
            kParts[group] * ((1.0 - kAlike) * weights[pair] / sums[group] + kAlike / counts[group]);
    }
    return weights;
}

void SourceSchedule::extend(const std::vector<char>& held)
{
    const std::int64_t size = std::min(std::max(kFirstBlock, end() / 2), m_candidates - end());
    const std::vector<double> share = shares(held);
    for (std::int64_t k = 0; k < size; ++k)
    {
        // Each pair is owed its share of every candidate, also of earlier blocks; whom most is
        // owed, the first of equals, gets the next.
        for (std::size_t pair = 0; pair < share.size(); ++pair)
        {
            m_due[pair] += share[pair];
        }
        const auto next = static_cast<std::size_t>(std::ranges::max_element(m_due) - m_due.begin());
        m_due[next] -= 1.0;
        m_turns.push_back({.source = kMixedSources[next % kMixedSources.size()],
                           .preshape = m_preshapes[next / kMixedSources.size()],
                           .turn = m_taken[next]++});
    }
}
}  // namespace bullet_ccd::grasp
