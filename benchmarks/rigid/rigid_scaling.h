/// How time, memory and build time grow with the number of triangles.
#pragma once

#include "benchmarks/rigid/rigid_sets.h"
#include "bullet_ccd/toi/toi.h"

#include <nlohmann/json_fwd.hpp>

namespace bullet_ccd::benchmarks
{
struct ScalingOptions
{
    double tolerance = 1e-4;
    ToiStrategy strategy = ToiStrategy::BestFirst;
    int repeats = 5;
    bool quick = false;  ///< small meshes only
};

/// Prints a table for knots and bumpy spheres of 1K to 1M triangles, the same motions at all sizes.
/// @return its rows
nlohmann::json printScaling(MeshLibrary& meshes, const ScalingOptions& options);
}  // namespace bullet_ccd::benchmarks
