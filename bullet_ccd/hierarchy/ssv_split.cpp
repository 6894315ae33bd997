#include "bullet_ccd/hierarchy/ssv_split.h"

#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/parallel_sort.h>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Array4f;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();

/// A triangle on its way down. Single precision and scaled to the size of the mesh: enough to
/// decide by, and it moves half as much memory.
struct Item
{
    Vector3f corners[3];
    std::int32_t triangle;
};

/// Axes of largest, middle and smallest spread; the fourth lane is unused.
struct ItemAxes
{
    Array4f x{1.0F, 0.0F, 0.0F, 0.0F};
    Array4f y{0.0F, 1.0F, 0.0F, 0.0F};
    Array4f z{0.0F, 0.0F, 1.0F, 0.0F};

    [[nodiscard]] Array4f operator()(const Vector3f& p) const
    {
        return x * p.x() + y * p.y() + z * p.z();
    }
};

struct Bounds
{
    Array4f low = Array4f::Constant(kFloatInfinity);
    Array4f high = Array4f::Constant(-kFloatInfinity);

    void add(const Array4f& p)
    {
        low = low.min(p);
        high = high.max(p);
    }
    void add(const Bounds& other)
    {
        low = low.min(other.low);
        high = high.max(other.high);
    }
    /// Half of it.
    [[nodiscard]] float surface() const
    {
        const Array4f size = high - low;
        return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
    }
};

/// Three times the middle of an item's corners.
Array4f middleOf(const Item& item, const ItemAxes& axes)
{
    return axes(item.corners[0] + item.corners[1] + item.corners[2]);
}

Bounds boundsOf(const Item& item, const ItemAxes& axes)
{
    Bounds bounds;
    for (const Vector3f& corner : item.corners)
    {
        bounds.add(axes(corner));
    }
    return bounds;
}

/// At most `limit` of the items, evenly spread: decisions about many are taken by a sample.
template <class Visit>
void forSample(std::span<const Item> items, std::size_t limit, Visit&& visit)
{
    const std::size_t stride = (items.size() + limit - 1) / limit;
    for (std::size_t i = 0; i < items.size(); i += stride)
    {
        visit(items[i]);
    }
}

ItemAxes principalAxes(std::span<const Item> items)
{
    constexpr std::size_t kSample = 256;
    // Sums about a point of the set, so that a small set far out loses nothing.
    const Vector3d about = items[0].corners[0].cast<double>();
    Vector3d sum = Vector3d::Zero();
    Matrix3d square = Matrix3d::Zero();
    double count = 0.0;
    forSample(items,
              kSample,
              [&](const Item& item)
              {
                  for (const Vector3f& corner : item.corners)
                  {
                      const Vector3d d = corner.cast<double>() - about;
                      sum += d;
                      square.noalias() += d * d.transpose();
                      count += 1.0;
                  }
              });
    square -= sum * sum.transpose() / count;
    const double scale = square.cwiseAbs().maxCoeff();
    ItemAxes axes;
    if (scale > 0.0)
    {
        Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
        solver.computeDirect(square / scale);
        const Eigen::Matrix3f vectors = solver.eigenvectors().cast<float>();
        if (vectors.allFinite())
        {
            axes.x << vectors.row(0).reverse().transpose().array(), 0.0F;
            axes.y << vectors.row(1).reverse().transpose().array(), 0.0F;
            axes.z << vectors.row(2).reverse().transpose().array(), 0.0F;
        }
    }
    return axes;
}

/// Where a set is divided, and half the surfaces of the boxes on both sides.
struct Cut
{
    int axis = kNone;
    float place = 0.0F;  ///< of three times the middle
    float cost = kFloatInfinity;
    float surfaceLeft = 0.0F;
    float surfaceRight = 0.0F;
};

/// Counts and bounds of the items by the place of their middles, along all three axes at once.
class Bins
{
public:
    Bins(std::span<const Item> items, const ItemAxes& axes) : m_axes(axes)
    {
        Bounds middles;
        const auto visitMiddle = [&](const Item& item)
        {
            middles.add(middleOf(item, axes));
            ++m_total;
        };
        forSample(items, kSample, visitMiddle);
        m_count = std::clamp(m_total, 4, kMostBins);
        m_low = middles.low;
        m_scale = static_cast<float>(m_count) / (middles.high - middles.low);
        for (int axis = 0; axis < 3; ++axis)
        {
            m_isFlat[axis] = !(m_scale[axis] < kFloatInfinity);
        }
        forSample(items, kSample, [&](const Item& item) { add(item); });
    }

