/// Approach and closing by overlap tests at small steps, as grasp planners have long done it: the
/// baseline that continuous queries are measured against, and their differential oracle.
#pragma once

#include "grasp/closing/closing.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// What the baseline asks of a collision library: links of a hand against the object (kNone) and
/// against each other.
class LinkProximity
{
public:
    /// Of a link and another body that stand there. Distances are those of the surfaces, 0 if they
    /// intersect [m]; any value >= `bound` if it is not less.
    using Pose = Eigen::Isometry3d;
    using Overlap =
        std::function<bool(std::int32_t, const Pose& X_WA, std::int32_t, const Pose& X_WB)>;
    using Distance = std::function<double(
        std::int32_t, const Pose& X_WA, std::int32_t, const Pose& X_WB, double bound)>;

    LinkProximity(Overlap overlap, Distance distance)
        : m_overlap(std::move(overlap)), m_distance(std::move(distance))
    {
    }

    /// Puts the links there, one pose per link. The object rests in W.
    void place(std::span<const Pose> X_WL) { m_poses.assign(X_WL.begin(), X_WL.end()); }
    [[nodiscard]] bool overlap(std::int32_t link, std::int32_t other) const
    {
        return m_overlap(link, poseOf(link), other, poseOf(other));
    }
    [[nodiscard]] double distance(std::int32_t link, std::int32_t other, double bound) const
    {
        return m_distance(link, poseOf(link), other, poseOf(other), bound);
    }

private:
    [[nodiscard]] Pose poseOf(std::int32_t link) const
    {
        return link == kNone ? Pose::Identity() : m_poses[static_cast<std::size_t>(link)];
    }

    Overlap m_overlap;
    Distance m_distance;
    std::vector<Pose> m_poses;
};

/// On the project's own hierarchies. Keeps references to both.
[[nodiscard]] std::unique_ptr<LinkProximity> treeProximity(const grasp::HandModel& hand,
                                                           const grasp::GraspObject& object);

/// The defaults are GraspIt!'s: one hundredth of a second at its default joint speeds a step, 10 mm
/// of approach, contact between 0 and 0.1 mm, links in contact within 0.2 mm, 500 steps at most.
struct DiscreteOptions
{
    double closingStep = 0.01;   ///< [s]; joints close at grasp::ClosingDrives' speeds
    double approachStep = 0.01;  ///< [m]
    double contactGap = 1e-4;    ///< bisection ends at a distance between 0 and this [m]
    double contactLayer = 2e-4;  ///< pairs that were bisected and are this close are contacts [m]
    std::int64_t maxSteps = 500;
    int maxHalvings = 66;
};

/// Moves the hand, joints at rest, along `shift` (W) in steps; at the first overlap the step is
/// bisected until the pairs that overlap are apart by less than the contact gap.
/// Returns the part of `shift` travelled; infinite if nothing was hit.
///
/// No guarantee: what is thinner than a step may be passed.
[[nodiscard]] double discreteApproach(LinkProximity& proximity,
                                      const grasp::HandModel& hand,
                                      const Eigen::Isometry3d& X_WStart,
                                      const Eigen::Vector3d& shift,
                                      const std::vector<double>& positions,
                                      const DiscreteOptions& options);

/// Closes as grasp::CloseHand says, but in steps: all running joints move by one step; where pairs
/// overlap, the step is bisected over these pairs alone, until they are apart by less than the
/// contact gap, then all pairs are tested again; links in contact stop with the joints between them
/// and the palm. After maxSteps it stops where it is (status IterationLimit).
///
/// No guarantee: contact may be jumped over, and links may end where a finer step would not let
/// them.
[[nodiscard]] grasp::ClosingResult discreteClosing(LinkProximity& proximity,
                                                   const grasp::HandModel& hand,
                                                   const Eigen::Isometry3d& X_WH,
                                                   const std::vector<double>& positions,
                                                   const DiscreteOptions& options);

/// discreteClosing() as an engine. Keeps a reference to the proximity, which is of the hand and the
/// object that the engine is asked for.
[[nodiscard]] grasp::CloseHand discreteEngine(LinkProximity& proximity,
                                              const DiscreteOptions& options);

/// The largest difference of a joint between two postures [rad]. The difference of a sliding joint
/// [m] counts ten times.
/// @pre a and b have one entry per link
[[nodiscard]] double postureDifference(const grasp::HandModel& hand,
                                       std::span<const double> a,
                                       std::span<const double> b);
}  // namespace bullet_ccd::benchmarks
