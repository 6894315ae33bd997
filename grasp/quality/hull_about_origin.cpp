#include "grasp/quality/hull_about_origin.h"

#include "bullet_ccd/math/check.h"
#include "bullet_ccd/reduce/qhull_state.h"
#include "grasp/force/singular_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

namespace bullet_ccd::grasp
{
namespace
{
/// Amounts by which the whitened points (of size 1) are moved before qhull sees them: not at all,
/// then as little as it takes. Points that nearly coincide or are nearly coplanar, by 1e-13 to
/// 1e-10, defeat its merging of facets; scattered by more than that they are in general position.
constexpr std::array kScatter = {0.0, 1e-10, 1e-9, 1e-8};
/// A facet must support all points up to this, else the hull is not trusted. The smallest support
/// over the facets is then the radius up to twice this (whitened): moving points by `a` moves every
/// support by at most a * sqrt(d).
constexpr double kSupportSlack = 1e-7;

/// Affine map y = forward (x - center) after which the points have unit variance in all directions.
struct Whitening
{
    Eigen::VectorXd center;
    Eigen::MatrixXd forward;
    double determinant = 0.0;  ///< |det forward|; 0: the points are flat
};

Whitening whiten(const Eigen::MatrixXd& points)
{
    Whitening result;
    result.center = points.rowwise().mean();
    const Eigen::MatrixXd centered = points.colwise() - result.center;
    const auto [sigma, U] = singularValues(centered);
    if (sigma.size() < points.rows() || !(sigma.minCoeff() > kFlatness * sigma.maxCoeff()))
    {
        return result;
    }
    const Eigen::VectorXd scale =
        std::sqrt(static_cast<double>(points.cols())) * sigma.cwiseInverse();
    result.forward = scale.asDiagonal() * U.transpose();
    result.determinant = scale.prod();
    return result;
}

/// FA: with the volume. Pp: no reports of precision. No joggle: facets are merged instead, so that
/// symmetric hulls keep their exact values.
bool buildHull(QhullState& hull, Eigen::MatrixXd& points)
{
    char options[] = "qhull FA Pp";
    return hull.build(
        options, points.data(), static_cast<int>(points.rows()), static_cast<int>(points.cols()));
}

/// What the facets say about `whitened`; nothing if one of them does not support these points,
/// because qhull merged what it should not have.
std::optional<HullAboutOrigin> measure(const QhullState& hull,
                                       const Whitening& whitening,
                                       const Eigen::MatrixXd& whitened)
{
    const Eigen::VectorXd origin = whitening.forward * whitening.center;  // -(the image of 0)
    double radius = std::numeric_limits<double>::infinity();
    for (const facetT* facet = hull.state().facet_list; facet != nullptr && facet->next != nullptr;
         facet = facet->next)
    {
        const Eigen::Map<const Eigen::VectorXd> normal(facet->normal, whitened.rows());
        const double support = (normal.transpose() * whitened).maxCoeff();
        if (!(std::abs(support + facet->offset) <= kSupportSlack))
        {
            return std::nullopt;
        }
        // Back to the given frame: u = forward^T normal / |..|, max u.x = (support +
        // normal.origin)/|..|
        const double stretch = (whitening.forward.transpose() * normal).norm();
        radius = std::min(radius, (support + normal.dot(origin)) / stretch);
    }
    return HullAboutOrigin{.radius = std::max(radius, 0.0),
                           .volume = hull.state().totvol / whitening.determinant,
                           .flat = false};
}

/// Same points, each coordinate moved by less than `amount`; always by the same numbers.
Eigen::MatrixXd scattered(const Eigen::MatrixXd& points, double amount)
{
    std::mt19937_64 random;
    return points.unaryExpr(
        [&](double x)
        {
            const double unit = static_cast<double>(random() >> 11) * 0x1p-53;
            return x + amount * (2.0 * unit - 1.0);
        });
}
}  // namespace

HullAboutOrigin hullAboutOrigin(const Eigen::MatrixXd& points)
{
    BULLET_CCD_ASSERT(points.rows() >= 2);
    if (points.cols() <= points.rows())
    {
        return {};
    }
    const Whitening whitening = whiten(points);
    if (!(whitening.determinant > 0.0))
    {
        return {};
    }
    const Eigen::MatrixXd whitened = whitening.forward * (points.colwise() - whitening.center);
    for (const double amount : kScatter)
    {
        Eigen::MatrixXd input = scattered(whitened, amount);
        QhullState hull;
        if (!buildHull(hull, input))
        {
            continue;
        }
        if (const std::optional<HullAboutOrigin> result = measure(hull, whitening, whitened))
        {
            return *result;
        }
    }
    return {};
}
}  // namespace bullet_ccd::grasp
