#include "bullet_ccd/hierarchy/ssv_tree.h"

#include "bullet_ccd/math/check.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <oneapi/tbb/parallel_invoke.h>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Corners = std::array<Eigen::Vector3d, 3>;

// The two conversions are not inlined: GCC 12 (-O2, vectorised) drops a conversion to float and
// back to double within one function and goes on with the unrounded value, so that extents would be
// measured about a center that is not the stored one.

/// Nearest floats.
[[gnu::noinline]] Eigen::Vector3f toFloats(const Eigen::Vector3d& x)
{
    return x.cast<float>();
}

/// Smallest float that is not below `x`.
[[gnu::noinline]] float roundUp(double x)
{
    const float f = static_cast<float>(x);
    return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity())
                                      : f;
}

/// Single-precision axes as the queries see them: two stored columns, the third their cross
/// product.
struct Axes
{
    Eigen::Vector3f axis0;
    Eigen::Vector3f axis1;

    [[nodiscard]] Eigen::Matrix3d matrix() const
    {
        Eigen::Matrix3d m;
        m.col(0) = axis0.cast<double>();
        m.col(1) = axis1.cast<double>();
        m.col(2) = m.col(0).cross(m.col(1));
        return m;
    }
};

struct Builder
{
    std::span<const Corners> corners;
    std::vector<Eigen::Vector3d> centroids;
    std::vector<std::int32_t> order;
    std::vector<SsvNode>* nodes = nullptr;  ///< of the binary tree

    void build(std::size_t node, std::size_t firstFree, std::size_t begin, std::size_t end);
    [[nodiscard]] std::size_t split(const Axes& axes, std::size_t begin, std::size_t end);
    [[nodiscard]] Axes principalAxes(std::size_t begin, std::size_t end) const;
    [[nodiscard]] SsvNode fit(const Axes& axes, std::size_t begin, std::size_t end) const;
    [[nodiscard]] std::size_t triangle(std::size_t i) const
    {
        return static_cast<std::size_t>(order[i]);
    }
};

/// Orthonormal axes from the columns of largest and middle extent.
Axes toAxes(const Eigen::Vector3d& first, const Eigen::Vector3d& second)
{
    return {.axis0 = toFloats(first), .axis1 = toFloats(second)};
}

/// Axes of a single triangle: its longest edge and the normal of that edge in its plane; any axes
/// that fit what is left of a degenerate one.
Axes triangleAxes(const Corners& c)
{
    Eigen::Vector3d edge = c[1] - c[0];
    Eigen::Vector3d other = c[2] - c[0];
    for (int k = 1; k < 3; ++k)
    {
        const auto i = static_cast<std::size_t>(k);
        const Eigen::Vector3d candidate = c[(i + 1) % 3] - c[i];
        if (candidate.squaredNorm() > edge.squaredNorm())
        {
            edge = candidate;
            other = c[(i + 2) % 3] - c[i];
        }
    }
    const double length = edge.norm();
    if (!(length > 0.0))
    {
        return toAxes(Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY());
    }
    const Eigen::Vector3d first = edge / length;
    Eigen::Vector3d second = other - first.dot(other) * first;
    const double height = second.norm();
    second = height > 1e-9 * length ? Eigen::Vector3d(second / height) : first.unitOrthogonal();
    // Once more: what was left along the first axis grew with the division.
    second = (second - first.dot(second) * first).normalized();
    return toAxes(first, second);
}

Axes Builder::principalAxes(std::size_t begin, std::size_t end) const
{
    if (end - begin == 1)
    {
        return triangleAxes(corners[triangle(begin)]);
    }
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = begin; i < end; ++i)
    {
        mean += centroids[triangle(i)];
    }
    mean /= static_cast<double>(end - begin);
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::size_t i = begin; i < end; ++i)
    {
        for (const Eigen::Vector3d& corner : corners[triangle(i)])
        {
            const Eigen::Vector3d d = corner - mean;
            covariance.noalias() += d * d.transpose();
        }
    }
    const double scale = covariance.cwiseAbs().maxCoeff();
    if (!(scale > 0.0))
    {
        return toAxes(Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY());
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance / scale);
    return toAxes(solver.eigenvectors().col(2), solver.eigenvectors().col(1));
}

