#include "grasp/quality/wrench_space.h"

#include "tests/grasp/contact_sets.h"
#include "tests/grasp/quality/brute_hull.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace bullet_ccd::grasp
{
namespace
{
using Vector6 = Eigen::Matrix<double, 6, 1>;

using tests::contactOnUnitSphere;
using tests::randomGrasp;
using tests::randomVector;
using tests::tetrahedralGrasp;

GraspQuality qualityOf(const std::vector<GraspContact>& contacts,
                       const WrenchSpaceOptions& options = {},
                       const Eigen::Vector3d& reference = Eigen::Vector3d::Zero())
{
    const std::vector<Wrench> wrenches = contactWrenches(contacts, reference, options);
    const GraspQuality quality = wrenchSpaceQuality(wrenches, options.forceClosureThreshold);
    // Two ways to epsilon: of the whole hull, and of the facets that could be the nearest.
    EXPECT_NEAR(wrenchSpaceEpsilon(wrenches), quality.epsilon, 2e-9);
    return quality;
}

Eigen::MatrixXd matrixOf(const std::vector<Wrench>& wrenches)
{
    Eigen::MatrixXd points(6, static_cast<Eigen::Index>(wrenches.size()));
    for (std::size_t i = 0; i < wrenches.size(); ++i)
    {
        points.col(static_cast<Eigen::Index>(i)) = wrenches[i];
    }
    return points;
}

TEST(ContactWrenches, EdgesHaveUnitNormalForceAndLieOnTheCone)
{
    std::mt19937 random(1);
    const std::vector<GraspContact> contacts = randomGrasp(random, 5);
    const WrenchSpaceOptions options{.friction = 0.4, .coneEdges = 7, .torqueScale = 0.25};
    const Eigen::Vector3d reference(0.1, -0.2, 0.3);
    const std::vector<Wrench> wrenches = contactWrenches(contacts, reference, options);
    ASSERT_EQ(wrenches.size(), 35U);
    for (std::size_t i = 0; i < wrenches.size(); ++i)
    {
        const GraspContact& contact = contacts[i / 7];
        const Eigen::Vector3d force = wrenches[i].head<3>();
        EXPECT_NEAR(force.dot(contact.normal), 1.0, 1e-14);
        EXPECT_NEAR((force - contact.normal).norm(), 0.4, 1e-14);
        const Eigen::Vector3d moment = (contact.point - reference).cross(force) / 0.25;
        EXPECT_LT((wrenches[i].tail<3>() - moment).norm(), 1e-13);
        const double turn = (force - contact.normal)
                                .dot(wrenches[i / 7 * 7 + (i + 1) % 7].head<3>() - contact.normal);
        EXPECT_NEAR(turn / 0.16, std::cos(2.0 * std::numbers::pi / 7.0), 1e-13);
    }
}

TEST(ContactWrenches, OptionsThatMakeNoSenseAreRefused)
{
    const std::vector<GraspContact> contacts = tetrahedralGrasp();
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    EXPECT_THROW(static_cast<void>(contactWrenches(contacts, zero, {.coneEdges = 2})),
                 std::invalid_argument);
    EXPECT_THROW(static_cast<void>(contactWrenches(contacts, zero, {.torqueScale = 0.0})),
                 std::invalid_argument);
    EXPECT_THROW(static_cast<void>(contactWrenches(contacts, zero, {.friction = -0.1})),
                 std::invalid_argument);
}

// Q04: exact cones give mu / sqrt(2); the inscribed pyramid with m edges contains the cone of
// mu cos(pi / m).
TEST(WrenchSpace, TetrahedralGraspOfTheUnitSphereIsBoundedByItsClosedForm)
{
    for (const double friction : {0.2, 0.3, 0.5})
    {
        for (const int edges : {6, 8, 16, 32})
        {
            const GraspQuality quality =
                qualityOf(tetrahedralGrasp(), {.friction = friction, .coneEdges = edges});
            const double exact = friction / std::sqrt(2.0);
            EXPECT_LE(quality.epsilon, exact + 1e-12);
            EXPECT_GE(quality.epsilon, exact * std::cos(std::numbers::pi / edges) - 1e-12);
            EXPECT_TRUE(quality.forceClosure);
        }
    }
}

// Q05
TEST(WrenchSpace, AntipodalHardContactsAreNoForceClosure)
{
    std::mt19937 random(2);
    for (int trial = 0; trial < 20; ++trial)
    {
        const Eigen::Vector3d direction = randomVector(random);
        const GraspQuality quality =
            qualityOf({contactOnUnitSphere(direction), contactOnUnitSphere(-direction)});
        EXPECT_EQ(quality.epsilon, 0.0);
        EXPECT_EQ(quality.volume, 0.0);
        EXPECT_FALSE(quality.forceClosure);
    }
}

TEST(WrenchSpace, NoContactAndOneContactAreNoForceClosure)
{
    EXPECT_FALSE(wrenchSpaceQuality({}, 0.0).forceClosure);
    const GraspQuality one = qualityOf({contactOnUnitSphere({0, 0, 1})});
    EXPECT_EQ(one.epsilon, 0.0);
    EXPECT_EQ(one.volume, 0.0);
    EXPECT_FALSE(one.forceClosure);
    const std::vector<GraspContact> repeated(5, contactOnUnitSphere({0, 0, 1}));
    EXPECT_EQ(qualityOf(repeated).epsilon, 0.0);
}

TEST(WrenchSpace, DuplicatedContactsChangeNothing)
{
    std::vector<GraspContact> contacts = tetrahedralGrasp();
    const GraspQuality once = qualityOf(contacts);
    contacts.insert(contacts.end(), contacts.begin(), contacts.begin() + 4);
    const GraspQuality twice = qualityOf(contacts);
    EXPECT_NEAR(twice.epsilon, once.epsilon, 1e-12);
    EXPECT_NEAR(twice.volume, once.volume, 1e-10 * once.volume);
}

TEST(WrenchSpace, ThresholdDecidesForceClosure)
{
    const std::vector<Wrench> wrenches =
        contactWrenches(tetrahedralGrasp(), Eigen::Vector3d::Zero(), {});
    const double epsilon = wrenchSpaceQuality(wrenches, 0.0).epsilon;
    EXPECT_TRUE(wrenchSpaceQuality(wrenches, 0.99 * epsilon).forceClosure);
    EXPECT_FALSE(wrenchSpaceQuality(wrenches, 1.01 * epsilon).forceClosure);
}

TEST(WrenchSpace, RandomGraspsAgreeWithTheEnumerationOfAllFacets)
{
    std::mt19937 random(4);
    int closures = 0;
    constexpr int kTrials = 40;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const WrenchSpaceOptions options{.friction = 0.5, .coneEdges = 4};
        const std::vector<Wrench> wrenches =
            contactWrenches(randomGrasp(random, 4), Eigen::Vector3d::Zero(), options);
        const double expected = tests::bruteHull(matrixOf(wrenches)).radius;
        EXPECT_NEAR(wrenchSpaceQuality(wrenches, 0.0).epsilon, expected, 1e-9);
        closures += expected > 0.0 ? 1 : 0;
    }
    EXPECT_GT(closures, kTrials / 10);
    EXPECT_LT(closures, 9 * kTrials / 10);
}

/// max_i u.w_i: how far the hull reaches along u.
double support(const Eigen::MatrixXd& wrenches, const Vector6& u)
{
    return (u.transpose() * wrenches).maxCoeff();
}

/// Smallest support that a random descent from `u` finds.
double descend(const Eigen::MatrixXd& wrenches, Vector6 u, std::mt19937& random)
{
    std::normal_distribution<double> normal;
    double best = support(wrenches, u);
    for (double step = 0.5; step > 1e-7; step *= 0.995)
    {
        const Vector6 offset = Vector6::NullaryExpr([&] { return step * normal(random); });
        const Vector6 trial = (u + offset).normalized();
        const double value = support(wrenches, trial);
        if (value < best)
        {
            best = value;
            u = trial;
        }
    }
    return best;
}

// The epsilon of many contacts: a lower bound of the support in all directions that is attained.
TEST(WrenchSpace, EpsilonIsTheSmallestSupportOverAllDirections)
{
    std::mt19937 random(6);
    std::normal_distribution<double> normal;
    int positive = 0;
    for (int trial = 0; trial < 6; ++trial)
    {
        const std::vector<Wrench> wrenches =
            contactWrenches(randomGrasp(random, 7), Eigen::Vector3d::Zero(), {});
        const Eigen::MatrixXd matrix = matrixOf(wrenches);
        const double epsilon = wrenchSpaceQuality(wrenches, 0.0).epsilon;
        positive += epsilon > 0.0 ? 1 : 0;
        double smallest = 1e9;
        for (int start = 0; start < 20; ++start)
        {
            const Vector6 u = Vector6::NullaryExpr([&] { return normal(random); }).normalized();
            smallest = std::min(smallest, descend(matrix, u, random));
        }
        EXPECT_GE(smallest, epsilon > 0.0 ? epsilon - 1e-12 : -1e9);
        EXPECT_LE(smallest, epsilon + 0.02);
        for (int sample = 0; epsilon > 0.0 && sample < 20000; ++sample)
        {
            const Vector6 u = Vector6::NullaryExpr([&] { return normal(random); }).normalized();
            ASSERT_GE(support(matrix, u), epsilon - 1e-12);
        }
    }
    EXPECT_GE(positive, 3);
}

// Q07: with a torque scale that grows with the object.
TEST(WrenchSpace, ScalingObjectAndTorqueScaleTogetherChangesNothing)
{
    std::mt19937 random(8);
    std::vector<GraspContact> contacts = randomGrasp(random, 8);
    const GraspQuality before = qualityOf(contacts);
    ASSERT_GT(before.epsilon, 0.0);
    for (GraspContact& contact : contacts)
    {
        contact.point *= 0.037;
    }
    const GraspQuality after = qualityOf(contacts, {.torqueScale = 0.037});
    EXPECT_NEAR(after.epsilon, before.epsilon, 1e-10);
    EXPECT_NEAR(after.volume, before.volume, 1e-8 * before.volume);
}

// Moments along a stretched axis: force and moment parts scale apart.
TEST(WrenchSpace, VolumeScalesWithTheCubeOfTheTorqueScale)
{
    std::mt19937 random(9);
    const std::vector<GraspContact> contacts = randomGrasp(random, 8);
    const double one = qualityOf(contacts, {.torqueScale = 1.0}).volume;
    const double half = qualityOf(contacts, {.torqueScale = 0.5}).volume;
    EXPECT_GT(one, 0.0);
    EXPECT_NEAR(half, 8.0 * one, 1e-8 * one);
}

// A rotation also turns the pyramids about their normals: bounded by the cones they approximate.
TEST(WrenchSpace, RotationChangesEpsilonByNoMoreThanThePyramidsDo)
{
    std::mt19937 random(10);
    int closures = 0;
    for (int trial = 0; trial < 10; ++trial)
    {
        const std::vector<GraspContact> contacts = randomGrasp(random, 7);
        std::vector<GraspContact> turned = contacts;
        const Eigen::Quaterniond rotation =
            Eigen::Quaterniond(Eigen::AngleAxisd(1.0 + trial, randomVector(random).normalized()));
        for (GraspContact& contact : turned)
        {
            contact.point = rotation * contact.point;
            contact.normal = rotation * contact.normal;
        }
        constexpr int kEdges = 16;
        // Every pyramid of friction mu / cos(pi / m) contains the cone of mu, hence all its
        // pyramids.
        const double wider = 0.5 / std::cos(std::numbers::pi / kEdges);
        const double epsilon = qualityOf(contacts, {.coneEdges = kEdges}).epsilon;
        EXPECT_LE(epsilon,
                  qualityOf(turned, {.friction = wider, .coneEdges = kEdges}).epsilon + 1e-9);
        closures += epsilon > 0.0 ? 1 : 0;
    }
    EXPECT_GE(closures, 3);
}

TEST(WrenchSpace, OrderOfContactsDoesNotMatter)
{
    std::mt19937 random(12);
    std::vector<GraspContact> contacts = randomGrasp(random, 7);
    const GraspQuality before = qualityOf(contacts);
    std::shuffle(contacts.begin(), contacts.end(), random);
    const GraspQuality after = qualityOf(contacts);
    EXPECT_GT(before.epsilon, 0.0);
    EXPECT_NEAR(after.epsilon, before.epsilon, 1e-10);
    EXPECT_NEAR(after.volume, before.volume, 1e-8 * before.volume);
}

TEST(WrenchSpace, ForceClosureDoesNotDependOnTheMomentOrigin)
{
    std::mt19937 random(14);
    int closures = 0;
    constexpr int kTrials = 30;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const std::vector<GraspContact> contacts = randomGrasp(random, 5);
        const GraspQuality here = qualityOf(contacts);
        const GraspQuality there = qualityOf(contacts, {}, 2.0 * randomVector(random));
        EXPECT_EQ(here.epsilon > 1e-9, there.epsilon > 1e-9);
        EXPECT_NEAR(here.volume, there.volume, 1e-7 * here.volume);
        closures += here.epsilon > 1e-9 ? 1 : 0;
    }
    EXPECT_GT(closures, kTrials / 10);
    EXPECT_LT(closures, 9 * kTrials / 10);
}

