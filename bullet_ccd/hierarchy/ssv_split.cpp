#include "bullet_ccd/hierarchy/ssv_split.h"

#include "bullet_ccd/hierarchy/ssv_points.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <oneapi/tbb/parallel_invoke.h>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();

/// A triangle in single precision, scaled to the size of the mesh: enough to decide by.
struct Item
{
    Vector3f corners[3];
    std::int32_t triangle;
};

/// A triangle on its way down. It is small because it is moved often.
struct Place
{
    Vector3f middle;     ///< three times that of its corners
    std::uint32_t item;  ///< triangles are in the order of their numbers there
};

/// Some of the items.
class ItemSet
{
public:
    ItemSet(std::span<const Item> items, std::span<Place> places)
        : m_items(items.data()), m_places(places)
    {
    }
    [[nodiscard]] std::size_t size() const { return m_places.size(); }
    [[nodiscard]] const Item& operator[](std::size_t i) const { return m_items[m_places[i].item]; }
    [[nodiscard]] std::span<Place> places() const { return m_places; }
    [[nodiscard]] ItemSet part(std::size_t begin, std::size_t count) const
    {
        return {*this, m_places.subspan(begin, count)};
    }

private:
    ItemSet(const ItemSet& all, std::span<Place> places) : m_items(all.m_items), m_places(places) {}

    const Item* m_items;
    std::span<Place> m_places;
};

/// Axes of largest, middle and smallest spread; the fourth lane is unused.
struct ItemAxes
{
    FourNumbers x{1.0F, 0.0F, 0.0F, 0.0F};
    FourNumbers y{0.0F, 1.0F, 0.0F, 0.0F};
    FourNumbers z{0.0F, 0.0F, 1.0F, 0.0F};

    [[nodiscard]] FourNumbers operator()(const Vector3f& p) const
    {
        return x * p.x() + y * p.y() + z * p.z();
    }
    [[nodiscard]] Vector3f operator[](int i) const { return {x[i], y[i], z[i]}; }
};

/// A box along these axes: a range in every lane.
struct Bounds : FourRanges
{
    using FourRanges::add;
    void add(const Bounds& other)
    {
        low = smaller(other.low, low);
        high = larger(other.high, high);
    }
    /// Areas of three sides; their sum is half the surface.
    [[nodiscard]] FourNumbers sides() const
    {
        const FourNumbers size = high - low;
        return size * __builtin_shufflevector(size, size, 1, 2, 0, 3);
    }
    /// Half of it.
    [[nodiscard]] float surface() const { return sumOf(sides()); }

    static float sumOf(FourNumbers sides) { return sides[0] + sides[1] + sides[2]; }
    /// The same of four boxes.
    static FourNumbers sumsOf(const FourNumbers (&sides)[4])
    {
        const FourNumbers ab = __builtin_shufflevector(sides[0], sides[1], 0, 4, 1, 5);
        const FourNumbers cd = __builtin_shufflevector(sides[2], sides[3], 0, 4, 1, 5);
        const FourNumbers lastAB = __builtin_shufflevector(sides[0], sides[1], 2, 6, 3, 7);
        const FourNumbers lastCD = __builtin_shufflevector(sides[2], sides[3], 2, 6, 3, 7);
        return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) +
               __builtin_shufflevector(ab, cd, 2, 3, 6, 7) +
               __builtin_shufflevector(lastAB, lastCD, 0, 1, 4, 5);
    }
};

/// What a number is sorted by, and where it is.
struct Key
{
    std::uint32_t number;  ///< in the order of the floats
    std::uint32_t index;
};

Key keyOf(float x, std::size_t index)
{
    const auto bits = std::bit_cast<std::uint32_t>(x + 0.0F);  // -0 equals 0
    constexpr std::uint32_t kSign = 0x80000000U;
    return {(bits & kSign) != 0 ? ~bits : bits | kSign, static_cast<std::uint32_t>(index)};
}

