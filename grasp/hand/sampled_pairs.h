/// Pairs of links that need not be tested against each other, found by trying: what an SRDF lists
/// as disable_collisions.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
/// What sampling found about a pair, by the names that SRDF gives as reasons; the first that fits.
enum class PairFinding : std::uint8_t
{
    Adjacent,  ///< joined, with no other geometry between: they overlap about their joint by design
    Default,   ///< overlap at rest: positions 0, or the limits next to it
    Always,    ///< overlap in nearly all samples
    Never,     ///< overlap in no sample, which is no proof
    Sometimes,  ///< has to be tested
};

[[nodiscard]] BULLET_CCD_API const char* nameOf(PairFinding finding);

struct SampledPair
{
    std::int32_t first = 0;   ///< link, below `second`
    std::int32_t second = 0;  ///< link
    PairFinding finding = PairFinding::Never;
    int samples = 0;   ///< in which the pair was looked at
    int overlaps = 0;  ///< of them
    /// What to do about it, as far as sampling can tell: true but for Sometimes.
    [[nodiscard]] bool canBeDisabled() const { return finding != PairFinding::Sometimes; }
};

struct PairSampling
{
    int samples = 10'000;
    std::uint64_t seed = 1;
    double always = 0.95;  ///< least share of samples with an overlap that counts as always
    double reach = 1e-4;   ///< surfaces this near overlap [m]
};

/// Every pair of links with geometry, in order of their indices. Joint positions are uniform
/// between the limits, over a full turn for revolute joints without; sliding joints without limits
/// rest. Mimic joints follow. Surfaces are looked at: a link wholly inside another one does not
/// overlap it. The answer depends on nothing but the arguments. Throws std::invalid_argument if the
/// options are out of range or the sizes do not match.
/// @param linkTrees one entry a link, null for a link without geometry
[[nodiscard]] BULLET_CCD_API std::vector<SampledPair> samplePairs(
    const KinematicTree& tree,
    std::span<const SsvTree* const> linkTrees,
    const PairSampling& sampling);

/// An SRDF whose robot element holds a disable_collisions for every pair and nothing else.
[[nodiscard]] BULLET_CCD_API std::string disabledPairsSrdf(const std::string& robot,
                                                           const KinematicTree& tree,
                                                           std::span<const SampledPair> pairs);
}  // namespace bullet_ccd::grasp
