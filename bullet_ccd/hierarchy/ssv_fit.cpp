#include "bullet_ccd/hierarchy/ssv_fit.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <oneapi/tbb/parallel_for.h>
#include <vector>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Matrix3f;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// A coordinate along axes is right to less than this fraction of the size of a box: of at most
/// twice the size, the input costs 6e-8, products and sums 1.8e-7, the third axis 1e-7; that axes
/// are orthogonal to 1e-7 only costs twice that of the size.
constexpr double kRounding = 1e-6;

/// Smallest floats that are not below what is given, which is not below 0. Not inlined for the
/// reason told at toFloats().
template <std::size_t kCount>
[[gnu::noinline]] std::array<float, kCount> roundedUp(const std::array<double, kCount>& x)
{
    std::array<float, kCount> f;
    for (std::size_t k = 0; k < kCount; ++k)
    {
        f[k] = static_cast<float>(x[k]);
        const std::uint32_t next = static_cast<double>(f[k]) < x[k] ? 1 : 0;
        f[k] = std::bit_cast<float>(std::bit_cast<std::uint32_t>(f[k]) + next);
    }
    return f;
}

Vector3d toDoubles(const float (&x)[3])
{
    return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
}

SsvNode storeNode(const SsvAxes& axes, const Vector3f& center, const Vector3d& half, double radius)
{
    SsvNode node{};
    for (int k = 0; k < 3; ++k)
    {
        node.center[k] = center[k];
        node.axis0[k] = axes.axis0[k];
        node.axis1[k] = axes.axis1[k];
    }
    const std::array<float, 5> up =
        roundedUp<5>({half[0], half[1], half[2], radius, half.norm() * (1.0 + 1e-6)});
    std::copy_n(up.begin(), 3, node.half);
    node.radius = up[3];
    node.coreRadius = up[4];
    return node;
}

/// Surface of a box with these half-extents, swept by a ball: in proportion to the chance that a
/// random line meets it. Steiner: S(K + r B) = S(K) + 2 r M(K) + 4 pi r^2 with M = 2 pi (x + y + z)
/// for a box.
double sweptSurface(const Vector3d& half, double radius)
{
    return 8.0 * (half[0] * half[1] + half[1] * half[2] + half[2] * half[0]) +
           4.0 * std::numbers::pi * radius * (half.sum() + radius);
}

/// Coordinates of the points along the axes of a box, about its middle.
class AlongAxes
{
public:
    AlongAxes(const SsvPoints& points, const Matrix3d& axes)
        : m_points(points), m_axes(axes.cast<float>())
    {
    }
    void moveTo(const Vector3d& middle) { m_middle = middle.cast<float>(); }

    [[nodiscard]] FourNumbers operator()(std::size_t i, int k) const
    {
        return m_points.along(m_axes.col(k), i) - m_middle[k];
    }
    /// How far out they are.
    [[nodiscard]] FourNumbers away(std::size_t i, int k) const
    {
        const FourNumbers x = (*this)(i, k);
        return larger(x, -x);
    }

private:
    const SsvPoints& m_points;
    Matrix3f m_axes;  ///< columns
    Vector3f m_middle = Vector3f::Zero();
};

/// Largest distance of points from a core.
class Reach
{
public:
    explicit Reach(const Vector3d& half) : m_core(half.cast<float>()) {}

    /// Of coordinates how far out they are.
    void add(FourNumbers x, FourNumbers y, FourNumbers z)
    {
        const FourNumbers outX = larger(x - m_core[0], FourNumbers{});
        const FourNumbers outY = larger(y - m_core[1], FourNumbers{});
        const FourNumbers outZ = larger(z - m_core[2], FourNumbers{});
        m_squared = larger(outX * outX + outY * outY + outZ * outZ, m_squared);
    }
    [[nodiscard]] FourNumbers squared() const { return m_squared; }

private:
    Vector3f m_core;
    FourNumbers m_squared{};
};
}  // namespace

