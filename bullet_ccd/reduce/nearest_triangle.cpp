#include "bullet_ccd/reduce/nearest_triangle.h"

#include "bullet_ccd/distance/triangle_distance.h"

#include <array>
#include <span>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

/// Lower bound of the distance of a point (tree's frame) from what is below a node.
double boxDistance(const SsvNode& node, const Vector3d& point)
{
    const auto vector = [](const float(&v)[3])
    { return Vector3d(Eigen::Map<const Eigen::Vector3f>(v).cast<double>()); };
    const Vector3d offset = point - vector(node.center);
    const Vector3d axis0 = vector(node.axis0);
    const Vector3d axis1 = vector(node.axis1);
    const Vector3d local(axis0.dot(offset), axis1.dot(offset), axis0.cross(axis1).dot(offset));
    const Vector3d outside = (local.cwiseAbs() - vector(node.half)).cwiseMax(0.0);
    // The axes are unit and orthogonal to single precision only.
    return outside.norm() - static_cast<double>(node.radius) -
           1e-6 * (offset.norm() + static_cast<double>(node.size()));
}

/// Looks for the triangle that is nearest to a point (tree's frame), nearest nodes first.
struct NearestSearch
{
    const SsvTree& tree;
    Vector3d point;
    double enough;
    Nearest best{};

    void look(std::int32_t slot)
    {
        const double distance = pointToTriangle(point, tree.corners(slot)).distance;
        if (distance < best.distance)
        {
            best = {.distance = distance, .slot = slot};
        }
    }

    void run(const SsvNode& node)
    {
        if (node.isLeaf())
        {
            look(node.first);
            return;
        }
        tree.open(node);
        std::array<std::pair<double, const SsvNode*>, kArity> children;
        const std::span<const SsvNode> nodes = tree.nodes().subspan(
            static_cast<std::size_t>(node.first), static_cast<std::size_t>(node.count));
        for (std::size_t k = 0; k < nodes.size(); ++k)
        {
            const double distance = boxDistance(nodes[k], point);
            std::size_t place = k;
            for (; place > 0 && distance < children[place - 1].first; --place)
            {
                children[place] = children[place - 1];
            }
            children[place] = {distance, &nodes[k]};
        }
        for (std::size_t k = 0;
             k < nodes.size() && children[k].first < best.distance && best.distance > enough;
             ++k)
        {
            run(*children[k].second);
        }
    }
};
}  // namespace

Nearest nearestTriangle(const SsvTree& tree,
                        const Vector3d& point,
                        std::int32_t guess,
                        double enough)
{
    NearestSearch search{.tree = tree, .point = point, .enough = enough};
    if (guess != kNone)
    {
        search.look(guess);
    }
    if (search.best.distance > enough)
    {
        search.run(tree.nodes()[0]);
    }
    return search.best;
}
}  // namespace bullet_ccd
