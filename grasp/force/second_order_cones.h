/// Vectors in a product of nonnegative numbers and second-order cones {(v_0, v_1) : |v_1| <= v_0}:
/// the operations that interior-point methods need.
#pragma once

#include <Eigen/Core>

#include <vector>

namespace bullet_ccd::grasp
{
/// A product: `nonnegative` numbers, then second-order cones of the given sizes.
struct ConeProduct
{
    Eigen::Index nonnegative = 0;
    std::vector<Eigen::Index> sizes;  ///< 2 or more each

    [[nodiscard]] Eigen::Index dimension() const;
    /// Barrier parameter: one for each number and each cone.
    [[nodiscard]] Eigen::Index degree() const;
    /// The unit of the Jordan product: ones, and (1, 0, ..) in each cone.
    [[nodiscard]] Eigen::VectorXd identity() const;
    /// How far `v` is from the nearest wall: smallest v_i and v_0 - |v_1|; negative outside.
    [[nodiscard]] double depth(const Eigen::VectorXd& v) const;
    /// u o v = (u . v, u_0 v_1 + v_0 u_1), and u_i v_i for the numbers.
    [[nodiscard]] Eigen::VectorXd jordan(const Eigen::VectorXd& u, const Eigen::VectorXd& v) const;
    /// The x with u o x = v. @pre u lies inside
    [[nodiscard]] Eigen::VectorXd divide(const Eigen::VectorXd& u, const Eigen::VectorXd& v) const;
    /// Largest step (infinity included) that keeps v + step * d in the product. @pre v lies inside
    [[nodiscard]] double longestStep(const Eigen::VectorXd& v, const Eigen::VectorXd& d) const;
};

/// The symmetric linear map W that maps the product onto itself with W z = W^-1 s (Nesterov and
/// Todd 1997; the formulas for these cones: Vandenberghe, "The CVXOPT linear and quadratic cone
/// program solvers", 2010, section 5).
class NesterovToddScaling
{
public:
    /// @pre s and z lie inside `product`, which outlives this
    NesterovToddScaling(const ConeProduct& product,
                        const Eigen::VectorXd& s,
                        const Eigen::VectorXd& z);

    /// W times each column.
    [[nodiscard]] Eigen::MatrixXd times(Eigen::MatrixXd columns) const;
    /// W^-1 times each column.
    [[nodiscard]] Eigen::MatrixXd inverseTimes(Eigen::MatrixXd columns) const;

private:
    const ConeProduct* m_product;
    Eigen::VectorXd m_points;  ///< of the numbers sqrt(s / z); of cones the unit hyperbolic vector
    std::vector<double> m_stretches;  ///< one a cone
};
}  // namespace bullet_ccd::grasp
