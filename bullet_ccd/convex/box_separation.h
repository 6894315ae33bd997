/// The best of the fifteen separating axes of two boxes.
#pragma once

#include "bullet_ccd/convex/closest_points.h"

#include <Eigen/Geometry>

namespace bullet_ccd
{
/// A direction that separates two boxes best, and the features that it belongs to.
struct BoxAxis
{
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  ///< unit, from A to B, in the frame of B
    double gap = 0.0;                                   ///< along it; negative if the boxes overlap
    int edgeA = -1;  ///< axis of the edge of A, or of the face of A if edgeB is -1
    int edgeB = -1;  ///< axis of the edge of B, or of the face of B if edgeA is -1
};

/// Up to rounding, the boxes are apart if and only if the gap is positive; it is at most their
/// distance, and less where a corner is nearest to a corner or an edge.
[[nodiscard]] BoxAxis bestBoxAxis(const Eigen::Vector3d& halfA,
                                  const Eigen::Vector3d& halfB,
                                  const Placement& pose);

/// The normal and gap of the same features at another pose. False if they do not separate the
/// boxes.
[[nodiscard]] bool refreshAxis(const Eigen::Vector3d& halfA,
                               const Eigen::Vector3d& halfB,
                               const Placement& pose,
                               BoxAxis& axis);

/// The points at which two boxes are `axis.gap` apart, if the features of the axis face each other;
/// they are then the closest points. False if not.
[[nodiscard]] bool facingPoints(const Eigen::Vector3d& halfA,
                                const Eigen::Vector3d& halfB,
                                const Placement& pose,
                                const BoxAxis& axis,
                                ClosestPoints& points);
}  // namespace bullet_ccd
