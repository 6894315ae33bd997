#include "tests/grasp/quality/brute_hull.h"

#include <Eigen/LU>

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

namespace bullet_ccd::tests
{
namespace
{
/// Next subset in lexicographic order; false after the last one.
bool nextSubset(std::vector<Eigen::Index>& subset, Eigen::Index count)
{
    const auto size = static_cast<Eigen::Index>(subset.size());
    for (Eigen::Index i = size - 1; i >= 0; --i)
    {
        Eigen::Index& entry = subset[static_cast<std::size_t>(i)];
        if (entry < count - size + i)
        {
            ++entry;
            std::iota(subset.begin() + i + 1, subset.end(), entry + 1);
            return true;
        }
    }
    return false;
}
}  // namespace

BruteHull bruteHull(const Eigen::MatrixXd& points)
{
    constexpr double kSlack = 1e-9;
    const Eigen::Index d = points.rows();
    std::vector<Eigen::Index> subset(static_cast<std::size_t>(d));
    std::iota(subset.begin(), subset.end(), 0);
    double factorial = 1.0;
    for (Eigen::Index i = 2; i <= d; ++i)
    {
        factorial *= static_cast<double>(i);
    }

    BruteHull result;
    double radius = std::numeric_limits<double>::infinity();
    do
    {
        // The plane u.x = 1 through the subset: distance 1/|u| from the origin.
        const Eigen::MatrixXd corners = points(Eigen::all, subset);
        const Eigen::FullPivLU<Eigen::MatrixXd> lu(corners.transpose());
        if (!lu.isInvertible())
        {
            continue;
        }
        const Eigen::VectorXd u = lu.solve(Eigen::VectorXd::Ones(d));
        const Eigen::VectorXd heights = points.transpose() * u;
        if (heights.minCoeff() >= 1.0 - kSlack)
        {
            return {};  // all points lie beyond this plane: the origin does not
        }
        if (heights.maxCoeff() <= 1.0 + kSlack)
        {
            ++result.facets;
            radius = std::min(radius, 1.0 / u.norm());
            result.volume += std::abs(lu.determinant()) / factorial;
        }
    } while (nextSubset(subset, points.cols()));
    result.radius = result.facets > 0 ? radius : 0.0;
    return result;
}
}  // namespace bullet_ccd::tests
