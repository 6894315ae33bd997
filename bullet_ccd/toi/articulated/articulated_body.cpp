#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"
#include "bullet_ccd/toi/articulated/articulated_culling.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace bullet_ccd
{
namespace
{
bool isFinite(const JointMotion& motion)
{
    const RigidMotion& root = motion.root;
    const auto finite = [](const std::vector<double>& values) {
        return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
    };
    return root.v_W.allFinite() && root.w_W.allFinite() && root.reference_B.allFinite() &&
           finite(motion.positions) && finite(motion.rates) &&
           std::all_of(motion.curves.begin(),
                       motion.curves.end(),
                       [](const JointCurve& curve)
                       { return std::isfinite(curve[0] + curve[1] + curve[2] + curve[3]); }) &&
           std::all_of(motion.balls.begin(),
                       motion.balls.end(),
                       [](const BallMotion& ball)
                       { return ball.start.allFinite() && ball.rate.allFinite(); });
}
}  // namespace

void checkBody(const ArticulatedBody& body)
{
    require(body.tree != nullptr && body.motion != nullptr,
            "articulatedToi: there is no kinematic tree, or no motion of its joints");
    const std::size_t links = body.tree->size();
    const bool hasBalls =
        std::any_of(body.tree->links.begin(),
                    body.tree->links.end(),
                    [](const Link& link) { return link.joint.type == JointType::Spherical; });
    // Messages are built only where they are needed: a query is to allocate nothing.
    if (body.linkTrees.size() != links || body.motion->positions.size() != links ||
        body.motion->rates.size() != links || (hasBalls && body.motion->balls.size() != links) ||
        (!body.motion->curves.empty() && body.motion->curves.size() != links))
    {
        throw std::invalid_argument("articulatedToi: " + std::to_string(links) + " links, but " +
                                    std::to_string(body.linkTrees.size()) + " hierarchies, " +
                                    std::to_string(body.motion->positions.size()) + " positions, " +
                                    std::to_string(body.motion->rates.size()) + " rates, " +
                                    std::to_string(body.motion->balls.size()) +
                                    " motions of spherical joints and " +
                                    std::to_string(body.motion->curves.size()) +
                                    " curves: give one of each a link, and curves if there are "
                                    "any");
    }
    require(isFinite(*body.motion),
            "time of impact: a velocity or joint position is NaN or infinite");
    if (!isPose(body.motion->root.X_W0))
    {
        failPose("articulatedToi: pose of the root", body.motion->root.X_W0);
    }
    const auto count = static_cast<std::int32_t>(links);
    for (const auto& [linkA, linkB] : body.selfPairs)
    {
        const bool isGood = linkA >= 0 && linkB >= 0 && linkA < count && linkB < count &&
                            linkA != linkB &&
                            body.linkTrees[static_cast<std::size_t>(linkA)] != nullptr &&
                            body.linkTrees[static_cast<std::size_t>(linkB)] != nullptr;
        if (!isGood)
        {
            throw std::invalid_argument("articulatedToi: the pair of links (" +
                                        std::to_string(linkA) + ", " + std::to_string(linkB) +
                                        ") does not name two links with geometry");
        }
    }
}

std::vector<std::pair<std::int32_t, std::int32_t>> selfPairsOf(
    const KinematicTree& tree,
    std::span<const SsvTree* const> linkTrees,
    std::span<const std::pair<std::int32_t, std::int32_t>> disabled)
{
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
    // Links that only fixed joints lie between are one body.
    std::vector<std::int32_t> bodyOf(tree.size());
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        const Link& link = tree.links[i];
        const bool isFixed = link.parent != kNone && !link.joint.isMovable();
        bodyOf[i] =
            isFixed ? bodyOf[static_cast<std::size_t>(link.parent)] : static_cast<std::int32_t>(i);
    }
    for (std::size_t a = 0; a < tree.size(); ++a)
    {
        for (std::size_t b = a + 1; b < tree.size(); ++b)
        {
            const std::pair pair{static_cast<std::int32_t>(a), static_cast<std::int32_t>(b)};
            const bool isDisabled =
                std::any_of(disabled.begin(),
                            disabled.end(),
                            [&](const auto& other) {
                                return other == pair || other == std::pair{pair.second, pair.first};
                            });
            if (linkTrees[a] != nullptr && linkTrees[b] != nullptr && bodyOf[a] != bodyOf[b] &&
                !isDisabled)
            {
                pairs.push_back(pair);
            }
        }
    }
    return pairs;
}
}  // namespace bullet_ccd
