#include "grasp/force/grasp_forces.h"

#include "tests/grasp/contact_sets.h"
#include "tests/grasp/force/pinch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
using ::testing::HasSubstr;
using tests::aroundCylinder;
using tests::contactOnUnitSphere;
using tests::pushByPrismaticJoints;
using tests::randomGrasp;
using tests::randomVector;

constexpr double kWeight = 9.81;
constexpr double kRelative = 1e-7;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Wrench kGravity = (Wrench() << 0.0, 0.0, -kWeight, 0.0, 0.0, 0.0).finished();

const ForceOptions kBothSolvers[] = {{.solver = ForceSolver::Cone},
                                     {.solver = ForceSolver::LinearProgram, .coneEdges = 8}};

ForceOptions with(ForceOptions options, ForceObjective objective)
{
    options.objective = objective;
    return options;
}

/// Residuals of an answer, against the load it balances.
void expectBalanced(const GraspForces& answer, double load)
{
    ASSERT_EQ(answer.status, ForceStatus::Balanced) << answer.reason;
    EXPECT_LT(answer.residuals.force, 1e-7 * load);
    EXPECT_LT(answer.residuals.moment, 1e-7 * load);
    EXPECT_LT(answer.residuals.cone, 1e-7 * load);
    EXPECT_LT(answer.residuals.torque, 1e-7 * load);
    EXPECT_LT(answer.residuals.normal, 1e-7 * load);
    EXPECT_NEAR(answer.value, answer.bound, 1e-6 * (load + std::abs(answer.value)));
}

// k fingers around an upright cylinder hold it with W / (k mu) each. The pyramids' edges are at
// multiples of 45 degrees from a horizontal tangent, so one points up.
TEST(GraspForces, FingersAroundACylinderShareItsWeight)
{
    for (const ForceOptions& options : kBothSolvers)
    {
        for (const int fingers : {2, 3, 4, 5, 8})
        {
            for (const double friction : {0.1, 0.5, 1.2})
            {
                ForceProblem problem = aroundCylinder(fingers, 0.04, {.friction = friction});
                problem.load = kGravity;
                const GraspForces total = solveGraspForces(problem, options);
                expectBalanced(total, kWeight);
                EXPECT_NEAR(total.value, kWeight / friction, kRelative * kWeight / friction);
                const GraspForces most =
                    solveGraspForces(problem, with(options, ForceObjective::Max));
                expectBalanced(most, kWeight);
                const double each = kWeight / (fingers * friction);
                EXPECT_NEAR(most.value, each, 1e-6 * each);
                for (const ContactForce& force : most.contacts)
                {
                    EXPECT_NEAR(force.normal, each, 1e-5 * each);
                    EXPECT_NEAR(force.force.z(), kWeight / fingers, 1e-5 * kWeight);
                }
            }
        }
    }
}

// Half-way between two edges a pyramid is thinner: mu cos(pi / m) instead of mu. Exact cones do not
// mind.
TEST(GraspForces, LoadBetweenTwoEdgesCostsThePyramidItsFactor)
{
    for (const int edges : {4, 8, 16})
    {
        ForceProblem problem = aroundCylinder(2, 0.04, {.friction = 0.5});
        const double angle = std::numbers::pi / edges;
        problem.load.head<3>() = kWeight * Eigen::Vector3d(0.0, std::cos(angle), std::sin(angle));
        const double exact = solveGraspForces(problem).value;
        EXPECT_NEAR(exact, kWeight / 0.5, kRelative * kWeight);
        const double pyramid =
            solveGraspForces(problem, {.solver = ForceSolver::LinearProgram, .coneEdges = edges})
                .value;
        EXPECT_NEAR(pyramid, exact / std::cos(angle), kRelative * kWeight);
    }
}

