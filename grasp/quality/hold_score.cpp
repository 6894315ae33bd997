#include "grasp/quality/hold_score.h"

#include "grasp/quality/hold_score_coefficients.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kMostRatio = 1000.0;

double spread(const Grasp& grasp)
{
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const GraspContact& contact : grasp.contacts)
    {
        mean += contact.point / static_cast<double>(grasp.contacts.size());
    }
    double squared = 0.0;
    for (const GraspContact& contact : grasp.contacts)
    {
        squared +=
            (contact.point - mean).squaredNorm() / static_cast<double>(grasp.contacts.size());
    }
    return std::sqrt(squared);
}
}  // namespace

double holdScore(const Grasp& grasp, const GraspObject& object, double mass)
{
    if (!grasp.quality.largestMass)
    {
        return 0.0;
    }
    const double ratio = std::min(kMostRatio, *grasp.quality.largestMass / mass);
    const std::array features{1.0, std::log(ratio + 0.1), spread(grasp) / object.radius};
    static_assert(features.size() == kHoldScore.size());
    const double sum =
        std::inner_product(features.begin(), features.end(), kHoldScore.begin(), 0.0);
    return 1.0 / (1.0 + std::exp(-sum));
}
}  // namespace bullet_ccd::grasp