SsvNode boxOfTriangle(const SsvCorners& corners)
{
    const SsvTriangleBox box = triangleBox(corners);
    const Vector3d& corner = corners[box.corner];
    const Vector3f center = toFloats(corner + box.center);
    // From the center as it is stored to the middle of the box, by small numbers only.
    const Vector3d offset = (center.cast<double>() - corner) - box.center;
    Vector3d half = box.half + (box.axes.matrix().transpose() * offset).cwiseAbs();
    half.array() += kRounding * half.norm() + SsvPoints::kSmallest;
    return storeNode(box.axes, center, half, 0.0);
}

SsvNode roundedBox(const SsvPoints& points, const SsvAxes& axes)
{
    const Matrix3d e = axes.matrix();
    const double unit = points.unit();
    // Extents are measured from the center as it is stored.
    AlongAxes along(points, e);
    Vector3d low;
    Vector3d high;
    FourRanges ranges[3];
    for (std::size_t i = 0; i < points.fours(); ++i)
    {
        for (int k = 0; k < 3; ++k)
        {
            ranges[k].add(along(i, k));
        }
    }
    const FourNumbers lows =
        folded(ranges[0].low, ranges[1].low, ranges[2].low, ranges[2].low, smaller);
    const FourNumbers highs =
        folded(ranges[0].high, ranges[1].high, ranges[2].high, ranges[2].high, larger);
    for (int k = 0; k < 3; ++k)
    {
        low[k] = static_cast<double>(lows[k]);
        high[k] = static_cast<double>(highs[k]);
    }
    const Vector3f center = toFloats(points.about() + e * (0.5 * unit * (low + high)));
    const Vector3d offset = e.transpose() * (center.cast<double>() - points.about());
    Vector3d half = (unit * high - offset).cwiseMax(offset - unit * low);
    const double rounding = kRounding * half.norm() + SsvPoints::kSmallest;
    half.array() += rounding;
    const SsvNode box = storeNode(axes, center, half, 0.0);
    constexpr double kFlat = 0.02;
    if (!(half[2] > kFlat * half[1]))
    {
        return box;  // too little to gain
    }
    along.moveTo(offset / unit);
    constexpr int kSteps = 4;
    const auto coreOf = [&half](int step) -> Vector3d
    { return (half.array() - half[2] * step / kSteps).cwiseMax(0.0).matrix(); };
    std::array<Reach, kSteps> reaches = {Reach(coreOf(1) / unit),
                                         Reach(coreOf(2) / unit),
                                         Reach(coreOf(3) / unit),
                                         Reach(coreOf(4) / unit)};
    for (std::size_t i = 0; i < points.fours(); i += points.stride())
    {
        const FourNumbers x = along.away(i, 0);
        const FourNumbers y = along.away(i, 1);
        const FourNumbers z = along.away(i, 2);
        for (Reach& reach : reaches)
        {
            reach.add(x, y, z);
        }
    }
    const FourNumbers squared = folded(reaches[0].squared(),
                                       reaches[1].squared(),
                                       reaches[2].squared(),
                                       reaches[3].squared(),
                                       larger);
    Vector3d bestHalf = half;
    const double boxSurface = sweptSurface(half, 0.0);
    double bestSurface = boxSurface;
    for (int i = 1; i <= kSteps; ++i)
    {
        const Vector3d core = coreOf(i);
        const double surface =
            sweptSurface(core, unit * std::sqrt(static_cast<double>(squared[i - 1])));
        if (surface < bestSurface)
        {
            bestSurface = surface;
            bestHalf = core;
        }
    }
    if (bestSurface == boxSurface)
    {
        return box;
    }
    SsvNode rounded = storeNode(axes, center, bestHalf, 0.0);
    Reach reach(toDoubles(rounded.half) / unit);
    for (std::size_t i = 0; i < points.fours(); ++i)
    {
        reach.add(along.away(i, 0), along.away(i, 1), along.away(i, 2));
    }
    const FourNumbers farthest = reach.squared();
    const float most =
        std::max(std::max(farthest[0], farthest[1]), std::max(farthest[2], farthest[3]));
    const double radius = unit * std::sqrt(static_cast<double>(most)) * (1.0 + kRounding) +
                          2.0 * rounding;  // of three coordinates
    rounded.radius = roundedUp<1>({radius})[0];
    return sweptSurface(bestHalf, radius) < boxSurface ? rounded : box;
}

