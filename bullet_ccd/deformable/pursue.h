/// The search in time for the first contact of one pair of features. Internal to the room.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"

namespace bullet_ccd
{
struct Pursuit
{
    ElementaryResult result;
    bool startsNear = false;  ///< within the tolerance at t = 0
};

/// Local advancement. Everything before the returned time has been certified, so that time is never
/// later than the first contact.
///
/// Terminates: every turn of the loop either moves time forward by a representable step, or divides
/// the step that it tries by four, which ends where the support step takes over; maxIterations
/// bounds it whatever happens.
/// @pre pair.kind fits N: 3 for a vertex and a face, 4 for two edges
template <std::size_t N>
[[nodiscard]] Pursuit pursue(const ElementaryPair& pair, const ElementaryOptions& options);

/// elementaryToi() without its checks of the input, for pairs whose vertices were checked before.
/// With coordinates that are not finite the answer is Overlapping.
[[nodiscard]] ElementaryResult uncheckedElementaryToi(const ElementaryPair& pair,
                                                      const ElementaryOptions& options);

/// Throws std::invalid_argument as elementaryToi() says.
void checkElementaryOptions(const ElementaryOptions& options);
}  // namespace bullet_ccd
