#include "bullet_ccd/hierarchy/ssv_blocks.h"

#include "bullet_ccd/hierarchy/face_slabs.h"
#include "bullet_ccd/hierarchy/ssv_fit.h"
#include "bullet_ccd/hierarchy/ssv_split.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// Most triangles of a block, unless they are all at one place. Fewer would be built less in vain
/// and have more nodes above them, which are always built.
constexpr std::int32_t kMostOfBlock = 1024;

/// Triangles of a cell of a grid: a range of their order.
struct GridCell
{
    std::int32_t begin = 0;
    std::int32_t end = 0;
    AlignedBox3d box{};  ///< of all their corners, in the tree's frame

    [[nodiscard]] std::int32_t count() const { return end - begin; }
};

/// The cells of a grid over a box.
class Grid
{
public:
    Grid(const AlignedBox3d& box, std::size_t triangles) : m_low(box.min())
    {
        // A surface meets about six times the square of so many.
        constexpr double kTrianglesPerCell = 100.0;
        constexpr double kMost = 64.0;
        const double along = std::clamp(
            std::sqrt(static_cast<double>(triangles) / (6.0 * kTrianglesPerCell)), 2.0, kMost);
        const double longest = box.sizes().maxCoeff();
        m_perLength = longest > 0.0 ? along / longest : 0.0;
        for (Eigen::Index k = 0; k < 3; ++k)
        {
            const double cells = std::ceil(box.sizes()[k] * m_perLength);
            m_sides[static_cast<std::size_t>(k)] =
                static_cast<std::int32_t>(std::clamp(cells, 1.0, along + 1.0));
        }
    }

    [[nodiscard]] std::size_t size() const
    {
        return static_cast<std::size_t>(m_sides[0] * m_sides[1] * m_sides[2]);
    }
    [[nodiscard]] std::uint32_t cellOf(const Vector3d& point) const
    {
        std::int32_t cell = 0;
        for (std::size_t k = 3; k-- > 0;)
        {
            const auto axis = static_cast<Eigen::Index>(k);
            const auto at = static_cast<std::int32_t>((point[axis] - m_low[axis]) * m_perLength);
            cell = cell * m_sides[k] + std::clamp(at, 0, m_sides[k] - 1);
        }
        return static_cast<std::uint32_t>(cell);
    }

private:
    Vector3d m_low;
    double m_perLength = 0.0;
    std::array<std::int32_t, 3> m_sides{};
};

/// Sorts triangles into cells of at most kMostOfBlock, as far as they are at different places.
class CellSorter
{
public:
    CellSorter(const TriangleMesh& mesh, const Vector3d& origin)
        : m_mesh(mesh),
          m_origin(origin),
          m_order(mesh.triangles.size()),
          m_sorted(m_order.size()),
          m_keys(m_order.size())
    {
        std::iota(m_order.begin(), m_order.end(), 0);
        const AlignedBox3d box = bounds(mesh);
        sort({.begin = 0,
              .end = static_cast<std::int32_t>(m_order.size()),
              .box = AlignedBox3d(box.min() - origin, box.max() - origin)});
    }

    [[nodiscard]] std::vector<GridCell>& cells() { return m_cells; }
    /// Of the triangles; that of a cell is a range of it.
    [[nodiscard]] std::span<const std::int32_t> order() const { return m_order; }
    [[nodiscard]] double radius() const { return std::sqrt(m_radiusSquared); }

private:
    /// What a thread saw of the cells of a grid.
    struct Tally
    {
        explicit Tally(std::size_t cells) : counts(cells, 0), boxes(cells) {}

        std::vector<std::int32_t> counts;
        std::vector<AlignedBox3d> boxes;
        double radiusSquared = 0.0;
    };

