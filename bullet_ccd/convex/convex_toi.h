/// First contact of two moving convex shapes, exact shapes without triangles.
///
/// One idea is behind it: a direction that separates the shapes now does so for a while. The gap
/// along a direction, which may itself turn, is a semi-concave function of time, so that two
/// evaluations of it certify all times in between. Where it ends to separate, a better direction is
/// looked for. bullet_ccd/convex/README.md has the proof.
#pragma once

#include "bullet_ccd/convex/convex_shape.h"
#include "bullet_ccd/export.h"
#include "bullet_ccd/motion/rigid_motion.h"
#include "bullet_ccd/toi/toi.h"

#include <Eigen/Geometry>

namespace bullet_ccd
{
/// A shape, its place in the body, and the body's motion X_W(t), t in [0, 1].
struct ConvexBody
{
    const ConvexShape* shape = nullptr;
    RigidMotion motion{};
    Eigen::Isometry3d X_BG = Eigen::Isometry3d::Identity();  ///< pose of the shape in the body
};

/// First time in [0, 1] at which two rigidly moving convex shapes come within `options.tolerance`.
///
/// Guarantee: no contact for t in [0, result.time); ToiStatus says what each outcome promises. As
/// rigidToi(), but the shapes are solid and exact: one that is inside the other is Overlapping, and
/// a distance is that of the solids. There are no triangles to name; the points are the closest
/// points. ToiOptions::strategy has no meaning here; maxIterations counts directions.
///
/// Allocates nothing. At most one of the shapes is a half-space.
/// Throws std::invalid_argument for motions that are not finite, a tolerance that is not positive,
/// a null shape, and two half-spaces.
[[nodiscard]] BULLET_CCD_API ToiResult convexToi(const ConvexBody& bodyA,
                                                 const ConvexBody& bodyB,
                                                 const ToiOptions& options);
}  // namespace bullet_ccd