// A pinch with weight and a torque about the line of the fingers: each soft contact bears half of
// both, sqrt((W / 2)^2 + (T / 2e)^2) = mu f_n. Hard contacts bear no such torque.
TEST(GraspForces, SoftPinchBearsATorqueAboutItsLine)
{
    const ContactLaw soft{.model = ContactModel::SoftFinger, .friction = 0.5, .torsion = 0.01};
    for (const double torque : {0.0, 0.02, 0.3})
    {
        ForceProblem problem = aroundCylinder(2, 0.04, soft);
        problem.load = kGravity;
        problem.load[3] = torque;
        const GraspForces answer = solveGraspForces(problem);
        expectBalanced(answer, kWeight + torque / 0.01);
        const double each = std::hypot(kWeight / 2.0, torque / 0.02) / 0.5;
        EXPECT_NEAR(answer.value, 2.0 * each, kRelative * each);
        EXPECT_NEAR(std::abs(answer.contacts[0].torsion), torque / 2.0, 1e-6);
        problem.load.head<3>().setZero();
        if (torque > 0.0)
        {
            // A pole of the ellipsoid is a vertex of the pyramid.
            const double alone =
                solveGraspForces(problem, {.solver = ForceSolver::LinearProgram}).value;
            EXPECT_NEAR(alone, torque / (0.5 * 0.01), kRelative * alone);
            problem.law.model = ContactModel::HardFinger;
            EXPECT_EQ(solveGraspForces(problem).status, ForceStatus::Infeasible);
        }
    }
}

TEST(GraspForces, FrictionlessContactsPushBackAlongTheirNormals)
{
    ForceProblem problem;
    problem.law.model = ContactModel::Frictionless;
    for (int axis = 0; axis < 3; ++axis)
    {
        problem.contacts.push_back(contactOnUnitSphere(Eigen::Vector3d::Unit(axis)));
        problem.contacts.push_back(contactOnUnitSphere(-Eigen::Vector3d::Unit(axis)));
    }
    problem.load.head<3>() = Eigen::Vector3d(1.0, -2.0, 3.0);
    for (const ForceOptions& options : kBothSolvers)
    {
        const GraspForces answer = solveGraspForces(problem, options);
        expectBalanced(answer, 4.0);
        EXPECT_NEAR(answer.value, 6.0, 1e-7);
        EXPECT_NEAR(answer.contacts[0].normal, 1.0, 1e-6);
        EXPECT_NEAR(answer.contacts[3].normal, 2.0, 1e-6);
        EXPECT_NEAR(solveGraspForces(problem, with(options, ForceObjective::Max)).value, 3.0, 1e-7);
    }
    problem.load[4] = 0.1;  // forces through the centre give no moment
    EXPECT_EQ(solveGraspForces(problem).status, ForceStatus::Infeasible);
}

// Squeezing a pinch as hard as a limit F allows leaves mu F - W / 2 of friction.
TEST(GraspForces, FirmPinchUsesAllThatLimitsAllow)
{
    for (const ForceOptions& options : kBothSolvers)
    {
        const ForceOptions firm = with(options, ForceObjective::Firm);
        ForceProblem problem = aroundCylinder(2, 0.04, {.friction = 0.5});
        problem.load = kGravity;
        EXPECT_EQ(solveGraspForces(problem, firm).status, ForceStatus::Unbounded);

        problem.maxNormalForce = 40.0;
        GraspForces answer = solveGraspForces(problem, firm);
        expectBalanced(answer, kWeight);
        EXPECT_NEAR(answer.value, 0.5 * 40.0 - kWeight / 2.0, 1e-6);
        EXPECT_NEAR(answer.contacts[0].margin, answer.value, 1e-5);

        pushByPrismaticJoints(problem, 25.0);
        answer = solveGraspForces(problem, firm);
        expectBalanced(answer, kWeight);
        EXPECT_NEAR(answer.value, 0.5 * 25.0 - kWeight / 2.0, 1e-6);
        EXPECT_NEAR(answer.jointTorques[0], 25.0, 1e-5);

        problem.load.setZero();  // what is left to do without a load: squeeze
        answer = solveGraspForces(problem, firm);
        EXPECT_NEAR(answer.value, 0.5 * 25.0, 1e-6);
    }
}