/// Sorts by the numbers and keeps the order of equal ones: digit by digit, without a branch that
/// depends on them.
void sortKeys(std::span<Key> keys, std::span<Key> spare)
{
    constexpr std::size_t kFew = 64;
    if (keys.size() <= kFew)
    {
        std::sort(keys.begin(),
                  keys.end(),
                  [](const Key& a, const Key& b)
                  { return std::pair(a.number, a.index) < std::pair(b.number, b.index); });
        return;
    }
    spare = spare.first(keys.size());
    constexpr std::size_t kDigits = 4;
    constexpr std::size_t kValues = 256;
    std::array<std::array<std::uint32_t, kValues>, kDigits> places{};
    const auto digitOf = [](const Key& key, std::size_t digit)
    { return (key.number >> (8 * digit)) % kValues; };
    for (const Key& key : keys)
    {
        for (std::size_t digit = 0; digit < kDigits; ++digit)
        {
            ++places[digit][digitOf(key, digit)];
        }
    }
    for (std::size_t digit = 0; digit < kDigits; ++digit)
    {
        std::uint32_t place = 0;
        for (std::uint32_t& count : places[digit])
        {
            place += std::exchange(count, place);
        }
        for (const Key& key : keys)
        {
            spare[places[digit][digitOf(key, digit)]++] = key;
        }
        std::swap(keys, spare);  // an even number of times
    }
}

/// Three times the middle of an item's corners.
FourNumbers middleOf(const Item& item, const ItemAxes& axes)
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
void forSample(const ItemSet& items, std::size_t limit, Visit&& visit)
{
    const std::size_t stride = (items.size() + limit - 1) / limit;
    for (std::size_t i = 0; i < items.size(); i += stride)
    {
        visit(items[i]);
    }
}

ItemAxes principalAxes(const ItemSet& items)
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
            axes.x = FourNumbers{vectors(0, 2), vectors(0, 1), vectors(0, 0), 0.0F};
            axes.y = FourNumbers{vectors(1, 2), vectors(1, 1), vectors(1, 0), 0.0F};
            axes.z = FourNumbers{vectors(2, 2), vectors(2, 1), vectors(2, 0), 0.0F};
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
    Bins(const ItemSet& items, const ItemAxes& axes) : m_axes(axes)
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
        const FourNumbers place = (middleOf(item, m_axes) - m_low) * m_scale;
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
    FourNumbers m_low;
    FourNumbers m_scale;
    bool m_isFlat[3] = {};
    int m_count = 0;
    int m_total = 0;
    Bin m_bins[3][kMostBins];
};

/// Makes two children of a node, adjacent from `firstFree` on; the first gets `left` triangles.
void splitNode(std::span<SsvBinaryNode> nodes,
               std::size_t node,
               std::size_t firstFree,
               std::size_t left,
               float surfaceLeft,
               float surfaceRight)
{
    SsvBinaryNode& here = nodes[node];
    if (node == 0)
    {
        here.surface = surfaceLeft + surfaceRight;
    }
    here.first = static_cast<std::int32_t>(firstFree);
    const auto middle = here.begin + static_cast<std::int32_t>(left);
    nodes[firstFree] = {here.begin, middle, 0, surfaceLeft};
    nodes[firstFree + 1] = {middle, here.end, 0, surfaceRight};
}

/// Divides a small set down to its triangles, along the principal axes of the set.
class SmallSplitter
{
public:
    static constexpr std::size_t kMost = 1024;

    SmallSplitter(const ItemSet& items, std::span<SsvBinaryNode> nodes)
        : m_items(items), m_nodes(nodes)
    {
        const ItemAxes axes = principalAxes(items);
        std::array<std::array<Key, kMost>, 3> keys;
        std::array<Key, kMost> spare;
        for (std::size_t i = 0; i < items.size(); ++i)
        {
            m_bounds[i] = boundsOf(items[i], axes);
            const FourNumbers middle = middleOf(items[i], axes);
            for (std::size_t axis = 0; axis < 3; ++axis)
            {
                keys[axis][i] = keyOf(middle[axis], i);
            }
        }
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
            sortKeys(std::span(keys[axis]).first(items.size()), spare);
            for (std::size_t i = 0; i < items.size(); ++i)
            {
                m_sorted[axis][i] = static_cast<std::uint16_t>(keys[axis][i].index);
            }
        }
    }

    /// Builds what is below a node that holds all of the items, from `firstFree` on.
    void run(std::size_t node, std::size_t firstFree)
    {
        m_firstSlot = m_nodes[node].begin;
        build(node, firstFree);
        std::array<Place, kMost> old;
        const std::span<Place> places = m_items.places();
        std::copy(places.begin(), places.end(), old.begin());
        for (std::size_t i = 0; i < places.size(); ++i)
        {
            places[i] = old[m_sorted[0][i]];
        }
    }

