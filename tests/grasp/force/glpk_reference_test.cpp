// The programs again, written from the formulas and solved by GLPK: linear ones as they are, conic
// ones between inscribed and circumscribed pyramids.
#include "grasp/force/force_problem.h"
#include "grasp/force/grasp_forces.h"
#include "tests/grasp/contact_sets.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <glpk.h>
#include <memory>
#include <numbers>
#include <optional>

namespace bullet_ccd::grasp
{
namespace
{
class GlpkProblem
{
public:
    GlpkProblem() : m_problem(glp_create_prob(), &glp_delete_prob) { glp_term_out(GLP_OFF); }

    int addRow(double lower, double upper)
    {
        const int row = glp_add_rows(m_problem.get(), 1);
        glp_set_row_bnds(m_problem.get(), row, lower == upper ? GLP_FX : GLP_DB, lower, upper);
        return row;
    }
    void boundFromAbove(int row) { glp_set_row_bnds(m_problem.get(), row, GLP_UP, 0.0, 0.0); }
    /// A column from 0 on with its entries in rows 1, 2, ..
    void addColumn(double cost, const Eigen::VectorXd& entries)
    {
        const int column = glp_add_cols(m_problem.get(), 1);
        glp_set_col_bnds(m_problem.get(), column, GLP_LO, 0.0, 0.0);
        glp_set_obj_coef(m_problem.get(), column, cost);
        std::vector<int> rows = {0};
        std::vector<double> values = {0.0};
        for (Eigen::Index k = 0; k < entries.size(); ++k)
        {
            rows.push_back(static_cast<int>(k) + 1);
            values.push_back(entries[k]);
        }
        glp_set_mat_col(
            m_problem.get(), column, static_cast<int>(entries.size()), rows.data(), values.data());
    }
    /// Least cost; nothing if infeasible.
    std::optional<double> minimum()
    {
        glp_smcp parameters;
        glp_init_smcp(&parameters);
        parameters.msg_lev = GLP_MSG_OFF;
        parameters.presolve = GLP_OFF;
        glp_simplex(m_problem.get(), &parameters);
        return glp_get_status(m_problem.get()) == GLP_OPT
                   ? std::optional(glp_get_obj_val(m_problem.get()))
                   : std::nullopt;
    }

private:
    std::unique_ptr<glp_prob, decltype(&glp_delete_prob)> m_problem;
};

/// Rows: 6 of equilibrium, torques, for Max one a contact. Columns: one an edge, for Max the bound.
std::optional<double> glpkForces(const ForceProblem& problem, bool largest, int edges)
{
    GlpkProblem glpk;
    const auto joints = static_cast<Eigen::Index>(problem.torqueLimits.size());
    const auto contacts = static_cast<Eigen::Index>(problem.contacts.size());
    for (int k = 0; k < 6; ++k)
    {
        glpk.addRow(-problem.load[k], -problem.load[k]);
    }
    for (Eigen::Index j = 0; j < joints; ++j)
    {
        const double limit = problem.torqueLimits[static_cast<std::size_t>(j)];
        glpk.addRow(-limit, limit);
    }
    for (Eigen::Index i = 0; largest && i < contacts; ++i)
    {
        glpk.boundFromAbove(glpk.addRow(-1.0, 0.0));
    }
    const Eigen::Index rows = 6 + joints + (largest ? contacts : 0);
    for (Eigen::Index i = 0; i < contacts; ++i)
    {
        const GraspContact& contact = problem.contacts[static_cast<std::size_t>(i)];
        const Eigen::Vector3d a = contact.normal.unitOrthogonal();
        const Eigen::Vector3d b = contact.normal.cross(a);
        for (int edge = 0; edge < edges; ++edge)
        {
            const double phi = 2.0 * std::numbers::pi * edge / edges;
            const Eigen::Vector3d force =
                contact.normal + problem.law.friction * (std::cos(phi) * a + std::sin(phi) * b);
            Eigen::VectorXd column = Eigen::VectorXd::Zero(rows);
            column.head<3>() = force;
            column.segment<3>(3) = contact.point.cross(force);
            column.segment(6, joints) =
                jacobianOf(problem).middleRows<3>(6 * i).transpose() * force;
            if (largest)
            {
                column[6 + joints + i] = 1.0;
            }
            glpk.addColumn(largest ? 0.0 : 1.0, column);
        }
    }
    if (largest)
    {
        Eigen::VectorXd column = Eigen::VectorXd::Zero(rows);
        column.tail(contacts).setConstant(-1.0);
        glpk.addColumn(1.0, column);
    }
    return glpk.minimum();
}

/// Three joints that limit about half of what would be possible without.
ForceProblem randomReferenceProblem(std::mt19937& random, int contacts)
{
    ForceProblem problem{.contacts = tests::randomGrasp(random, contacts)};
    problem.load << tests::randomVector(random), 0.3 * tests::randomVector(random);
    problem.jacobian.resize(3 * problem.contacts.size());
    for (Twist& twist : problem.jacobian)
    {
        for (double& entry : twist)
        {
            entry = 0.1 * tests::randomVector(random).x();
        }
    }
    problem.torqueLimits.assign(3, 0.5);
    return problem;
}

ForceObjective objectiveOf(bool largest)
{
    return largest ? ForceObjective::Max : ForceObjective::Total;
}

TEST(GlpkReference, LinearProgramsOfRandomGraspsHaveTheSameValue)
{
    constexpr int kEdges = 8;
    std::mt19937 random(1);
    int balanced = 0;
    constexpr int kTrials = 200;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const ForceProblem problem = randomReferenceProblem(random, 2 + trial % 9);
        const bool largest = trial % 2 == 1;
        const GraspForces answer = solveGraspForces(problem,
                                                    {.objective = objectiveOf(largest),
                                                     .solver = ForceSolver::LinearProgram,
                                                     .coneEdges = kEdges});
        const std::optional<double> expected = glpkForces(problem, largest, kEdges);
        ASSERT_EQ(answer.status, expected ? ForceStatus::Balanced : ForceStatus::Infeasible)
            << trial;
        if (expected)
        {
            ++balanced;
            EXPECT_NEAR(answer.value, *expected, 1e-6 * (1.0 + *expected)) << trial;
        }
    }
    EXPECT_GT(balanced, kTrials / 5);
    EXPECT_LT(balanced, 4 * kTrials / 5);
}

// Circumscribed pyramids are the inscribed ones of mu / cos(pi / m): with 64 edges 0.12 % apart.
TEST(GlpkReference, ExactConesLieBetweenTheirPyramids)
{
    constexpr int kEdges = 64;
    std::mt19937 random(2);
    int balanced = 0;
    int infeasible = 0;
    constexpr int kTrials = 120;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const ForceProblem problem = randomReferenceProblem(random, 2 + trial % 9);
        const bool largest = trial % 2 == 1;
        ForceProblem wider = problem;
        wider.law.friction /= std::cos(std::numbers::pi / kEdges);
        const GraspForces answer = solveGraspForces(problem, {.objective = objectiveOf(largest)});
        const std::optional<double> upper = glpkForces(problem, largest, kEdges);
        const std::optional<double> lower = glpkForces(wider, largest, kEdges);
        ASSERT_NE(answer.status, ForceStatus::Undecided) << trial;
        if (upper)
        {
            ++balanced;
            ASSERT_TRUE(lower.has_value());
            ASSERT_EQ(answer.status, ForceStatus::Balanced) << trial;
            EXPECT_LE(answer.value, *upper * (1.0 + 1e-7)) << trial;
            EXPECT_GE(answer.value, *lower * (1.0 - 1e-7)) << trial;
        }
        if (!lower)
        {
            ++infeasible;
            ASSERT_EQ(answer.status, ForceStatus::Infeasible) << trial;
        }
    }
    EXPECT_GT(balanced, kTrials / 5);
    EXPECT_GT(infeasible, kTrials / 5);
}
}  // namespace
}  // namespace bullet_ccd::grasp