    /// The cut between two bins with the smallest sum of surface times root of count: between the
    /// count itself, which is right where every triangle below costs the same, and none, as for a
    /// search that follows one path only.
    [[nodiscard]] Cut best() const
    {
        Cut best;
        for (int axis = 0; axis < 3; ++axis)
        {
            if (!m_isFlat[axis])
            {
                sweep(axis, best);
            }
        }
        return best;
    }

private:
    static constexpr int kMostBins = 16;
    static constexpr std::size_t kSample = 1024;

    struct Bin
    {
        Bounds bounds;
        int count = 0;
    };

    void add(const Item& item)
    {
        const Bounds bounds = boundsOf(item, m_axes);
        const Array4f place = (middleOf(item, m_axes) - m_low) * m_scale;
        for (int axis = 0; axis < 3; ++axis)
        {
            if (!m_isFlat[axis])
            {
                const int i = std::clamp(static_cast<int>(place[axis]), 0, m_count - 1);
                Bin& bin = m_bins[axis][i];
                bin.bounds.add(bounds);
                ++bin.count;
            }
        }
    }

    void sweep(int axis, Cut& best) const
    {
        const Bin* const bins = m_bins[axis];
        float surfaceFrom[kMostBins];
        Bounds right;
        for (int i = m_count - 1; i > 0; --i)
        {
            right.add(bins[i].bounds);
            surfaceFrom[i] = right.surface();
        }
        Bounds left;
        int count = 0;
        for (int i = 1; i < m_count; ++i)
        {
            left.add(bins[i - 1].bounds);
            count += bins[i - 1].count;
            if (std::min(count, m_total - count) * kLeastShare < m_total)
            {
                continue;
            }
            const float surfaceLeft = left.surface();
            const float cost = surfaceLeft * std::sqrt(static_cast<float>(count)) +
                               surfaceFrom[i] * std::sqrt(static_cast<float>(m_total - count));
            if (cost < best.cost)
            {
                best = {.axis = axis,
                        .place = m_low[axis] + static_cast<float>(i) / m_scale[axis],
                        .cost = cost,
                        .surfaceLeft = surfaceLeft,
                        .surfaceRight = surfaceFrom[i]};
            }
        }
    }

public:
    /// A side gets at least an eighth of the triangles, so that the depth stays logarithmic.
    static constexpr int kLeastShare = 8;

private:
    const ItemAxes& m_axes;
    Array4f m_low;
    Array4f m_scale;
    bool m_isFlat[3] = {};
    int m_count = 0;
    int m_total = 0;
    Bin m_bins[3][kMostBins];
};

class Splitter
{
public:
    std::vector<Item> items;
    std::vector<SsvBinaryNode> nodes;

    void run()
    {
        nodes.resize(2 * items.size() - 1);
        nodes[0] = {0, static_cast<std::int32_t>(items.size()), 0, 0.0F};
        build(0, 1);
    }

private:
    /// Divides the items in two where they are cheapest, or at the median of the longest axis
    /// where that would unbalance the tree. Returns the size of the first half.
    static std::size_t divide(std::span<Item> items, Cut& cut)
    {
        const ItemAxes axes = principalAxes(items);
        cut = Bins(items, axes).best();
        if (cut.axis != kNone)
        {
            const auto middle = std::partition(
                items.begin(),
                items.end(),
                [&](const Item& item) { return middleOf(item, axes)[cut.axis] < cut.place; });
            const auto left = static_cast<std::size_t>(middle - items.begin());
            if (std::min(left, items.size() - left) * Bins::kLeastShare >= items.size())
            {
                return left;
            }
        }
        const std::size_t half = items.size() / 2;
        const auto key = [&](const Item& item)
        { return std::pair(middleOf(item, axes)[0], item.triangle); };
        std::nth_element(items.begin(),
                         items.begin() + static_cast<std::ptrdiff_t>(half),
                         items.end(),
                         [&](const Item& a, const Item& b) { return key(a) < key(b); });
        cut.surfaceLeft = surfaceOf(items.first(half), axes);
        cut.surfaceRight = surfaceOf(items.subspan(half), axes);
        return half;
    }