private:
    struct SmallCut
    {
        std::size_t axis = 0;
        std::size_t left = 1;  ///< how many
        float cost = kFloatInfinity;
        float surfaceLeft = 0.0F;
        float surfaceRight = 0.0F;
    };

    void build(std::size_t node, std::size_t firstFree)
    {
        SsvBinaryNode& here = m_nodes[node];
        const auto begin = static_cast<std::size_t>(here.begin - m_firstSlot);
        const auto count = static_cast<std::size_t>(here.end - here.begin);
        if (count == 1)
        {
            return;
        }
        SmallCut cut;
        if (count > 2)
        {
            for (std::size_t axis = 0; axis < 3; ++axis)
            {
                sweep(axis, begin, count, cut);
            }
            divide(cut, begin, count);
        }
        splitNode(m_nodes, node, firstFree, cut.left, cut.surfaceLeft, cut.surfaceRight);
        build(firstFree, firstFree + 2);
        build(firstFree + 1, firstFree + 2 * cut.left);
    }

    /// All cuts along one axis that leave enough on both sides; four at a time, without a branch
    /// that depends on them.
    void sweep(std::size_t axis, std::size_t begin, std::size_t count, SmallCut& best)
    {
        const std::uint16_t* const sorted = m_sorted[axis].data() + begin;
        const std::size_t least = (count + Bins::kLeastShare - 1) / Bins::kLeastShare;
        const std::size_t last = count - least;
        Bounds right;
        for (std::size_t i = count - 1; i > last; --i)
        {
            right.add(m_bounds[sorted[i]]);
        }
        for (std::size_t i = last; i >= least; --i)
        {
            right.add(m_bounds[sorted[i]]);
            m_sidesFrom[i] = right.sides();
        }
        Bounds left;
        for (std::size_t i = 1; i < least; ++i)
        {
            left.add(m_bounds[sorted[i - 1]]);
        }
        for (std::size_t i = least; i <= last; ++i)
        {
            left.add(m_bounds[sorted[i - 1]]);
            m_sidesTo[i] = left.sides();
        }
        for (std::size_t i = last + 1; i < last + 4; ++i)  // they fill the last four
        {
            m_sidesTo[i] = m_sidesFrom[i] = FourNumbers{} + kFloatInfinity;
        }

        const float* const roots = rootsOfCounts();
        FourNumbers cost = FourNumbers{} + kFloatInfinity;
        using Places = std::int32_t __attribute__((vector_size(16)));
        Places at{};
        Places here = Places{0, 1, 2, 3} + static_cast<std::int32_t>(least);
        for (std::size_t i = least; i <= last; i += 4, here += 4)
        {
            const FourNumbers to = Bounds::sumsOf(
                {m_sidesTo[i], m_sidesTo[i + 1], m_sidesTo[i + 2], m_sidesTo[i + 3]});
            const FourNumbers from = Bounds::sumsOf(
                {m_sidesFrom[i], m_sidesFrom[i + 1], m_sidesFrom[i + 2], m_sidesFrom[i + 3]});
            FourNumbers rootsTo;
            FourNumbers rootsFrom;
            std::memcpy(&rootsTo, roots + i, sizeof(rootsTo));
            std::memcpy(&rootsFrom, roots + count - i - 3, sizeof(rootsFrom));
            const FourNumbers costs =
                to * rootsTo + from * __builtin_shufflevector(rootsFrom, rootsFrom, 3, 2, 1, 0);
            at = costs < cost ? here : at;
            cost = smaller(costs, cost);
        }
        int lane = 0;  // of the first of the cheapest
        for (int other = 1; other < 4; ++other)
        {
            const bool isBetter =
                cost[other] < cost[lane] || (cost[other] == cost[lane] && at[other] < at[lane]);
            lane = isBetter ? other : lane;
        }
        if (cost[lane] < best.cost)
        {
            const auto i = static_cast<std::size_t>(at[lane]);
            best = {
                axis, i, cost[lane], Bounds::sumOf(m_sidesTo[i]), Bounds::sumOf(m_sidesFrom[i])};
        }
    }

    /// From three counts below zero to three above the most.
    static const float* rootsOfCounts()
    {
        static const std::array<float, kMost + 7> roots = []
        {
            std::array<float, kMost + 7> made{};
            for (std::size_t i = 0; i <= kMost; ++i)
            {
                made[i + 3] = std::sqrt(static_cast<float>(i));
            }
            return made;
        }();
        return roots.data() + 3;
    }

    /// Keeps the items of both sides in order along every axis.
    void divide(const SmallCut& cut, std::size_t begin, std::size_t count)
    {
        for (std::size_t i = 0; i < count; ++i)
        {
            m_isLeft[m_sorted[cut.axis][begin + i]] = i < cut.left ? 1 : 0;
        }
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
            if (axis == cut.axis)
            {
                continue;
            }
            std::uint16_t* const sorted = m_sorted[axis].data() + begin;
            std::size_t left = 0;
            std::size_t right = 0;
            for (std::size_t i = 0; i < count; ++i)
            {
                const std::uint16_t item = sorted[i];
                sorted[left] = item;
                m_rest[right] = item;
                left += m_isLeft[item];
                right += 1U - m_isLeft[item];
            }
            std::copy_n(m_rest.begin(), right, sorted + left);
        }
    }

    ItemSet m_items;
    std::span<SsvBinaryNode> m_nodes;
    std::int32_t m_firstSlot = 0;
    std::array<Bounds, kMost> m_bounds;
    std::array<std::array<std::uint16_t, kMost>, 3> m_sorted;
    // Scratch, here because the recursion may be deep.
    FourNumbers m_sidesTo[kMost + 4];
    FourNumbers m_sidesFrom[kMost + 4];
    std::array<std::uint16_t, kMost> m_isLeft;
    std::array<std::uint16_t, kMost> m_rest;
};