    void look(std::size_t i, const Grid& grid, Tally& tally)
    {
        const Triangle& triangle = m_mesh.triangles[static_cast<std::size_t>(m_order[i])];
        AlignedBox3d box;
        Vector3d sum = Vector3d::Zero();
        for (const std::int32_t index : triangle)
        {
            const Vector3d corner = m_mesh.vertices[static_cast<std::size_t>(index)] - m_origin;
            box.extend(corner);
            sum += corner;
            tally.radiusSquared = std::max(tally.radiusSquared, corner.squaredNorm());
        }
        const std::uint32_t cell = grid.cellOf(sum / 3.0);
        m_keys[i] = cell;
        ++tally.counts[cell];
        tally.boxes[cell].extend(box);
    }

    /// Least, greatest and sums do not depend on which thread saw what.
    Tally tallyOf(const GridCell& whole, const Grid& grid)
    {
        tbb::enumerable_thread_specific<Tally> tallies([&] { return Tally(grid.size()); });
        constexpr std::size_t kGrain = 1U << 14;
        using Range = tbb::blocked_range<std::size_t>;
        tbb::parallel_for(
            Range(
                static_cast<std::size_t>(whole.begin), static_cast<std::size_t>(whole.end), kGrain),
            [&](const Range& range)
            {
                Tally& tally = tallies.local();
                for (std::size_t i = range.begin(); i < range.end(); ++i)
                {
                    look(i, grid, tally);
                }
            });
        Tally all(grid.size());
        for (const Tally& tally : tallies)
        {
            for (std::size_t cell = 0; cell < grid.size(); ++cell)
            {
                all.counts[cell] += tally.counts[cell];
                all.boxes[cell].extend(tally.boxes[cell]);
            }
            all.radiusSquared = std::max(all.radiusSquared, tally.radiusSquared);
        }
        return all;
    }

    void sort(const GridCell& whole)
    {
        const Grid grid(whole.box, static_cast<std::size_t>(whole.count()));
        const Tally tally = tallyOf(whole, grid);
        m_radiusSquared = std::max(m_radiusSquared, tally.radiusSquared);
        std::vector<std::int32_t> ends(grid.size());
        std::vector<GridCell> parts;
        std::int32_t end = whole.begin;
        for (std::size_t cell = 0; cell < grid.size(); ++cell)
        {
            ends[cell] = end;
            const std::int32_t count = tally.counts[cell];
            if (count > 0)
            {
                // Zeros have one sign, whichever came first.
                const AlignedBox3d& box = tally.boxes[cell];
                parts.push_back({.begin = end,
                                 .end = end + count,
                                 .box = AlignedBox3d(Vector3d(box.min().array() + 0.0),
                                                     Vector3d(box.max().array() + 0.0))});
            }
            end += count;
        }
        for (auto i = static_cast<std::size_t>(whole.begin);
             i < static_cast<std::size_t>(whole.end);
             ++i)
        {
            m_sorted[static_cast<std::size_t>(ends[m_keys[i]]++)] = m_order[i];
        }
        std::copy(m_sorted.begin() + whole.begin,
                  m_sorted.begin() + whole.end,
                  m_order.begin() + whole.begin);
        for (const GridCell& part : parts)
        {
            if (part.count() <= kMostOfBlock || parts.size() == 1)
            {
                m_cells.push_back(part);
            }
            else
            {
                sort(part);
            }
        }
    }

    const TriangleMesh& m_mesh;
    Vector3d m_origin;
    std::vector<std::int32_t> m_order;
    std::vector<std::int32_t> m_sorted;
    std::vector<std::uint32_t> m_keys;
    std::vector<GridCell> m_cells;
    double m_radiusSquared = 0.0;
};

float surfaceOf(const AlignedBox3d& box)
{
    const Vector3d s = box.sizes();
    return static_cast<float>(s.x() * s.y() + s.y() * s.z() + s.z() * s.x());
}

/// Binary tree over cells, whose leaves are blocks: they are cut where it is cheapest by the
/// surfaces of the boxes and the triangles in them.
class CellTree
{
public:
    explicit CellTree(std::span<GridCell> cells) : m_cells(cells)
    {
        m_nodes.push_back({});
        build(0, cells, 0);
    }

