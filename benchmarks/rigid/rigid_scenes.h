/// Scenes and methods of the rigid chart.
#pragma once

#include "benchmarks/rigid/rigid_sets.h"
#include "benchmarks/support/chart.h"

namespace bullet_ccd::benchmarks
{
struct RigidChartOptions
{
    bool quick = false;
    double peerSeconds = 1.0;  ///< limit of one query of FCL's conservative advancement
    int repeats = 3;           ///< of fast methods; the median counts
};

/// Names of the sets that the chart shows.
[[nodiscard]] const std::vector<std::string>& rigidChartSets();

/// A scene with its truths, and all methods that are in this build: three strategies of ours and
/// samples on our hierarchy; FCL's advancement and samples; Bullet's casts where shapes are convex.
/// The methods share ownership of what they need.
[[nodiscard]] ChartScene makeRigidScene(const std::string& set,
                                        MeshLibrary& meshes,
                                        const RigidChartOptions& options);
}  // namespace bullet_ccd::benchmarks
