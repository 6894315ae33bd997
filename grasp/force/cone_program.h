/// Second-order cone programs of up to a few hundred rows, by a primal-dual interior-point method.
///
///     primal: min c.x          s.t. A x = b, G x + s = h, s in K
///     dual:   max -b.y - h.z   s.t. A^T y + G^T z + c = 0, z in K
///
/// The method follows the central path of the homogeneous embedding, which has a solution whether
/// or not the programs have one: it ends in an optimum or in a proof that there is none. Dense
/// matrices: meant for grasps, where the number of unknowns is 3 or 4 a contact. Source:
/// Vandenberghe, "The CVXOPT linear and quadratic cone program solvers", 2010; predictor, corrector
/// and embedding after Mehrotra 1992 and Xu, Hung and Ye 1996.
#pragma once

#include "grasp/force/second_order_cones.h"

#include <Eigen/Core>

#include <cstdint>

namespace bullet_ccd::grasp
{
struct ConeProgram
{
    Eigen::VectorXd c;    ///< n
    Eigen::MatrixXd A;    ///< p x n, of any rank
    Eigen::VectorXd b;    ///< p
    Eigen::MatrixXd G;    ///< m x n, of rank n
    Eigen::VectorXd h;    ///< m
    ConeProduct cones{};  ///< K, of dimension m
};

enum class ConeStatus : std::uint8_t
{
    Optimal,     ///< x and the dual (y, z), both feasible, with values that agree
    Infeasible,  ///< (y, z): A^T y + G^T z = 0, z in K and b.y + h.z = -1: no x can exist
    Unbounded,   ///< x: A x = 0, -G x in K and c.x = -1: a direction without end
    Undecided,   ///< between these, within what rounding can tell; x is the last iterate
};

struct ConeSolution
{
    ConeStatus status = ConeStatus::Undecided;
    Eigen::VectorXd x, y, z;
    double value = 0.0;     ///< c.x
    double bound = 0.0;     ///< -b.y - h.z: no feasible x has less, up to the residual
    double residual = 0.0;  ///< largest violation of the equations above, relative to b, h and c
    int iterations = 0;
};

/// Values agree and equations hold to `kConeAccuracy`, relative to the numbers of the program;
/// where rounding stops the method earlier, to `kConeAccuracyAtLeast`, else the answer is
/// Undecided. Deterministic; safe from several threads. Never throws for numerical reasons.
/// @pre all numbers are finite, about 1 in size, and sizes agree
inline constexpr double kConeAccuracy = 1e-9;
inline constexpr double kConeAccuracyAtLeast = 1e-6;
[[nodiscard]] ConeSolution solve(const ConeProgram& program);
}  // namespace bullet_ccd::grasp
