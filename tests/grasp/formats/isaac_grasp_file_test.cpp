// Reads isaac_grasp files back with yaml-cpp.
#include "grasp/formats/isaac_grasp_file.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <sstream>
#include <yaml-cpp/yaml.h>

namespace bullet_ccd::grasp
{
namespace
{
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> keysOf(const YAML::Node& map)
{
    std::vector<std::string> keys;
    for (const auto& entry : map)
    {
        keys.push_back(entry.first.as<std::string>());
    }
    return keys;
}

/// A gripper closed on a cube, turned by 0.3 about (1, 2, 2) / 3.
Grasp makeGrasp(double epsilon, RejectReason reject)
{
    Grasp grasp;
    grasp.reject = reject;
    grasp.preshape = "half open";
    grasp.X_WH = Eigen::Translation3d(0.1 / 3.0, -0.02, 1e-17) *
                 Eigen::AngleAxisd(0.3, Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0);
    grasp.positions = {0.0, 0.1 / 7.0, 0.1 / 7.0};
    grasp.quality.epsilon = epsilon;
    return grasp;
}

class IsaacGraspFile : public ::testing::Test
{
protected:
    IsaacGraspFile() { m_hand.preshapes.push_back({"half open", {0.0, 0.0125, 0.0125}}); }

    [[nodiscard]] std::string text(const std::vector<Grasp>& grasps) const
    {
        std::ostringstream out;
        writeIsaacGrasps(out, m_run, m_hand, m_object, grasps);
        return out.str();
    }

    HandModel m_hand = tests::makeGripper(true);
    GraspObject m_object = makeGraspObject("cube", makeBox({0.02, 0.02, 0.02}));
    GraspRun m_run{.handFile = "/robots/gripper.urdf",
                   .srdfFile = {},
                   .objectFile = "/objects/a \"good\": cube.obj",
                   .objectScale = 0.001,
                   .options = {}};
};

TEST_F(IsaacGraspFile, EveryNumberComesBackExactly)
{
    const Grasp grasp = makeGrasp(0.3, RejectReason::None);
    const YAML::Node file = YAML::Load(text({grasp}));
    ASSERT_THAT(keysOf(file["grasps"]), ElementsAre("grasp_0"));
    const YAML::Node read = file["grasps"]["grasp_0"];
    EXPECT_THAT(keysOf(read),
                ElementsAre("confidence",
                            "position",
                            "orientation",
                            "cspace_position",
                            "pregrasp_cspace_position"));
    EXPECT_EQ(read["position"].as<std::vector<double>>(),
              (std::vector<double>{0.1 / 3.0, -0.02, 1e-17}));
    // w = cos(angle / 2), xyz = sin(angle / 2) axis.
    const double sine = std::sin(0.15);
    EXPECT_NEAR(read["orientation"]["w"].as<double>(), std::cos(0.15), 1e-15);
    EXPECT_THAT(read["orientation"]["xyz"].as<std::vector<double>>(),
                ::testing::Pointwise(::testing::DoubleNear(1e-15),
                                     {sine / 3.0, 2.0 * sine / 3.0, 2.0 * sine / 3.0}));
    EXPECT_EQ(read["cspace_position"]["left_joint"].as<double>(), 0.1 / 7.0);
    EXPECT_EQ(read["pregrasp_cspace_position"]["left_joint"].as<double>(), 0.0125);
    EXPECT_DOUBLE_EQ(read["confidence"].as<double>(), 0.75);
}

TEST_F(IsaacGraspFile, TheHeadSaysFormatFramesAndFiles)
{
    const std::string written = text({});
    // Readers compare the version as a number or as text: it must stand there as they have it.
    EXPECT_THAT(written, HasSubstr("format: isaac_grasp\nformat_version: 1.0\n"));
    const YAML::Node file = YAML::Load(written);
    EXPECT_EQ(file["object_frame_link"].as<std::string>(), "cube");
    EXPECT_EQ(file["object_file"].as<std::string>(), m_run.objectFile.string());
    EXPECT_EQ(file["object_scale"].as<double>(), 0.001);
    EXPECT_EQ(file["gripper_frame_link"].as<std::string>(), "palm");
    EXPECT_EQ(file["gripper_file"].as<std::string>(), m_run.handFile.string());
    EXPECT_TRUE(file["grasps"].IsMap());
    EXPECT_EQ(file["grasps"].size(), 0U);
}

TEST_F(IsaacGraspFile, OnlyForceClosuresAreThereInTheirOrder)
{
    const YAML::Node grasps = YAML::Load(text({makeGrasp(0.4, RejectReason::None),
                                               makeGrasp(0.2, RejectReason::None),
                                               makeGrasp(0.3, RejectReason::Penetration),
                                               makeGrasp(0.001, RejectReason::NoForceClosure),
                                               makeGrasp(0.1, RejectReason::None)}))["grasps"];
    EXPECT_THAT(keysOf(grasps), ElementsAre("grasp_0", "grasp_1", "grasp_2"));
    EXPECT_DOUBLE_EQ(grasps["grasp_0"]["confidence"].as<double>(), 0.8);
    EXPECT_DOUBLE_EQ(grasps["grasp_1"]["confidence"].as<double>(), 2.0 / 3.0);
    EXPECT_DOUBLE_EQ(grasps["grasp_2"]["confidence"].as<double>(), 0.5);
}

TEST_F(IsaacGraspFile, MimicJointsAreLeftOut)
{
    const std::vector<Grasp> grasps = {makeGrasp(0.3, RejectReason::None)};
    for (const char* key : {"cspace_position", "pregrasp_cspace_position"})
    {
        EXPECT_THAT(keysOf(YAML::Load(text(grasps))["grasps"]["grasp_0"][key]),
                    ElementsAre("left_joint"));
    }
    m_hand.robot.tree.links[2].joint.mimicOf = kNone;
    EXPECT_THAT(keysOf(YAML::Load(text(grasps))["grasps"]["grasp_0"]["cspace_position"]),
                ElementsAre("left_joint", "right_joint"));
}

TEST_F(IsaacGraspFile, NamesStayNames)
{
    m_hand.robot.tree.links[1].joint.name = "true";
    const std::string written = text({makeGrasp(0.3, RejectReason::None)});
    EXPECT_THAT(written, HasSubstr("\"true\": "));
}

TEST_F(IsaacGraspFile, APreshapeOfAnotherHandIsRefused)
{
    Grasp grasp = makeGrasp(0.3, RejectReason::None);
    grasp.preshape = "fist";
    try
    {
        static_cast<void>(text({grasp}));
        FAIL() << "written without a preshape";
    }
    catch (const std::invalid_argument& error)
    {
        EXPECT_THAT(error.what(), HasSubstr("\"fist\""));
    }
}

TEST(IsaacConfidence, OrdersAsEpsilonDoesAndStaysBelowOne)
{
    double previous = isaacConfidence(0.0);
    EXPECT_EQ(previous, 0.0);
    for (double epsilon = 1e-6; epsilon < 10.0; epsilon *= 1.1)
    {
        EXPECT_GT(isaacConfidence(epsilon), previous);
        previous = isaacConfidence(epsilon);
    }
    EXPECT_LT(previous, 1.0);
}
}  // namespace
}  // namespace bullet_ccd::grasp
