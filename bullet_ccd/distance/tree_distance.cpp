#include "bullet_ccd/distance/tree_distance.h"

#include "bullet_ccd/distance/ssv_pair.h"
#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <tuple>

namespace bullet_ccd
{
namespace
{
/// Depth-first descent over pairs of nodes that may be closer than `bound`; `leaf` gets the pair of
/// triangles and may lower the bound.
template <class Leaf>
struct Descent
{
    const SsvTree& treeA;
    const SsvTree& treeB;
    Eigen::Matrix3d R;  // tree frame of A in tree frame of B
    Eigen::Vector3d p;
    double bound;
    NodeMarks exempt;
    Leaf& leaf;

    [[nodiscard]] const SsvNode& nodeA(std::int32_t i) const
    {
        return treeA.nodes()[static_cast<std::size_t>(i)];
    }
    [[nodiscard]] const SsvNode& nodeB(std::int32_t i) const
    {
        return treeB.nodes()[static_cast<std::size_t>(i)];
    }
    [[nodiscard]] double separationOf(std::int32_t a, std::int32_t b) const
    {
        return separation(place(nodeA(a), R, p), place(nodeB(b)), bound);
    }

    void run(std::int32_t a, std::int32_t b)
    {
        const SsvNode& nodeOfA = nodeA(a);
        const SsvNode& nodeOfB = nodeB(b);
        if (nodeOfA.isLeaf() && nodeOfB.isLeaf())
        {
            leaf(*this, nodeOfA.first, nodeOfB.first);
            return;
        }
        const bool openA =
            nodeOfB.isLeaf() || (!nodeOfA.isLeaf() && nodeOfA.size() >= nodeOfB.size());
        // The nearest first, so that the bound shrinks early: insertion into at most kArity places.
        std::array<std::tuple<double, std::int32_t, std::int32_t>, kArity> children;
        const std::int32_t count = openA ? nodeOfA.count : nodeOfB.count;
        const PlacedSsv whole = openA ? place(nodeOfB) : place(nodeOfA, R, p);
        for (std::int32_t k = 0; k < count; ++k)
        {
            const std::int32_t childA = openA ? nodeOfA.first + k : a;
            const std::int32_t childB = openA ? b : nodeOfB.first + k;
            const double apart = openA ? separation(place(nodeA(childA), R, p), whole, bound)
                                       : separation(whole, place(nodeB(childB)), bound);
            const std::tuple child(apart, childA, childB);
            auto place = static_cast<std::size_t>(k);
            for (; place > 0 && child < children[place - 1]; --place)
            {
                children[place] = children[place - 1];
            }
            children[place] = child;
        }
        const std::span near(children.data(), static_cast<std::size_t>(count));
        for (const auto& [lowerBound, childA, childB] : near)
        {
            if (lowerBound <= bound && bound >= 0.0 && !exempt.exempts(childA, childB))
            {
                run(childA, childB);
            }
        }
    }

    /// Exact distance of two triangles by their slots, in the mesh frame of B; nothing if a look
    /// shows that it is beyond the bound.
    [[nodiscard]] std::optional<TrianglePair> measure(std::int32_t a, std::int32_t b) const
    {
        TriangleCorners corners = treeA.corners(a);
        for (Eigen::Vector3d& corner : corners)
        {
            corner = R * corner + p;
        }
        const TriangleCorners others = treeB.corners(b);
        if (planeShowsFarther(corners, others, bound))
        {
            return std::nullopt;
        }
        const TriangleDistance d = triangleDistance(corners, others);
        return TrianglePair{.triangleA = treeA.triangle(a),
                            .triangleB = treeB.triangle(b),
                            .distance = d.distance,
                            .pointA = d.pointA + treeB.origin(),
                            .pointB = d.pointB + treeB.origin()};
    }
};

template <class Leaf>
void descend(const SsvTree& treeA,
             const SsvTree& treeB,
             const Eigen::Isometry3d& X_BA,
             double bound,
             const NodeMarks& exempt,
             Leaf leaf)
{
    require(!treeA.nodes().empty() && !treeB.nodes().empty(),
            "distance of meshes: a hierarchy is empty: build it with buildSsvTree()");
    require(!std::isnan(bound), "distance of meshes: the bound is NaN");
    if (!isPose(X_BA))
    {
        failPose("distance of meshes: X_BA", X_BA);
    }
    Descent<Leaf> descent{.treeA = treeA,
                          .treeB = treeB,
                          .R = X_BA.linear(),
                          .p = X_BA * treeA.origin() - treeB.origin(),
                          .bound = bound,
                          .exempt = exempt,
                          .leaf = leaf};
    if (descent.separationOf(0, 0) <= bound && !exempt.exempts(0, 0))
    {
        descent.run(0, 0);
    }
}
}  // namespace

TrianglePair treeDistance(const SsvTree& treeA,
                          const SsvTree& treeB,
                          const Eigen::Isometry3d& X_BA,
                          double upperBound,
                          const NodeMarks& exempt)
{
    TrianglePair best{.distance = upperBound};
    descend(treeA,
            treeB,
            X_BA,
            upperBound,
            exempt,
            [&](auto& descent, std::int32_t a, std::int32_t b)
            {
                const std::optional<TrianglePair> pair = descent.measure(a, b);
                if (pair && pair->distance < best.distance)
                {
                    best = *pair;
                    // Nothing is closer than touching: a negative bound ends the descent.
                    descent.bound = pair->distance > 0.0 ? pair->distance : -1.0;
                }
            });
    return best;
}

void trianglePairsWithin(const SsvTree& treeA,
                         const SsvTree& treeB,
                         const Eigen::Isometry3d& X_BA,
                         double threshold,
                         std::vector<TrianglePair>& pairs)
{
    const auto first = static_cast<std::ptrdiff_t>(pairs.size());
    descend(treeA,
            treeB,
            X_BA,
            threshold,
            {},
            [&](auto& descent, std::int32_t a, std::int32_t b)
            {
                const std::optional<TrianglePair> pair = descent.measure(a, b);
                if (pair && pair->distance <= threshold)
                {
                    pairs.push_back(*pair);
                }
            });
    std::sort(pairs.begin() + first,
              pairs.end(),
              [](const TrianglePair& x, const TrianglePair& y) {
                  return std::pair(x.triangleA, x.triangleB) < std::pair(y.triangleA, y.triangleB);
              });
}
}  // namespace bullet_ccd