// A finger of length L whose hinge turns with at most tau pushes with tau / L.
TEST(GraspForces, HingedFingersPushByTorqueOverLength)
{
    ForceProblem problem = aroundCylinder(2, 0.04, {.friction = 0.5});
    problem.load = kGravity;
    problem.jacobian.assign(4, Twist::Zero());
    constexpr double kLength = 0.1;
    for (std::size_t i = 0; i < 2; ++i)
    {
        problem.jacobian[2 * i + i].head<3>() = kLength * problem.contacts[i].normal;
    }
    problem.torqueLimits = {2.0, kInfinity};
    for (const ForceOptions& options : kBothSolvers)
    {
        const GraspForces least = solveGraspForces(problem, options);
        expectBalanced(least, kWeight);
        EXPECT_NEAR(least.jointTorques[0], kLength * kWeight / (2.0 * 0.5), 1e-6);
        EXPECT_NEAR(least.jointTorques[1], least.jointTorques[0], 1e-6);
        const GraspForces firm = solveGraspForces(problem, with(options, ForceObjective::Firm));
        EXPECT_NEAR(firm.value, 0.5 * 2.0 / kLength - kWeight / 2.0, 1e-6);
    }
}

// The pinch needs W / (2 mu) a finger; a limit just below is the reason, just above is none.
TEST(GraspForces, JointLimitsThatForbidAGraspAreNamed)
{
    const double needed = kWeight / (2.0 * 0.5);
    for (const ForceOptions& options : kBothSolvers)
    {
        for (const ForceObjective objective :
             {ForceObjective::Total, ForceObjective::Max, ForceObjective::Firm})
        {
            ForceProblem problem = aroundCylinder(2, 0.04, {.friction = 0.5});
            problem.load = kGravity;
            pushByPrismaticJoints(problem, 1.001 * needed);
            EXPECT_EQ(solveGraspForces(problem, with(options, objective)).status,
                      ForceStatus::Balanced);
            problem.torqueLimits[1] = 0.999 * needed;
            const GraspForces answer = solveGraspForces(problem, with(options, objective));
            ASSERT_EQ(answer.status, ForceStatus::Infeasible);
            EXPECT_THAT(answer.reason, HasSubstr("joint torque limits"));
            EXPECT_THAT(answer.reason, HasSubstr("push_1"));
            ASSERT_TRUE(answer.certificate.has_value());
            EXPECT_FALSE(answer.certificate->coneOnly());
            EXPECT_TRUE(answer.contacts.empty());
        }
    }
}

TEST(GraspForces, LargestNormalForceThatForbidsAGraspIsNamed)
{
    ForceProblem problem = aroundCylinder(3, 0.04, {.friction = 0.5});
    problem.load = kGravity;
    problem.maxNormalForce = 0.99 * kWeight / (3.0 * 0.5);
    for (const ForceOptions& options : kBothSolvers)
    {
        for (const ForceObjective objective :
             {ForceObjective::Total, ForceObjective::Max, ForceObjective::Firm})
        {
            const GraspForces answer = solveGraspForces(problem, with(options, objective));
            ASSERT_EQ(answer.status, ForceStatus::Infeasible);
            EXPECT_THAT(answer.reason, HasSubstr("largest normal force"));
        }
    }
}

// Limits are not blamed for what friction cannot do either.
TEST(GraspForces, FrictionIsBlamedWhereItAloneIsTheReason)
{
    std::vector<ForceProblem> problems;
    problems.push_back(aroundCylinder(1, 0.04, {}));
    problems.push_back(aroundCylinder(2, 0.04, {.friction = 0.0}));
    problems.push_back(aroundCylinder(2, 0.04, {}));
    problems.back().load[3] = 0.1;  // about the line through two hard contacts
    problems.push_back({.contacts = {4, contactOnUnitSphere({0, 0, 1})}});
    for (ForceProblem& problem : problems)
    {
        problem.load += kGravity;
        pushByPrismaticJoints(problem, 1e-3);
        for (const ForceOptions& options : kBothSolvers)
        {
            const GraspForces answer = solveGraspForces(problem, options);
            ASSERT_EQ(answer.status, ForceStatus::Infeasible);
            EXPECT_THAT(answer.reason, HasSubstr("friction cones alone"));
            ASSERT_TRUE(answer.certificate.has_value());
            EXPECT_TRUE(answer.certificate->coneOnly());
            EXPECT_GT(answer.certificate->provenUpTo, 1e4 * kWeight);
        }
    }
}

