/// Certified steps of one pair of volumes or triangles from one pose: the inner half of
/// firstContact().
#pragma once

#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/toi/kernels/triangle_approach.h"

#include <algorithm>
#include <limits>

namespace bullet_ccd
{
/// How near the bodies of a pair may come.
struct PairLimits
{
    double floor = 0.0;      ///< distance that must be kept
    double threshold = 0.0;  ///< in contact at this distance
    double aim = 0.0;        ///< part of what is between them that a step leaves
    bool anyWithin = false;  ///< any distance up to the threshold is near enough

    /// Distance that no step may go below.
    [[nodiscard]] double margin() const { return floor + aim * (threshold - floor); }
    /// Near enough to stop.
    [[nodiscard]] double near() const
    {
        return anyWithin ? threshold : floor + std::min(1.0, 2.0 * aim) * (threshold - floor);
    }
    /// How thick two volumes may be together that are looked through (see meetsBelow()).
    [[nodiscard]] double room() const { return anyWithin ? 0.5 * (threshold - floor) : 0.0; }
};

/// Relative state of a pair of bodies at one time.
struct PairState
{
    std::int32_t pair = kNone;
    double time = -1.0;
    RelativeMotion motion{};
    double rounding = 0.0;  ///< of a gap, over the rest of the step [m]
};

/// What a step from one pose certifies.
struct Step
{
    double time = 0.0;  ///< no contact before it, counted from the pose
    double gap = -std::numeric_limits<double>::infinity();
};

/// Two triangles at one pose: distance and the certified step.
struct TriangleStep
{
    TriangleDistance distance;
    double time = 0.0;
};

/// Certified step of two volumes, the best over all separating axes, in double precision: the
/// reference of nodeSteps().
[[nodiscard]] Step nodeStep(const RelativeMotion& motion,
                            double margin,
                            const SsvNode& nodeA,
                            const SsvNode& nodeB);

/// Certified step of two nodes along the normals of the largest faces, in double precision: where
/// flat lies on flat, the gap is smaller than what single precision can say.
/// @param byVertices the nodes are the roots: extents are those of all vertices, so that whatever
///                   lies on a flat face is apart from it, round as it may be; in O(vertices)
[[nodiscard]] Step flatStep(const SsvTree& treeA,
                            const SsvTree& treeB,
                            const PairState& state,
                            double margin,
                            std::int32_t nodeA,
                            std::int32_t nodeB,
                            bool byVertices = false);

/// Certified step of two triangles in slots of the trees along their normals, and along the
/// direction between their closest points. It is long where they slide along each other: closest
/// points at their edges see only what comes towards them.
/// @param across from A to B between their closest points, in the frame of B's tree
[[nodiscard]] double slidingStep(const SsvTree& treeA,
                                 const SsvTree& treeB,
                                 const PairState& state,
                                 double margin,
                                 std::int32_t slotA,
                                 std::int32_t slotB,
                                 const Eigen::Vector3d& across);

/// Distance and certified step of two triangles in slots of the trees.
/// @param apart they are known not to touch at this time
[[nodiscard]] TriangleStep triangleStep(const SsvTree& treeA,
                                        const SsvTree& treeB,
                                        const PairState& state,
                                        double margin,
                                        bool apart,
                                        std::int32_t slotA,
                                        std::int32_t slotB);
}  // namespace bullet_ccd
