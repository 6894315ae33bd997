#include "grasp/quality/exact_epsilon.h"

#include "grasp/quality/force_closure.h"
#include "grasp/quality/wrench_space.h"
#include "tests/grasp/contact_sets.h"
#include "tests/grasp/quality/brute_hull.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
using tests::contactOnUnitSphere;
using tests::randomGrasp;
using tests::randomVector;
using tests::tetrahedralGrasp;

const Eigen::Vector3d kOrigin = Eigen::Vector3d::Zero();
const ContactLaw kFrictionless{.model = ContactModel::Frictionless};

ContactLaw hard(double friction)
{
    return {.friction = friction};
}

ContactLaw soft(double torsion)
{
    return {.model = ContactModel::SoftFinger, .friction = 0.5, .torsion = torsion};
}

/// Epsilon of the part of the wrench space in the given coordinates (0 to 2 forces, 3 to 5
/// moments).
EpsilonBounds epsilonIn(const std::vector<int>& coordinates,
                        const std::vector<GraspContact>& contacts,
                        const ContactLaw& law,
                        WrenchNorm norm)
{
    const auto dimension = static_cast<Eigen::Index>(coordinates.size());
    std::vector<ContactBasis> bases;
    for (const GraspContact& contact : contacts)
    {
        bases.push_back(contactBasis(contact, law, kOrigin, 1.0));
    }
    const auto support = [&](const Eigen::VectorXd& u) -> Eigen::VectorXd
    {
        Wrench direction = Wrench::Zero();
        direction(coordinates) = u;
        return wrenchSupport(bases, law, norm, direction)(coordinates);
    };
    Eigen::MatrixXd start(dimension, 2 * dimension + 1);
    for (Eigen::Index k = 0; k < dimension; ++k)
    {
        start.col(2 * k) = support(Eigen::VectorXd::Unit(dimension, k));
        start.col(2 * k + 1) = support(-Eigen::VectorXd::Unit(dimension, k));
    }
    start.col(2 * dimension) = support(Eigen::VectorXd::Ones(dimension).normalized());
    return largestBallAboutOrigin(support, start, 1e-6, 20000);
}

void expectValue(const EpsilonBounds& bounds, double exact, double resolution)
{
    EXPECT_LE(bounds.lower, exact + 1e-9);
    EXPECT_GE(bounds.upper, exact - 1e-9);
    EXPECT_LE(bounds.upper - bounds.lower, resolution);
}

TEST(LargestBallAboutOrigin, IsThatOfTheHullOfRandomPoints)
{
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    int inside = 0;
    constexpr int kTrials = 60;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const Eigen::Index d = 2 + trial % 4;
        const Eigen::MatrixXd points =
            Eigen::MatrixXd::NullaryExpr(d, 4 * d, [&] { return normal(random); });
        const double expected = tests::bruteHull(points).radius;
        const EpsilonBounds bounds = largestBallAboutOrigin(
            [&](const Eigen::VectorXd& u) -> Eigen::VectorXd
            {
                Eigen::Index best = 0;
                (u.transpose() * points).maxCoeff(&best);
                return points.col(best);
            },
            points,
            1e-12,
            1000);
        EXPECT_NEAR(bounds.lower, expected, 1e-9);
        EXPECT_NEAR(bounds.upper, expected, 1e-9);
        inside += bounds.forceClosure() ? 1 : 0;
    }
    EXPECT_GT(inside, kTrials / 4);
    EXPECT_LT(inside, kTrials);
}

TEST(ExactEpsilon, SixFrictionlessContactsInForceSpace)
{
    std::vector<GraspContact> contacts;
    for (int axis = 0; axis < 3; ++axis)
    {
        contacts.push_back(contactOnUnitSphere(Eigen::Vector3d::Unit(axis)));
        contacts.push_back(contactOnUnitSphere(-Eigen::Vector3d::Unit(axis)));
    }
    expectValue(
        epsilonIn({0, 1, 2}, contacts, kFrictionless, WrenchNorm::L1), 1.0 / std::sqrt(3.0), 1e-6);
    expectValue(epsilonIn({0, 1, 2}, contacts, kFrictionless, WrenchNorm::LInfinity), 1.0, 1e-6);
}

TEST(ExactEpsilon, AntipodalContactsInForceSpaceHaveTheFrictionOrOne)
{
    const std::vector<GraspContact> contacts = {contactOnUnitSphere({1, 0, 0}),
                                                contactOnUnitSphere({-1, 0, 0})};
    for (const double friction : {0.2, 0.5, 0.9, 1.5})
    {
        expectValue(epsilonIn({0, 1, 2}, contacts, hard(friction), WrenchNorm::L1),
                    std::min(1.0, friction),
                    1e-6);
    }
}

