/// Convex hull of points in any dimension: its volume and its largest ball about the origin.
///
/// The points are first whitened (mapped so that they spread alike in every direction): the map
/// takes facets to facets, and qhull then meets neither thin hulls nor mixed units. A facet
/// contributes by its normal only; how far the hull reaches along it is measured on the points
/// themselves, so that facets that qhull merged to repair rounding leave no trace in the result.
#pragma once

#include <Eigen/Core>

namespace bullet_ccd::grasp
{
struct HullAboutOrigin
{
    double radius = 0.0;  ///< of the largest ball about 0 inside the hull; 0 if 0 is not inside
    double volume = 0.0;
    bool flat = true;  ///< the points span no volume: radius and volume are 0
};

/// Points whose smallest singular value (about their mean) is below this part of the largest are
/// flat. Half the width of the hull, and so the radius, is at most the smallest singular value:
/// what is called 0 is at most this part of the largest.
inline constexpr double kFlatness = 1e-9;

/// @param points  d x n, one point a column, d >= 2
/// Exact up to rounding; where points nearly coincide or are nearly coplanar and qhull gives up,
/// they are first moved by 1e-10 to 1e-8 of the size of the hull, and the radius is exact up to
/// 1e-7 of it. Deterministic and safe to call from several threads. A hull that qhull cannot build
/// even then counts as flat.
/// @pre all coordinates are finite
[[nodiscard]] HullAboutOrigin hullAboutOrigin(const Eigen::MatrixXd& points);
}  // namespace bullet_ccd::grasp
