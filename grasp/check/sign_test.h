/// Signs of determinants of points, and what they say about segments, triangles and closed
/// surfaces. A sign is returned only where it is certain; 0 means that rounding leaves it open.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>

namespace bullet_ccd::grasp
{
using Corners = std::array<Eigen::Vector3d, 3>;

/// +1 if a, b, c turn counter-clockwise seen along -z, -1 if clockwise.
[[nodiscard]] int orient2d(const Eigen::Vector3d& a,
                           const Eigen::Vector3d& b,
                           const Eigen::Vector3d& c);

/// +1 if d is below the plane of a, b, c: on the side from which they turn clockwise; -1 if above.
[[nodiscard]] int orient3d(const Eigen::Vector3d& a,
                           const Eigen::Vector3d& b,
                           const Eigen::Vector3d& c,
                           const Eigen::Vector3d& d);

enum class Crossing : std::uint8_t
{
    None,
    Touching,  ///< within rounding of each other, or of the rim of one
    Proper,    ///< an edge of one passes through the inside of the other
};

[[nodiscard]] Crossing crossing(const Corners& triangleA, const Corners& triangleB);

/// Distance of a point from a triangle [m].
[[nodiscard]] double pointTriangleDistance(const Eigen::Vector3d& point, const Corners& triangle);
}  // namespace bullet_ccd::grasp
