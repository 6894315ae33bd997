#include "benchmarks/reference/catalogue/cases.h"

#include "benchmarks/reference/catalogue/catalogue.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <stdexcept>

namespace bullet_ccd::reference
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

RightTimes rightTimes(const CaseAnswer& answer, double tolerance, double rounding)
{
    constexpr double kUlps = 4.0 * std::numeric_limits<double>::epsilon();
    return {.earliest = answer.startsTouching
                            ? 0.0
                            : *answer.time - kUlps - 1.1 * leadTime(answer, tolerance + rounding),
            .latest = *answer.time + kUlps + leadTime(answer, rounding)};
}

ArticulatedScene sceneOf(const ArticulatedCase& tested)
{
    return {.tree = tested.tree,
            .motion = tested.motion,
            .linkMeshes = tested.linkMeshes,
            .selfPairs = tested.selfPairs,
            .obstacles = tested.obstacles,
            .obstacleMotions = std::vector<RigidMotion>(tested.obstacles.size())};
}

double roundingOf(const RigidCase& tested)
{
    return roundingOf(tested.scene);
}

double roundingOf(const ArticulatedCase& tested)
{
    double size = 0.0;
    for (const TriangleMesh& mesh : tested.obstacles)
    {
        size = std::max(size, radiusOf(mesh));
    }
    for (std::size_t i = 0; i < tested.tree.size(); ++i)
    {
        size += radiusOf(tested.linkMeshes[i]) + tested.tree.links[i].X_PL0.translation().norm();
    }
    const RigidMotion& root = tested.motion.root;
    return 64.0 * 1.2e-16 * (size + root.X_W0.translation().norm() + root.v_W.norm());
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

ArticulatedCase articulatedCase(std::string_view id)
{
    const std::vector<ArticulatedCase> all = articulatedCases();
    const auto found = std::ranges::find(all, id, &ArticulatedCase::id);
    return found == all.end() ? throw std::invalid_argument(std::string(id)) : *found;
}
}  // namespace bullet_ccd::reference
