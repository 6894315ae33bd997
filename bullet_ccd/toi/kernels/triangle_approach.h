/// Two triangles at one pose: the input and output of the SIMD kernel. Plain data only, see
/// node_batch.h.
#pragma once

namespace bullet_ccd
{
/// Relative motion of a pair of bodies at one time, in double precision. Vectors are in the axes of
/// B's tree; A and B are the trees of the pair, x a point in its own tree's frame:
///   place of x in A     R (x + armA) + p
///   its velocity        velocity + wA x (R (x + armA))
///   place of x in B     x
///   its velocity        wB x (x + armB)
///   |acceleration| of x in A relative to B, along a unit direction n, over the rest of the step:
///     constant + perRadiusA |x + radiusArmA| + axisA |wA x n| |wA x (R (x + armA))|
///   and for B the like. NodeBatch has the same in single precision.
/// Where all of that is in a plane with the unit normal u, which rests in the axes of n, no point
/// accelerates along u: then |n x u| times these bounds counts, and `acrossPlane`.
struct RelativeMotion
{
    double R[9];  ///< row by row
    double p[3];
    double armA[3];
    double velocity[3];
    double wA[3];
    double spinA;  ///< |wA|
    double constant;
    double perRadiusA;
    double radiusArmA[3];
    double axisA;
    double wB[3];
    double armB[3];
    double spinB;
    double perRadiusB;
    double axisB;
    double plane[3];     ///< u, or zero if there is no such plane
    double acrossPlane;  ///< acceleration along u after all, by rounding
};

/// Closest points of two triangles by their edges and corners, and what follows for the motion
/// along the direction between them.
struct TriangleApproach
{
    double pointA[3];  ///< on A, in B's tree
    double pointB[3];
    double distance;  ///< of the two points: an upper bound of the distance of the triangles
    double gap;       ///< of the triangles along the direction of the points: a lower bound
    double time;      ///< in which no pair of corners can bring the gap down to the margin
};

/// Corners are given in their trees' frames. If the triangles intersect, or the direction is badly
/// conditioned, gap falls short of distance; the answer is then of no use.
void approachTriangles(const RelativeMotion& motion,
                       const double* cornersA,
                       const double* cornersB,
                       double margin,
                       TriangleApproach& approach);

/// The last line of approachTriangles() for another direction n, a unit vector from A to B: fills
/// gap and time only.
void approachAlong(const RelativeMotion& motion,
                   const double* cornersA,
                   const double* cornersB,
                   const double* n,
                   double margin,
                   TriangleApproach& approach);
}  // namespace bullet_ccd
