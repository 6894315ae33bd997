#include "tests/stability/cases.h"

#include "tests/stability/catalogue.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
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

namespace
{
/// Stable: a case that has two forms keeps their order.
template <typename Case>
std::vector<Case> inOrder(std::initializer_list<std::vector<Case>> groups)
{
    std::vector<Case> all;
    for (const std::vector<Case>& group : groups)
    {
        std::copy(group.begin(), group.end(), std::back_inserter(all));
    }
    std::stable_sort(
        all.begin(), all.end(), [](const Case& a, const Case& b) { return a.id < b.id; });
    for (Case& tested : all)
    {
        tested.title = catalogueRow(tested.id).title;
    }
    return all;
}
}  // namespace

std::vector<RigidCase> rigidCases()
{
    return inOrder({translationCases(),
                    rotationCases(),
                    grazingCases(),
                    degenerateCases(),
                    stateCases(),
                    foundCases()});
}

std::vector<ArticulatedCase> articulatedCases()
{
    return inOrder({chainCases(), graspCases(), foundChainCases()});
}
}  // namespace bullet_ccd::tests
