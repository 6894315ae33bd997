// Plans with options of approach, and closing at the end of paths.
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/closing/closing.h"
#include "grasp/planner/grasp_planner.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
using tests::makeGripper;

std::vector<Grasp> planTogether(const HandModel& hand,
                                const GraspObject& object,
                                const PlannerOptions& options)
{
    return planGrasps(hand, object, options, [] { return kinematicClosing(); });
}

TEST(PlannedApproaches, DoNotDependOnTheNumberOfThreads)
{
    const HandModel hand = makeGripper(true);
    const GraspObject object = makeGraspObject("box", makeBox({0.02, 0.03, 0.05}));
    for (const ApproachSource source : {ApproachSource::Surface, ApproachSource::Boxes})
    {
        PlannerOptions options{.candidates = 12,
                               .seed = 5,
                               .jobs = 1,
                               .approach = {.source = source, .tableTop = true, .standoff = 0.05},
                               .volumes = 0};
        const std::vector<Grasp> alone = planTogether(hand, object, options);
        options.jobs = 3;
        const std::vector<Grasp> together = planTogether(hand, object, options);
        ASSERT_EQ(alone.size(), 12U);
        ASSERT_EQ(together.size(), 12U);
        for (std::size_t k = 0; k < alone.size(); ++k)
        {
            EXPECT_EQ(alone[k].candidate, together[k].candidate);
            EXPECT_EQ(alone[k].reject, together[k].reject);
            EXPECT_EQ(alone[k].X_WH.matrix(), together[k].X_WH.matrix());
            EXPECT_EQ(alone[k].positions, together[k].positions);
            EXPECT_LE(alone[k].approach_W.z(), 1e-8);
        }
        EXPECT_EQ(alone.front().reject, RejectReason::None);
    }
}

TEST(PlannedApproaches, ThatMeetNothingWithinTheirReachAreRejected)
{
    const HandModel hand = makeGripper(true);
    const GraspObject object = makeGraspObject("box", makeBox({0.02, 0.03, 0.05}));
    PlannerOptions options{.candidates = 8, .volumes = 0};
    std::vector<double> travels;
    for (const Grasp& grasp : planTogether(hand, object, options))
    {
        ASSERT_NE(grasp.reject, RejectReason::NoApproachHit);
        travels.push_back(grasp.approachDistance);
    }
    std::sort(travels.begin(), travels.end());
    options.approach.reach = 0.5 * (travels[3] + travels[4]);
    const std::vector<Grasp> grasps = planTogether(hand, object, options);
    EXPECT_EQ(std::count_if(grasps.begin(),
                            grasps.end(),
                            [](const Grasp& g) { return g.reject == RejectReason::NoApproachHit; }),
              4);
}

TEST(PlannedApproaches, RefuseOptionsThatCannotBe)
{
    const HandModel hand = makeGripper(true);
    const GraspObject object = makeGraspObject("box", makeBox({0.02, 0.03, 0.05}));
    EXPECT_THROW(static_cast<void>(planTogether(hand, object, {.approach = {.reach = -1.0}})),
                 std::invalid_argument);
}

class CloseOnPath : public ::testing::Test
{
protected:
    [[nodiscard]] static Eigen::Isometry3d at(double x, double z)
    {
        return Eigen::Isometry3d(Eigen::Translation3d(x, 0.0, z));
    }
    [[nodiscard]] PathGrasp close(const std::vector<Eigen::Isometry3d>& path) const
    {
        return closeOnPath(
            m_hand, m_bar, path, m_hand.preshapes.front(), m_options, kinematicClosing());
    }

    HandModel m_hand = makeGripper(false);
    GraspObject m_bar = makeGraspObject("bar", makeBox({0.03, 0.02, 0.03}));
    PlannerOptions m_options{.volumes = 0};
};

