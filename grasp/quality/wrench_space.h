/// Grasp wrench space of contacts with pyramids for cones, and its two classical qualities.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
struct WrenchSpaceOptions
{
    double friction = ContactLaw{}.friction;  ///< Coulomb coefficient mu
    int coneEdges = 8;                        ///< edges of the inscribed friction pyramid
    double torqueScale = 1;                   ///< lambda [m]: moments are divided by it
    double forceClosureThreshold = 0.005;
    ContactModel model = ContactModel::HardFinger;
    double torsion = ContactLaw{}.torsion;  ///< soft finger: e [m]
};

/// Edges of the friction pyramids (coneEdges() of contact_models.h), as wrenches about `reference`.
/// Unit normal force each; contact by contact, as many as the model has edges.
[[nodiscard]] BULLET_CCD_API std::vector<Wrench> contactWrenches(
    std::span<const GraspContact> contacts,
    const Eigen::Vector3d& reference,
    const WrenchSpaceOptions& options);

/// Epsilon and volume of the convex hull of the wrenches (L1: normal forces sum to at most 1), by
/// qhull. A hull that does not contain the origin, or is flat, has epsilon 0 (a flat one volume 0
/// as well): an answer, not a failure. Deterministic.
[[nodiscard]] BULLET_CCD_API GraspQuality wrenchSpaceQuality(std::span<const Wrench> wrenches,
                                                             double forceClosureThreshold);

/// Epsilon alone, to 1e-9 of what wrenchSpaceQuality() finds, many times as fast: of the hull only
/// those facets are made that could be the nearest.
[[nodiscard]] BULLET_CCD_API double wrenchSpaceEpsilon(std::span<const Wrench> wrenches);
}  // namespace bullet_ccd::grasp
