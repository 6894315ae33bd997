#include "tests/stability/cases.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace bullet_ccd::tests
{
double leadTime(const CaseAnswer& answer, double gap)
{
    double time = std::numeric_limits<double>::infinity();
    if (answer.closingSpeed > 0.0)
    {
        time = gap / answer.closingSpeed;
    }
    if (answer.closingAcceleration > 0.0)
    {
        time = std::min(time, std::sqrt(2.0 * gap / answer.closingAcceleration));
    }
    return time;
}

std::vector<RigidCase> rigidCases()
{
    std::vector<RigidCase> all;
    for (auto&& group : {translationCases(), rotationCases(), grazingCases(), degenerateCases()})
    {
        std::copy(group.begin(), group.end(), std::back_inserter(all));
    }
    return all;
}
}  // namespace bullet_ccd::tests
