/// Distance queries of two meshes at fixed poses.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/math/stop_condition.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// A pair of triangles and its closest points, in the frame of B [m].
struct TrianglePair
{
    std::int32_t triangleA = kNone;
    std::int32_t triangleB = kNone;
    double distance = 0.0;  ///< [m]
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
};

/// Marks of the nodes of two trees, one per node, or empty for no marks. A pair of nodes that are
/// both marked is left out, with all that is below them. The marks of the leaves decide which pairs
/// of triangles are left out.
struct NodeMarks
{
    std::span<const std::uint8_t> a{};
    std::span<const std::uint8_t> b{};

    [[nodiscard]] bool exempts(std::int32_t nodeA, std::int32_t nodeB) const
    {
        return !a.empty() && a[static_cast<std::size_t>(nodeA)] != 0 &&
               b[static_cast<std::size_t>(nodeB)] != 0;
    }
};

/// Distance of two meshes and a pair of triangles that has it. If the distance is not below
/// `upperBound`, the result is `upperBound` with triangles kNone.
///
/// Guarantee: the named pair is as far apart as the result says, up to rounding, and no other pair
/// is nearer by more than a millionth of it. This share is what ends the search where flat faces of
/// many triangles are equally far from each other everywhere.
/// @param X_BA       pose of A's frame in B's
/// @param upperBound [m]
[[nodiscard]] BULLET_CCD_API TrianglePair treeDistance(const SsvTree& treeA,
                                                       const SsvTree& treeB,
                                                       const Eigen::Isometry3d& X_BA,
                                                       double upperBound,
                                                       const NodeMarks& exempt = {});

/// A distance as far as it was found out.
struct DistanceBounds
{
    TrianglePair nearest;     ///< that was found; as treeDistance() says it if complete
    double lowerBound = 0.0;  ///< no pair of triangles is nearer [m]
    bool isComplete = true;   ///< false if the query was stopped before the nearest was known
};

/// treeDistance() that can be stopped. What was not looked at by then is bounded by its volumes.
[[nodiscard]] BULLET_CCD_API DistanceBounds distanceBounds(const SsvTree& treeA,
                                                           const SsvTree& treeB,
                                                           const Eigen::Isometry3d& X_BA,
                                                           double upperBound,
                                                           const StopCondition& stop,
                                                           const NodeMarks& exempt = {});

/// No bound of a distance.
constexpr double kAnyDistance = std::numeric_limits<double>::infinity();

/// A distance of two meshes that is right within an accuracy, and a pair of triangles that has it.
/// Nothing is opened that could be nearer than this pair by no more than the accuracy.
///
/// Guarantee: lowerBound <= true distance <= nearest.distance <= lowerBound + accuracy, up to the
/// share that treeDistance() names; so for meshes that are within the accuracy of each other any
/// pair within it will do. If no pair is below `upperBound`, nearest is as treeDistance() says.
/// @param X_BA     pose of A's frame in B's
/// @param accuracy [m], > 0
/// Throws std::invalid_argument for an accuracy that is not above 0, or a pose that is none.
[[nodiscard]] BULLET_CCD_API DistanceBounds distanceWithin(const SsvTree& treeA,
                                                           const SsvTree& treeB,
                                                           const Eigen::Isometry3d& X_BA,
                                                           double accuracy,
                                                           const StopCondition& stop = {},
                                                           const NodeMarks& exempt = {},
                                                           double upperBound = kAnyDistance);

/// Appends to `pairs` all pairs of triangles at a distance <= `threshold` [m], in the order of
/// (triangleA, triangleB). Points are in the frame of B.
/// @return false if the query was stopped before all were found
BULLET_CCD_API bool trianglePairsWithin(const SsvTree& treeA,
                                        const SsvTree& treeB,
                                        const Eigen::Isometry3d& X_BA,
                                        double threshold,
                                        std::vector<TrianglePair>& pairs,
                                        const StopCondition& stop = {});

/// Marks with 1 the triangles of both meshes that are at a distance <= `threshold` [m] from the
/// other mesh. Triangles that are marked already cost next to nothing, so that many poses can
/// follow each other, and meshes may intersect widely: pairs are not listed.
/// @param marksA,marksB one entry per triangle
/// @return false if the query was stopped before all were found
BULLET_CCD_API bool markTrianglesWithin(const SsvTree& treeA,
                                        const SsvTree& treeB,
                                        std::span<const Eigen::Isometry3d> posesOfAInB,
                                        double threshold,
                                        std::span<std::uint8_t> marksA,
                                        std::span<std::uint8_t> marksB,
                                        const StopCondition& stop = {});
}  // namespace bullet_ccd
