/// Approach and closing of one hand on one object by several methods.
#pragma once

#include "benchmarks/closing/discrete_closing.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
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

/// A method over all candidates.
struct MethodResult
{
    std::string name;
    std::vector<ClosingOutcome> outcomes;  ///< one a candidate
    double meanMicroseconds = 0.0;
    /// Candidates of which a joint ends more than kSamePosture from the reference.
    int otherPosture = 0;
};

struct ClosingCase
{
    const grasp::HandModel& hand;
    const grasp::GraspObject& object;
    int candidates = 20;
    std::uint64_t seed = 1;
};

/// Of one hand and object; candidates whose approach meets nothing are left out of all.
struct ClosingComparison
{
    int candidates = 0;
    std::vector<MethodResult> methods;  ///< ours first, then the baselines
    int oursOther = 0;                  ///< ours against the fine sweep
    double worstOther = 0.0;            ///< by so much [rad or m]
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

/// Postures that are farther apart are not the same.
inline constexpr double kSamePosture = 0.02;

/// Ours (continuous), the discrete baseline on FCL and on the project's own hierarchies at the
/// default step and at larger ones, and, for the posture, a sweep of 0.001 rad.
///
/// Every method makes its own approach; all close from where ours ended, so that the postures can
/// be compared.
/// @param withPeers  otherwise ours alone, and no reference
[[nodiscard]] ClosingComparison compareClosing(const ClosingCase& scene, bool withPeers);
}  // namespace bullet_ccd::benchmarks
