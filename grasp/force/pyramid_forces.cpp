#include "grasp/force/force_solvers.h"
#include "grasp/force/linear_program.h"

#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
/// Unknowns: amplitudes of the pyramids' edges, contact by contact, then the objective's value for
/// Max and Firm. Rows: equilibrium, torques, normal parts.
class ForceLinearProgram
{
public:
    ForceLinearProgram(const ScaledProblem& problem, ForceObjective objective, int edges)
        : m_problem(problem),
          m_objective(objective),
          m_edges(coneEdges(problem.law, edges)),
          m_contacts(problem.graspMap.cols() / problem.coordinates)
    {
    }

    [[nodiscard]] ScaledForces solution() const
    {
        const LinearProgram program = build();
        const LinearSolution raw = solve(program);
        ScaledForces result;
        switch (raw.status)
        {
            case LinearStatus::Optimal:
                result.status = ForceStatus::Balanced;
                result.forces = forcesOf(raw.x);
                result.value = m_objective == ForceObjective::Firm ? -raw.value : raw.value;
                result.bound = result.value;
                break;
            case LinearStatus::Infeasible:
                result.status = ForceStatus::Infeasible;
                result.multipliers = proof();
                break;
            case LinearStatus::Unbounded:
                result.status = ForceStatus::Unbounded;
                break;
            case LinearStatus::Undecided:
                break;
        }
        return result;
    }

private:
    [[nodiscard]] Eigen::Index amplitudes() const { return m_contacts * m_edges.cols(); }

    /// Local forces of contact i per unit of its amplitudes.
    [[nodiscard]] auto coordinatesOf(const Eigen::MatrixXd& map, Eigen::Index contact) const
    {
        return map.middleCols(contact * m_problem.coordinates, m_problem.coordinates);
    }

    /// Rows of equilibrium, torques and normal parts; `extra` columns after the amplitudes.
    [[nodiscard]] LinearProgram constraints(Eigen::Index extra) const
    {
        const Eigen::Index joints = m_problem.torqueMap.rows();
        LinearProgram program(6 + joints + m_contacts, amplitudes() + extra);
        for (Eigen::Index i = 0; i < m_contacts; ++i)
        {
            auto columns = program.rows.middleCols(i * m_edges.cols(), m_edges.cols());
            columns.topRows<6>() = coordinatesOf(m_problem.graspMap, i) * m_edges;
            columns.middleRows(6, joints) = coordinatesOf(m_problem.torqueMap, i) * m_edges;
            columns.row(6 + joints + i).setOnes();
        }
        program.rowLower.head<6>() = m_problem.target;
        program.rowUpper.head<6>() = m_problem.target;
        program.rowLower.segment(6, joints) = -m_problem.torqueLimits;
        program.rowUpper.segment(6, joints) = m_problem.torqueLimits;
        program.rowUpper.tail(m_contacts).setConstant(m_problem.maxNormalForce);
        return program;
    }

    [[nodiscard]] LinearProgram build() const
    {
        const Eigen::Index last = amplitudes();
        if (m_objective == ForceObjective::Total)
        {
            LinearProgram program = constraints(0);
            program.cost.setOnes();
            return program;
        }
        LinearProgram program = constraints(1);
        auto column = program.rows.col(last);
        if (m_objective == ForceObjective::Max)
        {
            column.tail(m_contacts).setConstant(-1.0);
            program.rowUpper.tail(m_contacts).setZero();
            program.columnUpper[last] = m_problem.maxNormalForce;
            program.cost[last] = 1.0;
            return program;
        }
        // |f_t| <= mu f_n - t: a margin t takes the normal force t / mu (frictionless: t) from what
        // the amplitudes have.
        const double share = marginShare();
        for (Eigen::Index i = 0; i < m_contacts; ++i)
        {
            const Eigen::Index normal = i * m_problem.coordinates;
            column.head<6>() += share * m_problem.graspMap.col(normal);
            column.segment(6, m_problem.torqueMap.rows()) +=
                share * m_problem.torqueMap.col(normal);
        }
        column.tail(m_contacts).setConstant(share);
        program.cost[last] = -1.0;
        return program;
    }

    /// Normal force a unit of margin.
    [[nodiscard]] double marginShare() const
    {
        return m_problem.coordinates == 1 ? 1.0 : 1.0 / m_problem.law.friction;
    }

    [[nodiscard]] Eigen::VectorXd forcesOf(const Eigen::VectorXd& x) const
    {
        const Eigen::MatrixXd amplitude = x.head(amplitudes()).reshaped(m_edges.cols(), m_contacts);
        Eigen::MatrixXd forces = m_edges * amplitude;
        if (m_objective == ForceObjective::Firm)
        {
            forces.row(0).array() += marginShare() * x[amplitudes()];
        }
        return forces.reshaped();
    }

    /// Least sum of what equilibrium lacks: its duals are the multipliers of a certificate.
    [[nodiscard]] ForceMultipliers proof() const
    {
        const Eigen::Index joints = m_problem.torqueMap.rows();
        LinearProgram program = constraints(12);
        program.rows.topRightCorner<6, 12>() << Eigen::Matrix<double, 6, 6>::Identity(),
            -Eigen::Matrix<double, 6, 6>::Identity();
        program.cost.tail<12>().setOnes();
        const LinearSolution raw = solve(program);
        if (raw.status != LinearStatus::Optimal)
        {
            return {.torques = Eigen::VectorXd::Zero(joints),
                    .normals = Eigen::VectorXd::Zero(m_contacts)};
        }
        return {.equilibrium = raw.rowDuals.head<6>(),
                .torques = -raw.rowDuals.segment(6, joints),
                .normals = -raw.rowDuals.tail(m_contacts)};
    }

    const ScaledProblem& m_problem;
    ForceObjective m_objective;
    Eigen::MatrixXd m_edges;  ///< local coordinates x edges, normal part 1
    Eigen::Index m_contacts;
};
}  // namespace

ScaledForces solveByPyramids(const ScaledProblem& problem, ForceObjective objective, int edges)
{
    return ForceLinearProgram(problem, objective, edges).solution();
}
}  // namespace bullet_ccd::grasp
