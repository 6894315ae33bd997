#include "grasp/check/box_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
constexpr std::int32_t kMaxCellsPerAxis = 256;
}  // namespace

BoxGrid::BoxGrid(std::vector<Eigen::AlignedBox3d> boxes)
    : m_boxes(std::move(boxes)), m_lastQuery(m_boxes.size(), 0)
{
    for (const Eigen::AlignedBox3d& box : m_boxes)
    {
        m_bounds.extend(box);
    }
    // Edge of a cell: the extents that count share out as many cells as there are boxes.
    const Eigen::Vector3d extent = (m_bounds.max() - m_bounds.min()).cwiseMax(0.0);
    double product = 1.0;
    int axes = 0;
    for (int k = 0; k < 3; ++k)
    {
        const bool counts = extent[k] > 1e-6 * extent.maxCoeff();
        product *= counts ? extent[k] : 1.0;
        axes += counts ? 1 : 0;
    }
    if (axes > 0)
    {
        const double edge = std::pow(product / static_cast<double>(m_boxes.size()), 1.0 / axes);
        for (int k = 0; k < 3; ++k)
        {
            const auto cells = std::clamp(std::ceil(extent[k] / edge), 1.0, 1.0 * kMaxCellsPerAxis);
            m_size[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(cells);
            m_cellsPerLength[k] = extent[k] > 0.0 ? cells / extent[k] : 0.0;
        }
    }

    // Counting sort of (cell, box).
    m_firstEntry.assign(static_cast<std::size_t>(m_size[0] * m_size[1] * m_size[2]) + 1, 0);
    for (const Eigen::AlignedBox3d& box : m_boxes)
    {
        forCells(box, [&](std::size_t cell) { ++m_firstEntry[cell + 1]; });
    }
    std::partial_sum(m_firstEntry.begin(), m_firstEntry.end(), m_firstEntry.begin());
    m_entries.resize(m_firstEntry.back());
    std::vector<std::size_t> next = m_firstEntry;
    for (std::size_t i = 0; i < m_boxes.size(); ++i)
    {
        forCells(m_boxes[i],
                 [&](std::size_t cell) { m_entries[next[cell]++] = static_cast<std::int32_t>(i); });
    }
}

BoxGrid::Cell BoxGrid::cellOf(const Eigen::Vector3d& point) const
{
    Cell cell{};
    for (std::size_t k = 0; k < 3; ++k)
    {
        const auto axis = static_cast<Eigen::Index>(k);
        const double place = (point[axis] - m_bounds.min()[axis]) * m_cellsPerLength[axis];
        cell[k] = static_cast<std::int32_t>(std::clamp(place, 0.0, m_size[k] - 1.0));
    }
    return cell;
}

template <typename Visit>
void BoxGrid::forCells(const Eigen::AlignedBox3d& box, const Visit& visit) const
{
    const Cell low = cellOf(box.min());
    const Cell high = cellOf(box.max());
    for (std::int32_t z = low[2]; z <= high[2]; ++z)
    {
        for (std::int32_t y = low[1]; y <= high[1]; ++y)
        {
            for (std::int32_t x = low[0]; x <= high[0]; ++x)
            {
                const std::int64_t row = std::int64_t{z} * m_size[1] + y;
                visit(static_cast<std::size_t>(row * m_size[0] + x));
            }
        }
    }
}

void BoxGrid::query(const Eigen::AlignedBox3d& box, std::vector<std::int32_t>& found)
{
    found.clear();
    ++m_queries;
    if (!box.intersects(m_bounds))
    {
        return;
    }
    forCells(box,
             [&](std::size_t cell)
             {
                 for (std::size_t i = m_firstEntry[cell]; i < m_firstEntry[cell + 1]; ++i)
                 {
                     const auto number = static_cast<std::size_t>(m_entries[i]);
                     if (m_lastQuery[number] != m_queries && m_boxes[number].intersects(box))
                     {
                         m_lastQuery[number] = m_queries;
                         found.push_back(m_entries[i]);
                     }
                 }
             });
}
}  // namespace bullet_ccd::grasp
