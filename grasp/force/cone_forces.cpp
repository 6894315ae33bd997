#include "grasp/force/cone_program.h"
#include "grasp/force/force_solvers.h"

#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
/// Unknowns: the local forces, and for Max and Firm the value of the objective as the last.
class ForceConeProgram
{
public:
    ForceConeProgram(const ScaledProblem& problem, ForceObjective objective)
        : m_problem(problem),
          m_objective(objective),
          m_forces(problem.graspMap.cols()),
          m_contacts(m_forces / problem.coordinates),
          m_unknowns(m_forces + (objective == ForceObjective::Total ? 0 : 1))
    {
        m_program.c = Eigen::VectorXd::Zero(m_unknowns);
        m_program.A = Eigen::MatrixXd::Zero(6, m_unknowns);
        m_program.A.leftCols(m_forces) = problem.graspMap;
        m_program.b = problem.target;
        const Eigen::Index capacity = m_forces + 2 * problem.torqueMap.rows() + 2 * m_contacts + 2;
        m_program.G = Eigen::MatrixXd::Zero(capacity, m_unknowns);
        m_program.h = Eigen::VectorXd::Zero(capacity);
        addTorques();
        addNormals();
        m_coneRow = m_rows;
        addCones();
        m_program.G.conservativeResize(m_rows, Eigen::NoChange);
        m_program.h.conservativeResize(m_rows);
    }

    [[nodiscard]] ScaledForces solution() const
    {
        const ConeSolution raw = solve(m_program);
        ScaledForces result;
        result.iterations = raw.iterations;
        switch (raw.status)
        {
            case ConeStatus::Optimal:
                result.status = ForceStatus::Balanced;
                result.forces = raw.x.head(m_forces);
                // Firm maximises.
                result.value = m_objective == ForceObjective::Firm ? -raw.value : raw.value;
                result.bound = m_objective == ForceObjective::Firm ? -raw.bound : raw.bound;
                break;
            case ConeStatus::Infeasible:
                result.status = ForceStatus::Infeasible;
                result.multipliers = multipliersOf(raw);
                break;
            case ConeStatus::Unbounded:
                result.status = ForceStatus::Unbounded;
                break;
            case ConeStatus::Undecided:
                break;
        }
        return result;
    }

private:
    [[nodiscard]] Eigen::Index normalOf(Eigen::Index contact) const
    {
        return contact * m_problem.coordinates;
    }

    /// |row . forces| <= limit.
    void addTorques()
    {
        for (const double sign : {1.0, -1.0})
        {
            const Eigen::Index count = m_problem.torqueMap.rows();
            m_program.G.block(m_rows, 0, count, m_forces) = sign * m_problem.torqueMap;
            m_program.h.segment(m_rows, count) = m_problem.torqueLimits;
            m_rows += count;
        }
    }

    /// Max: f_n <= s <= largest. Else f_n <= largest; Firm: t >= 0.
    void addNormals()
    {
        const bool limited = std::isfinite(m_problem.maxNormalForce);
        // Keeps the numbers of the row about 1 in size.
        const double size = limited ? std::max(1.0, m_problem.maxNormalForce) : 1.0;
        m_normalRow = m_rows;
        if (m_objective == ForceObjective::Max)
        {
            for (Eigen::Index i = 0; i < m_contacts; ++i)
            {
                m_program.G(m_rows, normalOf(i)) = 1.0;
                m_program.G(m_rows++, m_forces) = -1.0;
            }
            if (limited)
            {
                m_program.G(m_rows, m_forces) = 1.0 / size;
                m_program.h[m_rows++] = m_problem.maxNormalForce / size;
            }
            m_program.c[m_forces] = 1.0;
            return;
        }
        for (Eigen::Index i = 0; limited && i < m_contacts; ++i)
        {
            m_program.G(m_rows, normalOf(i)) = 1.0 / size;
            m_program.h[m_rows++] = m_problem.maxNormalForce / size;
        }
        m_normalRows = m_rows - m_normalRow;
        m_normalRowSize = size;
        if (m_objective == ForceObjective::Firm)
        {
            m_program.G(m_rows++, m_forces) = -1.0;
            m_program.c[m_forces] = -1.0;
        }
        else
        {
            for (Eigen::Index i = 0; i < m_contacts; ++i)
            {
                m_program.c[normalOf(i)] = 1.0;
            }
        }
    }

    /// (mu f_n - t, f_1, f_2, m_n / e) in the cone; frictionless: f_n - t >= 0.
    void addCones()
    {
        const ContactLaw& law = m_problem.law;
        const Eigen::Index d = m_problem.coordinates;
        for (Eigen::Index i = 0; i < m_contacts; ++i)
        {
            m_program.G(m_rows, normalOf(i)) = d == 1 ? -1.0 : -law.friction;
            if (m_objective == ForceObjective::Firm)
            {
                m_program.G(m_rows, m_forces) = 1.0;
            }
            for (Eigen::Index k = 1; k < d; ++k)
            {
                m_program.G(m_rows + k, normalOf(i) + k) = k == 3 ? -1.0 / law.torsion : -1.0;
            }
            m_rows += d;
            if (d > 1)
            {
                m_program.cones.sizes.push_back(d);
            }
        }
        m_program.cones.nonnegative = d == 1 ? m_rows : m_coneRow;
    }

    [[nodiscard]] ForceMultipliers multipliersOf(const ConeSolution& raw) const
    {
        const Eigen::Index joints = m_problem.torqueMap.rows();
        ForceMultipliers multipliers;
        multipliers.equilibrium = -raw.y;
        multipliers.torques = raw.z.head(joints) - raw.z.segment(joints, joints);
        multipliers.normals = Eigen::VectorXd::Zero(m_contacts);
        if (m_objective == ForceObjective::Max && std::isfinite(m_problem.maxNormalForce))
        {
            multipliers.normals = raw.z.segment(m_normalRow, m_contacts);
        }
        else if (m_objective != ForceObjective::Max && m_normalRows > 0)
        {
            multipliers.normals = raw.z.segment(m_normalRow, m_contacts) / m_normalRowSize;
        }
        return multipliers;
    }

    const ScaledProblem& m_problem;
    ForceObjective m_objective;
    Eigen::Index m_forces, m_contacts, m_unknowns;
    ConeProgram m_program;
    Eigen::Index m_rows = 0;
    Eigen::Index m_normalRow = 0;
    Eigen::Index m_normalRows = 0;
    double m_normalRowSize = 1.0;
    Eigen::Index m_coneRow = 0;
};
}  // namespace

ScaledForces solveByCones(const ScaledProblem& problem, ForceObjective objective)
{
    return ForceConeProgram(problem, objective).solution();
}
}  // namespace bullet_ccd::grasp
