/// First contact of two boxes, as far as a direction between them and features that face each other
/// decide it: all in registers of four numbers, for processors with AVX2 and FMA. Nothing here may
/// include Eigen, whose functions would be compiled for these processors only.
#pragma once

#include <cstdint>

namespace bullet_ccd
{
/// A box that turns at constant speed about a reference point that moves on a straight line.
struct MovingBox
{
    const double* axes[3];  ///< of the box at t = 0, in W's axes
    const double* half;     ///< three half sizes [m]
    const double* arm;      ///< from the reference to the middle, in its own axes [m]
    const double* w;        ///< angular velocity, in W's axes [rad per step]
    double reach;           ///< farthest point from the reference [m]
};

/// All distances are those of the boxes before any ball sweeps them.
struct MovingBoxes
{
    MovingBox a;
    MovingBox b;
    const double* D0;  ///< from A's reference to B's at t = 0
    const double* V;   ///< and how it changes
    double farthest;   ///< |D(t)| at most
    double sizes;      ///< of all that is added up: a gap is right to 32 roundings of it
    double floor;      ///< distance that must be kept
    double threshold;  ///< in contact at this distance
    double aim;        ///< part of what is between them that a step leaves
    double begin;      ///< what is before is certified, what is after `end` need not be
    double end;
    std::int64_t mostLooks;
};

struct BoxesMeeting
{
    enum class Outcome : std::uint8_t
    {
        Apart,  ///< until the end
        Hit,    ///< near enough at `time`, where the closest points are known
        Open,   ///< apart until `time`; the closest points are asked for there
    };

    Outcome outcome = Outcome::Open;
    bool touches = false;  ///< they begin within the threshold
    bool presses = false;  ///< and close in
    double time = 0.0;
    double gap = 0.0;         ///< of boxes that are apart: at least
    double pointA[3] = {};    ///< of a hit: from B's reference, in W's axes
    double pointB[3] = {};    ///< likewise
    double normal[3] = {};    ///< unit, from A to B, in W's axes
    std::int64_t looks = 0;   ///< times at which a direction was looked for
    std::int64_t probes = 0;  ///< gaps at later times
};

/// Guarantee: as convexToi(), for what the outcome says.
/// @pre all angular velocities are below kMostTurning; begin <= end
using BoxKernel = BoxesMeeting(const MovingBoxes& boxes);
inline constexpr double kMostTurning = 1e4;  ///< [rad per step]

/// Null below SimdLevel::Avx2.
[[nodiscard]] BoxKernel* boxKernel();
}  // namespace bullet_ccd
