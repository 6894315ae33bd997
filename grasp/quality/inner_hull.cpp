#include "grasp/quality/inner_hull.h"

#include "bullet_ccd/math/check.h"

#include <Eigen/LU>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

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
        addFacet(vertices);
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

std::int32_t InnerHull::addFacet(const Ridge& vertices)
{
    // Through all vertices goes {x : v . (x - inside) = 1}.
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxDimension, kMaxDimension> spokes(
        m_dimension, m_dimension);
    for (Eigen::Index k = 0; k < m_dimension; ++k)
    {
        const auto vertex = static_cast<std::size_t>(vertices[static_cast<std::size_t>(k)]);
        spokes.row(k) = (m_points[vertex] - m_inside).transpose();
    }
    const Vector v = spokes.partialPivLu().solve(Vector::Ones(m_dimension));
    const double length = v.norm();
    Facet facet;
    facet.vertices = vertices;
    facet.normal = v / length;
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
    return index;
}

bool InnerHull::sees(const Vector& point, std::int32_t index) const
{
    return facet(index).normal.dot(point) > facet(index).offset + kBeyond;
}

std::vector<std::int32_t> InnerHull::visibleFrom(const Vector& point, std::int32_t first) const
{
    std::vector<std::int32_t> visible = {first};
    std::set<std::int32_t> known = {first};
    for (std::size_t next = 0; next < visible.size(); ++next)
    {
        for (int k = 0; k < m_dimension; ++k)
        {
            const std::int32_t neighbour =
                facet(visible[next]).neighbours[static_cast<std::size_t>(k)];
            if (known.insert(neighbour).second && sees(point, neighbour))
            {
                visible.push_back(neighbour);
            }
        }
    }
    return visible;
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
    // Two new facets are neighbours where they share all vertices but one; a facet's sorted
    // vertices less that one lead to the first of the two.
    std::map<Ridge, std::pair<std::int32_t, std::size_t>> open;
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
            const std::int32_t added = addFacet(vertices);
            m_facets[static_cast<std::size_t>(added)].neighbours[last] = outer;
            auto& outerNeighbours = m_facets[static_cast<std::size_t>(outer)].neighbours;
            *std::find(outerNeighbours.begin(), outerNeighbours.end(), index) = added;
            for (std::size_t j = 0; j < last; ++j)
            {
                Ridge ridge = vertices;
                ridge[j] = -1;
                std::sort(ridge.begin(), ridge.end());
                const auto [found, isNew] = open.try_emplace(ridge, added, j);
                if (!isNew)
                {
                    const auto [other, opposite] = found->second;
                    m_facets[static_cast<std::size_t>(added)].neighbours[j] = other;
                    m_facets[static_cast<std::size_t>(other)].neighbours[opposite] = added;
                    open.erase(found);
                }
            }
        }
    }
}
}  // namespace bullet_ccd::grasp
