#include "grasp/force/second_order_cones.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace bullet_ccd::grasp
{
namespace
{
/// sqrt(v_0^2 - |v_1|^2), as a product: no cancellation of squares near the wall.
template <typename Vector>
double hyperbolicNorm(const Vector& v)
{
    const double tail = v.tail(v.size() - 1).norm();
    return std::sqrt((v[0] - tail) * (v[0] + tail));
}

/// Calls visit(cone number, first entry, size) for the second-order cones.
template <typename Visit>
void forEachCone(const ConeProduct& product, const Visit& visit)
{
    Eigen::Index first = product.nonnegative;
    for (std::size_t cone = 0; cone < product.sizes.size(); ++cone)
    {
        visit(cone, first, product.sizes[cone]);
        first += product.sizes[cone];
    }
}
}  // namespace

Eigen::Index ConeProduct::dimension() const
{
    return std::accumulate(sizes.begin(), sizes.end(), nonnegative);
}

Eigen::Index ConeProduct::degree() const
{
    return nonnegative + static_cast<Eigen::Index>(sizes.size());
}

Eigen::VectorXd ConeProduct::identity() const
{
    Eigen::VectorXd e = Eigen::VectorXd::Zero(dimension());
    e.head(nonnegative).setOnes();
    forEachCone(*this, [&](std::size_t, Eigen::Index first, Eigen::Index) { e[first] = 1.0; });
    return e;
}

double ConeProduct::depth(const Eigen::VectorXd& v) const
{
    double least =
        nonnegative > 0 ? v.head(nonnegative).minCoeff() : std::numeric_limits<double>::infinity();
    forEachCone(*this,
                [&](std::size_t, Eigen::Index first, Eigen::Index size)
                { least = std::min(least, v[first] - v.segment(first + 1, size - 1).norm()); });
    return least;
}

Eigen::VectorXd ConeProduct::jordan(const Eigen::VectorXd& u, const Eigen::VectorXd& v) const
{
    Eigen::VectorXd product = u.cwiseProduct(v);
    forEachCone(*this,
                [&](std::size_t, Eigen::Index first, Eigen::Index size)
                {
                    const auto uCone = u.segment(first, size);
                    const auto vCone = v.segment(first, size);
                    product[first] = uCone.dot(vCone);
                    product.segment(first + 1, size - 1) =
                        uCone[0] * vCone.tail(size - 1) + vCone[0] * uCone.tail(size - 1);
                });
    return product;
}

Eigen::VectorXd ConeProduct::divide(const Eigen::VectorXd& u, const Eigen::VectorXd& v) const
{
    Eigen::VectorXd quotient = v.cwiseQuotient(u);
    forEachCone(*this,
                [&](std::size_t, Eigen::Index first, Eigen::Index size)
                {
                    const auto uCone = u.segment(first, size);
                    const auto vCone = v.segment(first, size);
                    const double norm = hyperbolicNorm(uCone);
                    const double head =
                        (uCone[0] * vCone[0] - uCone.tail(size - 1).dot(vCone.tail(size - 1))) /
                        (norm * norm);
                    quotient[first] = head;
                    quotient.segment(first + 1, size - 1) =
                        (vCone.tail(size - 1) - head * uCone.tail(size - 1)) / uCone[0];
                });
    return quotient;
}

double ConeProduct::longestStep(const Eigen::VectorXd& v, const Eigen::VectorXd& d) const
{
    double speed = 0.0;  // at which the nearest wall comes closer, in steps^-1
    for (Eigen::Index i = 0; i < nonnegative; ++i)
    {
        speed = std::max(speed, -d[i] / v[i]);
    }
    // Seen from v / |v|_J as the unit, d becomes (head, tail), which meets the wall at
    // 1 / (|tail| - head).
    forEachCone(*this,
                [&](std::size_t, Eigen::Index first, Eigen::Index size)
                {
                    const double norm = hyperbolicNorm(v.segment(first, size));
                    const Eigen::VectorXd unit = v.segment(first, size) / norm;
                    const Eigen::VectorXd move = d.segment(first, size) / norm;
                    const double head =
                        unit[0] * move[0] - unit.tail(size - 1).dot(move.tail(size - 1));
                    const double along = (head + move[0]) / (unit[0] + 1.0);
                    const double tail = (move.tail(size - 1) - along * unit.tail(size - 1)).norm();
                    speed = std::max(speed, tail - head);
                });
    return 1.0 / speed;
}

NesterovToddScaling::NesterovToddScaling(const ConeProduct& product,
                                         const Eigen::VectorXd& s,
                                         const Eigen::VectorXd& z)
    : m_product(&product), m_points(s.size())
{
    m_points.head(product.nonnegative) =
        s.head(product.nonnegative).cwiseQuotient(z.head(product.nonnegative)).cwiseSqrt();
    forEachCone(product,
                [&](std::size_t, Eigen::Index first, Eigen::Index size)
                {
                    const double normS = hyperbolicNorm(s.segment(first, size));
                    const double normZ = hyperbolicNorm(z.segment(first, size));
                    const Eigen::VectorXd unitS = s.segment(first, size) / normS;
                    const Eigen::VectorXd unitZ = z.segment(first, size) / normZ;
                    const double gamma = std::sqrt(0.5 * (1.0 + unitS.dot(unitZ)));
                    auto point = m_points.segment(first, size);
                    point = (unitS - unitZ) / (2.0 * gamma);
                    point[0] = (unitS[0] + unitZ[0]) / (2.0 * gamma);
                    m_stretches.push_back(std::sqrt(normS / normZ));
                });
}

namespace
{
/// [w_0, w_1^T; w_1, I + w_1 w_1^T / (1 + w_0)] times each column, with w_1 times `sign`: the
/// inverse of a unit hyperbolic map has the opposite sign.
template <typename Block, typename Point>
void applyHyperbolic(Block block, const Point& w, double sign)
{
    const Eigen::Index rest = w.size() - 1;
    const Eigen::VectorXd tail = sign * w.tail(rest);
    const Eigen::RowVectorXd along = tail.transpose() * block.bottomRows(rest);
    const Eigen::RowVectorXd head = block.row(0);
    block.bottomRows(rest) += tail * (head + along / (1.0 + w[0]));
    block.row(0) = w[0] * head + along;
}
}  // namespace

Eigen::MatrixXd NesterovToddScaling::times(Eigen::MatrixXd columns) const
{
    columns.topRows(m_product->nonnegative).array().colwise() *=
        m_points.head(m_product->nonnegative).array();
    forEachCone(*m_product,
                [&](std::size_t cone, Eigen::Index first, Eigen::Index size)
                {
                    auto block = columns.middleRows(first, size);
                    applyHyperbolic(block, m_points.segment(first, size), 1.0);
                    block *= m_stretches[cone];
                });
    return columns;
}

Eigen::MatrixXd NesterovToddScaling::inverseTimes(Eigen::MatrixXd columns) const
{
    columns.topRows(m_product->nonnegative).array().colwise() /=
        m_points.head(m_product->nonnegative).array();
    forEachCone(*m_product,
                [&](std::size_t cone, Eigen::Index first, Eigen::Index size)
                {
                    auto block = columns.middleRows(first, size);
                    applyHyperbolic(block, m_points.segment(first, size), -1.0);
                    block /= m_stretches[cone];
                });
    return columns;
}
}  // namespace bullet_ccd::grasp
