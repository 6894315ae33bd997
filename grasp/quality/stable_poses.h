/// On which faces of its convex hull an object stands.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"

#include <Eigen/Core>

#include <vector>

namespace bullet_ccd::grasp
{
struct StablePose
{
    Eigen::Vector3d down = Eigen::Vector3d::Zero();  ///< unit, object's frame, out of its face
    /// By how much the ground may lean, in the worst direction, before the object tips [rad].
    double tilt = 0.0;
};

/// Faces of the convex hull on which the centre of mass projects inside, so far from the edges that
/// the ground may lean by `leastTilt` [rad] before the object tips; those that stand firmest first.
/// A face is what the object touches a plane with, to a thousandth of its radius; faces whose
/// normals differ by less than 3 degrees are one. So a cylinder of many sides stands on its ends
/// and rolls on its sides. None for an object that spans no volume.
[[nodiscard]] BULLET_CCD_API std::vector<StablePose> stablePoses(const GraspObject& object,
                                                                 double leastTilt = 0.0873);
}  // namespace bullet_ccd::grasp
