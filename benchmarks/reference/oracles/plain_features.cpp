#include "benchmarks/reference/oracles/plain_features.h"

#include "bullet_ccd/deformable/moving_polygon.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
/// The vertices of a vertex, an edge or a triangle; the last one is repeated.
using Feature = std::array<std::int32_t, 3>;

/// Features in the order of a tree of boxes over the whole step, which halves them down to one.
struct Tree
{
    std::vector<Feature> features;
    std::vector<Eigen::AlignedBox3d> boxes;  // of the features
    std::vector<Eigen::AlignedBox3d> nodes;  // by the middles of what they hold
};

/// What a node of a tree holds.
struct Node
{
    Tree* tree;
    std::size_t first;
    std::size_t last;

    explicit Node(Tree& whole) : Node(whole, 0, whole.features.size()) {}
    Node(Tree& t, std::size_t from, std::size_t to) : tree(&t), first(from), last(to) {}
    [[nodiscard]] std::size_t size() const { return last - first; }
    [[nodiscard]] std::size_t middle() const { return (first + last) / 2; }
    [[nodiscard]] Node left() const { return {*tree, first, middle()}; }
    [[nodiscard]] Node right() const { return {*tree, middle(), last}; }
    [[nodiscard]] const Feature& feature() const { return tree->features[first]; }
    [[nodiscard]] Eigen::AlignedBox3d& box() const
    {
        return size() == 1 ? tree->boxes[first] : tree->nodes[middle()];
    }
};

/// Halves along the longest side, by where the features begin.
void cut(const Node& node, const std::vector<Eigen::Vector3d>& rest)
{
    if (node.size() < 2)
    {
        return;
    }
    const auto at = [&](std::size_t i) { return node.tree->features.begin() + std::ptrdiff_t(i); };
    const auto place = [&](const Feature& f) -> auto&
    {
        return rest[std::size_t(f[0])];
    };
    Eigen::AlignedBox3d box;
    std::for_each(at(node.first), at(node.last), [&](const Feature& f) { box.extend(place(f)); });
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    std::nth_element(at(node.first),
                     at(node.middle()),
                     at(node.last),
                     [&](const Feature& a, const Feature& b)
                     { return place(a)[axis] < place(b)[axis]; });
    cut(node.left(), rest);
    cut(node.right(), rest);
}

Tree treeOf(std::vector<Feature> all, const std::vector<Eigen::Vector3d>& rest)
{
    std::ranges::sort(all);
    all.erase(std::unique(all.begin(), all.end()), all.end());
    Tree tree{.features = std::move(all), .boxes = {}, .nodes = {}};
    tree.nodes.resize(tree.features.size());
    cut(Node(tree), rest);
    return tree;
}

const Eigen::AlignedBox3d& refit(const Node& node)
{
    if (node.size() > 1)
    {
        node.box() = refit(node.left()).merged(refit(node.right()));
    }
    return node.box();
}

/// Calls found() for those without a common vertex whose boxes overlap.
template <typename Found>
void meet(const Node& a, const Node& b, const Found& found)
{
    if (!a.box().intersects(b.box()))
    {
        return;
    }
    if (a.size() == 1 && b.size() == 1)
    {
        const Feature& other = b.feature();
        if (std::ranges::none_of(a.feature(),
                                 [&](auto v) { return std::ranges::count(other, v) > 0; }))
        {
            found(a.feature(), other);
        }
        return;
    }
    const bool isOfA = a.size() >= b.size();
    meet(isOfA ? a.left() : a, isOfA ? b : b.left(), found);
    meet(isOfA ? a.right() : a, isOfA ? b : b.right(), found);
}

template <typename Found>
void meetItself(const Node& node, const Found& found)
{
    if (node.size() > 1)
    {
        meetItself(node.left(), found);
        meetItself(node.right(), found);
        meet(node.left(), node.right(), found);
    }
}

double distanceNow(const FourPoints& x, ElementaryKind kind)
{
    if (kind == ElementaryKind::VertexFace)
    {
        Polygon<3> q;
        subtract(x, q);
        return nearestPoint<3>(q).distance;
    }
    Polygon<4> q;
    subtract(x, q);
    return nearestPoint<4>(q).distance;
}
/// A box of time and of the places on both features.
struct Cell
{
    std::array<double, 3> low{};
    std::array<double, 3> size{1.0, 1.0, 1.0};
};

