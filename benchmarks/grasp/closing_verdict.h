/// Which of two closings of a hand from the same pose went through something, where they differ.
#pragma once

#include "grasp/check/penetration_check.h"
#include "grasp/closing/closing.h"

#include <span>

namespace bullet_ccd::benchmarks
{
enum class ClosingVerdict : std::uint8_t
{
    Alike,        ///< every joint ends within the angle that is asked for
    OtherPasses,  ///< the other closing goes on through a contact: an exact check finds it inside
    FirstPasses,  ///< the first does
    Touches,      ///< one stops where surfaces are within the tolerance, the other misses them by
                  ///< less than that and goes on; neither is ever inside
    Unexplained,
};
[[nodiscard]] const char* toString(ClosingVerdict verdict);
inline constexpr int kClosingVerdicts = 5;

/// The case in which two closings began.
struct PosedClosing
{
    const grasp::HandModel& hand;
    const grasp::GraspObject& object;
    grasp::PenetrationCheck& check;  ///< of these two
    Eigen::Isometry3d X_WH;
    std::vector<double> open;  ///< one position a link
};

/// Where a closing with these stops has its joints at a time [s], one position a link.
[[nodiscard]] std::vector<double> positionsDuring(const PosedClosing& start,
                                                  std::span<const grasp::StopEvent> stops,
                                                  double time);

/// True if a link intersects the object, or is inside it, by the independent check; or a link that
/// it is paired with, by the exact distance.
[[nodiscard]] bool isInside(const PosedClosing& start, const std::vector<double>& positions);

/// The largest distance of a link from what stopped it, at the end of a closing [m].
[[nodiscard]] double largestStopGap(const PosedClosing& start, const grasp::ClosingResult& closing);

/// When two closings are alike.
struct ClosingLikeness
{
    double angle = 0.02;     ///< every joint ends within this [rad]; sliding ones a tenth [m]
    bool sameLinks = false;  ///< and the same links are stopped
    double reach = 1e-4;     ///< surfaces this close may be called touching [m]
};

/// Looks at the way of the closing that went on past the first stop in which the two differ, from
/// that stop to its end, in steps that begin at a nanosecond.
[[nodiscard]] ClosingVerdict compareClosings(const PosedClosing& start,
                                             const grasp::ClosingResult& first,
                                             const grasp::ClosingResult& other,
                                             const ClosingLikeness& likeness);
}  // namespace bullet_ccd::benchmarks