TEST(GraspForces, NoContactsBalanceNoLoadOnly)
{
    ForceProblem problem;
    EXPECT_EQ(solveGraspForces(problem).status, ForceStatus::Balanced);
    problem.load = kGravity;
    const GraspForces answer = solveGraspForces(problem);
    EXPECT_EQ(answer.status, ForceStatus::Infeasible);
    EXPECT_THAT(answer.reason, HasSubstr("no contacts"));
}

TEST(GraspForces, NoLoadNeedsNoForces)
{
    for (const ForceOptions& options : kBothSolvers)
    {
        const GraspForces answer = solveGraspForces(aroundCylinder(3, 0.04, {}), options);
        expectBalanced(answer, 1.0);
        EXPECT_NEAR(answer.value, 0.0, 1e-7);
    }
}

TEST(GraspForces, RepeatedContactsShareTheirForce)
{
    ForceProblem problem = aroundCylinder(3, 0.04, {});
    problem.load = kGravity;
    const double once = solveGraspForces(problem).value;
    problem.contacts.insert(
        problem.contacts.end(), problem.contacts.begin(), problem.contacts.begin() + 3);
    for (const ForceOptions& options : kBothSolvers)
    {
        const GraspForces twice = solveGraspForces(problem, options);
        expectBalanced(twice, kWeight);
        EXPECT_NEAR(twice.value, once, 1e-6);
        const GraspForces most = solveGraspForces(problem, with(options, ForceObjective::Max));
        EXPECT_NEAR(most.value, once / 6.0, 1e-6);
    }
}

/// A random grasp with a load and limits that bind in about half of the cases.
ForceProblem randomProblem(std::mt19937& random, int contacts)
{
    ForceProblem problem{.contacts = randomGrasp(random, contacts)};
    problem.load << randomVector(random), 0.3 * randomVector(random);
    problem.jacobian.resize(problem.contacts.size() * problem.contacts.size());
    for (Twist& twist : problem.jacobian)
    {
        for (double& entry : twist)
        {
            entry = 0.1 * randomVector(random).x();
        }
    }
    problem.torqueLimits.assign(problem.contacts.size(), 0.8);
    return problem;
}

// A rotation turns pyramids about their normals as well, so only exact cones are invariant.
TEST(GraspForces, FrameReferenceAndOrderDoNotMatter)
{
    std::mt19937 random(5);
    int balanced = 0;
    for (int trial = 0; trial < 40; ++trial)
    {
        const ForceProblem problem = randomProblem(random, 5);
        const GraspForces before = solveGraspForces(problem);
        const Eigen::Quaterniond turn(
            Eigen::AngleAxisd(1.0 + trial, randomVector(random).normalized()));
        const Eigen::Vector3d shift = randomVector(random);

        ForceProblem moved = problem;
        moved.reference = problem.reference + shift;
        moved.load.tail<3>() -= shift.cross(problem.load.head<3>());
        for (Twist& twist : moved.jacobian)
        {
            twist << turn * twist.head<3>(), turn * twist.tail<3>();
        }
        for (GraspContact& contact : moved.contacts)
        {
            contact.point = turn * contact.point;
            contact.normal = turn * contact.normal;
        }
        moved.reference = turn * moved.reference;
        moved.load << turn * moved.load.head<3>(), turn * moved.load.tail<3>();
        std::reverse(moved.contacts.begin(), moved.contacts.end());
        for (auto joint = moved.jacobian.begin(); joint != moved.jacobian.end(); joint += 5)
        {
            std::reverse(joint, joint + 5);
        }
        const GraspForces after = solveGraspForces(moved);
        ASSERT_EQ(before.status, after.status);
        if (before.status == ForceStatus::Balanced)
        {
            ++balanced;
            EXPECT_NEAR(after.value, before.value, 1e-6 * (1.0 + before.value));
        }
    }
    EXPECT_GT(balanced, 8);
    EXPECT_LT(balanced, 32);
}

