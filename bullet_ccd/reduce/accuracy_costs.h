/// What an accuracy costs for two bodies, measured on them.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace bullet_ccd
{
/// One accuracy: what keeps it, and what that costs.
///
/// There are two ways. Queries of the bodies themselves may keep it (ToiOptions::anyWithin); what
/// that takes is measured warm, the same queries again and again, and cold, with hierarchies that
/// are built as far as one query needs. Or smaller models are made first. These deviate from their
/// bodies by at most a fifth of the accuracy b each. Queries of them with a minimum separation of
/// 2b/5 and a tolerance of b/5 stop where the bodies themselves have a gap in (0, b].
struct AccuracyCost
{
    double accuracy = 0.0;  ///< [unit of the meshes]; 0: the bodies themselves, see tolerance
    double modelAccuracy = 0.0;
    double minimumSeparation = 0.0;
    double tolerance = 0.0;
    std::size_t trianglesA = 0;
    std::size_t trianglesB = 0;
    double bytes = 0.0;              ///< of both hierarchies with their meshes
    double reduceSeconds = 0.0;      ///< making the models
    double buildSeconds = 0.0;       ///< building their hierarchies
    double microseconds = 0.0;       ///< of a query, median
    double warmMicroseconds = 0.0;   ///< of a query of the bodies themselves, median
    double pairs = 0.0;              ///< of nodes and of triangles that it looks at, mean
    std::size_t trianglesSeen = 0;   ///< that all those queries together looked at
    double coldMilliseconds = 0.0;   ///< building as far as one query needs, and that query, median
    std::size_t trianglesBuilt = 0;  ///< for that query, median
    double largestGap = 0.0;         ///< of the bodies themselves where a query stopped
    int contacts = 0;
    int broken = 0;  ///< contacts at a gap of the bodies that is 0 or above the accuracy
};

/// Measures accuracies from 1e-6 to 5e-3, as far as they make sense for the size of the bodies, and
/// first the bodies themselves at a tolerance of 1e-6 of it. The same motions are asked for each:
/// A starts beside B in a random orientation and moves through it while it turns.
/// @param progress  called with the number of rows done and their total; false ends the run early
[[nodiscard]] BULLET_CCD_API std::vector<AccuracyCost> measureAccuracies(
    const SsvTree& bodyA,
    const SsvTree& bodyB,
    const std::function<bool(std::size_t, std::size_t)>& progress);
}  // namespace bullet_ccd