class Splitter
{
public:
    explicit Splitter(std::span<const Item> items)
        : m_items(items),
          m_places(items.size()),
          m_spare(items.size()),
          m_nodes(2 * items.size() - 1)
    {
        for (std::size_t i = 0; i < items.size(); ++i)
        {
            const Vector3f(&corners)[3] = items[i].corners;
            m_places[i] = {corners[0] + corners[1] + corners[2], static_cast<std::uint32_t>(i)};
        }
        m_nodes[0] = {0, static_cast<std::int32_t>(items.size()), 0, 0.0F};
        build(0, 1);
    }

    [[nodiscard]] std::span<const SsvBinaryNode> nodes() const { return m_nodes; }
    /// In the order of the slots.
    [[nodiscard]] std::span<const Place> places() const { return m_places; }

private:
    /// Those before the cut come first; the order on both sides stays. Returns how many they are.
    static std::size_t partition(std::span<Place> places,
                                 std::span<Place> spare,
                                 const Vector3f& axis,
                                 float cut)
    {
        std::size_t left = 0;
        std::size_t right = 0;
        for (const Place& here : places)  // without a branch that depends on it
        {
            const Place place = here;
            places[left] = place;
            spare[right] = place;
            const std::size_t isLeft = axis.dot(place.middle) < cut ? 1 : 0;
            left += isLeft;
            right += 1 - isLeft;
        }
        std::copy_n(spare.begin(), right, places.begin() + static_cast<std::ptrdiff_t>(left));
        return left;
    }

    /// Divides the items in two where they are cheapest, or at the median of the longest axis
    /// where that would unbalance the tree. Returns the size of the first half.
    static std::size_t divide(const ItemSet& items, std::span<Place> spare, Cut& cut)
    {
        const ItemAxes axes = principalAxes(items);
        const std::span<Place> places = items.places();
        cut = Bins(items, axes).best();
        if (cut.axis != kNone)
        {
            const std::size_t left = partition(places, spare, axes[cut.axis], cut.place);
            if (std::min(left, items.size() - left) * Bins::kLeastShare >= items.size())
            {
                return left;
            }
        }
        const std::size_t half = items.size() / 2;
        const auto key = [axis = axes[0]](const Place& place)
        { return std::pair(axis.dot(place.middle), place.item); };
        std::nth_element(places.begin(),
                         places.begin() + static_cast<std::ptrdiff_t>(half),
                         places.end(),
                         [&](const Place& a, const Place& b) { return key(a) < key(b); });
        cut.surfaceLeft = surfaceOf(items.part(0, half), axes);
        cut.surfaceRight = surfaceOf(items.part(half, items.size() - half), axes);
        return half;
    }

