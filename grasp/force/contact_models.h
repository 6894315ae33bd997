/// What forces a contact can pass on: frictionless, hard finger (Coulomb), soft finger.
///
/// A contact force has local coordinates (f_n, f_1, f_2, m_n): along the normal into the object,
/// two tangents, and the torsional moment about the normal; a model uses the first 1, 3 or 4 of
/// them. Its cone, for which all three are one formula:
///     sqrt(|f_t|^2 + (m_n / e)^2) <= mu f_n
#pragma once

#include "grasp/grasp_types.h"

#include <Eigen/Core>

#include <span>

namespace bullet_ccd::grasp
{
/// The simplest law with the same cone: without friction no tangents, without torsion a hard
/// finger. A cone thus has inner points in all of its coordinates. Throws std::invalid_argument for
/// negative or non-finite numbers.
[[nodiscard]] ContactLaw simplified(const ContactLaw& law);

/// Number of local coordinates: 1, 3 or 4.
/// @pre the law is simplified, here and below
[[nodiscard]] Eigen::Index coordinateCount(const ContactLaw& law);

/// Coordinates of a contact force; those that the model does not use do not exist.
using LocalForce = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 4, 1>;
/// Wrenches of the unit local coordinates, one a column.
using ContactBasis = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 4>;

/// Wrenches about `reference`, moments divided by `torqueScale` [m].
[[nodiscard]] ContactBasis contactBasis(const GraspContact& contact,
                                        const ContactLaw& law,
                                        const Eigen::Vector3d& reference,
                                        double torqueScale);

/// Largest value of direction . f over the forces f of the cone with normal part 1:
/// direction_n + mu sqrt(|direction_t|^2 + (e direction_m)^2).
[[nodiscard]] double coneSupport(const ContactLaw& law, const LocalForce& direction);
/// The force of the cone with normal part 1 that attains it.
[[nodiscard]] LocalForce coneSupportPoint(const ContactLaw& law, const LocalForce& direction);

/// mu f_n - sqrt(|f_t|^2 + (m_n / e)^2) [N]: how much friction is left; negative outside the cone.
/// Frictionless: f_n, for the contact can but part.
[[nodiscard]] double slipMargin(const ContactLaw& law, const LocalForce& force);

/// Edges of a pyramid inscribed in the cone, normal part 1, one a column. Hard finger: `edges` of
/// them, the first along the first tangent. Soft finger: 3 * edges + 2 on the latitudes 0, +-45 and
/// +-90 degrees of the ellipsoid. Frictionless: the normal.
[[nodiscard]] Eigen::MatrixXd coneEdges(const ContactLaw& law, int edges);

/// Throws std::invalid_argument "contact <number>: <what, value>: <remedy>" unless all points and
/// normals are finite and the normals have unit length.
void requireValidContacts(std::span<const GraspContact> contacts);
}  // namespace bullet_ccd::grasp