TEST_F(CloseOnPath, HoldsWhatTheStraightApproachHolds)
{
    const Grasp straight = closeAtPose(m_hand,
                                       m_bar,
                                       at(0.0, -0.2),
                                       {0.0, 0.0, 0.3},
                                       m_hand.preshapes.front(),
                                       m_options,
                                       kinematicClosing());
    ASSERT_EQ(straight.reject, RejectReason::None);
    const PathGrasp pieces = close({at(0.0, -0.2), at(0.0, -0.1), at(0.0, 0.1)});
    EXPECT_EQ(pieces.way.leg, 1U);
    EXPECT_EQ(pieces.grasp.reject, RejectReason::None);
    const double tolerance = m_options.closing.tolerance;
    EXPECT_NEAR(pieces.grasp.approachDistance, straight.approachDistance, tolerance);
    EXPECT_NEAR((pieces.grasp.approach_W - straight.approach_W).norm(), 0.0, 1e-12);
    EXPECT_NEAR(
        (pieces.grasp.X_WH.translation() - straight.X_WH.translation()).norm(), 0.0, tolerance);
    ASSERT_EQ(pieces.grasp.positions.size(), straight.positions.size());
    for (std::size_t link = 1; link < straight.positions.size(); ++link)
    {
        // The jaws open 40 mm to each side of the middle; the bar fills 30 mm.
        EXPECT_NEAR(pieces.grasp.positions[link], 0.01, tolerance);
        EXPECT_NEAR(straight.positions[link], 0.01, tolerance);
    }
}

TEST_F(CloseOnPath, GoesAroundACorner)
{
    // Beside the bar, then below it, then up: 60 mm below the palm's face meets it at -25 mm.
    const PathGrasp result = close({at(0.3, -0.12), at(0.0, -0.12), at(0.0, -0.04)});
    EXPECT_EQ(result.way.status, ToiStatus::Separated);
    EXPECT_NEAR(result.way.length, 0.38, 1e-12);
    EXPECT_EQ(result.grasp.reject, RejectReason::None);
    EXPECT_EQ(result.grasp.X_WStart.matrix(), at(0.3, -0.12).matrix());
    EXPECT_EQ(result.grasp.X_WH.matrix(), at(0.0, -0.04).matrix());
    // What is kept of the way is the straight line.
    EXPECT_NEAR(result.grasp.approachDistance, std::hypot(0.3, 0.08), 1e-12);
    EXPECT_NEAR(result.grasp.approach_W.norm(), 1.0, 1e-12);
    EXPECT_NEAR(
        (result.grasp.X_WStart.translation() +
         result.grasp.approachDistance * result.grasp.approach_W - result.grasp.X_WH.translation())
            .norm(),
        0.0,
        1e-12);
}

TEST_F(CloseOnPath, APathOfOnePoseIsAPose)
{
    const PathGrasp result = close({at(0.0, -0.04)});
    const Grasp posed = closeAtPose(m_hand,
                                    m_bar,
                                    at(0.0, -0.04),
                                    Eigen::Vector3d::Zero(),
                                    m_hand.preshapes.front(),
                                    m_options,
                                    kinematicClosing());
    EXPECT_EQ(result.grasp.reject, RejectReason::None);
    EXPECT_EQ(result.grasp.positions, posed.positions);
    EXPECT_EQ(result.grasp.quality.epsilon, posed.quality.epsilon);
    EXPECT_EQ(result.grasp.approachDistance, 0.0);
}

TEST_F(CloseOnPath, DoesNotSetOutFromAnOverlap)
{
    const PathGrasp result = close({at(0.0, 0.0), at(0.0, -0.3)});
    EXPECT_EQ(result.grasp.reject, RejectReason::OverlapAtStart);
    EXPECT_EQ(result.way.status, ToiStatus::Overlapping);
    EXPECT_EQ(result.way.length, 0.0);
    EXPECT_TRUE(result.grasp.positions.empty());
    EXPECT_THROW(static_cast<void>(close({})), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::grasp
