#include "grasp/force/elastic_hold.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kElasticWeight = 3.0;
constexpr double kElasticMu = 0.5;
constexpr double kCompliance = 5e-5;

/// Two jaws with a motor each that slide along x; four contacts a side, evenly about the centre.
struct Jaws
{
    ForceProblem problem;
    std::vector<double> stiffness{1000.0, 1000.0};

    explicit Jaws(double effort)
    {
        problem.law = {.model = ContactModel::HardFinger, .friction = kElasticMu};
        problem.torqueLimits = {effort, effort};
        problem.reference = Eigen::Vector3d(0.1, 0.2, 0.3);
        for (const double side : {-1.0, 1.0})
        {
            for (const double y : {-0.01, 0.01})
            {
                for (const double z : {-0.01, 0.01})
                {
                    problem.contacts.push_back(
                        {.link = side < 0.0 ? 1 : 2,
                         .point = problem.reference + Eigen::Vector3d(0.02 * side, y, z),
                         .normal = {-side, 0.0, 0.0},
                         .gap = 0.0});
                }
            }
        }
        for (const int jaw : {0, 1})
        {
            for (int contact = 0; contact < 8; ++contact)
            {
                Twist twist = Twist::Zero();
                twist[0] = contact / 4 == jaw ? 1.0 - 2.0 * jaw : 0.0;
                problem.jacobian.push_back(twist);
            }
        }
    }

    [[nodiscard]] ElasticHold hold(double asked) const
    {
        return holdElastically(problem, stiffness, kCompliance, kElasticWeight, asked);
    }
};

double sum(const std::vector<double>& numbers)
{
    return std::accumulate(numbers.begin(), numbers.end(), 0.0);
}

// Of a weight across the jaws, each of the 8 contacts takes an eighth by friction; of one along
// them, an eighth more or less of normal force. So a contact that is loaded by f_n holds
// mu f_n / ((mu + 1) / 8) weights in any direction.
TEST(ElasticHold, OfTwoJawsIsThatOfTheWorstDirection)
{
    for (const double asked : {0.5, 2.0, 10.0})
    {
        const ElasticHold hold = Jaws(1e4).hold(asked);
        EXPECT_NEAR(hold.weights, asked, 1e-5 * asked);
        const double needed = asked * kElasticWeight * (1.0 + kElasticMu) / kElasticMu;
        EXPECT_NEAR(sum(hold.normals), needed, 1e-4 * needed);
        for (const double torque : hold.torques)
        {
            EXPECT_NEAR(torque, 0.5 * needed, 1e-4 * needed);
        }
    }
}

// A motor gives the preload, and half of a weight along the jaws.
TEST(ElasticHold, IsLimitedByTheEfforts)
{
    for (const double effort : {1.0, 5.0, 20.0})
    {
        const ElasticHold hold = Jaws(effort).hold(100.0);
        const double expected =
            effort / (kElasticWeight * ((1.0 + kElasticMu) / (2.0 * kElasticMu) + 0.5));
        EXPECT_NEAR(hold.weights, expected, 1e-4 * expected);
    }
}

TEST(ElasticHold, IsNoneWhereTheContactsDoNotPressAgainstEachOther)
{
    Jaws oneSided(100.0);
    for (std::size_t contact = 4; contact < 8; ++contact)
    {
        oneSided.problem.contacts[contact].normal = Eigen::Vector3d::UnitX();
    }
    EXPECT_NEAR(oneSided.hold(2.0).weights, 0.0, 1e-5);
    // One point: it turns the object.
    Jaws point(100.0);
    point.problem.contacts.resize(1);
    point.problem.jacobian.resize(2);
    EXPECT_EQ(point.hold(2.0).weights, 0.0);
    Jaws none(100.0);
    none.problem.contacts.clear();
    none.problem.jacobian.clear();
    EXPECT_EQ(none.hold(2.0).weights, 0.0);
}

// The weights that it promises really leave each contact within its cone and each motor within its
// limit: loads in many directions, by the springs themselves.
TEST(ElasticHold, KeepsEveryContactInItsConeInEveryDirection)
{
    Jaws jaws(8.0);
    // Uneven, so that no symmetry helps.
    jaws.problem.contacts[3].point += Eigen::Vector3d(0.0, 0.004, 0.003);
    jaws.problem.contacts[6].point += Eigen::Vector3d(0.0, -0.006, 0.001);
    jaws.problem.contacts[6].normal = Eigen::Vector3d(-1.0, 0.1, 0.05).normalized();
    jaws.stiffness = {700.0, 2500.0};
    const ElasticHold hold = jaws.hold(100.0);
    ASSERT_GT(hold.weights, 0.1);
    EXPECT_LE(std::abs(hold.torques[0]), 8.0 * (1.0 + 1e-6));
    EXPECT_LE(std::abs(hold.torques[1]), 8.0 * (1.0 + 1e-6));
    // More is asked: as much is held.
    EXPECT_NEAR(jaws.hold(50.0).weights, hold.weights, 1e-4 * hold.weights);
    // Stronger motors hold more, smaller friction less.
    Jaws strong = jaws;
    strong.problem.torqueLimits = {16.0, 16.0};
    EXPECT_NEAR(strong.hold(100.0).weights, 2.0 * hold.weights, 1e-3 * hold.weights);
    Jaws slippery = jaws;
    slippery.problem.law.friction = 0.3;
    EXPECT_LT(slippery.hold(100.0).weights, hold.weights);
}

TEST(ElasticHold, RefusesNumbersThatAreNotPositive)
{
    const Jaws jaws(8.0);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double bad : {0.0, -1.0, nan})
    {
        EXPECT_THROW((void)holdElastically(jaws.problem, jaws.stiffness, bad, kElasticWeight, 2.0),
                     std::invalid_argument);
        EXPECT_THROW((void)holdElastically(jaws.problem, jaws.stiffness, kCompliance, bad, 2.0),
                     std::invalid_argument);
        EXPECT_THROW(
            (void)holdElastically(jaws.problem, jaws.stiffness, kCompliance, kElasticWeight, bad),
            std::invalid_argument);
    }
    EXPECT_THROW((void)holdElastically(
                     jaws.problem, std::vector<double>{1.0}, kCompliance, kElasticWeight, 2.0),
                 std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::grasp
