/// Two rigid bodies on their way: what tests and benchmarks of rigid queries exchange.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"

namespace bullet_ccd::tests
{
struct RigidScene
{
    TriangleMesh meshA = {};
    TriangleMesh meshB = {};
    RigidMotion motionA = {};
    RigidMotion motionB = {};
};

[[nodiscard]] inline RigidScene swapped(const RigidScene& scene)
{
    return {.meshA = scene.meshB,
            .meshB = scene.meshA,
            .motionA = scene.motionB,
            .motionB = scene.motionA};
}

/// The same motion seen from elsewhere.
[[nodiscard]] inline RigidMotion moved(const RigidMotion& motion, const Eigen::Isometry3d& X)
{
    return {.X_W0 = X * motion.X_W0,
            .v_W = X.linear() * motion.v_W,
            .w_W = X.linear() * motion.w_W,
            .reference_B = motion.reference_B};
}

[[nodiscard]] inline RigidScene moved(const RigidScene& scene, const Eigen::Isometry3d& X)
{
    RigidScene result = scene;
    result.motionA = moved(scene.motionA, X);
    result.motionB = moved(scene.motionB, X);
    return result;
}
}  // namespace bullet_ccd::tests
