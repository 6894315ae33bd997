#include "grasp/quality/inner_hull.h"

#include "bullet_ccd/math/check.h"

#include <Eigen/LU>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace bullet_ccd::grasp
{
namespace
{
/// A point nearer than this part of the size to the span of others adds no dimension to them.
constexpr double kFlat = 1e-9;
/// A facet is seen from a point that is beyond it by more than this, in units of the set.
constexpr double kBeyond = 1e-12;

/// Entry of a vertex list beyond the dimension; sorts last.
constexpr std::int32_t kUnused = std::numeric_limits<std::int32_t>::max();

/// Of a vertex (splitmix64). Sums of them tell sets of vertices apart.
std::uint64_t keyOf(std::int32_t vertex)
{
    std::uint64_t z = (static_cast<std::uint64_t>(vertex) + 1) * 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
}

/// Columns of d + 1 points that span all dimensions; fewer if there are none.
std::vector<Eigen::Index> spanningPoints(const Eigen::MatrixXd& points)
{
    const Eigen::VectorXd mean = points.rowwise().mean();
    Eigen::MatrixXd rest = points.colwise() - mean;
    const double size = points.cols() > 0 ? rest.colwise().norm().maxCoeff() : 0.0;
    Eigen::Index farthest = 0;
    std::vector<Eigen::Index> chosen;
    if (!(size > 0.0))
    {
        return chosen;
    }
    rest.colwise().norm().maxCoeff(&farthest);
    chosen.push_back(farthest);
    rest.colwise() -= Eigen::VectorXd(rest.col(farthest));
    for (Eigen::Index d = 0; d < points.rows(); ++d)
    {
        const double distance = rest.colwise().norm().maxCoeff(&farthest);
        if (!(distance > kFlat * size))
        {
            break;
        }
        chosen.push_back(farthest);
        const Eigen::VectorXd axis = rest.col(farthest) / distance;
        rest -= axis * (axis.transpose() * rest).eval();
    }
    return chosen;
}
}  // namespace

InnerHull::InnerHull(const Eigen::MatrixXd& points) : m_dimension(static_cast<int>(points.rows()))
{
    BULLET_CCD_ASSERT(m_dimension >= 2 && m_dimension <= kMaxDimension);
    const std::vector<Eigen::Index> corners = spanningPoints(points);
    if (static_cast<int>(corners.size()) <= m_dimension)
    {
        return;
    }
    m_inside = Vector::Zero(m_dimension);
    for (const Eigen::Index corner : corners)
    {
        m_points.emplace_back(points.col(corner));
        m_inside += points.col(corner) / static_cast<double>(corners.size());
    }
    // Facet k leaves corner k out; opposite its vertex j is the facet that leaves j out.
    for (std::int32_t omitted = 0; omitted <= m_dimension; ++omitted)
    {
        Ridge vertices;
        vertices.fill(kUnused);
        for (std::int32_t k = 0, corner = 0; corner <= m_dimension; ++corner)
        {
            if (corner != omitted)
            {
                vertices[static_cast<std::size_t>(k++)] = corner;
            }
        }
        addFacet(vertices, dualThrough(vertices));
        m_facets.back().neighbours = vertices;
    }
}

std::int32_t InnerHull::nearestFacet()
{
    while (!facet(m_nearest.top().second).alive)
    {
        m_nearest.pop();
    }
    return m_nearest.top().second;
}

InnerHull::Vector InnerHull::dualThrough(const Ridge& vertices) const
{
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxDimension, kMaxDimension> spokes(
        m_dimension, m_dimension);
    for (Eigen::Index k = 0; k < m_dimension; ++k)
    {
        const auto vertex = static_cast<std::size_t>(vertices[static_cast<std::size_t>(k)]);
        spokes.row(k) = (m_points[vertex] - m_inside).transpose();
    }
    return spokes.partialPivLu().solve(Vector::Ones(m_dimension));
}

/// Of the facet through the ridge of two others and a point beyond one of them. On the ridge both
/// duals give 1, and so does what lies between them; the point says where. So a facet costs O(d),
/// where solving for all its vertices costs O(d^3).
InnerHull::Vector InnerHull::dualBetween(const Facet& seen,
                                         const Facet& unseen,
                                         const Ridge& vertices,
                                         const Vector& apex) const
{
    const double above = seen.dual.dot(apex - m_inside) - 1.0;
    const double below = 1.0 - unseen.dual.dot(apex - m_inside);
    if (!(above > 0.0 && below >= 0.0 && std::isfinite(above + below)))
    {
        return dualThrough(vertices);
    }
    return (below * seen.dual + above * unseen.dual) / (above + below);
}

std::int32_t InnerHull::addFacet(const Ridge& vertices, const Vector& dual)
{
    const double length = dual.norm();
    Facet facet;
    facet.vertices = vertices;
    facet.dual = dual;
    facet.normal = dual / length;
    facet.offset = 1.0 / length + facet.normal.dot(m_inside);
    if (!std::isfinite(length))
    {
        // A sliver that is seen edge-on from inside: it hides nothing.
        facet.normal = Vector::Zero(m_dimension);
        facet.offset = std::numeric_limits<double>::infinity();
    }
    const auto index = static_cast<std::int32_t>(m_facets.size());
    m_nearest.emplace(facet.offset, index);
    m_facets.push_back(facet);
    m_lastLook.push_back(kNone);
    return index;
}

bool InnerHull::sees(const Vector& point, std::int32_t index) const
{
    return facet(index).normal.dot(point) > facet(index).offset + kBeyond;
}

std::vector<std::int32_t> InnerHull::visibleFrom(const Vector& point, std::int32_t first)
{
    const auto look = static_cast<std::int32_t>(m_points.size());
    std::vector<std::int32_t> visible = {first};
    m_lastLook[static_cast<std::size_t>(first)] = look;
    for (std::size_t next = 0; next < visible.size(); ++next)
    {
        for (int k = 0; k < m_dimension; ++k)
        {
            const std::int32_t neighbour =
                facet(visible[next]).neighbours[static_cast<std::size_t>(k)];
            std::int32_t& lastLook = m_lastLook[static_cast<std::size_t>(neighbour)];
            if (lastLook != look && sees(point, neighbour))
            {
                visible.push_back(neighbour);
            }
            lastLook = look;
        }
    }
    return visible;
}

/// Facets are neighbours where they have a ridge in common: two sides of one key. A table of keys
/// finds them in one pass, where sorting took half of the time of a search.
void InnerHull::join(const std::vector<Side>& sides)
{
    const std::size_t mask = std::bit_ceil(2 * sides.size()) - 1;
    m_table.assign(mask + 1, {.key = 0, .facet = kUnused, .place = 0});
    for (const Side& side : sides)
    {
        std::size_t slot = side.key & mask;
        while (m_table[slot].facet != kUnused && m_table[slot].key != side.key)
        {
            slot = (slot + 1) & mask;
        }
        Side& other = m_table[slot];
        if (other.facet == kUnused || other.facet == kNone)
        {
            other = side;
            continue;
        }
        m_facets[static_cast<std::size_t>(side.facet)]
            .neighbours[static_cast<std::size_t>(side.place)] = other.facet;
        m_facets[static_cast<std::size_t>(other.facet)]
            .neighbours[static_cast<std::size_t>(other.place)] = side.facet;
        other.facet = kNone;  // has its neighbour; the slot stays taken
    }
}

void InnerHull::add(const Vector& point, std::int32_t beyond)
{
    const std::vector<std::int32_t> visible = visibleFrom(point, beyond);
    for (const std::int32_t index : visible)
    {
        m_facets[static_cast<std::size_t>(index)].alive = false;
    }
    const auto apex = static_cast<std::int32_t>(m_points.size());
    m_points.push_back(point);
    const auto last = static_cast<std::size_t>(m_dimension - 1);
    std::vector<Side> sides;
    for (const std::int32_t index : visible)
    {
        const Facet old = facet(index);
        for (std::size_t k = 0; k <= last; ++k)
        {
            const std::int32_t outer = old.neighbours[k];
            if (!facet(outer).alive)
            {
                continue;
            }
            Ridge vertices = old.vertices;
            vertices[k] = vertices[last];
            vertices[last] = apex;
            const std::int32_t added =
                addFacet(vertices, dualBetween(old, facet(outer), vertices, point));
            m_facets[static_cast<std::size_t>(added)].neighbours[last] = outer;
            auto& outerNeighbours = m_facets[static_cast<std::size_t>(outer)].neighbours;
            *std::find(outerNeighbours.begin(), outerNeighbours.end(), index) = added;
            std::uint64_t whole = 0;
            for (std::size_t j = 0; j < last; ++j)
            {
                whole += keyOf(vertices[j]);
            }
            for (std::size_t j = 0; j < last; ++j)
            {
                const std::uint64_t key = whole - keyOf(vertices[j]);
                sides.push_back(
                    {.key = key, .facet = added, .place = static_cast<std::int32_t>(j)});
            }
        }
    }
    join(sides);
}
}  // namespace bullet_ccd::grasp
