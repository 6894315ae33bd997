#include "grasp/sim/contact_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

namespace bullet_ccd::grasp
{
namespace
{
/// A block of 2 kg on a floor, which would move at `velocity` (normal first) without contact.
Eigen::VectorXd impulseOnBlock(const Eigen::Vector3d& velocity, double friction)
{
    ContactProgram program;
    program.J = Eigen::Matrix3d::Identity();
    program.W = program.J / 2.0;
    program.compliance = Eigen::Vector3d::Zero();
    program.b = -velocity;
    program.friction = {friction};
    Eigen::VectorXd x = Eigen::VectorXd::Zero(3);
    EXPECT_EQ(solveContacts(program, x, {.accuracy = 1e-10, .maxIterations = 1000}).unfinished, 0);
    return x;
}

TEST(ContactProgram, BlockOnAFloorObeysCoulomb)
{
    // Leaves: no impulse.
    EXPECT_LT(impulseOnBlock({0.1, 0.3, 0.0}, 0.5).norm(), 1e-8);
    // Sticks: all of the motion is stopped, as 0.4 is less than 0.5 * 1.
    EXPECT_LT((impulseOnBlock({-1.0, 0.0, 0.4}, 0.5) - Eigen::Vector3d(2.0, 0.0, -0.8)).norm(),
              1e-8);
    // Slides: the normal stops the approach, no more, and friction is mu times it.
    EXPECT_LT((impulseOnBlock({-1.0, 3.0, 4.0}, 0.5) - Eigen::Vector3d(2.0, -0.6, -0.8)).norm(),
              1e-8);
    EXPECT_LT((impulseOnBlock({-1.0, 3.0, 4.0}, 0.0) - Eigen::Vector3d(2.0, 0.0, 0.0)).norm(),
              1e-8);
}

/// What Coulomb's law and the bounds ask of every row, with velocities v = A x - b.
void expectLaws(const ContactProgram& program, const Eigen::VectorXd& x, int& sliding)
{
    constexpr double kTolerance = 1e-6;
    const Eigen::VectorXd v =
        program.J * (program.W.transpose() * x) + program.compliance.cwiseProduct(x) - program.b;
    for (Eigen::Index i = 0; i < program.lower.size(); ++i)
    {
        EXPECT_GE(x[i], program.lower[i]);
        EXPECT_LE(x[i], program.upper[i]);
        const bool mayPush = x[i] < program.upper[i] - kTolerance;
        const bool mayPull = x[i] > program.lower[i] + kTolerance;
        EXPECT_FALSE(mayPush && v[i] < -kTolerance);
        EXPECT_FALSE(mayPull && v[i] > kTolerance);
    }
    for (std::size_t k = 0; k < program.friction.size(); ++k)
    {
        const Eigen::Index i = program.lower.size() + 3 * static_cast<Eigen::Index>(k);
        const double mu = program.friction[k];
        const Eigen::Vector2d slip = v.segment<2>(i + 1);
        EXPECT_LE(x.segment<2>(i + 1).norm(), mu * x[i] + 1e-12);
        EXPECT_GE(v[i], -kTolerance);
        EXPECT_LT(std::min(x[i], v[i]), kTolerance);
        if (x[i] > 1e-3 && slip.norm() > 1e-3)
        {
            ++sliding;
            EXPECT_LT((x.segment<2>(i + 1) + mu * x[i] * slip.normalized()).norm(), 1e-3);
        }
    }
}

TEST(ContactProgram, RandomProgramsObeyTheirLaws)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    int sliding = 0;
    constexpr int kPrograms = 200;
    for (int trial = 0; trial < kPrograms; ++trial)
    {
        const Eigen::Index bounded = trial % 4;
        const Eigen::Index contacts = 1 + trial % 5;
        const Eigen::Index n = bounded + 3 * contacts;
        const auto noise = [&] { return uniform(random); };
        ContactProgram program;
        program.J = program.W = Eigen::MatrixXd::NullaryExpr(n, n + 2, noise);
        program.compliance = Eigen::VectorXd::Zero(n);
        program.b = Eigen::VectorXd::NullaryExpr(n, noise);
        program.lower = Eigen::VectorXd::Constant(bounded, -0.1);
        program.upper = Eigen::VectorXd::Constant(bounded, 0.2);
        program.friction.assign(static_cast<std::size_t>(contacts), 0.1 * (1 + trial % 8));
        Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
        const ContactProgramOptions options{.accuracy = 1e-8, .maxIterations = 5000};
        EXPECT_EQ(solveContacts(program, x, options).unfinished, 0) << trial;
        expectLaws(program, x, sliding);
    }
    EXPECT_GE(sliding, kPrograms / 4);
}

/// A hand on an arm: drives and couplings without limits that move each other much more than what
/// the contacts do to them.
ContactProgram programOfAChain(std::uint32_t seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto noise = [&] { return uniform(random); };
    constexpr Eigen::Index kBounded = 9;
    constexpr Eigen::Index kContacts = 4;
    constexpr Eigen::Index kRows = kBounded + 3 * kContacts;
    Eigen::MatrixXd J = Eigen::MatrixXd::NullaryExpr(kRows, kRows + 4, noise);
    for (Eigen::Index i = 1; i < kBounded; ++i)
    {
        J.row(i) = 4.0 * J.row(0) + 0.3 * J.row(i);
    }
    ContactProgram program;
    program.J = program.W = J;
    program.compliance = Eigen::VectorXd::Zero(kRows);
    program.b = Eigen::VectorXd::NullaryExpr(kRows, noise);
    program.lower = Eigen::VectorXd::Constant(kBounded, -1e30);
    program.upper = Eigen::VectorXd::Constant(kBounded, 1e30);
    program.lower[kBounded - 1] = -2.0;  // a drive that may be at its limit
    program.upper[kBounded - 1] = 2.0;
    program.friction.assign(kContacts, 0.5);
    return program;
}

TEST(ContactProgram, ChainsThatCarryContactsAreSolvedExactly)
{
    int sliding = 0;
    int limited = 0;
    for (std::uint32_t seed = 1; seed <= 50; ++seed)
    {
        const ContactProgram program = programOfAChain(seed);
        Eigen::VectorXd x = Eigen::VectorXd::Zero(program.b.size());
        const ContactProgramOptions options{.accuracy = 1e-8, .maxIterations = 200};
        EXPECT_EQ(solveContacts(program, x, options).unfinished, 0) << seed;
        expectLaws(program, x, sliding);
        limited += std::abs(x[8]) == 2.0 ? 1 : 0;
    }
    EXPECT_GT(sliding, 0);
    EXPECT_GT(limited, 5);
    EXPECT_LT(limited, 45);
}

TEST(ContactProgram, WhatDoesNotMoveEachOtherIsSolvedAlone)
{
    // A pair of blocks, one on the other, at its solution, and a block that comes to no end.
    ContactProgram program;
    program.J = Eigen::MatrixXd::Identity(9, 9);
    program.J.block<3, 3>(3, 0) = -Eigen::Matrix3d::Identity();
    program.W = program.J;
    program.compliance = Eigen::VectorXd::Zero(9);
    Eigen::VectorXd x(9);
    x << 2.0, 0.1, 0.0, 1.0, 0.1, 0.1, 100.0, -40.0, 40.0;
    const Eigen::VectorXd pair = x.head<6>();
    program.b = program.J * (program.W.transpose() * x);
    program.b.tail<3>() << 1.0, 4.0, 0.0;
    program.friction = {0.5, 0.5, 0.5};
    EXPECT_EQ(solveContacts(program, x, {.accuracy = 1e-12, .maxIterations = 2}).unfinished, 1);
    EXPECT_LT((x.head<6>() - pair).norm(), 1e-10);
}

TEST(ContactProgram, WhatNothingMovesStaysAsItIs)
{
    // A block on a floor that has velocities of its own, as Bullet gives static bodies, and a floor
    // that carries two blocks does not make them one.
    ContactProgram program;
    program.J = Eigen::MatrixXd::Zero(6, 9);
    program.J.block<3, 3>(0, 0).setIdentity();
    program.J.block<3, 3>(3, 3).setIdentity();
    program.J.rightCols<3>().topRows<3>() = -Eigen::Matrix3d::Identity();
    program.J.rightCols<3>().bottomRows<3>() = -Eigen::Matrix3d::Identity();
    program.W = program.J / 2.0;
    program.W.rightCols<3>().setZero();
    program.compliance = Eigen::VectorXd::Zero(6);
    program.b.resize(6);
    program.b << 1.0, 0.0, -0.4, 1.0, 4.0, 0.0;
    program.friction = {0.5, 0.5};
    Eigen::VectorXd x(6);
    x << 2.0, 0.0, -0.8, 100.0, -40.0, 40.0;
    EXPECT_EQ(solveContacts(program, x, {.accuracy = 1e-12, .maxIterations = 2}).unfinished, 1);
    EXPECT_LT((x.head<3>() - Eigen::Vector3d(2.0, 0.0, -0.8)).norm(), 1e-10);
    EXPECT_EQ(solveContacts(program, x, {.accuracy = 1e-12, .maxIterations = 200}).unfinished, 0);
    EXPECT_LT((x.tail<3>() - Eigen::Vector3d(2.0, 1.0, 0.0)).norm(), 1e-10);
}

TEST(ContactProgram, GivesUpWithinTheCone)
{
    ContactProgram program;
    program.J = program.W = Eigen::Matrix3d::Identity();
    program.compliance = Eigen::Vector3d::Zero();
    program.b = Eigen::Vector3d(1.0, 4.0, 0.0);
    program.friction = {0.5};
    Eigen::VectorXd x = Eigen::Vector3d(100.0, -40.0, 40.0);
    EXPECT_EQ(solveContacts(program, x, {.accuracy = 1e-12, .maxIterations = 2}).unfinished, 1);
    EXPECT_LE(x.tail<2>().norm(), 0.5 * x[0] + 1e-12);
}
}  // namespace
}  // namespace bullet_ccd::grasp
