/// Two rigid bodies on their way: what tests and benchmarks of rigid queries exchange.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"

namespace bullet_ccd::reference
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

[[nodiscard]] inline RigidMotion scaled(RigidMotion motion, double factor)
{
    motion.X_W0.translation() *= factor;
    motion.v_W *= factor;
    motion.reference_B *= factor;
    return motion;
}

/// The same scene in a unit of length `factor` times as small.
[[nodiscard]] inline RigidScene scaled(RigidScene scene, double factor)
{
    for (TriangleMesh* mesh : {&scene.meshA, &scene.meshB})
    {
        for (Eigen::Vector3d& v : mesh->vertices)
        {
            v *= factor;
        }
    }
    scene.motionA = scaled(scene.motionA, factor);
    scene.motionB = scaled(scene.motionB, factor);
    return scene;
}
}  // namespace bullet_ccd::reference