TEST(ExactEpsilon, ThreeContactsOnADiscHaveTheFrictionUpToNineTenths)
{
    std::vector<GraspContact> contacts;
    for (int k = 0; k < 3; ++k)
    {
        const double angle = 2.0 * std::numbers::pi * k / 3.0;
        contacts.push_back(contactOnUnitSphere({std::cos(angle), std::sin(angle), 0.0}));
    }
    for (const double friction : {0.3, 0.5, 0.7, 0.9})
    {
        expectValue(epsilonIn({0, 1, 5}, contacts, hard(friction), WrenchNorm::L1), friction, 1e-6);
    }
    EXPECT_NEAR(epsilonIn({0, 1, 5}, contacts, hard(0.95), WrenchNorm::L1).lower, 0.9226, 5e-5);
    EXPECT_NEAR(epsilonIn({0, 1, 5}, contacts, hard(1.0), WrenchNorm::L1).lower, 0.9351, 5e-5);
}

TEST(ExactEpsilon, TetrahedralGraspHasFrictionOverRootTwo)
{
    for (const double friction : {0.1, 0.3, 0.5})
    {
        const EpsilonBounds bounds =
            exactEpsilon(tetrahedralGrasp(), kOrigin, {.law = hard(friction)});
        expectValue(bounds, friction / std::sqrt(2.0), 1e-6);
        EXPECT_TRUE(bounds.forceClosure());
    }
}

TEST(ExactEpsilon, AntipodalHardContactsHaveNone)
{
    const std::vector<GraspContact> contacts = {contactOnUnitSphere({1, 2, 3}),
                                                contactOnUnitSphere({-1, -2, -3})};
    for (const WrenchNorm norm : {WrenchNorm::L1, WrenchNorm::LInfinity})
    {
        const EpsilonBounds bounds = exactEpsilon(contacts, kOrigin, {.norm = norm});
        EXPECT_EQ(bounds.upper, 0.0);
        EXPECT_FALSE(bounds.forceClosure());
    }
}

// The values of 26-edged pyramids; cones do at least as well.
TEST(ExactEpsilon, AntipodalSoftContactsResistAllWrenches)
{
    constexpr double kTolerance = 1e-3;  // a whole circle of directions is nearest: points add up
    const std::vector<GraspContact> contacts = {contactOnUnitSphere({1, 0, 0}),
                                                contactOnUnitSphere({-1, 0, 0})};
    for (const auto& [torsion, expected] :
         {std::pair(0.1, 0.0499), std::pair(0.5, 0.2439), std::pair(2.0, 0.3105)})
    {
        const WrenchSpaceOptions options{.model = ContactModel::SoftFinger, .torsion = torsion};
        const GraspQuality pyramids =
            wrenchSpaceQuality(contactWrenches(contacts, kOrigin, options), 0.0);
        EXPECT_NEAR(pyramids.epsilon, expected, 5e-5);
        const EpsilonBounds cones =
            exactEpsilon(contacts, kOrigin, {.law = soft(torsion), .resolution = kTolerance});
        EXPECT_GE(cones.upper, pyramids.epsilon - 1e-9);
        EXPECT_LE(cones.upper - cones.lower, kTolerance);
    }
}

TEST(ExactEpsilon, PyramidsAreBracketedByCones)
{
    constexpr int kEdges = 8;
    std::mt19937 random(2);
    int closures = 0;
    constexpr int kTrials = 24;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const std::vector<GraspContact> contacts = randomGrasp(random, 3 + trial % 6);
        const double pyramids =
            wrenchSpaceQuality(contactWrenches(contacts, kOrigin, {.coneEdges = kEdges}), 0.0)
                .epsilon;
        const EpsilonBounds outer = exactEpsilon(contacts, kOrigin, {.resolution = 1e-5});
        const EpsilonBounds inner = exactEpsilon(
            contacts,
            kOrigin,
            {.law = hard(0.5 * std::cos(std::numbers::pi / kEdges)), .resolution = 1e-5});
        EXPECT_LE(pyramids, outer.upper + 1e-9);
        EXPECT_GE(pyramids, inner.lower - 1e-9);
        EXPECT_LE(outer.upper - outer.lower, 1e-5);
        closures += pyramids > 0.0 ? 1 : 0;
    }
    EXPECT_GT(closures, kTrials / 5);
    EXPECT_LT(closures, kTrials);
}

// Samples of the sphere: no direction reaches less far than the ball, for either norm.
TEST(ExactEpsilon, NoDirectionReachesLessThanTheBall)
{
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (const WrenchNorm norm : {WrenchNorm::L1, WrenchNorm::LInfinity})
    {
        const std::vector<GraspContact> contacts = randomGrasp(random, 8);
        const EpsilonBounds bounds =
            exactEpsilon(contacts, kOrigin, {.law = soft(0.2), .norm = norm});
        ASSERT_TRUE(bounds.forceClosure());
        double smallest = std::numeric_limits<double>::infinity();
        for (int sample = 0; sample < 20000; ++sample)
        {
            const Wrench u = Wrench::NullaryExpr([&] { return normal(random); }).normalized();
            double reach = norm == WrenchNorm::L1 ? -1e9 : 0.0;
            for (const GraspContact& contact : contacts)
            {
                const Eigen::Vector3d g = u.head<3>() + u.tail<3>().cross(contact.point);
                const double along = g.dot(contact.normal);
                const double twist = 0.2 * u.tail<3>().dot(contact.normal);
                const double one =
                    along + 0.5 * std::hypot((g - along * contact.normal).norm(), twist);
                reach = norm == WrenchNorm::L1 ? std::max(reach, one) : reach + std::max(0.0, one);
            }
            smallest = std::min(smallest, reach);
            ASSERT_GE(reach, bounds.lower - 1e-9);
        }
        EXPECT_LT(smallest, 3.0 * bounds.upper);
    }
}

