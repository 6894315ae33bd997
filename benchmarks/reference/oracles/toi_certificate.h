/// Judges an answer of a rigid time-of-impact query by proof or by counterexample.
///
/// That the bodies stay apart up to the reported time is proved by halving intervals: at the middle
/// m of an interval of half length h a pair of triangles is apart along some direction n; along n
/// the gap of two corners falls by at most |rate| h + acceleration h^2 / 2; if no gap can close the
/// pair is done with, else the interval is halved. A distance that vanishes (or falls to the
/// minimum separation) at one instant before the reported time is the counterexample. Poses,
/// corners and gaps are evaluated in long double from the definition of the motion; hierarchy,
/// distance and motion code of the library are not used.
#pragma once

#include "benchmarks/reference/scenes/rigid_scene.h"
#include "bullet_ccd/toi/toi.h"

#include <cstdint>
#include <string>

namespace bullet_ccd::reference
{
enum class Verdict : std::uint8_t
{
    Right,
    Late,         ///< a contact before the reported time
    Missed,       ///< a contact, and no contact reported
    False,        ///< contact reported at a distance beyond the tolerance
    WrongGap,     ///< `gap` is not the distance, or not a lower bound of it
    WrongStatus,  ///< the status does not describe the start of the motion
    GaveUp,       ///< at the usual iteration limit
    Undecided,    ///< neither proof nor counterexample within the effort allowed
};

[[nodiscard]] const char* nameOf(Verdict verdict);

struct Judgement
{
    Verdict verdict = Verdict::Right;
    double time = 0.0;             ///< of the counterexample, or where the proof got stuck
    double distance = 0.0;         ///< there
    std::int64_t evaluations = 0;  ///< pairs of triangles times instants
    std::string pair = {};         ///< which bodies, of answers about many

    [[nodiscard]] std::string text() const;
};

/// Distance of the bodies at one time and points that attain it, in W.
struct InstantDistance
{
    double distance = 0.0;  ///< 0 if the surfaces cross
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
};

[[nodiscard]] InstantDistance instantDistance(const RigidScene& scene, double t);

/// The same in double precision, for bodies that do not cross; else some positive distance.
[[nodiscard]] InstantDistance featureDistance(const RigidScene& scene, double t);

/// What rounding may do to a distance in that scene: 512 units in the last place of its largest
/// coordinate.
[[nodiscard]] double distanceRounding(const RigidScene& scene);

[[nodiscard]] Judgement judgeToi(const RigidScene& scene,
                                 const ToiOptions& options,
                                 const ToiResult& result);
}  // namespace bullet_ccd::reference
