#include "grasp/quality/force_closure.h"

#include "grasp/force/contact_models.h"
#include "grasp/force/linear_program.h"
#include "grasp/force/singular_values.h"

namespace bullet_ccd::grasp
{
namespace
{
/// Below this part of the largest singular value a direction counts as missing, ..
constexpr double kRank = 1e-9;
/// .. and below this the least weight, times the number of wrenches, as 0: CLP's tolerance is 1e-9.
constexpr double kLeastWeight = 1e-7;
}  // namespace

bool isForceClosure(std::span<const Wrench> wrenches)
{
    const auto count = static_cast<Eigen::Index>(wrenches.size());
    if (count < 7)
    {
        return false;
    }
    Eigen::MatrixXd matrix(6, count);
    for (Eigen::Index k = 0; k < count; ++k)
    {
        matrix.col(k) = wrenches[static_cast<std::size_t>(k)];
    }
    const Eigen::VectorXd sigma = singularValues(matrix).values;
    if (!(sigma[5] > kRank * sigma[0]))
    {
        return false;
    }
    // Weights t + beta_k, beta_k >= 0, that sum to `count` with combination 0: the largest t.
    LinearProgram program(7, count + 1);
    program.rows.topLeftCorner(6, count) = matrix / matrix.cwiseAbs().maxCoeff();
    program.rows.row(6).setOnes();
    program.rows.col(count).head<6>() = program.rows.topLeftCorner(6, count).rowwise().sum();
    program.rows(6, count) = static_cast<double>(count);
    program.rowLower.setZero();
    program.rowLower[6] = static_cast<double>(count);
    program.rowUpper = program.rowLower;
    program.cost[count] = -1.0;
    const LinearSolution solution = solve(program);
    return solution.status == LinearStatus::Optimal && -solution.value > kLeastWeight;
}
}  // namespace bullet_ccd::grasp
