/// The wrench space of a grasp, with pyramids in place of friction cones, and its two classical
/// qualities.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
/// How contacts become a wrench space.
struct WrenchSpaceOptions
{
    double friction = ContactLaw{}.friction;  ///< Coulomb coefficient mu
    int coneEdges = 8;                        ///< edges of the inscribed friction pyramid
    double torqueScale = 1;                   ///< lambda [m]; moments are divided by it
    double forceClosureThreshold = 0.005;
    ContactModel model = ContactModel::HardFinger;
    double torsion = ContactLaw{}.torsion;  ///< soft finger: e [m]
};

/// The edges of all friction pyramids as wrenches (force; moment / lambda) in W, contact by
/// contact. Every edge has a normal force of 1.
/// @param reference origin of the moments, in W [m]
/// Throws std::invalid_argument for a torque scale that is not positive.
[[nodiscard]] BULLET_CCD_API std::vector<Wrench> contactWrenches(
    std::span<const GraspContact> contacts,
    const Eigen::Vector3d& reference,
    const WrenchSpaceOptions& options);

/// Epsilon and volume of the convex hull of the wrenches (L1: normal forces sum to at most 1), by
/// qhull. A hull that does not contain the origin, or is flat, has epsilon 0; a flat one also has
/// volume 0. Neither is an error. The result is deterministic.
[[nodiscard]] BULLET_CCD_API GraspQuality wrenchSpaceQuality(std::span<const Wrench> wrenches,
                                                             double forceClosureThreshold);

/// Epsilon alone, many times as fast: only those facets of the hull are made that could be the
/// nearest.
///
/// Guarantee: the result is within 1e-9 of what wrenchSpaceQuality() finds.
[[nodiscard]] BULLET_CCD_API double wrenchSpaceEpsilon(std::span<const Wrench> wrenches);
}  // namespace bullet_ccd::grasp
