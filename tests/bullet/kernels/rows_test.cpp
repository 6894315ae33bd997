#include "bullet_ccd/bullet/kernels/btCcdRows.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <utility>

namespace bullet_ccd::tests
{
namespace
{
struct Row
{
    btSolverBody m_a;
    btSolverBody m_b;
    btSolverConstraint m_row;
};

/// @param body null: one that nothing moves
Row randomRow(std::mt19937& random, btRigidBody* body)
{
    std::uniform_real_distribution<double> real(-2.0, 2.0);
    std::uniform_int_distribution<int> third(0, 2);
    const auto number = [&] { return btScalar(real(random)); };
    const auto vector = [&] { return btVector3(number(), number(), number()); };
    Row row{};
    for (btSolverBody* side : {&row.m_a, &row.m_b})
    {
        side->m_deltaLinearVelocity = vector();
        side->m_deltaAngularVelocity = vector();
        side->m_angularFactor = vector();
        side->m_linearFactor = vector();
        side->m_invMass = vector();
        side->m_originalBody = third(random) == 0 ? nullptr : body;
    }
    row.m_row.m_contactNormal1 = vector();
    row.m_row.m_contactNormal2 = vector();
    row.m_row.m_relpos1CrossNormal = vector();
    row.m_row.m_relpos2CrossNormal = vector();
    row.m_row.m_angularComponentA = vector();
    row.m_row.m_angularComponentB = vector();
    row.m_row.m_appliedImpulse = number();
    row.m_row.m_jacDiagABInv = number();
    row.m_row.m_rhs = number();
    row.m_row.m_cfm = number();
    row.m_row.m_lowerLimit = number();
    row.m_row.m_upperLimit = row.m_row.m_lowerLimit + btFabs(number());
    return row;
}
}  // namespace

/// Rows within their limits, at them, and of bodies that nothing moves.
TEST(Rows, HaveTheSameBitsAsBullets)
{
    const btCcdRows quick = btCcdRows::quick();
    if (quick.m_generic == nullptr)
    {
        GTEST_SKIP() << "this processor has no AVX, or BULLET_CCD_SIMD forbids it";
    }
    btSequentialImpulseConstraintSolver solver;
    const std::array kinds{
        std::pair(quick.m_generic, solver.getScalarConstraintRowSolverGeneric()),
        std::pair(quick.m_lowerLimit, solver.getScalarConstraintRowSolverLowerLimit())};
    btRigidBody body(btScalar(1), nullptr, nullptr);
    std::mt19937 random(5);
    std::array<int, 3> limits{};
    for (int i = 0; i < 20000; ++i)
    {
        const Row row = randomRow(random, &body);
        for (const auto& [ours, theirs] : kinds)
        {
            Row a = row;
            Row b = row;
            ASSERT_EQ(ours(a.m_a, a.m_b, a.m_row), theirs(b.m_a, b.m_b, b.m_row));
            ASSERT_EQ(a.m_row.m_appliedImpulse, b.m_row.m_appliedImpulse);
            ASSERT_EQ(a.m_a.m_deltaLinearVelocity, b.m_a.m_deltaLinearVelocity);
            ASSERT_EQ(a.m_a.m_deltaAngularVelocity, b.m_a.m_deltaAngularVelocity);
            ASSERT_EQ(a.m_b.m_deltaLinearVelocity, b.m_b.m_deltaLinearVelocity);
            ASSERT_EQ(a.m_b.m_deltaAngularVelocity, b.m_b.m_deltaAngularVelocity);
            const btScalar impulse = a.m_row.m_appliedImpulse;
            ++limits[impulse == row.m_row.m_lowerLimit   ? 0
                     : impulse == row.m_row.m_upperLimit ? 1
                                                         : 2];
        }
    }
    EXPECT_GT(*std::ranges::min_element(limits), 1000);
}

TEST(Rows, AreBulletsOwnAgainAfterwards)
{
    btSequentialImpulseConstraintSolver solver;
    const btSingleConstraintRowSolver before = solver.getActiveConstraintRowSolverLowerLimit();
    {
        const btCcdQuickRows quick(solver, SOLVER_SIMD);
        const btCcdRows rows = btCcdRows::quick();
        const bool isScalar = before == solver.getScalarConstraintRowSolverLowerLimit();
        EXPECT_EQ(solver.getActiveConstraintRowSolverLowerLimit(),
                  rows.m_lowerLimit != nullptr && isScalar ? rows.m_lowerLimit : before);
    }
    EXPECT_EQ(solver.getActiveConstraintRowSolverLowerLimit(), before);
    // Rows that somebody else has chosen stay.
    const btSingleConstraintRowSolver own =
        [](btSolverBody&, btSolverBody&, const btSolverConstraint&) { return btScalar(0); };
    solver.setConstraintRowSolverGeneric(own);
    const btCcdQuickRows quick(solver, SOLVER_SIMD);
    EXPECT_EQ(solver.getActiveConstraintRowSolverGeneric(), own);
}
}  // namespace bullet_ccd::tests
