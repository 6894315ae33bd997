#include "grasp/force/force_certificate.h"

#include "tests/grasp/contact_sets.h"
#include "tests/grasp/force/pinch.h"

#include <gtest/gtest.h>

#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
ForceProblem weightOnAPinch(double limit)
{
    ForceProblem problem = tests::aroundCylinder(2, 1.0, {.friction = 0.5});
    problem.load << 0.0, 0.0, -1.0, 0.0, 0.0, 0.0;
    tests::pushByPrismaticJoints(problem, limit);
    return problem;
}

// Upwards, with both joints yielding at mu: u . (-load) = 1 > 2 * 0.5 * limit for any limit
// below 1.
TEST(ForceCertificate, AcceptsAProofMadeByHand)
{
    const ForceMultipliers byHand{.equilibrium = Wrench::Unit(2),
                                  .torques = Eigen::Vector2d::Constant(0.5),
                                  .normals = Eigen::Vector2d::Zero()};
    for (const double limit : {0.5, 0.999, 1.001, 2.0})
    {
        const ForceProblem problem = weightOnAPinch(limit);
        ScaledProblem scaledProblem = scaled(problem);
        ForceMultipliers multipliers = byHand;
        // Rows of the scaled problem are torques over their size.
        multipliers.torques =
            byHand.torques.cwiseProduct(scaledProblem.torqueScales) / scaledProblem.force;
        const auto certificate = verified(problem, scaledProblem, multipliers, 0);
        ASSERT_EQ(certificate.has_value(), limit < 1.0) << limit;
        if (certificate)
        {
            EXPECT_FALSE(certificate->coneOnly());
            EXPECT_NEAR(certificate->jointRates[0], 0.5, 1e-12);
        }
    }
}

TEST(ForceCertificate, RefusesWhatProvesNothing)
{
    const ForceProblem problem = weightOnAPinch(0.5);
    const ScaledProblem scaledProblem = scaled(problem);
    const Eigen::Vector2d zero = Eigen::Vector2d::Zero();
    for (const Wrench& direction : {Wrench(Wrench::Unit(2)),
                                    Wrench(-Wrench::Unit(2)),
                                    Wrench(Wrench::Unit(0)),
                                    Wrench(Wrench::Zero()),
                                    Wrench(Wrench::Constant(std::nan("")))})
    {
        EXPECT_FALSE(verified(problem,
                              scaledProblem,
                              {.equilibrium = direction, .torques = zero, .normals = zero},
                              0)
                         .has_value());
    }
}

/// Certificates of random problems against random forces: none that the cones and limits allow does
/// as much along the certificate's direction as balance needs.
TEST(ForceCertificate, NoSampledForcesReachWhatBalanceNeeds)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    int proofs = 0;
    int withLimits = 0;
    for (int trial = 0; trial < 60; ++trial)
    {
        ForceProblem problem{.contacts = tests::randomGrasp(random, 4)};
        problem.load << tests::randomVector(random), tests::randomVector(random);
        problem.maxNormalForce = 1.0;
        const GraspForces answer = solveGraspForces(problem);
        if (answer.status != ForceStatus::Infeasible)
        {
            continue;
        }
        ++proofs;
        withLimits += answer.certificate->coneOnly() ? 0 : 1;
        Wrench u = answer.certificate->direction;
        u.tail<3>() /= answer.certificate->length;
        const double needed = u.dot(-problem.load);
        for (int sample = 0; sample < 500; ++sample)
        {
            double done = 0.0;
            for (const GraspContact& contact : problem.contacts)
            {
                const Eigen::Vector3d side =
                    contact.normal.cross(tests::randomVector(random)).normalized();
                const Eigen::Vector3d force =
                    uniform(random) * (contact.normal + 0.5 * uniform(random) * side);
                done += u.head<3>().dot(force) + u.tail<3>().dot(contact.point.cross(force));
            }
            ASSERT_LT(done, needed);
        }
    }
    EXPECT_GT(proofs, 20);
    EXPECT_GT(withLimits, 5);
    EXPECT_GT(proofs - withLimits, 5);
}
}  // namespace
}  // namespace bullet_ccd::grasp
