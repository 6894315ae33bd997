#include "grasp/force/robust_forces.h"

#include "tests/grasp/contact_sets.h"
#include "tests/grasp/force/pinch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>

namespace bullet_ccd::grasp
{
namespace
{
/// A grasp that resists all wrenches, with a weight on it.
ForceProblem firmGrasp(std::mt19937& random)
{
    ForceProblem problem{.contacts = tests::tetrahedralGrasp()};
    for (const GraspContact& contact : tests::randomGrasp(random, 3))
    {
        problem.contacts.push_back(contact);
    }
    problem.load << 0.0, 0.0, -1.0, 0.0, 0.0, 0.0;
    return problem;
}

Wrench randomDisturbance(std::mt19937& random, const Disturbance& disturbance)
{
    std::normal_distribution<double> normal;
    Wrench w = Wrench::NullaryExpr([&] { return normal(random); }).normalized();
    w *= disturbance.size;
    w.tail<3>() *= disturbance.torqueScale;
    return w;
}

// Every disturbance of the size can be answered for the guaranteed value, and corners ask for the
// necessary one.
TEST(RobustForces, EveryDisturbanceOfTheSizeIsAnswered)
{
    std::mt19937 random(1);
    for (const ForceObjective objective :
         {ForceObjective::Total, ForceObjective::Max, ForceObjective::Firm})
    {
        ForceProblem problem = firmGrasp(random);
        problem.maxNormalForce = 30.0;
        const Disturbance disturbance{.size = 0.7, .torqueScale = 0.5};
        const RobustForces robust =
            solveForAnyWrench(problem, disturbance, {.objective = objective});
        ASSERT_EQ(robust.status, ForceStatus::Balanced) << robust.reason;
        double worst = objective == ForceObjective::Firm ? 1e9 : 0.0;
        for (int sample = 0; sample < 300; ++sample)
        {
            ForceProblem disturbed = problem;
            disturbed.load += randomDisturbance(random, disturbance);
            const GraspForces answer = solveGraspForces(disturbed, {.objective = objective});
            ASSERT_EQ(answer.status, ForceStatus::Balanced);
            worst = objective == ForceObjective::Firm ? std::min(worst, answer.value)
                                                      : std::max(worst, answer.value);
        }
        if (objective == ForceObjective::Firm)
        {
            EXPECT_GE(worst, robust.guaranteed - 1e-6);
            EXPECT_LE(robust.guaranteed, robust.necessary + 1e-6);
        }
        else
        {
            EXPECT_LE(worst, robust.guaranteed + 1e-6);
            EXPECT_GE(robust.guaranteed, robust.necessary - 1e-6);
        }
        ForceProblem corner = problem;
        corner.load += robust.worstDisturbance;
        EXPECT_NEAR(
            solveGraspForces(corner, {.objective = objective}).value, robust.guaranteed, 1e-6);
        EXPECT_EQ(robust.largestNormals.size(), problem.contacts.size());
    }
}

TEST(RobustForces, WhatSomeDisturbanceForbidsIsInfeasible)
{
    // Hard fingers bear no moment about the line between them.
    ForceProblem pinch = tests::aroundCylinder(2, 0.04, {});
    pinch.load << 0.0, 0.0, -1.0, 0.0, 0.0, 0.0;
    const RobustForces robust = solveForAnyWrench(pinch, {.size = 0.1, .torqueScale = 0.04});
    EXPECT_EQ(robust.status, ForceStatus::Infeasible);
    EXPECT_THAT(robust.reason, ::testing::HasSubstr("friction cones alone"));
    EXPECT_GT(robust.worstDisturbance.norm(), 0.0);
}

// As the size grows the answer goes from balanced over "not shown" to infeasible, never back.
TEST(RobustForces, LargerDisturbancesAreNeverEasier)
{
    std::mt19937 random(2);
    ForceProblem problem = firmGrasp(random);
    problem.maxNormalForce = 5.0;
    int last = 0;
    int statuses = 0;
    for (double size = 0.1; size < 20.0; size *= 1.35)
    {
        const ForceStatus status = solveForAnyWrench(problem, {.size = size}).status;
        const int hardness = status == ForceStatus::Balanced    ? 0
                             : status == ForceStatus::Undecided ? 1
                                                                : 2;
        EXPECT_GE(hardness, last) << size;
        statuses += hardness != last ? 1 : 0;
        last = std::max(last, hardness);
    }
    EXPECT_EQ(last, 2);
    EXPECT_GE(statuses, 1);
}

TEST(RobustForces, SizesThatMakeNoSenseAreRefused)
{
    const ForceProblem problem = tests::aroundCylinder(3, 0.04, {});
    for (const double bad : {0.0, -1.0, std::nan("")})
    {
        EXPECT_THROW(static_cast<void>(solveForAnyWrench(problem, {.size = bad})),
                     std::invalid_argument);
        EXPECT_THROW(
            static_cast<void>(solveForAnyWrench(problem, {.size = 1.0, .torqueScale = bad})),
            std::invalid_argument);
    }
}
}  // namespace
}  // namespace bullet_ccd::grasp
