/// Slow and obvious reference for the hull about the origin: every d-subset of the points is tried
/// as a facet.
#pragma once

#include <Eigen/Core>

namespace bullet_ccd::tests
{
struct BruteHull
{
    double radius = 0.0;      ///< 0 if the origin is outside
    double volume = 0.0;      ///< right for points in general position with the origin inside
    std::int64_t facets = 0;  ///< subsets that are facets
};

[[nodiscard]] BruteHull bruteHull(const Eigen::MatrixXd& points);
}  // namespace bullet_ccd::tests
