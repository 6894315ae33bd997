#include "grasp/quality/exact_epsilon.h"

#include "bullet_ccd/math/check.h"
#include "grasp/quality/inner_hull.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
/// Edges of the pyramids whose wrenches the search starts from.
constexpr int kStartEdges = 4;
}  // namespace

Wrench wrenchSupport(std::span<const ContactBasis> bases,
                     const ContactLaw& law,
                     WrenchNorm norm,
                     const Wrench& direction)
{
    Wrench sum = Wrench::Zero();
    Wrench best = Wrench::Zero();
    double largest = -std::numeric_limits<double>::infinity();
    for (const ContactBasis& basis : bases)
    {
        const LocalForce local = basis.transpose() * direction;
        const double reach = coneSupport(law, local);
        const bool isBest = reach > largest;
        if ((norm == WrenchNorm::L1 && isBest) || (norm == WrenchNorm::LInfinity && reach > 0.0))
        {
            const Wrench wrench = basis * coneSupportPoint(law, local);
            best = isBest ? wrench : best;
            largest = std::max(largest, reach);
            sum += wrench;
        }
    }
    return norm == WrenchNorm::L1 ? best : sum;
}

EpsilonBounds largestBallAboutOrigin(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& support,
    const Eigen::MatrixXd& start,
    double resolution,
    int maxPoints,
    double share)
{
    InnerHull hull(start);
    if (hull.flat())
    {
        return {};
    }
    EpsilonBounds bounds{.upper = std::numeric_limits<double>::infinity()};
    for (; bounds.points < maxPoints; ++bounds.points)
    {
        const std::int32_t nearest = hull.nearestFacet();
        const InnerHull::Vector normal = hull.facet(nearest).normal;
        bounds.lower = hull.facet(nearest).offset;
        const InnerHull::Vector point = support(normal);
        bounds.upper = std::min(bounds.upper, normal.dot(point));
        if (bounds.upper <= 0.0 ||
            bounds.upper - bounds.lower <= std::max(resolution, share * bounds.upper))
        {
            break;
        }
        hull.add(point, nearest);
    }
    bounds.upper = std::max(bounds.upper, 0.0);
    bounds.lower = std::clamp(bounds.lower, 0.0, bounds.upper);
    return bounds;
}

EpsilonBounds exactEpsilon(std::span<const GraspContact> contacts,
                           const Eigen::Vector3d& reference,
                           const ExactEpsilonOptions& options)
{
    requireValidContacts(contacts);
    require(options.torqueScale > 0.0 && std::isfinite(options.torqueScale),
            "exact epsilon: torque scale " + std::to_string(options.torqueScale) +
                ": give a positive length");
    require(options.resolution > 0.0, "exact epsilon: the resolution must be positive");
    require(reference.allFinite(), "exact epsilon: the reference is not finite");
    const ContactLaw law = simplified(options.law);
    const Eigen::MatrixXd edges = coneEdges(law, kStartEdges);
    std::vector<ContactBasis> bases;
    Eigen::MatrixXd start(6, edges.cols() * static_cast<Eigen::Index>(contacts.size()));
    for (const GraspContact& contact : contacts)
    {
        start.middleCols(edges.cols() * static_cast<Eigen::Index>(bases.size()), edges.cols()) =
            contactBasis(contact, law, reference, options.torqueScale) * edges;
        bases.push_back(contactBasis(contact, law, reference, options.torqueScale));
    }
    return largestBallAboutOrigin([&](const Eigen::VectorXd& u)
                                  { return wrenchSupport(bases, law, options.norm, u); },
                                  start,
                                  options.resolution,
                                  options.maxPoints,
                                  options.share);
}
}  // namespace bullet_ccd::grasp
