/// Eight pairs of nodes at eight poses: the input and output of the SIMD kernels. Plain data only,
/// because the kernels are compiled for several instruction sets and must not share inline code.
#pragma once

#include "bullet_ccd/hierarchy/ssv_node.h"

namespace bullet_ccd
{
/// Structure of arrays, one lane a pair. Vectors are in the axes of B's tree; A and B are the trees
/// of the pair, x a point of a node in its own tree's frame:
///   place of x in A     R (x + armA) + p
///   its velocity        velocity + wA x (R (x + armA))
///   place of x in B     x
///   its velocity        wB x (x + armB)
///   |acceleration| of x in A relative to B, along a unit direction n, over the rest of the step:
///     constant + perRadiusA |x + radiusArmA| + axisA |wA x n| |wA x (R (x + armA))|
///   and for B the like.
struct alignas(64) NodeBatch
{
    static constexpr int kLanes = 8;

    const SsvNode* a[kLanes];
    const SsvNode* b[kLanes];
    float R[9][kLanes];  ///< row by row
    float p[3][kLanes];
    float armA[3][kLanes];
    float velocity[3][kLanes];
    float wA[3][kLanes];
    float spinA[kLanes];  ///< |wA|, rounded up
    float constant[kLanes];
    float axisA[kLanes];
    float margin[kLanes];      ///< distance that must remain: subtracted from every gap
    float slack[kLanes];       ///< rounding of gaps along directions that are not normalised yet
    float speedSlack[kLanes];  ///< rounding of velocities

    float perRadiusA[kLanes];
    float radiusArmA[3][kLanes];
    float armB[3][kLanes];
    float wB[3][kLanes];
    float spinB[kLanes];
    float perRadiusB[kLanes];
    float axisB[kLanes];

    float step[kLanes];  ///< output: time in which the pair cannot come within the margin
    float gap[kLanes];   ///< output: by which it is farther apart than the margin, a lower bound

    bool turnsB = false;     ///< else wB, armB, spinB and axisB count as zero
    bool hasRadius = false;  ///< else perRadiusA and perRadiusB count as zero
};

/// Writes batch.step and batch.gap: for every lane the largest step that one of the separating axes
/// of its pair certifies, rounded down.
void nodeSteps(NodeBatch& batch);

/// Poses of two rigid bodies as functions of time, for eight times at once.
///
/// A's reference point moves from d0 at velocity v relative to B's; both turn about fixed axes. If
/// B does not turn all is in the axes of B's tree, else in those of the world.
struct RigidPoses
{
    double d0[3];
    double v[3];
    double rateA;  ///< |w| of A [rad per step]
    double rateB;
    float turnA[3][9];  ///< R_A(t) = turnA[0] + cos turnA[1] + sin turnA[2]
    float turnB[3][9];  ///< the same for the transposed rotation of B, if it turns
    float wA[3];
    float wB[3];    ///< in the axes of B's tree
    float armB[3];  ///< from B's reference to its tree's origin, in the tree's axes
    bool turnsB;
    /// A is seen from B's turning frame, where B rests: common rotation cancels. Needs wBw, the
    /// angular velocity of B in W, and wA holds that of A relative to B, in W.
    bool inFrameOfB;
    double wBw[3];
};

/// Fills R, p, velocity, wA and slack of `batch` for the given times.
void rigidPoses(const RigidPoses& poses,
                const double (&times)[NodeBatch::kLanes],
                float slackPerMeter,
                float slackFloor,
                NodeBatch& batch);
}  // namespace bullet_ccd
