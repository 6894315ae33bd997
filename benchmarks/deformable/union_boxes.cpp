#include "benchmarks/deformable/union_boxes.h"

#include "bullet_ccd/deformable/moving_polygon.h"

#include <algorithm>
#include <numeric>
#include <queue>
#include <set>
#include <utility>

namespace bullet_ccd::benchmarks
{
using Box = Eigen::AlignedBox3d;

/// Two children a node; a leaf has one triangle.
struct UnionBoxes::Tree
{
    struct Node
    {
        Box box;
        std::int32_t left = kNone;
        std::int32_t right = kNone;
        std::int32_t triangle = kNone;
    };
    /// A triangle with what belongs to it.
    struct Owner
    {
        std::vector<std::int32_t> vertices;
        std::vector<std::array<std::int32_t, 2>> edges;
    };

    explicit Tree(const TriangleMesh& of) : mesh(of), owners(of.triangles.size())
    {
        std::vector<bool> isOwned(mesh.vertices.size(), false);
        std::set<std::array<std::int32_t, 2>> seen;
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        {
            const Triangle& t = mesh.triangles[i];
            for (std::size_t k = 0; k < 3; ++k)
            {
                const std::array<std::int32_t, 2> edge{std::min(t[k], t[(k + 1) % 3]),
                                                       std::max(t[k], t[(k + 1) % 3])};
                if (seen.insert(edge).second)
                {
                    owners[i].edges.push_back(edge);
                }
                if (!isOwned[static_cast<std::size_t>(t[k])])
                {
                    isOwned[static_cast<std::size_t>(t[k])] = true;
                    owners[i].vertices.push_back(t[k]);
                }
            }
        }
        std::vector<std::int32_t> order(mesh.triangles.size());
        std::iota(order.begin(), order.end(), 0);
        nodes.reserve(2 * order.size());
        (void)build(order);
    }

    std::int32_t build(std::span<std::int32_t> order)
    {
        const auto index = static_cast<std::int32_t>(nodes.size());
        nodes.emplace_back();
        if (order.size() == 1)
        {
            nodes.back().triangle = order[0];
            return index;
        }
        const auto centre = [&](std::int32_t i) -> Eigen::Vector3d
        {
            const Triangle& t = mesh.triangles[static_cast<std::size_t>(i)];
            return place(t[0]) + place(t[1]) + place(t[2]);
        };
        Box box;
        for (const std::int32_t i : order)
        {
            box.extend(centre(i));
        }
        Eigen::Index axis = 0;
        box.sizes().maxCoeff(&axis);
        const std::size_t half = order.size() / 2;
        std::nth_element(order.begin(),
                         order.begin() + static_cast<std::ptrdiff_t>(half),
                         order.end(),
                         [&](std::int32_t a, std::int32_t b)
                         { return centre(a)[axis] < centre(b)[axis]; });
        const std::int32_t left = build(order.first(half));
        const std::int32_t right = build(order.subspan(half));
        nodes[static_cast<std::size_t>(index)].left = left;
        nodes[static_cast<std::size_t>(index)].right = right;
        return index;
    }

    [[nodiscard]] const Eigen::Vector3d& place(std::int32_t v) const
    {
        return mesh.vertices[static_cast<std::size_t>(v)];
    }
    [[nodiscard]] const Box& swept(std::int32_t v) const
    {
        return vertexBoxes[static_cast<std::size_t>(v)];
    }
    [[nodiscard]] Node& node(std::int32_t i) { return nodes[static_cast<std::size_t>(i)]; }

    void refit(std::span<const Eigen::Vector3d> start,
               std::span<const Eigen::Vector3d> end,
               double distance)
    {
        vertexBoxes.resize(start.size());
        const Eigen::Vector3d pad = Eigen::Vector3d::Constant(0.5 * distance);
        for (std::size_t v = 0; v < start.size(); ++v)
        {
            vertexBoxes[v] = Box(start[v].cwiseMin(end[v]) - pad, start[v].cwiseMax(end[v]) + pad);
        }
        for (auto it = nodes.rbegin(); it != nodes.rend(); ++it)
        {
            if (it->triangle != kNone)
            {
                const Triangle& t = mesh.triangles[static_cast<std::size_t>(it->triangle)];
                it->box = swept(t[0]).merged(swept(t[1])).merged(swept(t[2]));
            }
            else
            {
                it->box = node(it->left).box.merged(node(it->right).box);
            }
        }
    }

    void meet(std::int32_t a, std::int32_t b, std::vector<FeaturePair>& out)
    {
        const Node& nodeA = node(a);
        const Node& nodeB = node(b);
        if (a == b)
        {
            if (nodeA.triangle == kNone)
            {
                meet(nodeA.left, nodeA.left, out);
                meet(nodeA.right, nodeA.right, out);
                meet(nodeA.left, nodeA.right, out);
            }
            return;
        }
        if (!nodeA.box.intersects(nodeB.box))
        {
            return;
        }
        if (nodeA.triangle != kNone && nodeB.triangle != kNone)
        {
            features(nodeA.triangle, nodeB.triangle, out);
        }
        else if (nodeB.triangle != kNone ||
                 (nodeA.triangle == kNone && nodeA.box.volume() > nodeB.box.volume()))
        {
            meet(nodeA.left, b, out);
            meet(nodeA.right, b, out);
        }
        else
        {
            meet(a, nodeB.left, out);
            meet(a, nodeB.right, out);
        }
    }

