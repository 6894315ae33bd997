/// Inverse kinematics of an arm: which positions of its joints bring a link to a pose.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
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
/// The solvers are those of the Orocos Kinematics and Dynamics Library (KDL): Levenberg-Marquardt
/// from many starts, a low-discrepancy sequence in the ranges of the joints; and Newton's method
/// within the limits where a motion is continued.
class BULLET_CCD_API ArmKinematics
{
public:
    /// @param X_WR pose of the root
    /// Throws std::invalid_argument if no joint moves the link, or one of the chain follows another
    /// or is spherical.
    ArmKinematics(const KinematicTree& tree, std::int32_t link, const Eigen::Isometry3d& X_WR);

    /// The links below the joints of the chain.
    [[nodiscard]] const std::vector<std::int32_t>& joints() const { return m_joints; }

    /// The link's origin is no farther from the first joint of the chain than this, in whatever
    /// posture [m].
    [[nodiscard]] double reach() const { return m_reach; }
    /// The first joint, which nothing moves, in W [m].
    [[nodiscard]] const Eigen::Vector3d& shoulder() const { return m_shoulder; }

    /// Pose of the link.
    [[nodiscard]] Eigen::Isometry3d poseAt(const std::vector<double>& q) const;

    /// Solutions within the limits of the joints, in the order in which they are found, the first
    /// start at `near`. None if the pose cannot be reached, or was not found: more restarts find
    /// more. The answer depends on nothing but the arguments.
    ///
    /// Guarantee: the pose of every solution is within a nanometre and a microradian of `X_WL`.
    /// (KDL takes turns of less for none.)
    [[nodiscard]] std::vector<std::vector<double>> solve(const Eigen::Isometry3d& X_WL,
                                                         const std::vector<double>& near,
                                                         const IkOptions& options = {}) const;

    /// The solution that continues a motion: found from `near`, and no joint farther from it than
    /// `step`. Its pose is as near as those of solve() are.
    [[nodiscard]] std::optional<std::vector<double>> follow(const Eigen::Isometry3d& X_WL,
                                                            const std::vector<double>& near,
                                                            double step) const;

private:
    [[nodiscard]] bool isTooFar(const Eigen::Isometry3d& X_WL) const;

    struct Chain;  // KDL's, which is no part of the interface
    Eigen::Isometry3d m_X_WR;
    std::shared_ptr<const Chain> m_chain;
    std::vector<std::int32_t> m_joints;                    // links of the tree
    std::vector<Joint> m_limits;                           // their joints
    Eigen::Vector3d m_shoulder = Eigen::Vector3d::Zero();  // origin of the first of them [W, m]
    double m_reach = 0.0;                                  // the link is no farther from it [m]
};
}  // namespace bullet_ccd::grasp