namespace
{
/// Few triangles below a node, and their corners without repetition.
class Block
{
public:
    static constexpr std::int32_t kMostTriangles = 64;
    static constexpr std::size_t kMostPoints = 3 * kMostTriangles;
    using Bits = std::array<std::uint64_t, kMostPoints / 64>;

    /// Of the triangles below a node.
    void collect(std::span<const SsvCorners> corners, const SsvBranch& branch)
    {
        m_begin = static_cast<std::size_t>(branch.begin);
        m_count = 0;
        m_table.fill(kFree);
        for (std::size_t slot = m_begin; slot < static_cast<std::size_t>(branch.end); ++slot)
        {
            for (std::size_t k = 0; k < 3; ++k)
            {
                m_cornerAt[slot - m_begin][k] = find(corners[slot][k]);
            }
        }
    }

    [[nodiscard]] std::span<const Vector3d> points() const
    {
        return std::span(m_distinct).first(m_count);
    }

    /// Which of the points are corners of the triangle.
    [[nodiscard]] Bits cornersOf(std::size_t slot) const
    {
        Bits bits{};
        for (const std::uint8_t point : m_cornerAt[slot - m_begin])
        {
            bits[point / 64U] |= std::uint64_t{1} << point % 64U;
        }
        return bits;
    }

private:
    static constexpr std::uint8_t kFree = 255;
    static_assert(kMostPoints < kFree);

    std::uint8_t find(const Vector3d& point)
    {
        std::uint64_t hash = 0;
        for (const double x : point)
        {
            hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x9E3779B97F4A7C15U;
            hash ^= hash >> 32U;
        }
        std::size_t at = hash % m_table.size();
        while (m_table[at] != kFree && m_distinct[m_table[at]] != point)
        {
            at = (at + 1) % m_table.size();
        }
        if (m_table[at] == kFree)
        {
            m_table[at] = static_cast<std::uint8_t>(m_count);
            m_distinct[m_count++] = point;
        }
        return m_table[at];
    }

    std::size_t m_begin = 0;  ///< the first slot
    std::size_t m_count = 0;
    std::array<Vector3d, kMostPoints> m_distinct;
    std::array<std::array<std::uint8_t, 3>, kMostTriangles> m_cornerAt;
    std::array<std::uint8_t, 512> m_table;
};

/// Fits a few blocks at a time, level by level from the leaves up: nodes of one level wait for
/// nothing but those below.
class BlockFitter
{
public:
    static constexpr std::size_t kMostBlocks = 4;

    BlockFitter(std::span<const SsvBranch> branches,
                std::span<const SsvCorners> corners,
                std::span<SsvNode> nodes)
        : m_branches(branches), m_corners(corners), m_nodes(nodes)
    {
    }

    /// Fits the nodes at the top of blocks and all below them. Gives the points of every block.
    void fit(std::span<const std::int32_t> blocks, std::span<std::vector<Vector3d>> points)
    {
        for (std::size_t i = 0; i < blocks.size(); ++i)
        {
            m_blocks[i].collect(m_corners, m_branches[static_cast<std::size_t>(blocks[i])]);
            open(blocks[i], i);
            points[i].assign(m_blocks[i].points().begin(), m_blocks[i].points().end());
        }
        for (std::vector<Waiting>& level : m_levels)
        {
            fitLevel(level);
            level.clear();
        }
    }

private:
    /// An inner node, and which points of its block are below it.
    struct Waiting
    {
        Block::Bits bits{};
        std::int32_t node = 0;
        std::uint16_t block = 0;
        std::uint16_t count = 0;  ///< of points
    };
    struct Below
    {
        Block::Bits bits{};
        std::size_t height = 0;  ///< of a leaf 0
    };

