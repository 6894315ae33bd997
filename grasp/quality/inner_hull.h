/// A polytope that grows inside a convex set until its distance from the origin is that of the set.
///
/// Facets are simplices that star-wise surround a point inside, each with its neighbours; a new
/// point replaces the facets that it sees by a cone over their rim. Facets are never merged: that
/// costs nothing here, where only the facet nearest to the origin is ever asked for.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
class InnerHull
{
public:
    static constexpr int kMaxDimension = 6;
    using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxDimension, 1>;

    /// The largest simplex that is found greedily among the points, one a column; flat if they span
    /// less than all dimensions.
    /// @pre 2 to 6 rows, finite
    explicit InnerHull(const Eigen::MatrixXd& points);

    [[nodiscard]] bool flat() const { return m_facets.empty(); }

    struct Facet
    {
        std::array<std::int32_t, kMaxDimension> vertices{};
        std::array<std::int32_t, kMaxDimension> neighbours{};  ///< k-th: opposite the k-th vertex
        Vector dual;    ///< v . (x - a point inside) = 1 on the facet; infinite if seen edge-on
        Vector normal;  ///< unit, outward
        double offset = 0.0;  ///< normal . vertex
        bool alive = true;
    };

    /// The facet with the least offset: all of the hull's points x with normal . x <= offset for no
    /// other facet nearer to the origin.
    [[nodiscard]] std::int32_t nearestFacet();
    [[nodiscard]] const Facet& facet(std::int32_t index) const
    {
        return m_facets[static_cast<std::size_t>(index)];
    }

    /// Adds a point that lies beyond the facet.
    void add(const Vector& point, std::int32_t beyond);

private:
    using Ridge = std::array<std::int32_t, kMaxDimension>;

    /// A side of a facet through the newest point: what the other vertices of the side add up to,
    /// the facet, and the place in it of the vertex opposite.
    struct Side
    {
        std::uint64_t key;
        std::int32_t facet;
        std::int32_t place;
    };

    [[nodiscard]] Vector dualThrough(const Ridge& vertices) const;
    [[nodiscard]] Vector dualBetween(const Facet& seen,
                                     const Facet& unseen,
                                     const Ridge& vertices,
                                     const Vector& apex) const;
    std::int32_t addFacet(const Ridge& vertices, const Vector& dual);
    [[nodiscard]] bool sees(const Vector& point, std::int32_t facet) const;
    [[nodiscard]] std::vector<std::int32_t> visibleFrom(const Vector& point, std::int32_t first);
    void join(const std::vector<Side>& sides);

    int m_dimension;
    std::vector<Vector> m_points;
    Vector m_inside;
    std::vector<Facet> m_facets;
    std::vector<Side> m_table;
    std::vector<std::int32_t> m_lastLook;  ///< number of points when each facet was looked at
    std::priority_queue<std::pair<double, std::int32_t>,
                        std::vector<std::pair<double, std::int32_t>>,
                        std::greater<>>
        m_nearest;
};
}  // namespace bullet_ccd::grasp
