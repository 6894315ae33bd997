/// What a ToiWorkspace holds.
#pragma once

#include "bullet_ccd/toi/articulated/articulated_culling.h"
#include "bullet_ccd/toi/search/search.h"

#include <vector>

namespace bullet_ccd
{
/// Scratch of articulatedToi().
struct ArticulatedScratch
{
    /// A pair that was within the tolerance at t = 0 and has to close in further to count.
    struct Relaxed
    {
        std::int32_t bodyA = kNone;
        std::int32_t bodyB = kNone;
        double threshold = 0.0;
    };
    /// What became of a pair.
    struct Fate
    {
        bool isSearched = false;
        bool sawTriangles = false;
    };

    Environment environment;  ///< of a caller that has none
    LinkCulling culling;
    std::vector<Candidate> candidates;  ///< a block for every open interval
    std::vector<Fate> fates;            ///< of the candidates of the whole step
    std::vector<MovingBody> bodies;
    std::vector<BodyPair> pairs;
    std::vector<std::int32_t> bodyOfObstacle;
    std::vector<Relaxed> relaxed;
};

struct ToiWorkspace::Scratch
{
    SearchState state;
    ArticulatedScratch articulated;
};
}  // namespace bullet_ccd