    static float surfaceOf(std::span<const Item> items, const ItemAxes& axes)
    {
        Bounds bounds;
        for (const Item& item : items)
        {
            bounds.add(boundsOf(item, axes));
        }
        return bounds.surface();
    }

    /// A subtree over n triangles has 2n - 1 nodes, so every subtree knows its block of the array
    /// in advance and both halves can be built at the same time with the same result.
    void build(std::size_t node, std::size_t firstFree)
    {
        SsvBinaryNode& here = nodes[node];
        const auto begin = static_cast<std::size_t>(here.begin);
        const std::size_t count = static_cast<std::size_t>(here.end) - begin;
        if (count == 1)
        {
            return;
        }
        here.first = static_cast<std::int32_t>(firstFree);
        Cut cut;
        const std::size_t leftCount =
            count == 2 ? 1 : divide(std::span(items).subspan(begin, count), cut);
        if (node == 0)
        {
            here.surface = cut.surfaceLeft + cut.surfaceRight;
        }
        const auto middle = static_cast<std::int32_t>(begin + leftCount);
        nodes[firstFree] = {here.begin, middle, 0, cut.surfaceLeft};
        nodes[firstFree + 1] = {middle, here.end, 0, cut.surfaceRight};
        const std::size_t leftFree = firstFree + 2;
        const std::size_t rightFree = leftFree + 2 * leftCount - 2;
        const auto left = [&] { build(firstFree, leftFree); };
        const auto right = [&] { build(firstFree + 1, rightFree); };
        constexpr std::size_t kParallel = 2048;
        if (count >= kParallel)
        {
            tbb::parallel_invoke(left, right);
        }
        else
        {
            left();
            right();
        }
    }
};

std::vector<Item> makeItems(const TriangleMesh& mesh, const Vector3d& origin)
{
    double reach = 0.0;
    for (const Vector3d& vertex : mesh.vertices)
    {
        reach = std::max(reach, (vertex - origin).cwiseAbs().maxCoeff());
    }
    const double scale = reach > 0.0 ? 1.0 / reach : 0.0;
    std::vector<Item> items(mesh.triangles.size());
    for (std::size_t i = 0; i < items.size(); ++i)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto vertex = static_cast<std::size_t>(mesh.triangles[i][k]);
            items[i].corners[k] = (scale * (mesh.vertices[vertex] - origin)).cast<float>();
        }
        items[i].triangle = static_cast<std::int32_t>(i);
        rotateToSmallest(items[i].corners);
    }
    const auto numbers = [](const Item& item) { return item.corners[0].data(); };
    tbb::parallel_sort(items.begin(),
                       items.end(),
                       [&](const Item& a, const Item& b)
                       {
                           const auto order = std::lexicographical_compare_three_way(
                               numbers(a), numbers(a) + 9, numbers(b), numbers(b) + 9);
                           return order == 0 ? a.triangle < b.triangle : order < 0;
                       });
    return items;
}
}  // namespace

SsvTopology splitTriangles(const TriangleMesh& mesh, const Vector3d& origin)
{
    const std::size_t count = mesh.triangles.size();
    Splitter splitter;
    splitter.items = makeItems(mesh, origin);
    // Ties are broken by the place in the sorted order, which a file's order does not change.
    std::vector<std::int32_t> sorted(count);
    for (std::size_t i = 0; i < count; ++i)
    {
        sorted[i] = std::exchange(splitter.items[i].triangle, static_cast<std::int32_t>(i));
    }
    splitter.run();

    SsvTopology topology{.branches = flattened(splitter.nodes), .triangles = {}};
    topology.triangles.reserve(count);
    for (const Item& item : splitter.items)
    {
        topology.triangles.push_back(sorted[static_cast<std::size_t>(item.triangle)]);
    }
    return topology;
}
}  // namespace bullet_ccd
