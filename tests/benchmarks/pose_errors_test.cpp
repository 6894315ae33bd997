// What repeated grasps rest on: errors of poses, and the methods.
#include "benchmarks/grasp/pose_errors.h"

#include "benchmarks/closing/discrete_closing.h"
#include "tests/grasp/planner/test_hands.h"

#include <cmath>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using grasp::Grasp;
using grasp::RejectReason;
using nlohmann::json;

TEST(PoseError, IsAShiftAndATurnOfExactlyThatSize)
{
    const Vector3d center(0.1, -0.2, 0.3);
    for (const double magnitude : {1e-6, 1e-4, 1e-2})
    {
        std::set<int> octants;
        for (std::uint64_t seed = 0; seed < 200; ++seed)
        {
            const Isometry3d error = poseError(seed, magnitude, center);
            const Vector3d shift = error * center - center;
            EXPECT_NEAR(shift.norm(), magnitude, 1e-15);
            // Of a small turn the sine is known better than the cosine.
            const Eigen::Matrix3d skew = 0.5 * (error.linear() - error.linear().transpose());
            const double sine = Vector3d(skew(2, 1), skew(0, 2), skew(1, 0)).norm();
            EXPECT_NEAR(sine, std::sin(magnitude), 1e-15);
            octants.insert((shift.x() > 0 ? 1 : 0) + (shift.y() > 0 ? 2 : 0) +
                           (shift.z() > 0 ? 4 : 0));
            const Vector3d smaller = poseError(seed, 1e-3 * magnitude, center) * center - center;
            EXPECT_LT((shift - 1e3 * smaller).norm(), 1e-12) << "another direction";
        }
        EXPECT_EQ(octants.size(), 8u) << "directions are not all over the sphere";
    }
}

/// Two jaws with an opening of 80 mm around a bar of 60 mm.
class GraspMethods : public ::testing::Test
{
protected:
    [[nodiscard]] double changeBy(const GraspMethod& method, const Isometry3d& error) const
    {
        const Grasp before = method.run(m_start, m_shift);
        const Grasp after = method.run(error * m_start, error.linear() * m_shift);
        EXPECT_EQ(after.contacts.empty(), false) << method.name;
        return postureDifference(m_hand, before.positions, after.positions);
    }

    grasp::HandModel m_hand = tests::makeGripper(false);
    grasp::GraspObject m_bar = grasp::makeGraspObject("bar", makeBox({0.03, 0.02, 0.03}));
    std::vector<GraspMethod> m_methods = graspMethods(m_hand, m_bar, m_hand.preshapes.front());
    Isometry3d m_start{Eigen::Translation3d(0.0, 0.0, -0.2)};
    Vector3d m_shift{0.0, 0.0, 0.16};
};

TEST_F(GraspMethods, AgreeOnAnEasyClosing)
{
    const Grasp first = m_methods.front().run(m_start, m_shift);
    ASSERT_EQ(first.reject, RejectReason::None);
    for (const GraspMethod& method : m_methods)
    {
        const Grasp other = method.run(m_start, m_shift);
        EXPECT_EQ(other.reject, RejectReason::None) << method.name;
        // Contact is within 0.1 mm for all; a sliding joint counts ten times its way.
        EXPECT_LT(postureDifference(m_hand, first.positions, other.positions), 10.0 * 1e-4)
            << method.name;
        EXPECT_NEAR(first.quality.epsilon, other.quality.epsilon, 0.02) << method.name;
    }
}

TEST_F(GraspMethods, GiveTheSameWithoutAnErrorAndFollowOne)
{
    for (const GraspMethod& method : m_methods)
    {
        EXPECT_EQ(changeBy(method, Isometry3d::Identity()), 0.0) << method.name;
        const double change = changeBy(method, poseError(5, 1e-3, m_bar.centerOfMass));
        EXPECT_GT(change, 1e-4) << method.name;
        // A jaw goes by the shift and by the turn over half of the bar at most, and by the gap in
        // which it may stop.
        EXPECT_LT(change, 10.0 * (1e-3 * (1.0 + 0.05) + 1e-4)) << method.name;
    }
}

TEST(PoseErrors, SumUpWhatWasRepeated)
{
    json repeats = json::array();
    for (const double size : {1e-6, 1e-5, 1e-4, 1e-3})
    {
        for (int draw = 0; draw < 4; ++draw)
        {
            repeats.push_back({{"method", "ours"},
                               {"error", size},
                               {"same links", draw > 0},
                               {"kept", draw > 1},
                               {"change", draw * size}});
        }
    }
    testing::internal::CaptureStdout();
    EXPECT_TRUE(summarizePoseErrors({{{"repeats", repeats}}}));
    const std::string said = testing::internal::GetCapturedStdout();
    // Of 0 to 3 times the error the median is 2, the largest 3; where links are the same 2.
    EXPECT_THAT(said, testing::ContainsRegex("1e-03 +4 +2.0e-03 +3.0e-03 +2.0 +75 +50"));
    EXPECT_FALSE(summarizePoseErrors({{{"repeats", json::array()}}}));
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
