#include "bullet_ccd/distance/tree_distance.h"

#include "bullet_ccd/distance/extent.h"
#include "bullet_ccd/distance/ssv_pair.h"
#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace bullet_ccd
{
namespace
{
/// A pair of triangles is no better than another if it is nearer by less than this share.
constexpr double kTieShare = 1e-6;

/// A pair of nodes that a descent goes on with.
struct Child
{
    double lowerBound;
    double order;  ///< smallest first
    std::int32_t nodeA;
    std::int32_t nodeB;
};

/// A direction along which the closest pair so far is apart, and the gap along it from which on
/// other pairs are no better.
struct Tie
{
    Eigen::Vector3d inA = Eigen::Vector3d::Zero();
    Eigen::Vector3d inB = Eigen::Vector3d::Zero();
    double gap = std::numeric_limits<double>::infinity();
};

/// Depth-first descent over pairs of nodes that may be closer than `bound`; `leaf` gets the pair of
/// triangles and may lower the bound and set the tie.
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
    StopCondition stop{};
    std::int32_t untilCheck =
        std::numeric_limits<std::int32_t>::max();  // of `stop`, if it is given
    bool isStopped = false;
    double skipped = std::numeric_limits<double>::infinity();  // bound of what was not looked at
    Tie tie{};

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

    /// True if no pair of triangles below is nearer than the best by more than a tie allows: on
    /// flat faces all would be looked at, because volumes in single precision blur what they bound.
    [[nodiscard]] bool isNoBetter(std::int32_t a, std::int32_t b) const
    {
        return std::isfinite(tie.gap) &&
               extentAlong(treeB, b, tie.inB).low - extentAlong(treeA, a, tie.inA).high >= tie.gap;
    }

    /// Looks at the clock now and then.
    [[nodiscard]] bool mustStop()
    {
        constexpr std::int32_t kPairsBetween = 256;
        if (--untilCheck < 0)
        {
            untilCheck = kPairsBetween;
            isStopped = isStopped || stop.isDue();
        }
        return isStopped;
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
        // Of volumes that overlap, or are equally far, the ones whose centers are nearest.
        std::array<Child, kArity> children;
        const std::int32_t count = openA ? nodeOfA.count : nodeOfB.count;
        openA ? treeA.open(nodeOfA) : treeB.open(nodeOfB);
        const PlacedSsv whole = openA ? place(nodeOfB) : place(nodeOfA, R, p);
        for (std::int32_t k = 0; k < count; ++k)
        {
            const std::int32_t childA = openA ? nodeOfA.first + k : a;
            const std::int32_t childB = openA ? b : nodeOfB.first + k;
            const PlacedSsv part = openA ? place(nodeA(childA), R, p) : place(nodeB(childB));
            const double apart =
                openA ? separation(part, whole, bound) : separation(whole, part, bound);
            constexpr double kCenters = 0.01;
            const Child child{.lowerBound = apart,
                              .order = apart + kCenters * (part.center - whole.center).norm(),
                              .nodeA = childA,
                              .nodeB = childB};
            auto at = static_cast<std::size_t>(k);
            for (; at > 0 && child.order < children[at - 1].order; --at)
            {
                children[at] = children[at - 1];
            }
            children[at] = child;
        }
        const std::span near(children.data(), static_cast<std::size_t>(count));
        for (const auto& [lowerBound, order, childA, childB] : near)
        {
            if (lowerBound <= bound && bound >= 0.0 && !exempt.exempts(childA, childB) &&
                !isNoBetter(childA, childB))
            {
                if (mustStop())
                {
                    skipped = std::min(skipped, lowerBound);
                    continue;
                }
                run(childA, childB);
            }
        }
    }

    /// Before a pair is found: the normal of a large face along which the meshes are farthest
    /// apart. Along it nothing counts that is not below the bound.
    void setFirstTie()
    {
        double widest = 0.0;
        const auto consider = [&](const Eigen::Vector3d& normal)
        {
            for (const Eigen::Vector3d& n : {normal, Eigen::Vector3d(-normal)})
            {
                const Eigen::Vector3d inA = R.transpose() * n;
                const double gap =
                    extentAlong(treeB, 0, n).low - extentAlong(treeA, 0, inA).high - n.dot(p);
                if (gap > widest)
                {
                    widest = gap;
                    constexpr double kRounding = 1e-14;
                    tie = {.inA = inA,
                           .inB = n,
                           .gap = bound + n.dot(p) +
                                  kRounding * (treeA.radius() + treeB.radius() + p.norm())};
                }
            }
        };
        for (const Eigen::Vector3d& normal : treeB.faceSlabs().normals)
        {
            consider(normal);
        }
        for (const Eigen::Vector3d& normal : treeA.faceSlabs().normals)
        {
            consider(R * normal);
        }
    }

    /// @param accuracy what other pairs may be nearer by and are no better all the same [m]
    void setTie(const TrianglePair& best, double accuracy)
    {
        const Eigen::Vector3d across = (best.pointB - best.pointA).stableNormalized();
        constexpr double kRounding = 1e-15;
        tie = {.inA = R.transpose() * across,
               .inB = across,
               .gap = (1.0 - kTieShare) * best.distance - accuracy + across.dot(p) -
                      kRounding * (treeA.radius() + treeB.radius() + p.norm())};
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

/// What a descent left out.
struct Skipped
{
    bool isStopped = false;
    double lowerBound = std::numeric_limits<double>::infinity();
};

template <class Leaf>
Skipped descend(const SsvTree& treeA,
                const SsvTree& treeB,
                const Eigen::Isometry3d& X_BA,
                double bound,
                const NodeMarks& exempt,
                const StopCondition& stop,
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
                          .leaf = leaf,
                          .stop = stop};
    if (stop.isGiven())
    {
        descent.untilCheck = 0;
    }
    // Where it is only asked whether the two touch, volumes tell it sooner.
    constexpr double kTouching = 1e-6;
    if (std::isfinite(bound) && bound > kTouching * (treeA.radius() + treeB.radius()))
    {
        descent.setFirstTie();
    }
    const double apart = descent.separationOf(0, 0);
    if (apart <= bound && !exempt.exempts(0, 0) && !descent.isNoBetter(0, 0))
    {
        descent.skipped = descent.mustStop() ? apart : descent.skipped;
        if (!descent.isStopped)
        {
            descent.run(0, 0);
        }
    }
    return {.isStopped = descent.isStopped, .lowerBound = descent.skipped};
}
}  // namespace

namespace
{
/// @param accuracy 0: as near as rounding allows
DistanceBounds nearestPair(const SsvTree& treeA,
                           const SsvTree& treeB,
                           const Eigen::Isometry3d& X_BA,
                           double upperBound,
                           double accuracy,
                           const StopCondition& stop,
                           const NodeMarks& exempt)
{
    TrianglePair best{.distance = upperBound};
    const Skipped skipped = descend(
        treeA,
        treeB,
        X_BA,
        upperBound,
        exempt,
        stop,
        [&](auto& descent, std::int32_t a, std::int32_t b)
        {
            const std::optional<TrianglePair> pair = descent.measure(a, b);
            if (pair && pair->distance < best.distance)
            {
                best = *pair;
                // Nothing is closer than touching: a negative bound ends the descent.
                descent.bound = pair->distance > accuracy ? pair->distance - accuracy : -1.0;
                descent.setTie(*pair, accuracy);
            }
        });
    const double looked = (1.0 - kTieShare) * best.distance - accuracy;
    return {.nearest = best,
            .lowerBound = std::max(0.0, std::min(looked, skipped.lowerBound)),
            .isComplete = !skipped.isStopped};
}
}  // namespace

DistanceBounds distanceBounds(const SsvTree& treeA,
                              const SsvTree& treeB,
                              const Eigen::Isometry3d& X_BA,
                              double upperBound,
                              const StopCondition& stop,
                              const NodeMarks& exempt)
{
    return nearestPair(treeA, treeB, X_BA, upperBound, 0.0, stop, exempt);
}

DistanceBounds distanceWithin(const SsvTree& treeA,
                              const SsvTree& treeB,
                              const Eigen::Isometry3d& X_BA,
                              double accuracy,
                              const StopCondition& stop,
                              const NodeMarks& exempt,
                              double upperBound)
{
    require(accuracy > 0.0, "distance of meshes: the accuracy must be above 0");
    return nearestPair(treeA, treeB, X_BA, upperBound, accuracy, stop, exempt);
}

TrianglePair treeDistance(const SsvTree& treeA,
                          const SsvTree& treeB,
                          const Eigen::Isometry3d& X_BA,
                          double upperBound,
                          const NodeMarks& exempt)
{
    return distanceBounds(treeA, treeB, X_BA, upperBound, {}, exempt).nearest;
}

bool trianglePairsWithin(const SsvTree& treeA,
                         const SsvTree& treeB,
                         const Eigen::Isometry3d& X_BA,
                         double threshold,
                         std::vector<TrianglePair>& pairs,
                         const StopCondition& stop)
{
    const auto first = static_cast<std::ptrdiff_t>(pairs.size());
    const Skipped skipped = descend(treeA,
                                    treeB,
                                    X_BA,
                                    threshold,
                                    {},
                                    stop,
                                    [&](auto& descent, std::int32_t a, std::int32_t b)
                                    {
                                        const std::optional<TrianglePair> pair =
                                            descent.measure(a, b);
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
    return !skipped.isStopped;
}

namespace
{
/// Marks of triangles and of the nodes all of whose triangles are marked.
class GrowingMarks
{
public:
    GrowingMarks(const SsvTree& tree, std::span<std::uint8_t> marks)
        : m_tree(tree),
          m_marks(marks),
          m_nodes(tree.nodes().size(), 0),
          m_parents(tree.nodes().size(), kNone),
          m_unmarked(tree.nodes().size(), 0),
          m_leaves(tree.mesh().triangles.size(), kNone)
    {
        require(marks.size() == tree.mesh().triangles.size(),
                "marks of triangles: give one mark a triangle");
        tree.openAll();
        for (std::size_t i = 0; i < m_nodes.size(); ++i)
        {
            const SsvNode& node = tree.nodes()[i];
            m_unmarked[i] = node.count;
            for (std::int32_t k = 0; k < node.count; ++k)
            {
                m_parents[static_cast<std::size_t>(node.first) + static_cast<std::size_t>(k)] =
                    static_cast<std::int32_t>(i);
            }
            if (node.isLeaf() && node.first != kNone)
            {
                m_leaves[static_cast<std::size_t>(node.first)] = static_cast<std::int32_t>(i);
            }
        }
        for (std::int32_t slot = 0; slot < static_cast<std::int32_t>(m_leaves.size()); ++slot)
        {
            if (isMarked(slot))
            {
                grow(slot);
            }
        }
    }

    [[nodiscard]] std::span<const std::uint8_t> nodes() const { return m_nodes; }
    [[nodiscard]] bool isMarked(std::int32_t slot) const
    {
        return m_marks[static_cast<std::size_t>(m_tree.triangle(slot))] != 0;
    }
    void mark(std::int32_t slot)
    {
        if (!isMarked(slot))
        {
            m_marks[static_cast<std::size_t>(m_tree.triangle(slot))] = 1;
            grow(slot);
        }
    }

private:
    void grow(std::int32_t slot)
    {
        std::int32_t node = m_leaves[static_cast<std::size_t>(slot)];
        m_nodes[static_cast<std::size_t>(node)] = 1;
        for (node = m_parents[static_cast<std::size_t>(node)];
             node != kNone && --m_unmarked[static_cast<std::size_t>(node)] == 0;
             node = m_parents[static_cast<std::size_t>(node)])
        {
            m_nodes[static_cast<std::size_t>(node)] = 1;
        }
    }

    const SsvTree& m_tree;
    std::span<std::uint8_t> m_marks;
    std::vector<std::uint8_t> m_nodes;
    std::vector<std::int32_t> m_parents;
    std::vector<std::int32_t> m_unmarked;  ///< children of a node
    std::vector<std::int32_t> m_leaves;    ///< by their slots
};
}  // namespace

bool markTrianglesWithin(const SsvTree& treeA,
                         const SsvTree& treeB,
                         std::span<const Eigen::Isometry3d> posesOfAInB,
                         double threshold,
                         std::span<std::uint8_t> marksA,
                         std::span<std::uint8_t> marksB,
                         const StopCondition& stop)
{
    GrowingMarks a(treeA, marksA);
    GrowingMarks b(treeB, marksB);
    for (const Eigen::Isometry3d& X_BA : posesOfAInB)
    {
        const Skipped skipped = descend(treeA,
                                        treeB,
                                        X_BA,
                                        threshold,
                                        {.a = a.nodes(), .b = b.nodes()},
                                        stop,
                                        [&](auto& descent, std::int32_t slotA, std::int32_t slotB)
                                        {
                                            const auto pair = descent.measure(slotA, slotB);
                                            if (pair && pair->distance <= threshold)
                                            {
                                                a.mark(slotA);
                                                b.mark(slotB);
                                            }
                                        });
        if (skipped.isStopped)
        {
            return false;
        }
    }
    return true;
}
}  // namespace bullet_ccd