/// The earliest time below `best` at which the features may touch: `best` if the difference of the
/// features in the cell is apart from zero, else that of the halves along the longest side.
double bisect(
    const ElementaryPair& pair, const Cell& cell, double tolerance, double best, int& left)
{
    if (cell.low[0] >= best)
    {
        return best;
    }
    Eigen::AlignedBox3d box;
    std::array<double, 3> spread{};
    std::array<Eigen::Vector3d, 8> corner;
    for (std::size_t i = 0; i < 8; ++i)
    {
        std::array<double, 3> at = cell.low;
        for (std::size_t k = 0; k < 3; ++k)
        {
            at[k] += (i >> k & 1U) != 0 ? cell.size[k] : 0.0;
        }
        const auto& [t, u, v] = at;
        FourPoints x;
        for (std::size_t k = 0; k < 4; ++k)
        {
            x[k] = (1.0 - t) * pair.start[k] + t * pair.end[k];
        }
        corner[i] = (1.0 - v) * x[2] + v * x[3] - (1.0 - u) * x[0] - u * x[1];
        if (pair.kind == ElementaryKind::VertexFace)
        {
            corner[i] = (1.0 - u - v) * x[1] + u * x[2] + v * x[3] - x[0];
        }
        box.extend(corner[i]);
        for (std::size_t k = 0; k < 3; ++k)  // from the corner before it along axis k
        {
            const Eigen::Vector3d way = corner[i] - corner[i & ~(1U << k)];
            spread[k] = std::max(spread[k], way.lpNorm<Eigen::Infinity>());
        }
    }
    if (box.squaredExteriorDistance(Eigen::Vector3d::Zero()) > 1e-28)
    {
        return best;
    }
    if (box.sizes().maxCoeff() <= tolerance || --left < 0)
    {
        return cell.low[0];
    }
    const auto axis = static_cast<std::size_t>(std::ranges::max_element(spread) - spread.begin());
    for (const double side : {0.0, 0.5})
    {
        Cell half = cell;
        half.size[axis] *= 0.5;
        half.low[axis] += side * cell.size[axis];
        if (pair.kind == ElementaryKind::EdgeEdge || half.low[1] + half.low[2] <= 1.0)
        {
            best = bisect(pair, half, tolerance, best, left);
        }
    }
    return best;
}
}  // namespace

struct UnionBoxes::Trees
{
    std::array<Tree, 3> ofSize;  // vertices, edges, faces
};

UnionBoxes::UnionBoxes(const TriangleMesh& mesh) : m_trees(std::make_shared<Trees>())
{
    std::array<std::vector<Feature>, 3> ofSize;
    for (const Triangle& t : mesh.triangles)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
            ofSize[0].push_back({t[k], t[k], t[k]});
            ofSize[1].push_back({low, high, high});
        }
        ofSize[2].push_back({t[0], t[1], t[2]});
    }
    for (std::size_t i = 0; i < 3; ++i)
    {
        m_trees->ofSize[i] = treeOf(std::move(ofSize[i]), mesh.vertices);
    }
}

std::vector<FeaturePair> UnionBoxes::overlapping(std::span<const Eigen::Vector3d> start,
                                                 std::span<const Eigen::Vector3d> end,
                                                 double distance) const
{
    const Eigen::Vector3d pad = Eigen::Vector3d::Constant(0.5 * distance);
    for (Tree& tree : m_trees->ofSize)
    {
        tree.boxes.assign(tree.features.size(), {});
        for (std::size_t i = 0; i < tree.features.size(); ++i)
        {
            for (const std::int32_t vertex : tree.features[i])
            {
                const auto v = static_cast<std::size_t>(vertex);
                tree.boxes[i].extend(start[v].cwiseMin(end[v]) - pad);
                tree.boxes[i].extend(start[v].cwiseMax(end[v]) + pad);
            }
        }
        refit(Node(tree));
    }
    auto& [vertices, edges, faces] = m_trees->ofSize;
    std::vector<FeaturePair> pairs;
    meet(Node(vertices),
         Node(faces),
         [&](const Feature& v, const Feature& f) {
             pairs.push_back({ElementaryKind::VertexFace, {v[0], f[0], f[1], f[2]}});
         });
    meetItself(Node(edges),
               [&](const Feature& a, const Feature& b)
               {
                   const auto& [low, high] = std::minmax(a, b);
                   pairs.push_back({ElementaryKind::EdgeEdge, {low[0], low[1], high[0], high[1]}});
               });
    return pairs;
}

ElementaryPair pairOf(const FeaturePair& features,
                      std::span<const Eigen::Vector3d> start,
                      std::span<const Eigen::Vector3d> end)
{
    const auto at = [&](std::span<const Eigen::Vector3d> vertices, std::size_t k)
    { return vertices[static_cast<std::size_t>(features.vertices[k])]; };
    return {.kind = features.kind,
            .start = {at(start, 0), at(start, 1), at(start, 2), at(start, 3)},
            .end = {at(end, 0), at(end, 1), at(end, 2), at(end, 3)}};
}

double bisectionToi(const ElementaryPair& pair, double tolerance)
{
    int cells = 100'000;
    return bisect(pair, {}, tolerance, 2.0, cells);
}

double advancementToi(const ElementaryPair& pair, double tolerance)
{
    // The largest relative speed of a point of one feature and one of the other.
    FourPoints w;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 4; ++k)
    {
        w[k] = pair.end[k] - pair.start[k];
        mean += 0.25 * w[k];
    }
    const std::size_t ofFirst = pair.kind == ElementaryKind::VertexFace ? 1 : 2;
    double first = 0.0;
    double second = 0.0;
    for (std::size_t k = 0; k < 4; ++k)
    {
        double& speed = k < ofFirst ? first : second;
        speed = std::max(speed, (w[k] - mean).norm());
    }
    if (first + second == 0.0)
    {
        return distanceNow(pair.start, pair.kind) <= tolerance ? 0.0 : 2.0;
    }
    double t = 0.0;
    for (int i = 0; i < 100'000 && t <= 1.0; ++i)
    {
        FourPoints x;
        for (std::size_t k = 0; k < 4; ++k)
        {
            x[k] = pair.start[k] + t * w[k];
        }
        const double distance = distanceNow(x, pair.kind);
        if (distance <= tolerance)
        {
            return t;
        }
        t += 0.9 * distance / (first + second);
    }
    return t <= 1.0 ? t : 2.0;
}
}  // namespace bullet_ccd::reference
