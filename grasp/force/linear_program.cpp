#include "grasp/force/linear_program.h"

#include <Clp_C_Interface.h>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
/// Entries below this are what rounding left of 0. CLP would scale a row of them up and take it for
/// a constraint.
constexpr double kLeastEntry = 1e-13;

using Model = std::unique_ptr<Clp_Simplex, decltype(&Clp_deleteModel)>;

Model load(const LinearProgram& program)
{
    std::vector<CoinBigIndex> starts = {0};
    std::vector<int> indices;
    std::vector<double> values;
    for (Eigen::Index column = 0; column < program.rows.cols(); ++column)
    {
        for (Eigen::Index row = 0; row < program.rows.rows(); ++row)
        {
            if (std::abs(program.rows(row, column)) > kLeastEntry)
            {
                indices.push_back(static_cast<int>(row));
                values.push_back(program.rows(row, column));
            }
        }
        starts.push_back(static_cast<CoinBigIndex>(indices.size()));
    }
    Model model(Clp_newModel(), &Clp_deleteModel);
    Clp_setLogLevel(model.get(), 0);
    Clp_loadProblem(model.get(),
                    static_cast<int>(program.rows.cols()),
                    static_cast<int>(program.rows.rows()),
                    starts.data(),
                    indices.data(),
                    values.data(),
                    program.columnLower.data(),
                    program.columnUpper.data(),
                    program.cost.data(),
                    program.rowLower.data(),
                    program.rowUpper.data());
    // Its default, 1e-7, is more than what the answers promise.
    Clp_setPrimalTolerance(model.get(), 1e-9);
    Clp_setDualTolerance(model.get(), 1e-9);
    return model;
}

LinearStatus statusOf(int clpStatus)
{
    switch (clpStatus)
    {
        case 0:
            return LinearStatus::Optimal;
        case 1:
            return LinearStatus::Infeasible;
        case 2:
            return LinearStatus::Unbounded;
        default:
            return LinearStatus::Undecided;
    }
}
}  // namespace

LinearProgram::LinearProgram(Eigen::Index rowCount, Eigen::Index columnCount)
    : rows(Eigen::MatrixXd::Zero(rowCount, columnCount)),
      rowLower(Eigen::VectorXd::Constant(rowCount, -std::numeric_limits<double>::infinity())),
      rowUpper(-rowLower),
      columnLower(Eigen::VectorXd::Zero(columnCount)),
      columnUpper(Eigen::VectorXd::Constant(columnCount, std::numeric_limits<double>::infinity())),
      cost(Eigen::VectorXd::Zero(columnCount))
{
}

LinearSolution solve(const LinearProgram& program)
{
    const Model model = load(program);
    Clp_dual(model.get(), 0);
    LinearSolution solution{.status = statusOf(Clp_status(model.get())), .x = {}, .rowDuals = {}};
    if (solution.status == LinearStatus::Optimal)
    {
        solution.x = Eigen::Map<const Eigen::VectorXd>(Clp_primalColumnSolution(model.get()),
                                                       program.rows.cols());
        solution.rowDuals = Eigen::Map<const Eigen::VectorXd>(Clp_dualRowSolution(model.get()),
                                                              program.rows.rows());
        solution.value = program.cost.dot(solution.x);
    }
    return solution;
}
}  // namespace bullet_ccd::grasp