// Q08
TEST(WrenchSpace, AnotherContactNeverLowersTheQuality)
{
    std::mt19937 random(16);
    int grew = 0;
    for (int trial = 0; trial < 20; ++trial)
    {
        std::vector<GraspContact> contacts = randomGrasp(random, 5);
        const GraspQuality before = qualityOf(contacts);
        contacts.push_back(randomGrasp(random, 1).front());
        const GraspQuality after = qualityOf(contacts);
        EXPECT_GE(after.epsilon, before.epsilon - 1e-10);
        EXPECT_GE(after.volume, before.volume * (1.0 - 1e-8));
        grew += after.epsilon > before.epsilon + 1e-6 ? 1 : 0;
    }
    EXPECT_GT(grew, 3);
}

// As after a closing: contacts in tight clusters whose normals agree up to rounding, so that many
// wrenches nearly coincide.
TEST(WrenchSpace, ClustersOfNearlyEqualContactsKeepTheValueOfTheirCenters)
{
    std::mt19937 random(18);
    for (const double noise : {1e-15, 1e-12, 1e-9, 1e-6})
    {
        std::vector<GraspContact> contacts;
        for (const GraspContact& center : tetrahedralGrasp())
        {
            for (int copy = 0; copy < 3; ++copy)
            {
                GraspContact contact = center;
                contact.point += noise * randomVector(random);
                contacts.push_back(contact);
            }
        }
        const double expected = qualityOf(tetrahedralGrasp()).epsilon;
        EXPECT_NEAR(qualityOf(contacts).epsilon, expected, 10.0 * noise + 1e-10) << noise;
    }
}

TEST(WrenchSpace, HundredContactsGiveAnAnswer)
{
    std::mt19937 random(20);
    const GraspQuality quality = qualityOf(randomGrasp(random, 100), {.coneEdges = 4});
    EXPECT_TRUE(quality.forceClosure);
    EXPECT_GT(quality.epsilon, 0.2);
    EXPECT_LT(quality.epsilon, std::sqrt(1.25) * 2.0);
}
}  // namespace
}  // namespace bullet_ccd::grasp
