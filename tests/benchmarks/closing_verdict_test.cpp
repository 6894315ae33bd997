#include "benchmarks/grasp/closing_verdict.h"

#include "benchmarks/closing/discrete_closing.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/closing/closing.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

#include <optional>

namespace bullet_ccd::benchmarks
{
namespace
{
using grasp::ClosingResult;

/// Two jaws, 10 mm thick, that slide at 0.1 m/s towards each other from x = +-45 mm.
class ClosingVerdictTest : public ::testing::Test
{
protected:
    [[nodiscard]] static grasp::GraspObject plateAt(const Eigen::Vector3d& half,
                                                    const Eigen::Vector3d& center)
    {
        TriangleMesh mesh = makeBox(half);
        transformMesh(mesh, Eigen::Affine3d(Eigen::Translation3d(center)));
        return grasp::makeGraspObject("plate", std::move(mesh));
    }
    [[nodiscard]] PosedClosing startWith(const grasp::GraspObject& object)
    {
        m_check.emplace(m_hand, object);
        return {.hand = m_hand,
                .object = object,
                .check = *m_check,
                .X_WH = Eigen::Isometry3d::Identity(),
                .open = m_hand.preshapes.front().positions};
    }
    [[nodiscard]] ClosingResult ours(const PosedClosing& start, double tolerance) const
    {
        return grasp::kinematicClosing()(
            m_hand, start.object, start.X_WH, start.open, {.tolerance = tolerance});
    }
    [[nodiscard]] ClosingResult stepped(const PosedClosing& start, double step) const
    {
        return discreteClosing(*treeProximity(m_hand, start.object),
                               m_hand,
                               start.X_WH,
                               start.open,
                               {.closingStep = step});
    }

    grasp::HandModel m_hand = tests::makeGripper(false);
    std::optional<grasp::PenetrationCheck> m_check;
    const grasp::GraspObject m_plate = plateAt({0.005, 0.05, 0.028}, {0.0, 0.0, 0.03});
};

TEST_F(ClosingVerdictTest, ClosingsToTheSamePlateAreAlike)
{
    const PosedClosing start = startWith(m_plate);
    const ClosingResult first = ours(start, 2e-5);
    ASSERT_EQ(first.stops.size(), 2U);
    EXPECT_EQ(compareClosings(start, first, stepped(start, 0.01), {.sameLinks = true}),
              ClosingVerdict::Alike);
    EXPECT_LE(largestStopGap(start, first), 2e-5);
    EXPECT_FALSE(isInside(start, first.positions));
}

TEST_F(ClosingVerdictTest, NamesTheOneThatStepsOverAThinPlate)
{
    // 1 mm of plate, jaws of 10 mm: in steps of 25 mm the second ends beyond it.
    const grasp::GraspObject plate = plateAt({0.0005, 0.05, 0.028}, {-0.027, 0.0, 0.03});
    const PosedClosing start = startWith(plate);
    const ClosingResult first = ours(start, 2e-5);
    const ClosingResult other = stepped(start, 0.25);
    ASSERT_GT(postureDifference(m_hand, first.positions, other.positions), 0.02);
    EXPECT_EQ(compareClosings(start, first, other, {}), ClosingVerdict::OtherPasses);
    EXPECT_EQ(compareClosings(start, other, first, {}), ClosingVerdict::FirstPasses);
}

TEST_F(ClosingVerdictTest, ATouchWithinTheToleranceIsNoPassing)
{
    // The plate lies 40 um above the jaws' tips, at z = 60 mm: they slide along it.
    const grasp::GraspObject plate = plateAt({0.01, 0.05, 0.001}, {0.0, 0.0, 0.06104});
    const PosedClosing start = startWith(plate);
    const ClosingResult narrow = ours(start, 2e-5);
    ASSERT_TRUE(narrow.stops.empty());
    // Stopped under the plate's edge, as by a method that takes 100 um for a contact: the jaws come
    // as far as on a plate that is in their way, and then a little farther.
    const ClosingResult met = ours(startWith(m_plate), 2e-5);
    (void)startWith(plate);  // the check is of this plate again
    constexpr double kFarther = 1.05;
    ClosingResult wide = met;
    for (grasp::StopEvent& stop : wide.stops)
    {
        const auto link = static_cast<std::size_t>(stop.link);
        wide.positions[link] =
            start.open[link] + kFarther * (met.positions[link] - start.open[link]);
        stop.time *= kFarther;
    }
    ASSERT_GT(postureDifference(m_hand, wide.positions, narrow.positions), 0.02);
    EXPECT_EQ(compareClosings(start, wide, narrow, {}), ClosingVerdict::Touches);
    EXPECT_EQ(compareClosings(start, wide, narrow, {.reach = 1e-5}), ClosingVerdict::Unexplained);
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
