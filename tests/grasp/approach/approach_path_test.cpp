// Hands that follow paths until their first contact.
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/approach/approach.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kTolerance = 2e-5;  // [m]
// Of the gripper: its palm's corner in x and y, the palm's face, and the tips of its jaws.
constexpr double kPalmX = 0.06;
constexpr double kPalmY = 0.015;
constexpr double kPalmZ = -0.005;
constexpr double kTips = 0.06;

class ApproachPath : public ::testing::Test
{
protected:
    [[nodiscard]] PathApproach follow(const std::vector<Eigen::Isometry3d>& path)
    {
        const std::array bodies{RigidBody{.tree = &m_box, .motion = restAt(m_X_WBox)}};
        const Environment environment(bodies);
        return approachUntilContact(m_hand, environment, path, open(), kTolerance, m_work);
    }
    [[nodiscard]] ArticulatedToiResult shift(const Eigen::Isometry3d& X_WH,
                                             const Eigen::Vector3d& by)
    {
        const std::array bodies{RigidBody{.tree = &m_box, .motion = restAt(m_X_WBox)}};
        const Environment environment(bodies);
        return approachUntilContact(m_hand, environment, X_WH, open(), by, kTolerance, m_work);
    }
    [[nodiscard]] const std::vector<double>& open() const
    {
        return m_hand.preshapes.front().positions;
    }
    [[nodiscard]] static Eigen::Isometry3d at(double x, double y, double z)
    {
        return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
    }

    HandModel m_hand = tests::makeGripper(true);
    SsvTree m_box = buildSsvTree(makeBox({0.02, 0.02, 0.05}));
    Eigen::Isometry3d m_X_WBox = Eigen::Isometry3d::Identity();
    ToiWorkspace m_work;
};

TEST_F(ApproachPath, LeadsAroundACornerToAContactAtAKnownTime)
{
    constexpr double kBottom = -0.05;  // of the box
    constexpr double kStart = kBottom - kTips - 0.03;
    const std::vector<Eigen::Isometry3d> path{
        at(0.2, 0.0, kStart), at(0.0, 0.0, kStart), at(0.0, 0.0, kStart + 0.2)};
    const PathApproach way = follow(path);
    EXPECT_EQ(way.status, ToiStatus::Hit);
    EXPECT_EQ(way.leg, 1U);
    // The jaws pass the box on both sides, and the palm meets its bottom.
    const double exact = kBottom - kPalmZ - kStart;
    EXPECT_LE(way.time * 0.2, exact);
    EXPECT_GE(way.time * 0.2, exact - kTolerance);
    EXPECT_NEAR(way.length, 0.2 + way.time * 0.2, 1e-12);
    EXPECT_NEAR(
        (way.X_WH.translation() - Eigen::Vector3d(0.0, 0.0, kStart + way.time * 0.2)).norm(),
        0.0,
        1e-12);
    ASSERT_FALSE(way.contacts.empty());
    EXPECT_EQ(way.contacts.front().link, 0);
    // The straight way there is barred by the side of the box.
    const ArticulatedToiResult straight =
        shift(path.front(), way.X_WH.translation() - path.front().translation());
    EXPECT_EQ(straight.status, ToiStatus::Hit);
    EXPECT_LT(straight.time, 0.99);
}

TEST_F(ApproachPath, TurnsIntoAWallAtTheAngleInClosedForm)
{
    constexpr double kWall = 0.04;
    m_box = buildSsvTree(makeBox({0.2, 0.05, 0.2}));
    m_X_WBox = at(0.0, kWall + 0.05, 0.0);
    const Eigen::Isometry3d turned(
        Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()));
    const PathApproach way = follow({at(0.0, -0.1, 0.0), at(0.0, 0.0, 0.0), turned});
    EXPECT_EQ(way.status, ToiStatus::Hit);
    EXPECT_EQ(way.leg, 1U);
    // Height of the palm's corner: radius sin(angle + first).
    const double radius = std::hypot(kPalmX, kPalmY);
    const double first = std::atan2(kPalmY, kPalmX);
    const double exact = std::asin(kWall / radius) - first;
    const double angle = way.time * 0.5 * std::numbers::pi;
    EXPECT_LE(angle, exact + 1e-12);
    EXPECT_LE(radius * (std::sin(exact + first) - std::sin(angle + first)), kTolerance);
    EXPECT_NEAR(way.length, 0.1, 1e-12);
    EXPECT_NEAR(
        (way.X_WH.linear() - Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).matrix()).norm(),
        0.0,
        1e-12);
}

TEST_F(ApproachPath, AStraightPathInPiecesEndsWhereTheStraightApproachDoes)
{
    const Eigen::Isometry3d start =
        at(0.003, 0.001, -0.3) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d by(0.0, 0.0, 0.5);
    const ArticulatedToiResult whole = shift(start, by);
    ASSERT_EQ(whole.status, ToiStatus::Hit);
    for (const double cut : {0.1, 0.3, 0.6, 0.9})
    {
        Eigen::Isometry3d between = start;
        between.translation() += cut * by;
        Eigen::Isometry3d end = start;
        end.translation() += by;
        const PathApproach way = follow({start, between, end});
        EXPECT_EQ(way.status, ToiStatus::Hit);
        EXPECT_EQ(way.leg, cut < whole.time ? 1U : 0U);
        EXPECT_NEAR(way.length, whole.time * by.norm(), kTolerance);
        EXPECT_NEAR((way.X_WH.translation() - start.translation() - whole.time * by).norm(),
                    0.0,
                    kTolerance);
        EXPECT_NEAR((way.X_WH.linear() - start.linear()).norm(), 0.0, 1e-12);
    }
}

TEST_F(ApproachPath, LegsThatEndWithinTheToleranceStillEndTheWayBeforeAnOverlap)
{
    // The palm's face is 1.5, 1, 0.6, ... tolerances from the box where the legs meet.
    for (const double gaps : {1.5, 1.0, 0.9, 0.6, 0.4, 0.1})
    {
        const double meeting = -0.05 - kPalmZ - gaps * kTolerance;
        const PathApproach way =
            follow({at(0.0, 0.0, -0.3), at(0.0, 0.0, meeting), at(0.0, 0.0, 0.0)});
        EXPECT_TRUE(isContact(way.status)) << gaps;
        EXPECT_LT(way.X_WH.translation().z() + kPalmZ, -0.05) << gaps;
        EXPECT_GE(way.X_WH.translation().z() + kPalmZ, -0.05 - kTolerance) << gaps;
    }
}

TEST_F(ApproachPath, EndsAtTheLastPoseIfNothingIsInTheWay)
{
    const std::vector<Eigen::Isometry3d> path{
        at(1.0, 0.0, 0.0), at(1.0, 1.0, 0.0), at(1.0, 1.0, 0.0), at(1.0, 1.0, -2.0)};
    const PathApproach way = follow(path);
    EXPECT_EQ(way.status, ToiStatus::Separated);
    EXPECT_EQ(way.leg, 2U);
    EXPECT_EQ(way.time, 1.0);
    EXPECT_EQ(way.X_WH.matrix(), path.back().matrix());
    EXPECT_NEAR(way.length, 3.0, 1e-12);
    const PathApproach alone = follow({path.front()});
    EXPECT_EQ(alone.status, ToiStatus::Separated);
    EXPECT_EQ(alone.X_WH.matrix(), path.front().matrix());
    EXPECT_EQ(alone.length, 0.0);
    EXPECT_THROW(static_cast<void>(follow({})), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::grasp
