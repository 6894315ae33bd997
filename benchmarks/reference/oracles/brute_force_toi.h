/// Time of impact by marching: the reference of the time-of-impact queries.
///
/// The distance of two triangles, or how far apart they are along some direction, is evaluated at a
/// time, and time advances by distance / speed: no contact can lie in between. Where that step
/// falls below a floor the march goes on by (growing) floor steps until the surfaces cross, and the
/// crossing is bisected. Poses are computed here, from the definitions, not by the code under test.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <Eigen/Geometry>

#include <functional>
#include <optional>

namespace bullet_ccd::reference
{
/// A mesh on its way; no point of it moves faster than `speed` [m per step].
struct OracleBody
{
    const TriangleMesh* mesh = nullptr;
    std::function<Eigen::Isometry3d(double)> poseAt;
    double speed = 0.0;
};

struct OracleToi
{
    double low = 1.0;  ///< certified: no contact in [0, low); at most `until`
    /// A time at which the surfaces cross, while they do not cross 1e-15 earlier. The first contact
    /// is not later. None if no crossing was seen.
    std::optional<double> contact;
};

/// exp(t [w]) R0 about the reference, which moves with v.
[[nodiscard]] Eigen::Isometry3d oraclePose(const RigidMotion& motion, double t);

/// Composition of parent frames and joint rotations or shifts from the root down, or from a link
/// `base` down, in whose frame the pose then is.
[[nodiscard]] Eigen::Isometry3d oracleLinkPose(const KinematicTree& tree,
                                               const JointMotion& motion,
                                               std::int32_t link,
                                               double t,
                                               std::int32_t base = kNone);

/// The bodies refer to the mesh, the tree and the motion: these must outlive them.
[[nodiscard]] OracleBody oracleBody(const TriangleMesh& mesh, const RigidMotion& motion);
[[nodiscard]] OracleBody oracleLink(const TriangleMesh& mesh,
                                    const KinematicTree& tree,
                                    const JointMotion& motion,
                                    std::int32_t link,
                                    std::int32_t base = kNone);

[[nodiscard]] double oracleDistanceAt(const OracleBody& a, const OracleBody& b, double t);

/// Looks at [0, until], until <= 1.
[[nodiscard]] OracleToi bruteForceToi(const OracleBody& a, const OracleBody& b, double until = 1.0);
}  // namespace bullet_ccd::reference
