/// Certified steps of one pair of volumes or triangles from one pose: the inner half of
/// firstContact(). Everything is expressed in the axes of B's tree at that time.
#pragma once

#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <Eigen/Geometry>

#include <limits>

namespace bullet_ccd
{
/// What stays the same for a pair of bodies during a query.
struct PairConstants
{
    const SsvTree* treeA = nullptr;
    const SsvTree* treeB = nullptr;
    std::int32_t base = kNone;  ///< link whose frame is the frame of the query
    AccelerationBound accelerationA{};
    AccelerationBound accelerationB{};
    Eigen::Vector3d offsetA{};  ///< from the body's origin to the tree's, in the tree's axes
    Eigen::Vector3d offsetB{};
    double threshold = 0.0;  ///< in contact at this distance
};

/// Relative state of a pair at one time; everything in the axes of B's tree.
struct PairState
{
    std::int32_t pair = kNone;
    double time = -1.0;
    Eigen::Matrix3d R{};  ///< A's tree in B's
    Eigen::Vector3d p{};
    Eigen::Vector3d vA{}, wA{};  ///< velocity of A's tree origin, angular velocity
    Eigen::Vector3d vB{}, wB{};  ///< of B's
    double spinA = 0.0, spinB = 0.0;
    double rounding = 0.0;
};

/// What a step from one pose certifies.
struct Step
{
    double time = 0.0;  ///< no contact before it, counted from the pose
    double gap = -std::numeric_limits<double>::infinity();
};

/// Two triangles at one pose: exact distance and the certified step.
struct TriangleStep
{
    TriangleDistance distance;
    double time = 0.0;
};

/// Certified step of two volumes: the best over all separating axes.
[[nodiscard]] Step nodeStep(const PairConstants& constants,
                            const PairState& state,
                            const SsvNode& nodeA,
                            const SsvNode& nodeB);

/// Exact distance and certified step of two triangles (indices into the meshes of the trees).
[[nodiscard]] TriangleStep triangleStep(const PairConstants& constants,
                                        const PairState& state,
                                        std::int32_t triangleA,
                                        std::int32_t triangleB);
}  // namespace bullet_ccd