    void features(std::int32_t a, std::int32_t b, std::vector<FeaturePair>& out) const
    {
        const Owner& ofA = owners[static_cast<std::size_t>(a)];
        const Owner& ofB = owners[static_cast<std::size_t>(b)];
        vertexFaces(ofA, b, out);
        vertexFaces(ofB, a, out);
        for (const auto& p : ofA.edges)
        {
            const Box box = swept(p[0]).merged(swept(p[1]));
            for (const auto& q : ofB.edges)
            {
                if (p[0] != q[0] && p[0] != q[1] && p[1] != q[0] && p[1] != q[1] &&
                    box.intersects(swept(q[0]).merged(swept(q[1]))))
                {
                    const bool isInOrder = p < q;
                    const auto& first = isInOrder ? p : q;
                    const auto& second = isInOrder ? q : p;
                    out.push_back(
                        {ElementaryKind::EdgeEdge, {first[0], first[1], second[0], second[1]}});
                }
            }
        }
    }

    void vertexFaces(const Owner& owner, std::int32_t triangle, std::vector<FeaturePair>& out) const
    {
        const Triangle& t = mesh.triangles[static_cast<std::size_t>(triangle)];
        const Box box = swept(t[0]).merged(swept(t[1])).merged(swept(t[2]));
        for (const std::int32_t v : owner.vertices)
        {
            if (v != t[0] && v != t[1] && v != t[2] && box.intersects(swept(v)))
            {
                out.push_back({ElementaryKind::VertexFace, {v, t[0], t[1], t[2]}});
            }
        }
    }

    const TriangleMesh& mesh;
    std::vector<Owner> owners;
    std::vector<Node> nodes;  ///< parents before their children
    std::vector<Box> vertexBoxes;
};

UnionBoxes::UnionBoxes(const TriangleMesh& mesh) : m_tree(std::make_unique<Tree>(mesh)) {}
UnionBoxes::~UnionBoxes() = default;

std::vector<FeaturePair> UnionBoxes::candidates(std::span<const Eigen::Vector3d> start,
                                                std::span<const Eigen::Vector3d> end,
                                                double distance)
{
    m_tree->refit(start, end, distance);
    std::vector<FeaturePair> pairs;
    m_tree->meet(0, 0, pairs);
    return pairs;
}

namespace
{
/// Difference of the features at one time and place: u, v of the face, or of the two edges.
Eigen::Vector3d differenceAt(const ElementaryPair& pair, double t, double u, double v)
{
    FourPoints x;
    for (std::size_t k = 0; k < 4; ++k)
    {
        x[k] = (1.0 - t) * pair.start[k] + t * pair.end[k];
    }
    return pair.kind == ElementaryKind::VertexFace
               ? Eigen::Vector3d((1.0 - u - v) * x[1] + u * x[2] + v * x[3] - x[0])
               : Eigen::Vector3d((1.0 - v) * x[2] + v * x[3] - (1.0 - u) * x[0] - u * x[1]);
}

/// A box of time and the two parameters.
struct Cell
{
    std::array<double, 3> low{};
    std::array<double, 3> size{1.0, 1.0, 1.0};

    /// The earliest first; of equal ones the smallest, so that one is followed to its end.
    friend bool operator<(const Cell& a, const Cell& b)
    {
        return std::pair(a.low[0], a.size[0]) > std::pair(b.low[0], b.size[0]);
    }
};

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
}  // namespace

double bisectionToi(const ElementaryPair& pair, double tolerance)
{
    constexpr int kMostCells = 100'000;
    std::priority_queue<Cell> cells;
    cells.push({});
    for (int count = 0; !cells.empty(); ++count)
    {
        const Cell cell = cells.top();
        cells.pop();
        if (count > kMostCells)
        {
            return cell.low[0];
        }
        Box box;
        std::array<double, 3> spread{};
        std::array<Eigen::Vector3d, 8> corner;
        for (std::size_t i = 0; i < 8; ++i)
        {
            std::array<double, 3> at{};
            for (std::size_t k = 0; k < 3; ++k)
            {
                at[k] = cell.low[k] + ((i >> k & 1U) != 0 ? cell.size[k] : 0.0);
            }
            corner[i] = differenceAt(pair, at[0], at[1], at[2]);
            box.extend(corner[i]);
            for (std::size_t k = 0; k < 3; ++k)
            {
                if ((i >> k & 1U) != 0)
                {
                    const double move =
                        (corner[i] - corner[i ^ (1U << k)]).lpNorm<Eigen::Infinity>();
                    spread[k] = std::max(spread[k], move);
                }
            }
        }
        if (box.squaredExteriorDistance(Eigen::Vector3d::Zero()) > 1e-28)
        {
            continue;
        }
        if (box.sizes().maxCoeff() <= tolerance)
        {
            return cell.low[0];
        }
        const auto axis =
            static_cast<std::size_t>(std::ranges::max_element(spread) - spread.begin());
        for (const double side : {0.0, 0.5})
        {
            Cell half = cell;
            half.size[axis] *= 0.5;
            half.low[axis] += side * cell.size[axis];
            if (pair.kind == ElementaryKind::EdgeEdge || half.low[1] + half.low[2] <= 1.0)
            {
                cells.push(half);
            }
        }
    }
    return 2.0;
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
}  // namespace bullet_ccd::benchmarks