    /// Fits the leaves and lets the inner nodes wait.
    Below open(std::int32_t index, std::size_t block)
    {
        const SsvBranch& branch = m_branches[static_cast<std::size_t>(index)];
        SsvNode& node = m_nodes[static_cast<std::size_t>(index)];
        if (branch.count == 0)
        {
            const auto slot = static_cast<std::size_t>(branch.first);
            node = boxOfTriangle(m_corners[slot]);
            node.first = branch.first;
            node.count = 0;
            return {.bits = m_blocks[block].cornersOf(slot)};
        }
        Below all;
        for (std::int32_t k = 0; k < branch.count; ++k)
        {
            const Below below = open(branch.first + k, block);
            all.height = std::max(all.height, below.height + 1);
            for (std::size_t word = 0; word < all.bits.size(); ++word)
            {
                all.bits[word] |= below.bits[word];
            }
        }
        if (m_levels.size() < all.height)
        {
            m_levels.resize(all.height);
        }
        int count = 0;
        for (const std::uint64_t word : all.bits)
        {
            count += std::popcount(word);
        }
        m_levels[all.height - 1].push_back({.bits = all.bits,
                                            .node = index,
                                            .block = static_cast<std::uint16_t>(block),
                                            .count = static_cast<std::uint16_t>(count)});
        return all;
    }

    void fitLevel(std::span<Waiting> level)
    {
        // Boxes that are turned at once should have as many points as each other.
        std::sort(level.begin(),
                  level.end(),
                  [](const Waiting& a, const Waiting& b) { return a.count < b.count; });
        for (std::size_t begin = 0; begin < level.size(); begin += kSsvTurnedAtOnce)
        {
            const std::span<const Waiting> group =
                level.subspan(begin, std::min(kSsvTurnedAtOnce, level.size() - begin));
            std::array<SsvAxes, kSsvTurnedAtOnce> axes;
            for (std::size_t i = 0; i < group.size(); ++i)
            {
                gather(group[i], m_points[i]);
                axes[i] = axesOfLargestChild(m_branches[static_cast<std::size_t>(group[i].node)]);
            }
            turnToSmallBoxes(std::span(m_points).first(group.size()), axes);
            for (std::size_t i = 0; i < group.size(); ++i)
            {
                const auto index = static_cast<std::size_t>(group[i].node);
                m_nodes[index] = roundedBox(m_points[i], axes[i]);
                m_nodes[index].first = m_branches[index].first;
                m_nodes[index].count = m_branches[index].count;
            }
        }
    }

    void gather(const Waiting& waiting, SsvPoints& points)
    {
        const std::span<const Vector3d> all = m_blocks[waiting.block].points();
        std::size_t count = 0;
        for (std::size_t word = 0; word < waiting.bits.size(); ++word)
        {
            for (std::uint64_t rest = waiting.bits[word]; rest != 0; rest &= rest - 1)
            {
                m_gathered[count++] =
                    all[64 * word + static_cast<std::size_t>(std::countr_zero(rest))];
            }
        }
        points.begin(m_gathered[0], count);
        points.add(std::span(m_gathered).first(count));
        points.end();
    }

    [[nodiscard]] SsvAxes axesOfLargestChild(const SsvBranch& branch) const
    {
        const std::span<const SsvNode> children = m_nodes.subspan(
            static_cast<std::size_t>(branch.first), static_cast<std::size_t>(branch.count));
        const SsvNode& largest = *std::max_element(children.begin(),
                                                   children.end(),
                                                   [](const SsvNode& a, const SsvNode& b)
                                                   { return a.coreRadius < b.coreRadius; });
        return {.axis0 = Vector3f(largest.axis0), .axis1 = Vector3f(largest.axis1)};
    }

