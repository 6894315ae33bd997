#include "bullet_ccd/convex/convex_shape.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
void requireSize(double size, const char* what)
{
    require(size >= 0.0 && std::isfinite(size), what);
}
}  // namespace

ConvexShape ConvexShape::rounded(double by) const
{
    requireSize(by, "convex shape: the radius to round by must be finite and not negative");
    ConvexShape shape = *this;
    shape.radius += by;
    return shape;
}

ConvexShape sphereShape(double radius)
{
    return ConvexShape{}.rounded(radius);
}

ConvexShape capsuleShape(double radius, double halfLength)
{
    requireSize(halfLength, "convex shape: the half length must be finite and not negative");
    const ConvexShape segment{
        .core = ConvexCore::Segment, .half = {0.0, 0.0, halfLength}, .coreRadius = halfLength};
    return segment.rounded(radius);
}

ConvexShape boxShape(const Eigen::Vector3d& half)
{
    require(half.allFinite() && half.minCoeff() >= 0.0,
            "convex shape: half the size of a box must be finite and not negative");
    return {.core = ConvexCore::Box, .half = half, .coreRadius = half.norm()};
}

namespace
{
ConvexShape turnedShape(ConvexCore core, double radius, double halfLength)
{
    requireSize(radius, "convex shape: the radius must be finite and not negative");
    requireSize(halfLength, "convex shape: the half length must be finite and not negative");
    return {.core = core,
            .half = {radius, radius, halfLength},
            .coreRadius = std::hypot(radius, halfLength)};
}
}  // namespace

ConvexShape cylinderShape(double radius, double halfLength)
{
    return turnedShape(ConvexCore::Cylinder, radius, halfLength);
}

ConvexShape coneShape(double radius, double halfLength)
{
    return turnedShape(ConvexCore::Cone, radius, halfLength);
}

ConvexShape hullShape(std::span<const Eigen::Vector3d> points)
{
    require(!points.empty(), "convex shape: a hull needs at least one point");
    ConvexShape shape{.core = ConvexCore::Hull};
    std::vector<double> corners(3 * points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        require(points[i].allFinite(), "convex shape: a point of a hull is NaN or infinite");
        for (int k = 0; k < 3; ++k)
        {
            corners[static_cast<std::size_t>(k) * points.size() + i] = points[i][k];
        }
        shape.half = shape.half.cwiseMax(points[i].cwiseAbs());
        shape.coreRadius = std::max(shape.coreRadius, points[i].norm());
    }
    shape.corners = std::make_shared<const std::vector<double>>(std::move(corners));
    return shape;
}

ConvexShape halfSpaceShape(const Eigen::Vector3d& normal, double offset)
{
    const double length = normal.stableNorm();
    require(length > 0.0 && std::isfinite(length) && std::isfinite(offset),
            "convex shape: the normal of a half-space must not be 0; it and the offset are finite");
    return {.core = ConvexCore::HalfSpace, .half = normal / length, .offset = offset};
}
}  // namespace bullet_ccd
