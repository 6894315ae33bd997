#include "grasp/force/cone_program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace bullet_ccd::grasp
{
namespace
{
Eigen::VectorXd randomVector(std::mt19937& random, Eigen::Index size)
{
    std::normal_distribution<double> normal;
    return Eigen::VectorXd::NullaryExpr(size, [&] { return normal(random); });
}

ConeProduct mixedCones()
{
    return {.nonnegative = 3, .sizes = {2, 3, 5}};
}

Eigen::VectorXd insidePoint(std::mt19937& random, const ConeProduct& cones)
{
    Eigen::VectorXd v = randomVector(random, cones.dimension());
    return v + (0.1 - std::min(0.0, 1.5 * cones.depth(v))) * cones.identity();
}

/// min t with |x - center| <= t and normal . x = offset: distance of a point from a plane.
ConeProgram distanceToPlane(const Eigen::Vector3d& center,
                            const Eigen::Vector3d& normal,
                            double offset)
{
    ConeProgram program;
    program.c = Eigen::Vector4d(0.0, 0.0, 0.0, 1.0);
    program.A = Eigen::RowVector4d(normal.x(), normal.y(), normal.z(), 0.0);
    program.b = Eigen::VectorXd::Constant(1, offset);
    program.G = Eigen::MatrixXd::Zero(4, 4);
    program.G(0, 3) = -1.0;
    program.G.bottomLeftCorner<3, 3>() = -Eigen::Matrix3d::Identity();
    program.h = Eigen::Vector4d(0.0, -center.x(), -center.y(), -center.z());
    program.cones.sizes = {4};
    return program;
}

TEST(ConeProduct, DivisionUndoesTheJordanProduct)
{
    std::mt19937 random(1);
    const ConeProduct cones = mixedCones();
    EXPECT_EQ(cones.dimension(), 13);
    EXPECT_EQ(cones.degree(), 6);
    for (int trial = 0; trial < 50; ++trial)
    {
        const Eigen::VectorXd u = insidePoint(random, cones);
        const Eigen::VectorXd v = randomVector(random, 13);
        EXPECT_LT((cones.divide(u, cones.jordan(u, v)) - v).norm(), 1e-9 * v.norm());
        EXPECT_LT((cones.jordan(u, cones.identity()) - u).norm(), 1e-14);
    }
}

TEST(ConeProduct, LongestStepEndsOnTheWall)
{
    std::mt19937 random(2);
    const ConeProduct cones = mixedCones();
    int bounded = 0;
    for (int trial = 0; trial < 200; ++trial)
    {
        const Eigen::VectorXd v = insidePoint(random, cones);
        const Eigen::VectorXd d = randomVector(random, 13) + cones.identity();
        const double step = cones.longestStep(v, d);
        if (std::isinf(step))
        {
            EXPECT_GT(cones.depth(v + 1e6 * d), 0.0);
            continue;
        }
        ++bounded;
        EXPECT_NEAR(cones.depth(v + step * d), 0.0, 1e-9 * (1.0 + step));
        EXPECT_GT(cones.depth(v + 0.999 * step * d), 0.0);
    }
    EXPECT_GT(bounded, 50);
}

TEST(NesterovToddScaling, TakesBothPointsToTheSameOne)
{
    std::mt19937 random(3);
    const ConeProduct cones = mixedCones();
    for (int trial = 0; trial < 50; ++trial)
    {
        const Eigen::VectorXd s = insidePoint(random, cones);
        const Eigen::VectorXd z = insidePoint(random, cones);
        const NesterovToddScaling scaling(cones, s, z);
        EXPECT_LT((scaling.times(z) - scaling.inverseTimes(s)).norm(), 1e-10 * (1.0 + s.norm()));
        const Eigen::VectorXd v = randomVector(random, 13);
        EXPECT_LT((scaling.inverseTimes(scaling.times(v)) - v).norm(), 1e-10 * v.norm());
        EXPECT_GT(cones.depth(scaling.times(z)), 0.0);
    }
}

TEST(ConeProgram, DistanceFromAPlaneIsItsClosedForm)
{
    std::mt19937 random(4);
    for (int trial = 0; trial < 20; ++trial)
    {
        const Eigen::Vector3d center = randomVector(random, 3);
        const Eigen::Vector3d normal = randomVector(random, 3);
        const ConeSolution solution = solve(distanceToPlane(center, normal, 0.7));
        ASSERT_EQ(solution.status, ConeStatus::Optimal);
        const double exact = std::abs(normal.dot(center) - 0.7) / normal.norm();
        EXPECT_NEAR(solution.value, exact, 1e-8);
        EXPECT_NEAR(solution.bound, exact, 1e-8);
        EXPECT_LT(solution.iterations, 30);
    }
}

TEST(ConeProgram, RepeatedEquationsDoNoHarm)
{
    ConeProgram program = distanceToPlane({1.0, 2.0, 3.0}, {0.0, 0.0, 2.0}, 0.0);
    program.A = program.A.replicate(3, 1).eval();
    program.b = program.b.replicate(3, 1).eval();
    EXPECT_NEAR(solve(program).value, 3.0, 1e-8);
}

void expectProofOfInfeasibility(const ConeProgram& program)
{
    const ConeSolution solution = solve(program);
    ASSERT_EQ(solution.status, ConeStatus::Infeasible);
    EXPECT_NEAR(program.b.dot(solution.y) + program.h.dot(solution.z), -1.0, 1e-9);
    EXPECT_GE(program.cones.depth(solution.z), -1e-12);
    EXPECT_LT((program.A.transpose() * solution.y + program.G.transpose() * solution.z).norm(),
              1e-7);
}

TEST(ConeProgram, ContradictingEquationsAreProven)
{
    ConeProgram program = distanceToPlane({1.0, 2.0, 3.0}, {0.0, 0.0, 2.0}, 0.0);
    program.A = program.A.replicate(2, 1).eval();
    program.b = Eigen::Vector2d(0.0, 1.0);
    expectProofOfInfeasibility(program);
}

/// A plane at distance 0.5 + gap from a ball of radius 0.5, within which x must be.
TEST(ConeProgram, BallBesideAPlaneIsProvenInfeasible)
{
    for (const double gap : {1.0, 1e-2, 1e-4})
    {
        ConeProgram program = distanceToPlane({0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, 0.5 + gap);
        program.c.setZero();
        program.G(0, 3) = 0.0;
        program.h[0] = 0.5;
        program.G.conservativeResize(6, 4);  // 0 <= t <= 1: every unknown needs a row
        program.G.bottomRows<2>() << 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0;
        Eigen::MatrixXd G(6, 4);
        G << program.G.bottomRows<2>(), program.G.topRows<4>();
        Eigen::VectorXd h(6);
        h << 1.0, 0.0, program.h;
        program.G = G;
        program.h = h;
        program.cones = {.nonnegative = 2, .sizes = {4}};
        expectProofOfInfeasibility(program);
    }
}

TEST(ConeProgram, EndlessDescentIsFound)
{
    ConeProgram program = distanceToPlane({1.0, 2.0, 3.0}, {0.0, 0.0, 1.0}, 0.0);
    program.c[3] = -1.0;
    const ConeSolution solution = solve(program);
    ASSERT_EQ(solution.status, ConeStatus::Unbounded);
    EXPECT_NEAR(program.c.dot(solution.x), -1.0, 1e-9);
    EXPECT_LT((program.A * solution.x).norm(), 1e-7);
    EXPECT_GT(program.cones.depth(-program.G * solution.x), -1e-7);
}
}  // namespace
}  // namespace bullet_ccd::grasp
