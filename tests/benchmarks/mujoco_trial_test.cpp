#include "benchmarks/reference/oracles/mujoco_trial.h"

#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

namespace bullet_ccd::benchmarks
{
namespace
{
using grasp::TrialOutcome;

/// Two jaws press a cube of 40 mm by N each: it slips where the load is 2 mu N.
class TwoJaws : public ::testing::TestWithParam<bool>
{
protected:
    TwoJaws() : m_hand(tests::makeGripper(GetParam()))
    {
        for (Link& link : m_hand.robot.tree.links)
        {
            link.joint.maxEffort = 100.0;
        }
        m_grasp.X_WH.translation() = Eigen::Vector3d(0.0, 0.0, -0.035);
        m_grasp.X_WStart.translation() = Eigen::Vector3d(0.0, 0.0, -0.1);
        m_grasp.approach_W = Eigen::Vector3d::UnitZ();
        m_grasp.preshape = "open";
        m_grasp.positions = {0.0, 0.01995, 0.01995};
        for (const SsvTree* tree : m_hand.linkTrees)
        {
            m_pieces.links.push_back({.pieces = {tree->mesh()}, .bulge = 0.0});
        }
        m_pieces.object = {.pieces = {m_cube.tree.mesh()}, .bulge = 0.0};
        for (const double side : {-1.0, 1.0})
        {
            for (const double y : {-0.01, 0.01})
            {
                for (const double z : {-0.005, 0.02})
                {
                    m_grasp.contacts.push_back({.link = side < 0.0 ? 1 : 2,
                                                .point = {0.02 * side, y, z},
                                                .normal = {-side, 0.0, 0.0},
                                                .gap = 5e-5});
                }
            }
        }
    }
    /// By a squeeze that counts on a friction of 0.5.
    [[nodiscard]] TrialOutcome liftBy(double friction)
    {
        const grasp::Squeeze squeeze =
            squeezeOf(m_hand, m_grasp, {.mass = 0.3, .friction = 0.5, .firmness = 4.0});
        return reference::MujocoTrials(m_hand, m_cube, m_grasp, squeeze, m_pieces)
            .run(m_grasp, squeeze, grasp::shippedProtocol("lift"), 0.3, friction, 0.0)
            .outcome;
    }
    /// Of a load along y, across the jaws, of so much of 2 mu N.
    [[nodiscard]] TrialOutcome outcomeOf(double share, double mass, double friction)
    {
        const grasp::Squeeze squeeze =
            squeezeOf(m_hand, m_grasp, {.mass = mass, .friction = friction, .firmness = 4.0});
        EXPECT_TRUE(squeeze.exists()) << squeeze.reason;
        grasp::TrialPhase load;
        load.direction = Eigen::Vector3d::UnitY();
        load.amount = share * friction * squeeze.normalForce / (mass * 9.80665);
        return reference::MujocoTrials(m_hand, m_cube, m_grasp, squeeze, m_pieces)
            .run(m_grasp, squeeze, {.name = "load", .phases = {load}}, mass, friction, 0.0)
            .outcome;
    }

    grasp::HandModel m_hand;
    grasp::GraspObject m_cube =
        grasp::makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
    grasp::Grasp m_grasp;
    grasp::MjcfPieces m_pieces;
};

TEST_P(TwoJaws, SlipInMuJoCoWhereTheLoadIsTwiceTheFriction)
{
    for (const double mass : {0.1, 1.0})
    {
        for (const double friction : {0.3, 0.8})
        {
            EXPECT_EQ(outcomeOf(0.95, mass, friction), TrialOutcome::Held) << mass << friction;
            EXPECT_NE(outcomeOf(1.05, mass, friction), TrialOutcome::Held) << mass << friction;
        }
    }
}

TEST_P(TwoJaws, LiftInMuJoCoFromATableWhatTheirFrictionHolds)
{
    EXPECT_EQ(liftBy(0.5), TrialOutcome::Held);
    EXPECT_EQ(liftBy(0.02), TrialOutcome::Slipped);  // it stays on the table, up to the palm
}

/// Jaws hold the last 3 mm of a plate of 2 mm, whose middle is 200 mm away. MPR gives a contact
/// along the plate there, which would push it out.
TEST_P(TwoJaws, HoldTheEndOfAPlateInMuJoCo)
{
    TriangleMesh plate = makeBox(Eigen::Vector3d(0.001, 0.02, 0.2));
    transformMesh(plate, Eigen::Affine3d(Eigen::Translation3d(0.0, 0.0, 0.222)));
    m_pieces.object = {.pieces = {plate}, .bulge = 0.0};
    const grasp::GraspObject object = grasp::makeGraspObject("plate", std::move(plate));
    m_grasp.positions = {0.0, 0.03895, 0.03895};
    for (grasp::GraspContact& contact : m_grasp.contacts)
    {
        contact.point.x() *= 0.05;
        contact.point.z() = contact.point.z() > 0.0 ? 0.0245 : 0.0225;
    }
    const grasp::Squeeze squeeze =
        squeezeOf(m_hand, m_grasp, {.mass = 0.1, .friction = 0.5, .firmness = 80.0});
    ASSERT_TRUE(squeeze.exists()) << squeeze.reason;
    const grasp::TrialResult result =
        reference::MujocoTrials(m_hand, object, m_grasp, squeeze, m_pieces)
            .run(m_grasp,
                 squeeze,
                 {.name = "pull", .phases = {{.direction = Eigen::Vector3d::UnitZ()}}},
                 0.1,
                 0.5,
                 0.0);
    EXPECT_EQ(result.outcome, TrialOutcome::Held) << result.reason;
    EXPECT_LT(result.slip, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(AloneAndCoupled, TwoJaws, ::testing::Bool());
}  // namespace
}  // namespace bullet_ccd::benchmarks
