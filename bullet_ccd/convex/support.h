/// Farthest points of cores: all that the queries know of a shape.
#pragma once

#include "bullet_ccd/convex/convex_shape.h"

#include <Eigen/Core>

#include <cmath>

namespace bullet_ccd
{
/// The corner of a hull that is farthest along `direction`; the first of several.
[[nodiscard]] inline std::size_t farthestCorner(const std::vector<double>& corners,
                                                const Eigen::Vector3d& direction)
{
    const std::size_t count = corners.size() / 3;
    const double* x = corners.data();
    const double* y = x + count;
    const double* z = y + count;
    std::size_t farthest = 0;
    double most = direction.x() * x[0] + direction.y() * y[0] + direction.z() * z[0];
    for (std::size_t i = 1; i < count; ++i)
    {
        const double height = direction.x() * x[i] + direction.y() * y[i] + direction.z() * z[i];
        farthest = height > most ? i : farthest;
        most = height > most ? height : most;
    }
    return farthest;
}

/// The point of the core that is farthest along `direction`, of any length.
/// @pre the shape is not a half-space
[[nodiscard]] inline Eigen::Vector3d supportPoint(const ConvexShape& shape,
                                                  const Eigen::Vector3d& direction)
{
    const Eigen::Vector3d& h = shape.half;
    const auto signedHalf = [&](int k) { return std::copysign(h[k], direction[k]); };
    const auto rim = [&](double z) -> Eigen::Vector3d
    {
        const double across = std::hypot(direction.x(), direction.y());
        const double scale = across > 0.0 ? h.x() / across : 0.0;
        return {scale * direction.x(), scale * direction.y(), z};
    };
    switch (shape.core)
    {
        case ConvexCore::Point:
        case ConvexCore::HalfSpace:
            break;
        case ConvexCore::Segment:
        case ConvexCore::Box:
            return {signedHalf(0), signedHalf(1), signedHalf(2)};
        case ConvexCore::Cylinder:
            return rim(signedHalf(2));
        case ConvexCore::Cone:
        {
            const double across =
                std::sqrt(direction.x() * direction.x() + direction.y() * direction.y());
            return 2.0 * h.z() * direction.z() >= h.x() * across ? Eigen::Vector3d(0.0, 0.0, h.z())
                                                                 : rim(-h.z());
        }
        case ConvexCore::Hull:
        {
            const std::size_t i = farthestCorner(*shape.corners, direction);
            const std::size_t count = shape.corners->size() / 3;
            const double* x = shape.corners->data() + i;
            return {x[0], x[count], x[2 * count]};
        }
    }
    return Eigen::Vector3d::Zero();
}

/// direction . supportPoint(shape, direction).
[[nodiscard]] inline double supportHeight(const ConvexShape& shape,
                                          const Eigen::Vector3d& direction)
{
    const Eigen::Vector3d& h = shape.half;
    switch (shape.core)
    {
        case ConvexCore::Segment:
            return h.z() * std::abs(direction.z());
        case ConvexCore::Box:
            return h.dot(direction.cwiseAbs());
        case ConvexCore::Cylinder:
            return h.z() * std::abs(direction.z()) +
                   h.x() * std::sqrt(direction.head<2>().squaredNorm());
        case ConvexCore::Cone:
            return std::max(
                h.z() * direction.z(),
                h.x() * std::sqrt(direction.head<2>().squaredNorm()) - h.z() * direction.z());
        case ConvexCore::Hull:
            return direction.dot(supportPoint(shape, direction));
        case ConvexCore::Point:
        case ConvexCore::HalfSpace:
            break;
    }
    return 0.0;
}
}  // namespace bullet_ccd
