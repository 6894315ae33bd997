/// A scene of several tests.
#pragma once

#include "benchmarks/reference/scenes/rigid_scene.h"
#include "benchmarks/reference/scenes/shapes.h"

namespace bullet_ccd::tests
{
/// A cube of half edge 1 whose middle starts at that height above a large plane.
[[nodiscard]] inline reference::RigidScene cubeOverPlane(
    double height, const Eigen::Vector3d& v, const Eigen::Vector3d& w = Eigen::Vector3d::Zero())
{
    using namespace reference;
    return {.meshA = cube(1.0),
            .meshB = floorAt(0.0, 100.0),
            .motionA = {.X_W0 = poseOf({0.2, 0.1, height}), .v_W = v, .w_W = w}};
}
}  // namespace bullet_ccd::tests
