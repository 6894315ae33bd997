/// Momentum and energy of all that moves in a world, from masses, poses and velocities.
#pragma once

#include "benchmarks/reference/bullet/scene.h"

#include <Eigen/Core>

namespace bullet_ccd::reference
{
struct Momentum
{
    Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< [kg m/s]
    Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< about the world's origin [kg m^2/s]
    // Sums of absolute values, to judge the size of a change by.
    double linearScale = 0.0;
    double angularScale = 0.0;
};

[[nodiscard]] Momentum momentumOf(Scene& scene);

/// Kinetic and, in gravity along -z, potential [J]; rigid bodies only.
[[nodiscard]] double energyOf(Scene& scene, double gravity);
}  // namespace bullet_ccd::reference
