/// Closest points of two convex cores (Gilbert, Johnson, Keerthi), with a lower bound of their
/// distance that does not rest on how well the search went.
#pragma once

#include "bullet_ccd/convex/convex_shape.h"
#include "bullet_ccd/export.h"

#include <Eigen/Geometry>

#include <array>

namespace bullet_ccd
{
/// Pose of A's core in the frame of B's.
struct Placement
{
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
};

/// Up to four pairs of points of the two cores, each in its own frame. Whatever the poses are, they
/// are points of the cores: so a simplex found at one pose begins the search at the next.
struct Simplex
{
    std::array<Eigen::Vector3d, 4> a{};
    std::array<Eigen::Vector3d, 4> b{};
    int size = 0;
};

/// Two cores at one pose, in the frame of B.
struct ClosestPoints
{
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
    double distance = 0.0;  ///< of these points: not less than that of the cores; 0 if they meet
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, from A to B; zero if they meet
    double gap = 0.0;  ///< along the normal: not more than the distance of the cores
};

/// @param enough  the search ends early where the gap is larger than this and most of the distance
/// @param apart   the cores are known not to meet: then they are not said to, whatever
///                rounding says
/// @param simplex where to begin; empty if nothing is known. On return, what carries the points.
/// @pre neither is a half-space
[[nodiscard]] BULLET_CCD_API ClosestPoints closestPoints(const ConvexShape& coreA,
                                                         const ConvexShape& coreB,
                                                         const Placement& pose,
                                                         double enough,
                                                         bool apart,
                                                         Simplex& simplex);
}  // namespace bullet_ccd