TEST(ExactEpsilon, FrameOrderAndRepetitionDoNotMatter)
{
    std::mt19937 random(4);
    for (int trial = 0; trial < 4; ++trial)
    {
        std::vector<GraspContact> contacts = randomGrasp(random, 6);
        const EpsilonBounds before = exactEpsilon(contacts, kOrigin, {.resolution = 1e-5});
        const Eigen::Matrix3d turn =
            Eigen::AngleAxisd(1.0 + trial, randomVector(random).normalized()).toRotationMatrix();
        for (GraspContact& contact : contacts)
        {
            contact.point = turn * contact.point;
            contact.normal = turn * contact.normal;
        }
        std::reverse(contacts.begin(), contacts.end());
        contacts.insert(contacts.end(), contacts.begin(), contacts.begin() + 3);
        const EpsilonBounds after = exactEpsilon(contacts, kOrigin, {.resolution = 1e-5});
        EXPECT_LE(after.lower, before.upper + 1e-9);
        EXPECT_GE(after.upper, before.lower - 1e-9);
    }
}

TEST(ExactEpsilon, FewAndCoplanarContactsHaveNone)
{
    EXPECT_EQ(exactEpsilon({}, kOrigin, {}).upper, 0.0);
    EXPECT_EQ(exactEpsilon(std::vector{contactOnUnitSphere({0, 0, 1})}, kOrigin, {}).upper, 0.0);
    const std::vector<GraspContact> repeated(5, contactOnUnitSphere({0, 0, 1}));
    EXPECT_EQ(exactEpsilon(repeated, kOrigin, {}).upper, 0.0);
    std::vector<GraspContact> table;  // four feet: nothing pulls down
    for (const auto& [x, y] : {std::pair(1, 1), {1, -1}, {-1, 1}, {-1, -1}})
    {
        table.push_back({.point = Eigen::Vector3d(x, y, 0), .normal = {0, 0, 1}});
    }
    EXPECT_EQ(exactEpsilon(table, kOrigin, {}).upper, 0.0);
}

TEST(ExactEpsilon, BadInputIsRefused)
{
    std::vector<GraspContact> contacts = tetrahedralGrasp();
    EXPECT_THROW(static_cast<void>(exactEpsilon(contacts, kOrigin, {.torqueScale = 0.0})),
                 std::invalid_argument);
    EXPECT_THROW(static_cast<void>(exactEpsilon(contacts, kOrigin, {.law = hard(-1.0)})),
                 std::invalid_argument);
    EXPECT_THROW(
        static_cast<void>(exactEpsilon(contacts, Eigen::Vector3d::Constant(std::nan("")), {})),
        std::invalid_argument);
    contacts[0].point.x() = std::nan("");
    EXPECT_THROW(static_cast<void>(exactEpsilon(contacts, kOrigin, {})), std::invalid_argument);
}

TEST(ForceClosure, LinearProgramAgreesWithTheHullAboutAnyReference)
{
    std::mt19937 random(5);
    int closures = 0;
    constexpr int kTrials = 60;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const std::vector<GraspContact> contacts = randomGrasp(random, 3 + trial % 5);
        const std::vector<Wrench> here = contactWrenches(contacts, kOrigin, {.coneEdges = 6});
        const std::vector<Wrench> there =
            contactWrenches(contacts, 2.0 * randomVector(random), {.coneEdges = 6});
        const double epsilon = wrenchSpaceQuality(here, 0.0).epsilon;
        EXPECT_EQ(isForceClosure(here), epsilon > 1e-9) << epsilon;
        EXPECT_EQ(isForceClosure(there), epsilon > 1e-9) << epsilon;
        closures += epsilon > 1e-9 ? 1 : 0;
    }
    EXPECT_GT(closures, kTrials / 10);
    EXPECT_LT(closures, 9 * kTrials / 10);
}

TEST(ForceClosure, FlatAndOneSidedWrenchesHaveNone)
{
    EXPECT_FALSE(isForceClosure({}));
    const std::vector<GraspContact> pinch = {contactOnUnitSphere({1, 2, 3}),
                                             contactOnUnitSphere({-1, -2, -3})};
    EXPECT_FALSE(isForceClosure(contactWrenches(pinch, kOrigin, {})));
    EXPECT_TRUE(
        isForceClosure(contactWrenches(pinch, kOrigin, {.model = ContactModel::SoftFinger})));
    const std::vector<GraspContact> repeated(5, contactOnUnitSphere({0, 0, 1}));
    EXPECT_FALSE(isForceClosure(contactWrenches(repeated, kOrigin, {})));
}
}  // namespace
}  // namespace bullet_ccd::grasp
