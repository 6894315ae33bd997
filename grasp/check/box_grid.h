/// Uniform grid over axis-aligned boxes: which of them may overlap a given box.
#pragma once

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <vector>

namespace bullet_ccd::grasp
{
class BoxGrid
{
public:
    /// About as many cells as boxes. Boxes must not be empty.
    explicit BoxGrid(std::vector<Eigen::AlignedBox3d> boxes);

    [[nodiscard]] const Eigen::AlignedBox3d& bounds() const { return m_bounds; }

    /// Sets `found` to the numbers of all boxes that overlap or touch `box`, each once. The order
    /// depends on the arguments only. Not for several threads at a time.
    void query(const Eigen::AlignedBox3d& box, std::vector<std::int32_t>& found);

private:
    using Cell = std::array<std::int32_t, 3>;
    [[nodiscard]] Cell cellOf(const Eigen::Vector3d& point) const;
    /// Calls visit(index of the cell) for all cells that `box` reaches.
    template <typename Visit>
    void forCells(const Eigen::AlignedBox3d& box, const Visit& visit) const;

    std::vector<Eigen::AlignedBox3d> m_boxes;
    Eigen::AlignedBox3d m_bounds;
    Eigen::Vector3d m_cellsPerLength = Eigen::Vector3d::Zero();
    Cell m_size = {1, 1, 1};
    std::vector<std::size_t> m_firstEntry;  ///< of each cell in m_entries; one more at the end
    std::vector<std::int32_t> m_entries;
    std::vector<std::int64_t> m_lastQuery;  ///< that met the box
    std::int64_t m_queries = 0;
};
}  // namespace bullet_ccd::grasp
