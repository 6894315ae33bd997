/// Linear programs of a few hundred rows and columns, by CLP's dual simplex.
#pragma once

#include <Eigen/Core>

#include <cstdint>

namespace bullet_ccd::grasp
{
/// min cost . x  subject to  rowLower <= rows x <= rowUpper  and  columnLower <= x <= columnUpper;
/// infinite bounds are none.
struct LinearProgram
{
    /// All rows free, all columns from 0, no cost.
    LinearProgram(Eigen::Index rowCount, Eigen::Index columnCount);

    Eigen::MatrixXd rows;
    Eigen::VectorXd rowLower, rowUpper;
    Eigen::VectorXd columnLower, columnUpper;
    Eigen::VectorXd cost;
};

enum class LinearStatus : std::uint8_t
{
    Optimal,
    Infeasible,
    Unbounded,
    Undecided,  ///< CLP gave up
};

struct LinearSolution
{
    LinearStatus status = LinearStatus::Undecided;
    Eigen::VectorXd x;
    Eigen::VectorXd rowDuals;  ///< d(optimum) / d(bound of the row)
    double value = 0.0;
};

/// Vectors are empty unless the status is Optimal. Deterministic; safe from several threads.
/// @pre all numbers but bounds are finite, entries about 1 in size: below 1e-13 they count as 0
[[nodiscard]] LinearSolution solve(const LinearProgram& program);
}  // namespace bullet_ccd::grasp
