/// The shipped hands, written as MJCF in the style of Menagerie.
#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/closing/closing.h"
#include "grasp/hand/hand_model.h"
#include "grasp/planner/grasp_planner.h"
#include "tests/io/mjcf_writer.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

namespace bullet_ccd
{
namespace
{
/// A robot written as MJCF in Menagerie's style is the robot of the URDF.
TEST(MjcfRobots, ARobotIsTheSameFromMjcfAndUrdf)
{
    for (const std::string name :
         {"parallel_gripper", "three_finger_gripper", "anthropomorphic_hand"})
    {
        const std::filesystem::path file =
            std::filesystem::path(BULLET_CCD_SHARE) / "robots" / name / (name + ".urdf");
        SCOPED_TRACE(name);
        const tests::TempFolder folder;
        const RobotModel a = loadRobot(file);
        const RobotModel b = loadRobot(tests::writeMjcf(a, folder.path()));
        ASSERT_EQ(a.tree.size(), b.tree.size());
        EXPECT_EQ(a.name, b.name);
        for (std::size_t i = 0; i < a.tree.size(); ++i)
        {
            const Link& u = a.tree.links[i];
            const Link& m = b.tree.links[i];
            SCOPED_TRACE(u.name);
            EXPECT_EQ(u.name, m.name);
            EXPECT_EQ(u.parent, m.parent);
            EXPECT_TRUE(u.X_PL0.isApprox(m.X_PL0, 1e-14) || i == 0);
            EXPECT_EQ(u.joint.type, m.joint.type);
            EXPECT_EQ(u.joint.lower, m.joint.lower);
            EXPECT_EQ(u.joint.upper, m.joint.upper);
            EXPECT_EQ(u.joint.maxEffort, m.joint.maxEffort);
            EXPECT_EQ(u.joint.mimicOf, m.joint.mimicOf);
            EXPECT_EQ(u.joint.mimicMultiplier, m.joint.mimicMultiplier);
            EXPECT_EQ(u.joint.mimicOffset, m.joint.mimicOffset);
            EXPECT_NEAR(u.mass, m.mass, 1e-14);
            EXPECT_TRUE(u.inertia.isApprox(m.inertia, 1e-12));
            if (u.joint.isMovable())
            {
                EXPECT_EQ(u.joint.name, m.joint.name);
                EXPECT_TRUE(u.joint.axis.isApprox(m.joint.axis, 1e-14));
            }
            ASSERT_EQ(a.linkMeshes[i].triangles, b.linkMeshes[i].triangles);
            for (std::size_t v = 0; v < a.linkMeshes[i].vertices.size(); ++v)
            {
                ASSERT_NEAR(
                    (a.linkMeshes[i].vertices[v] - b.linkMeshes[i].vertices[v]).norm(), 0.0, 1e-14);
            }
        }
    }
}

TEST(MjcfRobots, AHandIsTheSameFromMjcfAndUrdfWithTheSameSrdf)
{
    const std::filesystem::path folder =
        std::filesystem::path(BULLET_CCD_SHARE) / "robots/anthropomorphic_hand";
    const tests::TempFolder written;
    const grasp::HandModel a = grasp::loadHand(folder / "anthropomorphic_hand.urdf");
    const grasp::HandModel b = grasp::loadHand(tests::writeMjcf(a.robot, written.path()),
                                               folder / "anthropomorphic_hand.srdf");
    EXPECT_EQ(a.closingDirections, b.closingDirections);
    EXPECT_EQ(a.selfPairs, b.selfPairs);
    ASSERT_EQ(a.preshapes.size(), b.preshapes.size());
    for (std::size_t i = 0; i < a.preshapes.size(); ++i)
    {
        EXPECT_EQ(a.preshapes[i].positions, b.preshapes[i].positions);
    }
    ASSERT_EQ(a.fingers.size(), b.fingers.size());
    for (std::size_t i = 0; i < a.fingers.size(); ++i)
    {
        EXPECT_EQ(a.fingers[i].links, b.fingers[i].links);
    }

    // And so are its grasps. Pyramids, because the search with exact cones ends within 1 %.
    const grasp::GraspObject box = grasp::makeGraspObject("box", makeBox({0.02, 0.03, 0.05}));
    const auto plan = [&](const grasp::HandModel& hand)
    {
        return grasp::planGrasps(
            hand, box, {.candidates = 6, .coneEdges = 8}, [] { return grasp::kinematicClosing(); });
    };
    const std::vector<grasp::Grasp> fromUrdf = plan(a);
    const std::vector<grasp::Grasp> fromMjcf = plan(b);
    EXPECT_EQ(fromUrdf.front().reject, grasp::RejectReason::None);
    for (std::size_t i = 0; i < fromUrdf.size(); ++i)
    {
        EXPECT_EQ(fromUrdf[i].candidate, fromMjcf[i].candidate);
        EXPECT_EQ(fromUrdf[i].reject, fromMjcf[i].reject);
        EXPECT_NEAR(fromUrdf[i].quality.epsilon, fromMjcf[i].quality.epsilon, 1e-6);
        ASSERT_EQ(fromUrdf[i].positions.size(), fromMjcf[i].positions.size());
        for (std::size_t k = 0; k < fromUrdf[i].positions.size(); ++k)
        {
            EXPECT_NEAR(fromUrdf[i].positions[k], fromMjcf[i].positions[k], 1e-6);
        }
    }
}
}  // namespace
}  // namespace bullet_ccd