    [[nodiscard]] std::span<const SsvBinaryNode> nodes() const { return m_nodes; }

private:
    static constexpr std::size_t kBins = 16;

    struct Bin
    {
        std::int64_t count = 0;
        AlignedBox3d box{};

        void add(const Bin& other)
        {
            count += other.count;
            box.extend(other.box);
        }
        [[nodiscard]] double cost() const
        {
            return count > 0 ? static_cast<double>(count) * static_cast<double>(surfaceOf(box))
                             : 0.0;
        }
    };

    /// Along an axis, in front of a bin.
    struct Cut
    {
        Eigen::Index axis = 0;
        std::size_t bin = 0;
        double cost = std::numeric_limits<double>::infinity();
    };

    static std::size_t binOf(const GridCell& cell, const AlignedBox3d& centers, Eigen::Index axis)
    {
        const double width = centers.sizes()[axis];
        const double at = (cell.box.center()[axis] - centers.min()[axis]) / width;
        return std::min(static_cast<std::size_t>(at * static_cast<double>(kBins)), kBins - 1);
    }

    static Cut bestCut(std::span<const GridCell> cells, const AlignedBox3d& centers)
    {
        Cut best;
        for (Eigen::Index axis = 0; axis < 3; ++axis)
        {
            if (!(centers.sizes()[axis] > 0.0))
            {
                continue;
            }
            std::array<Bin, kBins> bins{};
            for (const GridCell& cell : cells)
            {
                bins[binOf(cell, centers, axis)].add({.count = cell.count(), .box = cell.box});
            }
            std::array<double, kBins> right{};
            Bin sum;
            for (std::size_t i = kBins; i-- > 1;)
            {
                sum.add(bins[i]);
                right[i] = sum.cost();
            }
            sum = {};
            for (std::size_t i = 1; i < kBins; ++i)
            {
                sum.add(bins[i - 1]);
                const double cost = sum.cost() + right[i];
                if (cost < best.cost)
                {
                    best = {.axis = axis, .bin = i, .cost = cost};
                }
            }
        }
        return best;
    }

    /// @param slot  of the first triangle
    void build(std::size_t node, std::span<GridCell> cells, std::int32_t slot)
    {
        AlignedBox3d box;
        AlignedBox3d centers;
        std::int32_t count = 0;
        for (const GridCell& cell : cells)
        {
            box.extend(cell.box);
            centers.extend(cell.box.center());
            count += cell.count();
        }
        m_nodes[node] = {.begin = slot, .end = slot + count, .first = 0, .surface = surfaceOf(box)};
        if (cells.size() == 1 || count <= kMostOfBlock)
        {
            return;
        }
        const Cut cut = bestCut(cells, centers);
        auto middle = cells.begin() + static_cast<std::ptrdiff_t>(cells.size() / 2);
        if (cut.bin > 0)
        {
            middle = std::stable_partition(cells.begin(),
                                           cells.end(),
                                           [&](const GridCell& cell)
                                           { return binOf(cell, centers, cut.axis) < cut.bin; });
        }
        const std::size_t first = m_nodes.size();
        m_nodes[node].first = static_cast<std::int32_t>(first);
        m_nodes.resize(first + 2);
        build(first, {cells.begin(), middle}, slot);
        build(first + 1, {middle, cells.end()}, m_nodes[first].end);
    }

    std::span<GridCell> m_cells;
    std::vector<SsvBinaryNode> m_nodes;
};

std::array<Vector3d, 8> cornersOf(const AlignedBox3d& box)
{
    std::array<Vector3d, 8> corners;
    for (std::size_t i = 0; i < corners.size(); ++i)
    {
        corners[i] = box.corner(static_cast<AlignedBox3d::CornerType>(i));
    }
    return corners;
}

/// A volume around the boxes of some cells.
SsvNode volumeOf(std::span<const GridCell> cells)
{
    SsvPoints points;
    points.begin(cells.front().box.min(), 8 * cells.size());
    for (const GridCell& cell : cells)
    {
        points.add(cornersOf(cell.box));
    }
    points.end();
    return roundedBox(points, smallBoxAxes(points));
}
}  // namespace

