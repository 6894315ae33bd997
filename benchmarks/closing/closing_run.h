/// Approach and closing of one hand on one object by several methods.
#pragma once

#include "benchmarks/closing/discrete_closing.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// Where one method ended.
struct ClosingOutcome
{
    double travel = 0.0;  ///< of the approach, part of what is sensible; infinite without contact
    grasp::ClosingResult closing;
    double microseconds = 0.0;  ///< approach and closing
};

/// A candidate, and where the hand stands when it begins to close.
struct ClosingStart
{
    Eigen::Isometry3d X_WStart;
    Eigen::Vector3d shift;  ///< of the approach
    std::vector<double> open;
    Eigen::Isometry3d X_WH;  ///< where ours met the object
};

struct ClosingCase
{
    const grasp::HandModel& hand;
    const grasp::GraspObject& object;
    int candidates = 20;
    std::uint64_t seed = 1;
};

/// The candidates whose approach meets something.
[[nodiscard]] std::vector<ClosingStart> closingStarts(const ClosingCase& scene);

/// Approach and closing by one method.
using RunClosing = std::function<ClosingOutcome(const ClosingStart&)>;
[[nodiscard]] RunClosing runContinuous(const ClosingCase& scene, double tolerance);
[[nodiscard]] RunClosing runDiscrete(LinkProximity& proximity,
                                     const grasp::HandModel& hand,
                                     const DiscreteOptions& options);

/// The baseline's collision library is FCL.
[[nodiscard]] std::unique_ptr<LinkProximity> fclProximity(const grasp::HandModel& hand,
                                                          const grasp::GraspObject& object);

/// Of the approach and the closings at which postures are compared [m].
inline constexpr double kClosingTolerance = 2e-5;
/// Postures that are farther apart are not the same.
inline constexpr double kSamePosture = 0.02;
}  // namespace bullet_ccd::benchmarks