    std::span<const SsvBranch> m_branches;
    std::span<const SsvCorners> m_corners;
    std::span<SsvNode> m_nodes;
    std::array<Block, kMostBlocks> m_blocks;
    std::vector<std::vector<Waiting>> m_levels;  ///< by height above the leaves
    std::array<SsvPoints, kSsvTurnedAtOnce> m_points;
    std::array<Vector3d, Block::kMostPoints> m_gathered;
};

/// The nodes above blocks, and the blocks in the order of their slots.
struct Levels
{
    std::vector<std::int32_t> upper;
    std::vector<std::int32_t> blocks;
};

Levels levelsOf(std::span<const SsvBranch> branches)
{
    Levels levels;
    std::vector<std::int32_t> waiting = {0};
    while (!waiting.empty())
    {
        const std::int32_t node = waiting.back();
        waiting.pop_back();
        const SsvBranch& branch = branches[static_cast<std::size_t>(node)];
        if (branch.end - branch.begin <= Block::kMostTriangles)
        {
            levels.blocks.push_back(node);
            continue;
        }
        levels.upper.push_back(node);
        for (std::int32_t k = 0; k < branch.count; ++k)
        {
            waiting.push_back(branch.first + k);
        }
    }
    std::sort(levels.blocks.begin(),
              levels.blocks.end(),
              [&](std::int32_t a, std::int32_t b)
              {
                  return branches[static_cast<std::size_t>(a)].begin <
                         branches[static_cast<std::size_t>(b)].begin;
              });
    return levels;
}

using Indices = tbb::blocked_range<std::size_t>;

/// On all threads if there is more than one of grain.
template <class Work>
void forAll(std::size_t count, std::size_t grain, const Work& work)
{
    const Indices all(0, count, grain);
    if (all.is_divisible())
    {
        tbb::parallel_for(all, work);
    }
    else
    {
        work(all);  // starting threads would cost more than the work
    }
}
}  // namespace

void fitNodes(std::span<const SsvBranch> branches,
              std::span<const SsvCorners> corners,
              std::span<SsvNode> nodes)
{
    const Levels levels = levelsOf(branches);
    std::vector<std::vector<Vector3d>> points(levels.blocks.size());
    forAll(levels.blocks.size(),
           8,
           [&](const Indices& range)
           {
               BlockFitter fitter(branches, corners, nodes);
               for (std::size_t i = range.begin(); i < range.end(); i += BlockFitter::kMostBlocks)
               {
                   const std::size_t count = std::min(BlockFitter::kMostBlocks, range.end() - i);
                   fitter.fit(std::span(levels.blocks).subspan(i, count),
                              std::span(points).subspan(i, count));
               }
           });
    forAll(levels.upper.size(),
           1,
           [&](const Indices& range)
           {
               SsvPoints all;
               for (std::size_t i = range.begin(); i < range.end(); ++i)
               {
                   const auto index = static_cast<std::size_t>(levels.upper[i]);
                   const SsvBranch& branch = branches[index];
                   const auto beginsBefore = [&](std::int32_t block, std::int32_t slot)
                   { return branches[static_cast<std::size_t>(block)].begin < slot; };
                   const auto first = std::lower_bound(
                       levels.blocks.begin(), levels.blocks.end(), branch.begin, beginsBefore);
                   const auto last =
                       std::lower_bound(first, levels.blocks.end(), branch.end, beginsBefore);
                   const std::span<const std::vector<Vector3d>> below = std::span(points).subspan(
                       static_cast<std::size_t>(first - levels.blocks.begin()),
                       static_cast<std::size_t>(last - first));
                   std::size_t count = 0;
                   for (const std::vector<Vector3d>& block : below)
                   {
                       count += block.size();
                   }
                   all.begin(below[0][0], count);
                   for (const std::vector<Vector3d>& block : below)
                   {
                       all.add(block);
                   }
                   all.end();
                   nodes[index] = roundedBox(all, smallBoxAxes(all));
                   nodes[index].first = branch.first;
                   nodes[index].count = branch.count;
               }
           });
}
}  // namespace bullet_ccd