SsvUpperTree splitIntoBlocks(const TriangleMesh& mesh, const Vector3d& origin)
{
    CellSorter sorter(mesh, origin);
    std::vector<GridCell>& cells = sorter.cells();
    const CellTree cellTree(cells);
    SsvUpperTree tree;
    tree.radius = sorter.radius();
    tree.triangles.reserve(mesh.triangles.size());
    std::vector<std::int32_t> slotOfCell;
    for (const GridCell& cell : cells)
    {
        slotOfCell.push_back(static_cast<std::int32_t>(tree.triangles.size()));
        tree.triangles.insert(tree.triangles.end(),
                              sorter.order().begin() + cell.begin,
                              sorter.order().begin() + cell.end);
    }
    const std::vector<SsvBranch> branches = flattened(cellTree.nodes());
    tree.nodes.resize(branches.size());
    tbb::parallel_for(std::size_t{0},
                      branches.size(),
                      [&](std::size_t i)
                      {
                          const SsvBranch& branch = branches[i];
                          const auto cellAt = [&](std::int32_t slot) {
                              return std::lower_bound(slotOfCell.begin(), slotOfCell.end(), slot) -
                                     slotOfCell.begin();
                          };
                          tree.nodes[i] = volumeOf({cells.begin() + cellAt(branch.begin),
                                                    cells.begin() + cellAt(branch.end)});
                          tree.nodes[i].first = branch.first;
                          tree.nodes[i].count = branch.count;
                      });
    for (const SsvBranch& branch : branches)
    {
        if (branch.count == 0)
        {
            tree.blocks.push_back({.begin = branch.begin, .end = branch.end, .root = 0});
        }
    }
    std::ranges::sort(tree.blocks, {}, &SsvBlock::begin);
    auto root = static_cast<std::int32_t>(branches.size());
    for (SsvBlock& block : tree.blocks)
    {
        block.root = root;
        root += 2 * (block.end - block.begin) - 1;
    }
    for (std::size_t i = 0; i < branches.size(); ++i)
    {
        if (branches[i].count == 0)
        {
            tree.nodes[i].first =
                std::ranges::lower_bound(tree.blocks, branches[i].begin, {}, &SsvBlock::begin)
                    ->root;
            tree.nodes[i].count = 1;
        }
    }
    return tree;
}

FaceSlabs findUpperSlabs(const SsvUpperTree& upper,
                         const TriangleMesh& mesh,
                         const Vector3d& origin,
                         std::size_t nodes)
{
    const auto cornersAt = [&](std::size_t slot)
    {
        std::array<Vector3d, 3> corners;
        const auto triangle = static_cast<std::size_t>(upper.triangles[slot]);
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto vertex = static_cast<std::size_t>(mesh.triangles[triangle][k]);
            corners[k] = mesh.vertices[vertex] - origin;
        }
        return corners;
    };
    const std::size_t stride = (upper.triangles.size() + kFaceSample - 1) / kFaceSample;
    std::vector<std::array<Vector3d, 3>> sample;
    for (std::size_t slot = 0; slot < upper.triangles.size(); slot += stride)
    {
        sample.push_back(cornersAt(slot));
    }
    FaceSlabs faces{.normals = largestNormals(sample)};
    const std::size_t count = faces.normals.size();
    faces.slabs.resize(count * nodes);
    if (count == 0)
    {
        return faces;
    }
    tbb::parallel_for(
        std::size_t{0},
        upper.blocks.size(),
        [&](std::size_t i)
        {
            const SsvBlock& block = upper.blocks[i];
            const std::span<Slab> slabs =
                std::span(faces.slabs).subspan(static_cast<std::size_t>(block.root) * count, count);
            std::ranges::fill(slabs, kNoSlab);
            for (std::int32_t slot = block.begin; slot < block.end; ++slot)
            {
                const auto corners = cornersAt(static_cast<std::size_t>(slot));
                for (std::size_t k = 0; k < count; ++k)
                {
                    include(slabs[k], faces.normals[k], corners);
                }
            }
        });
    fillSlabs(faces.normals, upper.nodes, {}, 0, upper.nodes.size(), faces.slabs);
    return faces;
}

