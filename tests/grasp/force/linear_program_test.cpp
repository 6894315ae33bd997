#include "grasp/force/linear_program.h"

#include <gtest/gtest.h>

namespace bullet_ccd::grasp
{
namespace
{
/// max x + y within x + 2y <= 4, 3x + y <= 6: corner (1.6, 1.2).
LinearProgram triangle()
{
    LinearProgram program(2, 2);
    program.rows << 1.0, 2.0, 3.0, 1.0;
    program.rowUpper << 4.0, 6.0;
    program.cost << -1.0, -1.0;
    return program;
}

TEST(LinearProgram, CornerAndDualsOfAPlaneProblem)
{
    const LinearSolution solution = solve(triangle());
    ASSERT_EQ(solution.status, LinearStatus::Optimal);
    EXPECT_NEAR(solution.x[0], 1.6, 1e-12);
    EXPECT_NEAR(solution.x[1], 1.2, 1e-12);
    EXPECT_NEAR(solution.value, -2.8, 1e-12);
    // duals y <= 0 with y1 + 3 y2 = -1, 2 y1 + y2 = -1
    EXPECT_NEAR(solution.rowDuals[0], -0.4, 1e-12);
    EXPECT_NEAR(solution.rowDuals[1], -0.2, 1e-12);
}

TEST(LinearProgram, ContradictionAndEndlessnessAreAnswers)
{
    LinearProgram contradiction = triangle();
    contradiction.rowLower << 5.0, 0.0;
    contradiction.rowUpper << 6.0, 1.0;
    EXPECT_EQ(solve(contradiction).status, LinearStatus::Infeasible);
    LinearProgram endless = triangle();
    endless.rows << 1.0, -1.0, 1.0, -1.0;
    EXPECT_EQ(solve(endless).status, LinearStatus::Unbounded);
}

TEST(LinearProgram, ColumnBoundsHold)
{
    LinearProgram program = triangle();
    program.columnUpper[0] = 1.0;
    program.columnLower[1] = -10.0;
    program.cost << -1.0, 1.0;
    const LinearSolution solution = solve(program);
    ASSERT_EQ(solution.status, LinearStatus::Optimal);
    EXPECT_NEAR(solution.value, -11.0, 1e-12);
}
}  // namespace
}  // namespace bullet_ccd::grasp