TEST(GraspForces, ForcesScaleWithTheLoadAndNotWithTheSizeOfTheObject)
{
    std::mt19937 random(6);
    int balanced = 0;
    for (int trial = 0; trial < 20; ++trial)
    {
        ForceProblem problem = randomProblem(random, 6);
        const GraspForces before = solveGraspForces(problem);
        problem.load *= 1e4;
        for (double& limit : problem.torqueLimits)
        {
            limit *= 1e4 * 1e-3;
        }
        for (Twist& twist : problem.jacobian)
        {
            twist *= 1e-3;
        }
        problem.load.tail<3>() *= 1e-3;
        for (GraspContact& contact : problem.contacts)
        {
            contact.point *= 1e-3;
        }
        const GraspForces after = solveGraspForces(problem);
        ASSERT_EQ(before.status, after.status);
        if (before.status == ForceStatus::Balanced)
        {
            ++balanced;
            EXPECT_NEAR(after.value, 1e4 * before.value, 1e-2 * (1.0 + before.value));
        }
    }
    EXPECT_GT(balanced, 4);
}

// Inscribed pyramids: possible forces that are never better, and no worse than cones of
// mu cos(pi / m).
TEST(GraspForces, PyramidsAreBracketedByCones)
{
    std::mt19937 random(7);
    int balanced = 0;
    constexpr int kTrials = 60;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        ForceProblem problem = randomProblem(random, 3 + trial % 6);
        const ForceObjective objective =
            trial % 2 == 0 ? ForceObjective::Total : ForceObjective::Max;
        const GraspForces exact = solveGraspForces(problem, {.objective = objective});
        const GraspForces pyramid = solveGraspForces(
            problem,
            {.objective = objective, .solver = ForceSolver::LinearProgram, .coneEdges = 12});
        problem.law.friction *= std::cos(std::numbers::pi / 12);
        const GraspForces inner = solveGraspForces(problem, {.objective = objective});
        ASSERT_NE(exact.status, ForceStatus::Undecided);
        if (pyramid.status == ForceStatus::Balanced)
        {
            ++balanced;
            ASSERT_EQ(exact.status, ForceStatus::Balanced);
            EXPECT_LE(exact.value, pyramid.value * (1.0 + 1e-7));
            expectBalanced(pyramid, problem.load.norm());
            expectBalanced(exact, problem.load.norm());
        }
        if (inner.status == ForceStatus::Balanced)
        {
            ASSERT_EQ(pyramid.status, ForceStatus::Balanced);
            EXPECT_LE(pyramid.value, inner.value * (1.0 + 1e-7));
        }
    }
    EXPECT_GT(balanced, kTrials / 5);
    EXPECT_LT(balanced, 4 * kTrials / 5);
}

TEST(GraspForces, BadInputIsNamed)
{
    const auto messageOf = [](const ForceProblem& problem)
    {
        try
        {
            static_cast<void>(solveGraspForces(problem));
        }
        catch (const std::invalid_argument& error)
        {
            return std::string(error.what());
        }
        return std::string("no exception");
    };
    ForceProblem good = aroundCylinder(2, 0.04, {});
    pushByPrismaticJoints(good, 10.0);
    EXPECT_EQ(messageOf(good), "no exception");
    ForceProblem bad = good;
    bad.load[2] = std::nan("");
    EXPECT_THAT(messageOf(bad), HasSubstr("load"));
    bad = good;
    bad.contacts[1].point.x() = kInfinity;
    EXPECT_THAT(messageOf(bad), HasSubstr("contact 1"));
    bad = good;
    bad.contacts[0].normal.setZero();
    EXPECT_THAT(messageOf(bad), HasSubstr("contact 0"));
    bad = good;
    bad.torqueLimits[1] = 0.0;
    EXPECT_THAT(messageOf(bad), HasSubstr("joint 1"));
    bad = good;
    bad.jacobian.pop_back();
    EXPECT_THAT(messageOf(bad), HasSubstr("Jacobian"));
    bad = good;
    bad.jacobian[0][3] = std::nan("");
    EXPECT_THAT(messageOf(bad), HasSubstr("Jacobian"));
    bad = good;
    bad.maxNormalForce = std::nan("");
    EXPECT_THAT(messageOf(bad), HasSubstr("normal force"));
    bad = good;
    bad.law.friction = -1.0;
    EXPECT_THAT(messageOf(bad), HasSubstr("friction"));
    bad = good;
    bad.jointNames.pop_back();
    EXPECT_THAT(messageOf(bad), HasSubstr("joint names"));
}
}  // namespace
}  // namespace bullet_ccd::grasp
