#include "benchmarks/reference/oracles/plain_features.h"

#include "bullet_ccd/deformable/moving_polygon.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
/// A vertex, an edge or a triangle, and the box that holds it during the whole step.
struct Feature
{
    std::vector<std::int32_t> vertices;
    Eigen::AlignedBox3d box{};

    [[nodiscard]] double low() const { return box.min().x(); }
};
using Features = std::vector<Feature>;

/// The lowest along x first.
/// @param all vertices of each, maybe several times
Features boxedFeatures(std::vector<std::vector<std::int32_t>> all,
                       std::span<const Eigen::Vector3d> start,
                       std::span<const Eigen::Vector3d> end,
                       double distance)
{
    std::ranges::sort(all);
    all.erase(std::unique(all.begin(), all.end()), all.end());
    const Eigen::Vector3d pad = Eigen::Vector3d::Constant(0.5 * distance);
    Features features;
    for (const std::vector<std::int32_t>& vertices : all)
    {
        Feature& feature = features.emplace_back(Feature{.vertices = vertices});
        for (const std::int32_t vertex : vertices)
        {
            const auto v = static_cast<std::size_t>(vertex);
            feature.box.extend(start[v].cwiseMin(end[v]) - pad);
            feature.box.extend(start[v].cwiseMax(end[v]) + pad);
        }
    }
    std::ranges::sort(features, {}, &Feature::low);
    return features;
}

bool shareVertex(const Feature& a, const Feature& b)
{
    return std::ranges::any_of(
        a.vertices, [&](std::int32_t v) { return std::ranges::count(b.vertices, v) > 0; });
}

/// Calls meet() for those from `first` on that begin within the feature along x and overlap it.
template <typename Meet>
void meetFrom(Features::const_iterator first,
              const Features& others,
              const Feature& feature,
              const Meet& meet)
{
    for (; first != others.end() && first->low() <= feature.box.max().x(); ++first)
    {
        if (feature.box.intersects(first->box) && !shareVertex(feature, *first))
        {
            meet(*first);
        }
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

std::vector<FeaturePair> overlappingFeatures(const TriangleMesh& mesh,
                                             std::span<const Eigen::Vector3d> start,
                                             std::span<const Eigen::Vector3d> end,
                                             double distance)
{
    std::array<std::vector<std::vector<std::int32_t>>, 3> ofSize;
    for (const Triangle& t : mesh.triangles)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
            ofSize[0].push_back({t[k]});
            ofSize[1].push_back({low, high});
        }
        ofSize[2].push_back({t[0], t[1], t[2]});
    }
    const Features vertices = boxedFeatures(std::move(ofSize[0]), start, end, distance);
    const Features edges = boxedFeatures(std::move(ofSize[1]), start, end, distance);
    const Features faces = boxedFeatures(std::move(ofSize[2]), start, end, distance);
    std::vector<FeaturePair> pairs;
    const auto add = [&](ElementaryKind kind, const Feature& a, const Feature& b)
    {
        FeaturePair& pair = pairs.emplace_back(FeaturePair{.kind = kind});
        std::ranges::copy(b.vertices, std::ranges::copy(a.vertices, pair.vertices.begin()).out);
    };
    // Of two that overlap, one begins within the other along x.
    for (const Feature& vertex : vertices)
    {
        meetFrom(std::ranges::lower_bound(faces, vertex.low(), {}, &Feature::low),
                 faces,
                 vertex,
                 [&](const Feature& face) { add(ElementaryKind::VertexFace, vertex, face); });
    }
    for (const Feature& face : faces)
    {
        meetFrom(std::ranges::upper_bound(vertices, face.low(), {}, &Feature::low),
                 vertices,
                 face,
                 [&](const Feature& vertex) { add(ElementaryKind::VertexFace, vertex, face); });
    }
    for (auto edge = edges.begin(); edge != edges.end(); ++edge)
    {
        const auto addEdges = [&](const Feature& other)
        {
            const bool isInOrder = edge->vertices < other.vertices;
            add(ElementaryKind::EdgeEdge, isInOrder ? *edge : other, isInOrder ? other : *edge);
        };
        meetFrom(edge + 1, edges, *edge, addEdges);
    }
    return pairs;
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
