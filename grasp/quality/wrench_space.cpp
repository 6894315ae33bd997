#include "grasp/quality/wrench_space.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/contact_models.h"
#include "grasp/quality/exact_epsilon.h"
#include "grasp/quality/hull_about_origin.h"

namespace bullet_ccd::grasp
{
std::vector<Wrench> contactWrenches(std::span<const GraspContact> contacts,
                                    const Eigen::Vector3d& reference,
                                    const WrenchSpaceOptions& options)
{
    require(options.torqueScale > 0.0, "wrench space: torqueScale must be positive");
    const ContactLaw law = simplified(
        {.model = options.model, .friction = options.friction, .torsion = options.torsion});
    const Eigen::MatrixXd edges = grasp::coneEdges(law, options.coneEdges);
    std::vector<Wrench> wrenches;
    wrenches.reserve(contacts.size() * static_cast<std::size_t>(edges.cols()));
    for (const GraspContact& contact : contacts)
    {
        const ContactBasis basis = contactBasis(contact, law, reference, options.torqueScale);
        for (Eigen::Index edge = 0; edge < edges.cols(); ++edge)
        {
            wrenches.emplace_back(basis * edges.col(edge));
        }
    }
    return wrenches;
}

namespace
{
Eigen::MatrixXd columnsOf(std::span<const Wrench> wrenches)
{
    Eigen::MatrixXd points(6, static_cast<Eigen::Index>(wrenches.size()));
    for (std::size_t i = 0; i < wrenches.size(); ++i)
    {
        points.col(static_cast<Eigen::Index>(i)) = wrenches[i];
    }
    return points;
}
}  // namespace

double wrenchSpaceEpsilon(std::span<const Wrench> wrenches)
{
    constexpr double kTolerance = 1e-9;
    const Eigen::MatrixXd points = columnsOf(wrenches);
    const auto farthest = [&](const Eigen::VectorXd& direction) -> Eigen::VectorXd
    {
        Eigen::Index best = 0;
        (direction.transpose() * points).maxCoeff(&best);
        return points.col(best);
    };
    const auto limit = static_cast<int>(wrenches.size());
    return largestBallAboutOrigin(farthest, points, kTolerance, limit).lower;
}

GraspQuality wrenchSpaceQuality(std::span<const Wrench> wrenches, double forceClosureThreshold)
{
    const HullAboutOrigin hull = hullAboutOrigin(columnsOf(wrenches));
    return {.epsilon = hull.radius,
            .volume = hull.volume,
            .forceClosure = hull.radius > 0.0 && hull.radius >= forceClosureThreshold};
}
}  // namespace bullet_ccd::grasp
