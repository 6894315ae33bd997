/// What the sampler wants to know about an object: its principal directions and how wide it is
/// where a hand would close on it.
#pragma once

#include "grasp/grasp_types.h"

#include <cstdint>
#include <vector>

namespace bullet_ccd::grasp
{
/// Principal directions of the surface and the extents along them.
struct ObjectShape
{
    Eigen::Matrix3d axes =
        Eigen::Matrix3d::Identity();                  ///< columns, unit; the longest extent first
    Eigen::Vector3d lower = Eigen::Vector3d::Zero();  ///< along them, from the centre of mass [m]
    Eigen::Vector3d upper = Eigen::Vector3d::Zero();

    [[nodiscard]] Eigen::Vector3d extents() const { return upper - lower; }
};

/// Principal directions by the second moments of the surface about its centroid, so that they do
/// not depend on how finely a part is meshed. The sign of each axis is fixed by its largest
/// component.
[[nodiscard]] ObjectShape objectShape(const GraspObject& object);

/// What a pair of fingers that close along x of a frame would meet: rays along x through a 3 x 3
/// grid of points (y, z) around the frame's origin.
struct LocalWidth
{
    int hits = 0;        ///< rays that meet the object, of kRays
    double lower = 0.0;  ///< outermost surface along x over all rays [m]
    double upper = 0.0;
    /// Mean over the rays that hit of |n_x| at the outer surfaces, the smaller of both sides: 1
    /// where the fingers would meet two faces squarely, 0 where they would graze.
    double squareness = 0.0;
    /// Direction in which the two outer surfaces oppose each other: mean of their outward normals,
    /// upper less lower, over the rays that hit; unit, in the frame of the query; x if none hits.
    Eigen::Vector3d opposition = Eigen::Vector3d::UnitX();

    static constexpr int kRays = 9;
    [[nodiscard]] double width() const { return upper - lower; }
};

/// @param X_WG frame; `spacing` of the grid [m]
[[nodiscard]] LocalWidth localWidth(const GraspObject& object,
                                    const Eigen::Isometry3d& X_WG,
                                    double spacing);

/// Indices of all triangles that a line meets, in their order, and of some beside it.
/// @param along unit
[[nodiscard]] std::vector<std::int32_t> trianglesNearLine(const SsvTree& tree,
                                                          const Eigen::Vector3d& point,
                                                          const Eigen::Vector3d& along);
}  // namespace bullet_ccd::grasp
