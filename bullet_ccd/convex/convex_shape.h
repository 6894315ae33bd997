/// Exact convex shapes, without triangles: primitives and small hulls.
///
/// A shape is a core swept by a ball: a point, segment, box, cylinder, cone or hull of points, and
/// the radius of the ball. A sphere is a point swept by a ball, a capsule a segment. The length of
/// all shapes is along z; they are centred at their origin, a cone at half its height with its tip
/// at +z, as in Bullet.
#pragma once

#include "bullet_ccd/export.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace bullet_ccd
{
enum class ConvexCore : std::uint8_t
{
    Point,
    Segment,
    Box,
    Cylinder,
    Cone,
    Hull,
    HalfSpace,
};

/// A convex solid in its own frame. Make one with the functions below.
struct ConvexShape
{
    ConvexCore core = ConvexCore::Point;
    /// Half the size of the core's bounding box [m]; of a half-space the unit normal.
    Eigen::Vector3d half = Eigen::Vector3d::Zero();
    double offset = 0.0;      ///< of a half-space: it is where normal . x <= offset [m]
    double radius = 0.0;      ///< of the ball that sweeps the core [m]
    double coreRadius = 0.0;  ///< farthest point of the core from the origin [m]
    /// Corners of a hull, one coordinate after the other: all x, all y, all z.
    std::shared_ptr<const std::vector<double>> corners{};

    /// The shape swept by a ball of this radius [m]: rounded, and larger by it on all sides.
    /// Throws std::invalid_argument if it is negative or not finite.
    [[nodiscard]] BULLET_CCD_API ConvexShape rounded(double by) const;
};

// All of these throw std::invalid_argument for sizes that are negative or not finite. Sizes of 0
// are allowed: a box without height is a rectangle.

[[nodiscard]] BULLET_CCD_API ConvexShape sphereShape(double radius);

/// A cylinder of the given half length with a half sphere on either end.
[[nodiscard]] BULLET_CCD_API ConvexShape capsuleShape(double radius, double halfLength);

[[nodiscard]] BULLET_CCD_API ConvexShape boxShape(const Eigen::Vector3d& half);

[[nodiscard]] BULLET_CCD_API ConvexShape cylinderShape(double radius, double halfLength);

[[nodiscard]] BULLET_CCD_API ConvexShape coneShape(double radius, double halfLength);

/// The convex hull of at least one point, in any order; points inside are allowed. Every query
/// looks at all points, so beyond a hundred or so of them a mesh is faster.
[[nodiscard]] BULLET_CCD_API ConvexShape hullShape(std::span<const Eigen::Vector3d> points);

/// All points x with normal . x <= offset, for instance ground below a plane.
/// @param normal any length but 0
/// @param offset [m], counted along the normal of unit length
[[nodiscard]] BULLET_CCD_API ConvexShape halfSpaceShape(const Eigen::Vector3d& normal,
                                                        double offset = 0.0);
}  // namespace bullet_ccd
