/// What the rigid benchmark is measured against, as multiples of FCL at 1,001 samples.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace bullet_ccd::benchmarks
{
inline constexpr int kNaiveSamples = 1001;
/// Both bodies rotating against the same relative motion with one at rest, by time.
inline constexpr double kBothMovingMust = 1.5;

/// 0 where there is none.
struct RigidTarget
{
    std::string_view set;
    double originalC2A;  ///< the original C2A (axis of rotation corrected) on the same queries
    double must;
    double goal;
};

inline constexpr std::array<RigidTarget, 22> kRigidTargets{{
    {"bunny_ident", 3.25, 0.065, 0.028}, {"bunny_ani", 4.24, 0.17, 0.07},
    {"plate", 0.69, 0.075, 0.03},        {"knot_64k", 2.40, 0.065, 0.027},
    {"sphere_320k", 2.12, 0.045, 0.018}, {"bunny_near", 0.11, 0.004, 0.002},
    {"bunny_rot", 1.19, 0.020, 0.010},   {"bunny_trans", 0.33, 0.05, 0.025},
    {"finger", 0.79, 0.045, 0.0225},     {"tunnel", 0.74, 0.18, 0.09},
    {"bunny_random", 3.30, 0.0, 0.0},    {"bunny_both", 0.0, 0.0, 0.0},
    {"bunny_both_rest", 0.0, 0.0, 0.0},  {"knot_1k", 0.50, 0.0, 0.0},
    {"knot_4k", 0.90, 0.0, 0.0},         {"knot_16k", 1.49, 0.0, 0.0},
    {"knot_256k", 3.41, 0.0, 0.0},       {"sphere_1k", 0.43, 0.0, 0.0},
    {"sphere_5k", 0.72, 0.0, 0.0},       {"sphere_20k", 1.10, 0.0, 0.0},
    {"sphere_80k", 1.71, 0.0, 0.0},      {"tunnel_flat", 0.0, 0.0, 0.0},
}};

[[nodiscard]] inline const RigidTarget* findTarget(std::string_view set)
{
    const auto* found = std::ranges::find(kRigidTargets, set, &RigidTarget::set);
    return found == kRigidTargets.end() ? nullptr : found;
}

/// What the table shows by default; the convex sets serve the chart.
[[nodiscard]] inline std::vector<std::string> setsOfTable()
{
    std::vector<std::string> names;
    for (const RigidTarget& target : kRigidTargets)
    {
        names.emplace_back(target.set);
    }
    return names;
}
}  // namespace bullet_ccd::benchmarks
