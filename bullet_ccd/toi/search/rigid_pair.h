/// Relative motion of two rigid bodies whose reference points move on straight lines.
#pragma once

#include "bullet_ccd/toi/kernels/node_batch.h"
#include "bullet_ccd/toi/kernels/triangle_approach.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <array>

namespace bullet_ccd
{
/// What is constant about the pair, in double precision; see RigidPoses for the meaning.
struct RigidPair
{
    std::array<Eigen::Matrix3d, 3> turnA{};
    std::array<Eigen::Matrix3d, 3> turnB{};
    Eigen::Vector3d d0 = Eigen::Vector3d::Zero();
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    Eigen::Vector3d wA = Eigen::Vector3d::Zero();
    Eigen::Vector3d wB = Eigen::Vector3d::Zero();
    Eigen::Vector3d wBw = Eigen::Vector3d::Zero();
    Eigen::Vector3d armA =
        Eigen::Vector3d::Zero();  ///< from the reference to the tree's origin, in the tree's axes
    Eigen::Vector3d armB = Eigen::Vector3d::Zero();
    double rateA = 0.0, rateB = 0.0;
    bool turnsB = false;
    bool inFrameOfB = false;
    double spinA = 0.0;  ///< |wA|, which differs from rateA in the frame of B
    // Acceleration of A relative to B, see RelativeMotion.
    double constant = 0.0;
    double perRadiusA = 0.0;
    double axisA = 1.0;  ///< 0 where the axis of A does not keep its direction
    Eigen::Vector3d plane = Eigen::Vector3d::Zero();  ///< of accelerations, in B's tree's axes
    double acrossPlane = 0.0;
    double speed = 0.0;   ///< bound of the relative speed of any two points [m per step]
    double offset = 0.0;  ///< size of the world coordinates that the references were rounded to [m]
    double reach = 0.0;   ///< size of the coordinates apart from the translation [m]

    /// Relative motion at time t.
    [[nodiscard]] RelativeMotion at(double t) const;
};

/// Where accelerations and directions are seen from.
enum class RigidFrame
{
    Slower,  ///< W, or the turning frame of B if accelerations are smaller there
    OfB,     ///< directions turn with B, if it turns
};

/// @pre both motions are RigidMotion
[[nodiscard]] RigidPair makeRigidPair(const MovingBody& bodyA,
                                      const MovingBody& bodyB,
                                      RigidFrame frame = RigidFrame::Slower);

/// The same in the form that the SIMD kernels take.
[[nodiscard]] RigidPoses toRigidPoses(const RigidPair& pair);
}  // namespace bullet_ccd
