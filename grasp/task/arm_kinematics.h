/// Inverse kinematics of an arm: which positions of its joints bring a link to a pose.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <vector>

namespace bullet_ccd::grasp
{
struct IkOptions
{
    int wanted = 4;     ///< solutions after which the search ends
    int restarts = 60;  ///< starts spread over the joints' ranges, which also sample redundancy
    std::uint64_t seed = 1;
    double apart = 0.2;  ///< solutions differ by this in one joint at least [rad or m]
};

/// A chain of joints from the root of a tree to a link. Positions have one entry for each joint of
/// the chain that moves, from the root on.
///
/// Newton's method with damped least squares: the damping is half the squared error (Sugihara 2011,
/// "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method"), joints at a
/// limit that would leave it rest for the step, and what does not move the link is used to come
/// nearer to the middle of the ranges. Starts are a low-discrepancy sequence.
class BULLET_CCD_API ArmKinematics
{
public:
    /// @param X_WR pose of the root
    /// Throws std::invalid_argument if no joint moves the link, or one of the chain follows another
    /// or is spherical.
    ArmKinematics(const KinematicTree& tree, std::int32_t link, const Eigen::Isometry3d& X_WR);

    /// The links below the joints of the chain.
    [[nodiscard]] const std::vector<std::int32_t>& joints() const { return m_joints; }

    /// Pose of the link.
    [[nodiscard]] Eigen::Isometry3d poseAt(const std::vector<double>& q) const;

    /// Solutions within the limits of the joints, in the order in which they are found, the first
    /// start at `near`. None if the pose cannot be reached, or was not found: more restarts find
    /// more. The answer depends on nothing but the arguments.
    ///
    /// Guarantee: the pose of every solution is within a nanometre and a nanoradian of `X_WL`.
    [[nodiscard]] std::vector<std::vector<double>> solve(const Eigen::Isometry3d& X_WL,
                                                         const std::vector<double>& near,
                                                         const IkOptions& options = {}) const;

    /// The solution that continues a motion: found from `near`, and no joint farther from it than
    /// `step`.
    [[nodiscard]] std::optional<std::vector<double>> follow(const Eigen::Isometry3d& X_WL,
                                                            const std::vector<double>& near,
                                                            double step) const;

private:
    struct Frames;
    /// The link, and the axis and the origin of every joint, in W.
    [[nodiscard]] Frames framesAt(const std::vector<double>& q) const;
    [[nodiscard]] bool isTooFar(const Eigen::Isometry3d& X_WL) const;
    /// From where `q` is; false if that leads to no solution.
    [[nodiscard]] bool descend(const Eigen::Isometry3d& X_WL,
                               std::vector<double>& q,
                               double pull) const;

    Eigen::Isometry3d m_X_WR;
    std::vector<Link> m_chain;           // from below the root to the link
    std::vector<std::int32_t> m_joints;  // links of the tree
    std::vector<Joint> m_limits;         // their joints
    double m_reach = 0.0;                // the link is no farther from the first joint [m]
};
}  // namespace bullet_ccd::grasp