SsvNode Builder::fit(const Axes& axes, std::size_t begin, std::size_t end) const
{
    const Eigen::Matrix3d e = axes.matrix();
    Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector3d high = -low;
    for (std::size_t i = begin; i < end; ++i)
    {
        for (const Eigen::Vector3d& corner : corners[triangle(i)])
        {
            const Eigen::Vector3d s = e.transpose() * corner;
            low = low.cwiseMin(s);
            high = high.cwiseMax(s);
        }
    }
    const Eigen::Vector3f center = toFloats(e * (0.5 * (low + high)));

    // Half-extents about the center as stored. The projections on axes that are orthonormal to 1e-7
    // only differ from the coordinates s_k by that fraction of the distance: 1e-6 covers it.
    Eigen::Vector3d half = Eigen::Vector3d::Zero();
    double farthest = 0.0;
    for (std::size_t i = begin; i < end; ++i)
    {
        for (const Eigen::Vector3d& corner : corners[triangle(i)])
        {
            const Eigen::Vector3d d = corner - center.cast<double>();
            half = half.cwiseMax((e.transpose() * d).cwiseAbs());
            farthest = std::max(farthest, d.norm());
        }
    }
    half.array() += 1e-6 * farthest;

    SsvNode node{};
    for (int k = 0; k < 3; ++k)
    {
        node.center[k] = center[k];
        node.axis0[k] = axes.axis0[k];
        node.axis1[k] = axes.axis1[k];
        node.half[k] = roundUp(half[k]);
    }
    node.radius = 0.0F;
    node.coreRadius = roundUp(half.norm() * (1.0 + 1e-6));
    node.first = static_cast<std::int32_t>(begin);
    node.count = 0;
    return node;
}

/// Orders [begin, end) so that the two halves are [begin, middle) and [middle, end): across the
/// widest axis at the mean of the centroids, or at the median where the mean would unbalance the
/// tree, so that its depth stays logarithmic whatever the mesh.
std::size_t Builder::split(const Axes& axes, std::size_t begin, std::size_t end)
{
    const Eigen::Vector3d direction = axes.axis0.cast<double>();
    double mean = 0.0;
    for (std::size_t i = begin; i < end; ++i)
    {
        mean += direction.dot(centroids[triangle(i)]);
    }
    mean /= static_cast<double>(end - begin);
    const auto first = order.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = order.begin() + static_cast<std::ptrdiff_t>(end);
    const auto place = [&](std::int32_t t)
    { return direction.dot(centroids[static_cast<std::size_t>(t)]); };
    const auto cut = std::partition(first, last, [&](std::int32_t t) { return place(t) < mean; });

    const std::size_t count = end - begin;
    const auto left = static_cast<std::size_t>(cut - first);
    if (std::min(left, count - left) * 8 >= count)
    {
        return begin + left;
    }
    const auto middle = first + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(first,
                     middle,
                     last,
                     [&](std::int32_t a, std::int32_t b)
                     { return std::pair(place(a), a) < std::pair(place(b), b); });
    return begin + count / 2;
}

/// A subtree over n triangles has 2n - 1 nodes, so every subtree knows its block of the array in
/// advance and both halves can be built at the same time with the same result.
void Builder::build(std::size_t node, std::size_t firstFree, std::size_t begin, std::size_t end)
{
    const Axes axes = principalAxes(begin, end);
    SsvNode& here = (*nodes)[node];
    here = fit(axes, begin, end);
    if (end - begin == 1)
    {
        return;
    }
    here.first = static_cast<std::int32_t>(firstFree);
    here.count = 2;
    const std::size_t middle = split(axes, begin, end);
    const std::size_t leftFree = firstFree + 2;
    const std::size_t rightFree = leftFree + 2 * (middle - begin) - 2;
    const auto left = [&] { build(firstFree, leftFree, begin, middle); };
    const auto right = [&] { build(firstFree + 1, rightFree, middle, end); };
    constexpr std::size_t kParallel = 4096;
    if (end - begin >= kParallel)
    {
        tbb::parallel_invoke(left, right);
    }
    else
    {
        left();
        right();
    }
}

