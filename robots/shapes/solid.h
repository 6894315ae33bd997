/// Solids as signed distance functions: negative inside, positive outside, at most as steep as a
/// distance (1 metre a metre), so that a value is a safe radius of empty or of full space. Unions,
/// cuts and blends keep that; they make the composite household objects and robot links.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <functional>
#include <vector>

namespace bullet_ccd::shapes
{
using Solid = std::function<double(const Eigen::Vector3d&)>;
using Profile = std::vector<Eigen::Vector2d>;  ///< points (radius, z) [m]

[[nodiscard]] Solid ball(double radius);

/// Box of the given half extents about the origin, edges rounded within it.
[[nodiscard]] Solid roundedBox(const Eigen::Vector3d& halfExtents, double rounding);

/// Cylinder about z from `low` to `high`, edges rounded within it.
[[nodiscard]] Solid roundedCylinder(double radius, double low, double high, double rounding);

/// Solid of revolution of the closed region that `profile` and the axis bound (first and last point
/// on the axis, bottom to top), convex edges rounded by growing it by `growth`.
[[nodiscard]] Solid lathe(const Profile& profile, double growth);

/// Vessel wall: everything within `thickness` / 2 of the revolved open curve `profile`.
[[nodiscard]] Solid latheShell(const Profile& profile, double thickness);

/// A station of a tube.
struct TubePoint
{
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    double radius = 0.0;
};

/// Round tube along a polyline; the radius runs linearly between stations, which may differ by less
/// than their distance only.
[[nodiscard]] Solid tube(const std::vector<TubePoint>& points);

[[nodiscard]] Solid unite(const Solid& a, const Solid& b);
[[nodiscard]] Solid cut(const Solid& from, const Solid& what);

/// Union whose seam is a fillet of about `radius`.
[[nodiscard]] Solid blend(const Solid& a, const Solid& b, double radius);

/// Cut whose seam is rounded by about `radius`.
[[nodiscard]] Solid blendCut(const Solid& from, const Solid& what, double radius);

/// Intersection whose seam is rounded by about `radius`.
[[nodiscard]] Solid blendIntersect(const Solid& a, const Solid& b, double radius);

/// The solid moved by X.
[[nodiscard]] Solid placed(const Solid& solid, const Eigen::Isometry3d& X);
[[nodiscard]] Solid moved(const Solid& solid, const Eigen::Vector3d& by);

/// The solid stretched along the axes.
[[nodiscard]] Solid stretched(const Solid& solid, const Eigen::Vector3d& factors);

/// The solid whose surface is at p where `solid` has it at warp(p); `steepness` bounds how much the
/// warp stretches distances.
[[nodiscard]] Solid warped(const Solid& solid,
                           const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& warp,
                           double steepness);

/// Smooth curve (Catmull-Rom) through the given points, `steps` pieces between two of them.
[[nodiscard]] Profile smoothCurve(const Profile& points, int steps);
[[nodiscard]] std::vector<TubePoint> smoothCurve(const std::vector<TubePoint>& points, int steps);

/// Gradient of the solid's function by differences; points outwards.
[[nodiscard]] Eigen::Vector3d gradientAt(const Solid& solid, const Eigen::Vector3d& point);
}  // namespace bullet_ccd::shapes
