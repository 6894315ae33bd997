/// Epsilon of a grasp with exact friction cones, by cutting planes on support functions.
///
/// In direction u = (u_f; u_m) contact i reaches h_i(u), the support of its cone at normal force 1.
/// The wrench space of all contacts reaches max_i h_i (L1: normal forces sum to at most 1) or
/// sum_i max(0, h_i) (L-infinity: each at most 1). Epsilon is the least of that over |u| = 1, which
/// no pyramids are needed for; only its search is finite.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/force/contact_models.h"

#include <functional>
#include <span>

namespace bullet_ccd::grasp
{
enum class WrenchNorm : std::uint8_t
{
    L1,
    LInfinity,
};

struct ExactEpsilonOptions
{
    ContactLaw law{};
    WrenchNorm norm = WrenchNorm::L1;
    double torqueScale = 1.0;  ///< lambda [m]: moments are divided by it
    double resolution = 1e-6;  ///< how far apart the bounds may be in the end,
    double share = 0.0;        ///< or this part of the upper one, if that is more
    int maxPoints = 4000;      ///< of the polytope inside the wrench space
};

struct EpsilonBounds
{
    double lower = 0.0;  ///< a ball of this radius fits; 0: none was shown to
    double upper = 0.0;  ///< none of more than this does; 0: no force closure
    int points = 0;      ///< that the search took

    [[nodiscard]] bool forceClosure() const { return lower > 0.0; }
};

/// Guarantee: lower <= epsilon <= upper, up to rounding (1e-12); they differ by at most what the
/// options say unless maxPoints came first. Flat wrench spaces, such as that of two hard contacts,
/// have 0. Throws std::invalid_argument for contacts, laws or a torque scale that make no sense.
[[nodiscard]] BULLET_CCD_API EpsilonBounds exactEpsilon(std::span<const GraspContact> contacts,
                                                        const Eigen::Vector3d& reference,
                                                        const ExactEpsilonOptions& options);

/// The same for any convex set, in 2 to 6 dimensions.
/// @param support  for a unit direction u the point x of the set with the largest u . x
/// @param start    points of the set, one a column; the search starts from a simplex of them
[[nodiscard]] BULLET_CCD_API EpsilonBounds
largestBallAboutOrigin(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& support,
                       const Eigen::MatrixXd& start,
                       double resolution,
                       int maxPoints,
                       double share = 0.0);

/// The wrench farthest along `direction` in the space that the bases span, one basis a contact.
[[nodiscard]] BULLET_CCD_API Wrench wrenchSupport(std::span<const ContactBasis> bases,
                                                  const ContactLaw& law,
                                                  WrenchNorm norm,
                                                  const Wrench& direction);
}  // namespace bullet_ccd::grasp