    static float surfaceOf(const ItemSet& items, const ItemAxes& axes)
    {
        Bounds bounds;
        for (std::size_t i = 0; i < items.size(); ++i)
        {
            bounds.add(boundsOf(items[i], axes));
        }
        return bounds.surface();
    }

    /// A subtree over n triangles has 2n - 1 nodes, so every subtree knows its block of the array
    /// in advance and both halves can be built at the same time with the same result.
    void build(std::size_t node, std::size_t firstFree)
    {
        const auto begin = static_cast<std::size_t>(m_nodes[node].begin);
        const std::size_t count = static_cast<std::size_t>(m_nodes[node].end) - begin;
        const ItemSet here(m_items, std::span(m_places).subspan(begin, count));
        if (count <= SmallSplitter::kMost)
        {
            SmallSplitter(here, m_nodes).run(node, firstFree);
            return;
        }
        Cut cut;
        const std::size_t leftCount = divide(here, std::span(m_spare).subspan(begin, count), cut);
        splitNode(m_nodes, node, firstFree, leftCount, cut.surfaceLeft, cut.surfaceRight);
        const std::size_t leftFree = firstFree + 2;
        const std::size_t rightFree = firstFree + 2 * leftCount;
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

    std::span<const Item> m_items;
    std::vector<Place> m_places;
    std::vector<Place> m_spare;
    std::vector<SsvBinaryNode> m_nodes;
};

/// In the order of their numbers, whatever the order of the file.
std::vector<Item> makeItems(const TriangleMesh& mesh, const Vector3d& origin)
{
    double reach = 0.0;
    for (const Vector3d& vertex : mesh.vertices)
    {
        reach = std::max(reach, (vertex - origin).cwiseAbs().maxCoeff());
    }
    const double scale = reach > 0.0 ? 1.0 / reach : 0.0;
    const auto vertexOf = [&mesh](std::size_t triangle, std::size_t k) -> const Vector3d&
    { return mesh.vertices[static_cast<std::size_t>(mesh.triangles[triangle][k])]; };
    std::vector<Key> keys(mesh.triangles.size());
    for (std::size_t i = 0; i < keys.size(); ++i)
    {
        const auto x = [&](std::size_t k)
        { return static_cast<float>(scale * (vertexOf(i, k).x() - origin.x())); };
        keys[i] = keyOf(std::min({x(0), x(1), x(2)}), i);  // of the smallest corner
    }
    {
        std::vector<Key> spare(keys.size());
        sortKeys(keys, spare);
    }
    std::vector<Item> items(keys.size());
    for (std::size_t i = 0; i < items.size(); ++i)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            items[i].corners[k] = (scale * (vertexOf(keys[i].index, k) - origin)).cast<float>();
        }
        items[i].triangle = static_cast<std::int32_t>(keys[i].index);
        rotateToSmallest(items[i].corners);
    }
    const auto numbers = [](const Item& item) { return item.corners[0].data(); };
    const auto isLess = [&](const Item& a, const Item& b)
    {
        const auto order = std::lexicographical_compare_three_way(
            numbers(a), numbers(a) + 9, numbers(b), numbers(b) + 9);
        return order == 0 ? a.triangle < b.triangle : order < 0;
    };
    for (std::size_t begin = 0, end = 0; begin < items.size(); begin = end)
    {
        while (end < items.size() && keys[end].number == keys[begin].number)
        {
            ++end;
        }
        std::sort(items.begin() + static_cast<std::ptrdiff_t>(begin),
                  items.begin() + static_cast<std::ptrdiff_t>(end),
                  isLess);
    }
    return items;
}
}  // namespace

SsvTopology splitTriangles(const TriangleMesh& mesh, const Vector3d& origin)
{
    const std::size_t count = mesh.triangles.size();
    const std::vector<Item> items = makeItems(mesh, origin);
    const Splitter splitter(items);
    SsvTopology topology{.branches = flattened(splitter.nodes()), .triangles = {}};
    topology.triangles.reserve(count);
    for (const Place& place : splitter.places())
    {
        topology.triangles.push_back(items[place.item].triangle);
    }
    return topology;
}
}  // namespace bullet_ccd
