#include "grasp/squeeze/hold_score.h"

#include "grasp/squeeze/hold_score_coefficients.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace bullet_ccd::grasp
{
double holdScore(const Grasp& grasp, const Squeeze& squeeze)
{
    if (!squeeze.exists())
    {
        return 0.0;
    }
    std::set<std::int32_t> links;
    for (const GraspContact& contact : grasp.contacts)
    {
        links.insert(contact.link);
    }
    const std::array features{1.0,
                              std::sqrt(std::max(0.0, grasp.quality.epsilon)),
                              std::log(squeeze.weights + 0.1),
                              static_cast<double>(links.size())};
    static_assert(features.size() == kHoldScore.size());
    const double sum =
        std::inner_product(features.begin(), features.end(), kHoldScore.begin(), 0.0);
    return 1.0 / (1.0 + std::exp(-sum));
}
}  // namespace bullet_ccd::grasp