/// Surface of a volume, the measure of how likely it is to be met.
float surface(const SsvNode& node)
{
    const float x = node.half[0] + node.radius;
    const float y = node.half[1] + node.radius;
    const float z = node.half[2] + node.radius;
    return x * y + y * z + z * x;
}

/// Turns a binary tree into one of kArity: the children of a node are the cut below it that is
/// reached by always opening the largest. Siblings stay adjacent.
class Flattener
{
public:
    explicit Flattener(const std::vector<SsvNode>& binary) : m_binary(binary)
    {
        m_nodes.reserve(binary.size());
    }

    std::vector<SsvNode> run()
    {
        m_nodes.push_back(m_binary[0]);
        flatten(0);
        return std::move(m_nodes);
    }

private:
    void flatten(std::size_t out)
    {
        if (m_nodes[out].isLeaf())
        {
            return;
        }
        std::array<SsvNode, kArity> children;
        std::size_t count = 0;
        const auto add = [&](const SsvNode& node)
        {
            children[count++] = m_binary[static_cast<std::size_t>(node.first)];
            children[count++] = m_binary[static_cast<std::size_t>(node.first) + 1];
        };
        add(m_nodes[out]);
        while (count < kArity)
        {
            const auto end = children.begin() + static_cast<std::ptrdiff_t>(count);
            const auto measure = [](const SsvNode& n) { return n.isLeaf() ? -1.0F : surface(n); };
            const auto largest = std::max_element(children.begin(),
                                                  end,
                                                  [&](const SsvNode& a, const SsvNode& b)
                                                  { return measure(a) < measure(b); });
            if (largest->isLeaf())
            {
                break;
            }
            const SsvNode opened = *largest;
            *largest = children[--count];
            add(opened);
        }
        const std::size_t first = m_nodes.size();
        m_nodes.insert(
            m_nodes.end(), children.begin(), children.begin() + static_cast<std::ptrdiff_t>(count));
        m_nodes[out].first = static_cast<std::int32_t>(first);
        m_nodes[out].count = static_cast<std::int32_t>(count);
        for (std::size_t i = 0; i < count; ++i)
        {
            flatten(first + i);
        }
    }

    const std::vector<SsvNode>& m_binary;
    std::vector<SsvNode> m_nodes;
};
}  // namespace

std::array<Eigen::Vector3d, 3> SsvTree::cornersOfTriangle(std::int32_t triangle) const
{
    const Triangle& t = m_mesh.triangles[static_cast<std::size_t>(triangle)];
    Corners c;
    for (std::size_t k = 0; k < 3; ++k)
    {
        c[k] = m_mesh.vertices[static_cast<std::size_t>(t[k])] - m_origin;
    }
    return c;
}

SsvTree buildSsvTree(TriangleMesh mesh)
{
    checkMesh(mesh, "buildSsvTree");
    SsvTree tree;
    tree.m_mesh = std::move(mesh);
    tree.m_origin = bounds(tree.m_mesh).center();
    const std::size_t count = tree.m_mesh.triangles.size();
    std::vector<Corners> corners(count);
    Builder builder{.corners = corners,
                    .centroids = std::vector<Eigen::Vector3d>(count),
                    .order = std::vector<std::int32_t>(count)};
    for (std::size_t i = 0; i < count; ++i)
    {
        const Corners& c = corners[i] = tree.cornersOfTriangle(static_cast<std::int32_t>(i));
        for (const Eigen::Vector3d& corner : c)
        {
            tree.m_radius = std::max(tree.m_radius, corner.norm());
        }
        builder.centroids[i] = (c[0] + c[1] + c[2]) / 3.0;
    }
    std::iota(builder.order.begin(), builder.order.end(), 0);
    std::vector<SsvNode> binary(2 * count - 1);
    builder.nodes = &binary;
    builder.build(0, 1, 0, count);
    tree.m_nodes = Flattener(binary).run();
    tree.m_triangles = std::move(builder.order);
    tree.m_corners.reserve(count);
    for (const std::int32_t triangle : tree.m_triangles)
    {
        tree.m_corners.push_back(corners[static_cast<std::size_t>(triangle)]);
    }
    return tree;
}
}  // namespace bullet_ccd
