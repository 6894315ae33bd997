#include "grasp/quality/hold_score.h"

#include "grasp/quality/hold_score_coefficients.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kEnough = 4.0;
}  // namespace

double holdScore(const Grasp& grasp, double mass)
{
    if (!grasp.quality.largestMass)
    {
        return 0.0;
    }
    const double ratio = std::min(kEnough, *grasp.quality.largestMass / mass + 0.1);
    const std::array features{1.0, std::log(ratio), grasp.quality.epsilon};
    static_assert(features.size() == kHoldScore.size());
    const double sum =
        std::inner_product(features.begin(), features.end(), kHoldScore.begin(), 0.0);
    return 1.0 / (1.0 + std::exp(-sum));
}
}  // namespace bullet_ccd::grasp
