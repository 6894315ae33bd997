#include "bullet_ccd/toi/search/turn_profiles.h"

#include "bullet_ccd/hierarchy/face_slabs.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector2d;
using Eigen::Vector3d;

double cross(const Vector2d& a, const Vector2d& b)
{
    return a.x() * b.y() - a.y() * b.x();
}

/// Distance of the origin from a triangle in the plane.
double leastRadius(const std::array<Vector2d, 3>& corners)
{
    double least = corners[0].norm();
    bool isLeft = true;
    bool isRight = true;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vector2d& from = corners[k];
        const Vector2d edge = corners[(k + 1) % 3] - from;
        const double side = cross(from, edge);
        isLeft = isLeft && side >= 0.0;
        isRight = isRight && side <= 0.0;
        const double square = edge.squaredNorm();
        const double part = square > 0.0 ? std::clamp(-from.dot(edge) / square, 0.0, 1.0) : 0.0;
        least = std::min(least, Vector2d(from + part * edge).norm());
    }
    return isLeft || isRight ? 0.0 : least;
}

TurnProfile profileOf(const std::array<Vector3d, 3>& corners, const Eigen::Isometry3d& X_TG)
{
    TurnProfile profile{.radius = kNoSlab, .height = kNoSlab};
    std::array<Vector2d, 3> across;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vector3d corner = X_TG * corners[k];
        across[k] = corner.head<2>();
        profile.radius.high = std::max(profile.radius.high, across[k].norm());
        profile.height.low = std::min(profile.height.low, corner.z());
        profile.height.high = std::max(profile.height.high, corner.z());
    }
    profile.radius.low = leastRadius(across);
    return profile;
}

void widen(Slab& slab, const Slab& more)
{
    slab.low = std::min(slab.low, more.low);
    slab.high = std::max(slab.high, more.high);
}

double between(const Slab& a, const Slab& b)
{
    return std::max({a.low - b.high, b.low - a.high, 0.0});
}
}  // namespace

void fillProfiles(const SsvTree& tree,
                  const Eigen::Isometry3d& X_TG,
                  std::vector<TurnProfile>& profiles)
{
    const std::span<const SsvNode> nodes = tree.nodes();
    profiles.resize(nodes.size());
    for (std::size_t i = nodes.size(); i-- > 0;)  // children come after their parent
    {
        const SsvNode& node = nodes[i];
        if (node.isLeaf())
        {
            profiles[i] = profileOf(tree.corners(node.first), X_TG);
            continue;
        }
        TurnProfile profile{.radius = kNoSlab, .height = kNoSlab};
        for (std::int32_t child = 0; child < node.count; ++child)
        {
            const TurnProfile& below = profiles[static_cast<std::size_t>(node.first + child)];
            widen(profile.radius, below.radius);
            widen(profile.height, below.height);
        }
        profiles[i] = profile;
    }
}

double TurningPair::distance(std::int32_t nodeA, std::int32_t nodeB) const
{
    const TurnProfile& a = profiles[0][static_cast<std::size_t>(nodeA)];
    const TurnProfile& b = profiles[1][static_cast<std::size_t>(nodeB)];
    const double across = between(a.radius, b.radius);
    const double along = between(a.height, b.height);
    return std::sqrt(across * across + along * along) - rounding;
}
}  // namespace bullet_ccd
