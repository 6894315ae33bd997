#include "grasp/force/elastic_hold.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

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

double normals(const ElasticHold& hold)
{
    double sum = 0.0;
    for (std::size_t i = 0; i < hold.forces.size(); ++i)
    {
        sum += hold.forces[i].x() * (i < 4 ? 1.0 : -1.0);
    }
    return sum;
}

/// What the contacts answer to a force at the centre, by the springs themselves: unknown are the
/// motion of the object and of the joints, and every contact is a spring between a point of the
/// object and one of its jaw.
struct Answer
{
    std::vector<Eigen::Vector3d> forces;
    Eigen::Vector2d torques;
};

Answer answerOf(const Jaws& jaws, const Eigen::Vector3d& load)
{
    using Jacobian = Eigen::Matrix<double, 3, 8>;
    constexpr double kStiff = 1.0 / kCompliance;
    std::vector<Jacobian> stretches;  // of a contact, by the motion of the object and the joints
    Eigen::Matrix<double, 8, 8> system = Eigen::Matrix<double, 8, 8>::Zero();
    for (std::size_t i = 0; i < jaws.problem.contacts.size(); ++i)
    {
        const Eigen::Vector3d arm = jaws.problem.contacts[i].point - jaws.problem.reference;
        Jacobian stretch = Jacobian::Zero();
        stretch.leftCols<3>().setIdentity();
        stretch.middleCols<3>(3) << 0.0, arm.z(), -arm.y(), -arm.z(), 0.0, arm.x(), arm.y(),
            -arm.x(), 0.0;
        for (std::size_t j = 0; j < 2; ++j)
        {
            stretch.col(static_cast<Eigen::Index>(6 + j)) =
                -jaws.problem.jacobian[8 * j + i].head<3>();
        }
        stretches.push_back(stretch);
        system += kStiff * stretch.transpose() * stretch;
    }
    system(6, 6) += jaws.stiffness[0];
    system(7, 7) += jaws.stiffness[1];
    Eigen::Matrix<double, 8, 1> right = Eigen::Matrix<double, 8, 1>::Zero();
    right.head<3>() = load;
    const Eigen::Matrix<double, 8, 1> motion = system.ldlt().solve(right);
    Answer answer{.forces = {},
                  .torques = {-jaws.stiffness[0] * motion[6], -jaws.stiffness[1] * motion[7]}};
    for (const Jacobian& stretch : stretches)
    {
        answer.forces.emplace_back(-kStiff * (stretch * motion));
    }
    return answer;
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
        EXPECT_NEAR(normals(hold), needed, 1e-4 * needed);
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

// The unit of the weight does not matter: tons are held as grams are.
TEST(ElasticHold, ScalesWithTheWeight)
{
    for (const double scale : {1e-3, 1e3, 1e6})
    {
        const Jaws jaws(1e4 * scale);
        const ElasticHold hold =
            holdElastically(jaws.problem, jaws.stiffness, kCompliance, scale * kElasticWeight, 2.0);
        EXPECT_NEAR(hold.weights, 2.0, 1e-5);
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
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    double nearest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 2000; ++k)
    {
        const Eigen::Vector3d direction(normal(random), normal(random), normal(random));
        const Answer answer =
            answerOf(jaws, hold.weights * kElasticWeight * direction.normalized());
        Eigen::Vector3d all = hold.weights * kElasticWeight * direction.normalized();
        for (std::size_t i = 0; i < 8; ++i)
        {
            all += answer.forces[i];
            const Eigen::Vector3d force = hold.forces[i] + answer.forces[i];
            const Eigen::Vector3d& n = jaws.problem.contacts[i].normal;
            const double margin = kElasticMu * force.dot(n) - (force - force.dot(n) * n).norm();
            EXPECT_GE(margin, -1e-6);
            nearest = std::min(nearest, margin);
        }
        EXPECT_LT(all.norm(), 1e-6);
        for (std::size_t j = 0; j < 2; ++j)
        {
            EXPECT_LE(std::abs(hold.torques[j] + answer.torques[static_cast<Eigen::Index>(j)]),
                      8.0 * (1.0 + 1e-6));
        }
    }
    EXPECT_LT(nearest, 0.1 * kElasticWeight);  // it is not far from slipping either
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