SsvBlocks::SsvBlocks(std::vector<SsvBlock> blocks, const Parts& parts)
    : m_blocks(std::move(blocks)),
      m_parts(parts),
      m_used(m_blocks.size(), 0),
      m_flags(m_blocks.size())
{
}

void SsvBlocks::build(std::int32_t root)
{
    const auto found = std::ranges::lower_bound(m_blocks, root, {}, &SsvBlock::root);
    build(static_cast<std::size_t>(found - m_blocks.begin()));
}

void SsvBlocks::build(std::size_t index)
{
    // While a thread waits for the others that build a block, it takes no other task: that could
    // ask for the same block.
    tbb::collaborative_call_once(m_flags[index], [&] { fill(index); });
}

void SsvBlocks::fill(std::size_t index)
{
    const SsvBlock& block = m_blocks[index];
    const auto begin = static_cast<std::size_t>(block.begin);
    const std::size_t count = static_cast<std::size_t>(block.end) - begin;
    const std::span<SsvSlot> slots = m_parts.slots.subspan(begin, count);
    const std::vector<SsvSlot> before(slots.begin(), slots.end());
    TriangleMesh mesh;
    for (const SsvSlot slot : before)
    {
        const auto corner = static_cast<std::int32_t>(mesh.vertices.size());
        mesh.triangles.push_back({corner, corner + 1, corner + 2});
        for (const std::int32_t vertex : m_parts.meshTriangles[slot.triangle])
        {
            mesh.vertices.push_back(m_parts.vertices[static_cast<std::size_t>(vertex)] -
                                    m_parts.origin);
        }
    }
    const SsvTopology topology = splitTriangles(mesh, bounds(mesh).center());
    std::vector<std::array<Vector3d, 3>> corners(count);
    for (std::size_t i = 0; i < count; ++i)
    {
        const auto triangle = static_cast<std::size_t>(topology.triangles[i]);
        std::copy_n(&mesh.vertices[3 * triangle], 3, corners[i].begin());
        slots[i] =
            slotOf(static_cast<std::int32_t>(before[triangle].triangle), smallestOf(corners[i]));
        rotateToSmallest(corners[i]);
    }
    const std::span<SsvNode> nodes =
        m_parts.nodes.subspan(static_cast<std::size_t>(block.root), topology.branches.size());
    fitNodes(topology.branches, corners, nodes);
    const std::size_t normals = m_parts.normals.size();
    fillSlabs(m_parts.normals,
              nodes,
              corners,
              0,
              nodes.size(),
              m_parts.slabs.subspan(static_cast<std::size_t>(block.root) * normals,
                                    nodes.size() * normals));
    for (SsvNode& node : nodes)
    {
        node.first += node.isLeaf() ? block.begin : block.root;
    }
    m_used[index] = static_cast<std::int32_t>(nodes.size());
    m_builtTriangles += count;
}

void SsvBlocks::buildAll()
{
    tbb::parallel_for(std::size_t{0}, m_blocks.size(), [&](std::size_t index) { build(index); });
    std::call_once(
        m_marked,
        [&]
        {
            for (std::size_t i = 0; i < m_blocks.size(); ++i)
            {
                const SsvBlock& block = m_blocks[i];
                const auto end =
                    static_cast<std::size_t>(block.root + 2 * (block.end - block.begin) - 1);
                for (auto node = static_cast<std::size_t>(block.root + m_used[i]); node < end;
                     ++node)
                {
                    m_parts.nodes[node] = SsvNode{};
                    m_parts.nodes[node].first = kNone;
                }
            }
        });
}
}  // namespace bullet_ccd
