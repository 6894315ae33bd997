/// Which source and preshape each candidate of a plan comes from when sources are mixed.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/approach/approach_sampler.h"

#include <cstdint>
#include <vector>

namespace bullet_ccd::grasp
{
/// Spends candidates where they succeed: candidates go to pairs of a source and a preshape by a
/// high power of their rates of force closures, so that the best pair gets most of them, but 10 %
/// go to all pairs alike, so that every source has a fortieth at least, up to rounding. At first
/// most go to Sphere. Rates of pairs that were hardly tried are drawn towards what their source and
/// their preshape do elsewhere. A quarter are pinches whatever their rate, shared out among the
/// preshapes in the same way: what holds most is often one of them, also where others are force
/// closures.
///
/// Candidates are planned in blocks; the turns of a block follow from the outcomes of all blocks
/// before it, so they depend neither on threads nor on when a plan was stopped. Every block but the
/// first is half as large as all before it together.
class BULLET_CCD_API SourceSchedule
{
public:
    static constexpr std::int64_t kFirstBlock = 8;
    static constexpr double kPinched = 0.25;  ///< of the candidates are pinches
    static constexpr double kAlike = 0.1;     ///< of these and of the others go to all pairs alike

    /// @param preshapes of the hand that take part, by index; at least one
    SourceSchedule(std::vector<std::size_t> preshapes, std::int64_t candidates);

    /// Candidates before this number have a turn.
    [[nodiscard]] std::int64_t end() const { return static_cast<std::int64_t>(m_turns.size()); }
    /// @pre number < end()
    [[nodiscard]] const ApproachTurn& turn(std::int64_t number) const
    {
        return m_turns[static_cast<std::size_t>(number)];
    }
    /// Gives the next block its turns.
    /// @param held one entry per candidate before end(): not 0 for a force closure
    /// @pre end() is below the number of candidates
    void extend(const std::vector<char>& held);

private:
    [[nodiscard]] std::vector<double> shares(const std::vector<char>& held) const;
    [[nodiscard]] std::size_t pairOf(const ApproachTurn& turn) const;

    std::vector<std::size_t> m_preshapes;
    std::int64_t m_candidates = 0;
    std::vector<ApproachTurn> m_turns;
    std::vector<std::int64_t> m_taken;  // one a pair
    std::vector<double> m_due;          // what each pair is owed
};
}  // namespace bullet_ccd::grasp
