#include "bullet_ccd/deformable/certain_touch.h"
#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/deformable/exact_contact.h"
#include "bullet_ccd/deformable/moving_polygon.h"
#include "bullet_ccd/deformable/pursue.h"
#include "bullet_ccd/math/check.h"

#include <cmath>
#include <string>

namespace bullet_ccd
{
namespace
{
void checkFinite(const FourPoints& points, const char* when)
{
    for (std::size_t k = 0; k < points.size(); ++k)
    {
        if (!isPlace(points[k]))
        {
            throw std::invalid_argument("elementaryToi(): vertex " + std::to_string(k) +
                                        " at the " + when +
                                        " is not finite or farther from the origin than 1e12: give "
                                        "coordinates within that");
        }
    }
}
}  // namespace

void checkElementaryOptions(const ElementaryOptions& options)
{
    require(options.tolerance > 0.0 && std::isfinite(options.tolerance),
            "the tolerance must be a positive distance");
    require(options.minimumSeparation >= 0.0 && std::isfinite(options.minimumSeparation),
            "the minimum separation must be zero or a positive distance");
    require(options.maxIterations > 0, "maxIterations must be positive");
}

ElementaryResult elementaryToi(const ElementaryPair& pair, const ElementaryOptions& options)
{
    checkElementaryOptions(options);
    checkFinite(pair.start, "start");
    checkFinite(pair.end, "end");
    return uncheckedElementaryToi(pair, options);
}

ElementaryResult uncheckedElementaryToi(const ElementaryPair& pair,
                                        const ElementaryOptions& options)
{
    Pursuit pursuit = pair.kind == ElementaryKind::VertexFace ? pursue<3>(pair, options)
                                                              : pursue<4>(pair, options);
    ElementaryResult& result = pursuit.result;
    const bool isOpen = isContact(result.status) || gaveUp(result.status);
    if (options.depth == ElementaryDepth::Exact && isOpen)
    {
        if (!certainlyTouch(pair, options.minimumSeparation, result.time) &&
            !featuresTouch(pair, options.minimumSeparation))
        {
            result = {
                .status = pursuit.startsNear ? ToiStatus::TouchingLeaving : ToiStatus::Separated,
                .gap = options.minimumSeparation,
                .iterations = result.iterations};
        }
        else if (result.status == ToiStatus::IterationLimit)
        {
            // They touch: what was certified before stays, and no later time is known.
            result.status = pursuit.startsNear ? ToiStatus::TouchingPressing : ToiStatus::Hit;
        }
    }
    return result;
}
}  // namespace bullet_ccd
