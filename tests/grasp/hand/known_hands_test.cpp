#include "grasp/hand/hand_inference.h"
#include "grasp/hand/hand_model.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <gmock/gmock.h>
#include <ostream>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
/// A hand of the test data: what its maker says about it.
struct KnownHand
{
    std::string urdf;
    std::size_t fingers;
    std::size_t closingJoints;  ///< driven ones that flex the fingers
};

void PrintTo(const KnownHand& hand, std::ostream* stream)
{
    *stream << hand.urdf;
}

class KnownHands : public testing::TestWithParam<KnownHand>
{
protected:
    /// In the grasp frame of the preshape.
    static std::vector<Eigen::Vector3d> fingertips(const HandModel& hand,
                                                   const Preshape& preshape,
                                                   const std::vector<double>& positions)
    {
        const std::vector<Eigen::Isometry3d> poses =
            linkPoses(hand.robot.tree, graspFrame(hand, preshape).inverse(), positions);
        std::vector<Eigen::Vector3d> tips;
        for (const Finger& finger : hand.fingers)
        {
            tips.push_back(fingertip(hand.robot, finger, poses));
        }
        return tips;
    }

    static std::vector<double> between(const std::vector<double>& a,
                                       const std::vector<double>& b,
                                       double t)
    {
        std::vector<double> result(a.size());
        for (std::size_t i = 0; i < a.size(); ++i)
        {
            result[i] = a[i] + t * (b[i] - a[i]);
        }
        return result;
    }
};

TEST_P(KnownHands, FingersAndJointsAreAsBuilt)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(hands, "hands");
    for (const char* variant : {".urdf", "_mesh.urdf"})
    {
        const HandModel hand =
            loadHand(hands / (GetParam().urdf + variant), std::nullopt, BULLET_CCD_SHARE_FOLDER);
        EXPECT_TRUE(hand.notes.empty()) << hand.notes.front();
        EXPECT_EQ(hand.fingers.size(), GetParam().fingers);
        std::size_t closing = 0;
        for (std::size_t i = 0; i < hand.robot.tree.size(); ++i)
        {
            closing +=
                hand.closingDirections[i] != 0 && hand.robot.tree.links[i].joint.mimicOf == kNone
                    ? 1
                    : 0;
        }
        EXPECT_EQ(closing, GetParam().closingJoints);
        for (const auto& [a, b] : hand.selfPairs)
        {
            EXPECT_NE(hand.linkTrees[static_cast<std::size_t>(a)], nullptr);
            EXPECT_NE(hand.linkTrees[static_cast<std::size_t>(b)], nullptr);
        }
    }
}

TEST_P(KnownHands, FingertipsCloseTowardsTheGraspFrame)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(hands, "hands");
    const HandModel hand =
        loadHand(hands / (GetParam().urdf + "_mesh.urdf"), std::nullopt, BULLET_CCD_SHARE_FOLDER);
    for (const Preshape& preshape : hand.preshapes)
    {
        const std::vector<double> closed = closedPositions(hand, preshape.positions);
        const std::vector<Eigen::Vector3d> open = fingertips(hand, preshape, preshape.positions);
        for (std::size_t i = 0; i < open.size(); ++i)
        {
            double nearest = open[i].norm();
            for (int step = 1; step <= 20; ++step)
            {
                nearest = std::min(
                    nearest,
                    fingertips(hand, preshape, between(preshape.positions, closed, step / 20.0))[i]
                        .norm());
            }
            // A 6 cm object sits at the origin: the tip gets near it, sideways fingers less so.
            EXPECT_LT(nearest, 0.085) << preshape.name << " " << hand.fingers[i].name;
            EXPECT_LT(nearest, 0.95 * open[i].norm())
                << preshape.name << " " << hand.fingers[i].name;
        }
    }
}

TEST_P(KnownHands, FingersOpposeEachOtherAlongX)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(hands, "hands");
    const HandModel hand =
        loadHand(hands / (GetParam().urdf + "_mesh.urdf"), std::nullopt, BULLET_CCD_SHARE_FOLDER);
    const std::vector<Eigen::Vector3d> open =
        fingertips(hand, hand.preshapes[0], hand.preshapes[0].positions);
    double lower = 0.0;
    double upper = 0.0;
    for (const Eigen::Vector3d& tip : open)
    {
        lower = std::min(lower, tip.x());
        upper = std::max(upper, tip.x());
    }
    // Room for a 6 cm object, on both sides of the origin.
    EXPECT_LT(lower, -0.03);
    EXPECT_GT(upper, 0.03);
    // And the hand approaches with its palm behind the origin.
    const Eigen::Isometry3d X_GP =
        hand.X_RG.inverse() *
        linkPoses(hand.robot.tree,
                  Eigen::Isometry3d::Identity(),
                  hand.preshapes[0].positions)[static_cast<std::size_t>(hand.palm)];
    const TriangleMesh& palm = hand.robot.linkMeshes[static_cast<std::size_t>(hand.palm)];
    EXPECT_LT((X_GP * bounds(palm).center()).z(), -0.03);
}

TEST_P(KnownHands, WithoutSrdfTheFingersAreFoundToo)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(hands, "hands");
    HandModel inferred =
        loadHand(hands / (GetParam().urdf + "_mesh.urdf"), std::nullopt, BULLET_CCD_SHARE_FOLDER);
    const std::int32_t palm = std::exchange(inferred.palm, 0);
    const std::vector<int> known = inferred.closingDirections;
    const KinematicTree& tree = inferred.robot.tree;
    inferred.fingers = inferFingers(inferred.robot, inferred.palm);
    inferred.closingDirections =
        inferClosingDirections(inferred, std::vector<bool>(tree.size(), false));
    EXPECT_EQ(inferred.fingers.size(), GetParam().fingers);
    EXPECT_EQ(inferred.palm, palm);
    std::size_t expected = 0;
    std::size_t agree = 0;
    for (std::size_t i = 0; i < known.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        const int closing = joint.mimicOf == kNone ? known[i] : 0;
        const int guess = inferred.closingDirections[i];
        EXPECT_FALSE(closing == 0 && guess != 0) << joint.name << " keeps its preshape";
        EXPECT_GE(closing * guess, 0) << joint.name << " would open the hand";
        expected += closing != 0 ? 1 : 0;
        agree += closing * guess > 0 ? 1 : 0;
    }
    EXPECT_GT(expected, 0U);
    EXPECT_GE(10 * agree, 8 * expected);
}

INSTANTIATE_TEST_SUITE_P(All,
                         KnownHands,
                         testing::Values(KnownHand{"schunk_sah/schunk_sah_right", 4, 12},
                                         KnownHand{"allegro/allegro_right", 4, 11},
                                         KnownHand{"allegro/allegro_left", 4, 11},
                                         KnownHand{"barrett/barrett", 3, 6},
                                         KnownHand{"shadow/shadow_right", 5, 14},
                                         KnownHand{"schunk_svh/schunk_svh_right", 5, 7},
                                         KnownHand{"schunk_sdh/schunk_sdh", 3, 6},
                                         KnownHand{"leap/leap_right", 4, 11},
                                         KnownHand{"panda_gripper/panda_gripper", 2, 1}));
}  // namespace
}  // namespace bullet_ccd::grasp
