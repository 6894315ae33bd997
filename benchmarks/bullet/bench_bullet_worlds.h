/// Time per step of whole worlds.
#pragma once

#include "benchmarks/reference/bullet/scene.h"

#include <vector>

namespace bullet_ccd::benchmarks
{
struct WorldRow
{
    tests::Kind kind;
    int bodies = 0;
    double median = 0.0;   ///< of the steps [us]
    double mean = 0.0;     ///< [us]
    int outside = 0;       ///< bodies that are out of the bin in the end
    double queries = 0.0;  ///< times of impact asked for, a step
    double impacts = 0.0;  ///< a step
};

/// A pile of boxes, balls and hulls falls into a bin and is shot at; the worlds take turns step by
/// step.
[[nodiscard]] std::vector<WorldRow> runWorlds(int bodies, int steps);
}  // namespace bullet_ccd::benchmarks
