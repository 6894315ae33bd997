// `grasp task pick-place`: the files of a plan, and what the program says about input that is
// wrong.
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/run_program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kScene = R"(robot:
  start: {shoulder_bend_joint: -0.3, elbow_joint: -1.6, wrist_bend_joint: 1.2}
obstacles:
  - {name: table, box: [0.9, 1.3, 0.04], position: [0.62, 0, -0.02]}
objects:
  - {name: block, box: [0.04, 0.06, 0.08], position: [0.5, -0.2, 0.04]}
target: {position: [0.5, 0.3, 0], size: [0.1, 0.1]}
)";

class GraspTask : public ::testing::Test
{
protected:
    /// With one text of the scene in place of another.
    [[nodiscard]] Outcome run(const std::string& from = "",
                              const std::string& to = "",
                              const std::string& more = "") const
    {
        std::string text = kScene;
        if (!from.empty())
        {
            text.replace(text.find(from), from.size(), to);
        }
        std::ofstream(m_scene) << text;
        return runProgram(
            std::string(BULLET_CCD_GRASP_PROGRAM) + " task pick-place '" + m_scene.string() +
            "' --arm seven_joint_arm --hand parallel_gripper --object block -n 24 " + more);
    }

    void expectRefused(const std::string& from, const std::string& to, const std::string& why) const
    {
        const Outcome outcome = run(from, to);
        EXPECT_EQ(outcome.exitCode, 3) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(why));
    }

    tests::TempFolder m_temp;
    fs::path m_scene = m_temp.path() / "scene.yaml";
};

TEST_F(GraspTask, WritesThePlanAsJsonCsvYamlAndModel)
{
    const fs::path folder = m_temp.path() / "out";
    const Outcome outcome = run("", "", "-o '" + folder.string() + "'");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
    const auto plan = nlohmann::json::parse(contentOf(folder / "plan.json"));
    EXPECT_EQ(plan.at("schema"), "bullet_ccd.pick_place/1");
    EXPECT_TRUE(plan.at("solved"));
    ASSERT_EQ(plan.at("legs").size(), 9U);
    ASSERT_EQ(plan.at("joints").size(), 8U);  // of the arm, and one of the gripper
    EXPECT_TRUE(plan.at("attempts").back().at("failed_leg").is_null());
    // A row of the table for each waypoint; those where two legs meet are there once.
    std::size_t waypoints = 1;
    for (const auto& leg : plan.at("legs"))
    {
        EXPECT_GT(leg.at("certified_clearance_m"), 0.0);
        waypoints += leg.at("waypoints").size() - 1;
    }
    std::stringstream rows(contentOf(folder / "trajectory.csv"));
    std::string line;
    std::getline(rows, line);
    EXPECT_THAT(line, testing::StartsWith("time,shoulder_turn_joint,"));
    std::size_t count = 0;
    double time = -1.0;
    for (; std::getline(rows, line); ++count)
    {
        const double next = std::stod(line);
        EXPECT_GT(next, time);
        time = next;
    }
    EXPECT_EQ(count, waypoints);
    EXPECT_EQ(time, plan.at("duration_s"));
    EXPECT_THAT(contentOf(folder / "trajectory.yaml"), HasSubstr("  - left_jaw_joint\n"));
    EXPECT_EQ(contentOf(folder / "plan.glb").substr(0, 4), "glTF");
    EXPECT_EQ(contentOf(folder / "plan.png").substr(1, 3), "PNG");
    const std::string page = contentOf(folder / "report.html");
    EXPECT_THAT(page, HasSubstr("Moving block: seven_joint_arm_parallel_gripper"));
    EXPECT_THAT(page, HasSubstr("<td class=\"text\">transit</td>"));
    EXPECT_THAT(page, HasSubstr("<td class=\"text\">is the plan</td>"));
    EXPECT_THAT(page, HasSubstr("href=\"trajectory.yaml\""));
}

TEST_F(GraspTask, ShowsTheSceneAndTheReasonsWhereThereIsNoPlan)
{
    const fs::path folder = m_temp.path() / "out";
    const Outcome outcome = run("[0.5, 0.3, 0]", "[5, 0.3, 0]", "-o '" + folder.string() + "'");
    EXPECT_EQ(outcome.exitCode, 1);
    const std::string page = contentOf(folder / "report.html");
    EXPECT_THAT(page, HasSubstr("No plan: "));
    EXPECT_THAT(page, HasSubstr("block: is taken"));
    EXPECT_FALSE(fs::exists(folder / "plan.png"));
}

/// A plan, and what the other program says of its legs.
TEST_F(GraspTask, LegsAreCertifiedByTheOtherProgram)
{
    writeObj(makeBox({0.02, 0.03, 0.04}), m_temp.path() / "block.obj");
    const fs::path folder = m_temp.path() / "out";
    const Outcome planned =
        run("box: [0.04, 0.06, 0.08]", "mesh: block.obj", "-o '" + folder.string() + "'");
    ASSERT_EQ(planned.exitCode, 0) << planned.err;
    const auto certify = [&](const std::string& legs, const std::string& more)
    {
        const std::string base = "'" + folder.string() + "/";
        std::string files;
        std::istringstream names(legs);
        for (std::string name; names >> name;)
        {
            files += " " + base + name + "'";
        }
        return runProgram(std::string(BULLET_CCD_PROGRAM) + " certify " + base +
                          "robot.urdf' --srdf " + base + "robot.srdf' --trajectory" + files +
                          " --obstacles '" + m_scene.string() + "' --no-distance " + more);
    };
    const Outcome coming = certify("leg_1_transit.csv leg_2_approach.csv", "");
    EXPECT_EQ(coming.exitCode, 0) << coming.out << coming.err;
    const auto grasp = nlohmann::json::parse(contentOf(folder / "plan.json")).at("grasp");
    const auto& pose = grasp.at("object_pose_in_hand");
    std::string attached = (m_temp.path() / "block.obj").string() + "@" +
                           grasp.at("hand_link").get<std::string>() + "@";
    for (const auto* list : {&pose.at("quaternion_wxyz"), &pose.at("position_m")})
    {
        for (const auto& number : *list)
        {
            attached += (attached.back() == '@' ? "" : ",") + number.dump();
        }
    }
    const std::string attach = "--attach '" + attached + "' ";
    const std::string carrying = "leg_4_lift.csv leg_5_carry.csv leg_6_place.csv";
    const Outcome carried = certify(carrying, attach + "--without block");
    EXPECT_EQ(carried.exitCode, 0) << carried.out << carried.err;
    EXPECT_EQ(certify(carrying, attach).exitCode, 1) << "it is where it is taken from";
    const Outcome none = certify(carrying, attach + "--without blocks");
    EXPECT_EQ(none.exitCode, 3);
    EXPECT_THAT(none.err, HasSubstr("there is no obstacle blocks"));

    // The robot that was written is one that tasks take.
    const Outcome again =
        runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " task pick-place '" + m_scene.string() +
                   "' --arm '" + folder.string() + "/robot.urdf' --object block -n 24 -q");
    EXPECT_EQ(again.exitCode, 0) << again.out << again.err;
    const Outcome wrong = runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " task pick-place '" +
                                     m_scene.string() + "' --object block --arm seven_joint_arm");
    EXPECT_EQ(wrong.exitCode, 3);
    EXPECT_THAT(wrong.err, HasSubstr("does not divide into fingers"));
}

TEST_F(GraspTask, NamesWhatIsWrongWithAScene)
{
    expectRefused("elbow_joint", "elbow_joynt", "did you mean elbow_joint?");
    expectRefused("elbow_joint: -1.6", "elbow_joint: -3", "-3 of joint elbow_joint");
    expectRefused("elbow_joint: -1.6", "elbow_joint: .nan", "scene.yaml:2");
    expectRefused("position: [0.5, -0.2, 0.04]", "position: [0.5, .nan, 0.04]", "scene.yaml:6");
    expectRefused("position: [0.5, -0.2, 0.04]", "position: [0.5, -0.2, 0.02]", "intersects table");
    expectRefused("box: [0.04, 0.06, 0.08]", "box: [0.04, 0.06, 0]", "extents above 0");
    expectRefused("name: block", "name: brick", "there is no block");
    expectRefused("target:", "goal:", "goal");
    expectRefused("shoulder_bend_joint: -0.3", "shoulder_bend_joint: 1.9", "in collision");
}

TEST_F(GraspTask, NamesWhatIsWrongWithTheRobot)
{
    const Outcome flange = run("", "", "--flange wrist_trun");
    EXPECT_EQ(flange.exitCode, 3);
    EXPECT_THAT(flange.err, HasSubstr("no link 'wrist_trun'"));
    const Outcome mount = run("", "", "--mount 1,0,0");
    EXPECT_EQ(mount.exitCode, 2);
    const Outcome arm = run("", "", "--arm six_joint_arm");
    EXPECT_NE(arm.exitCode, 0);
}

TEST_F(GraspTask, SaysThatTheTargetIsOutOfReach)
{
    const Outcome far = run("[0.5, 0.3, 0]", "[5, 0.3, 0]");
    EXPECT_EQ(far.exitCode, 1);
    EXPECT_THAT(far.err, HasSubstr("nothing below the target region that block could stand on"));
    const Outcome limited = run("", "", "--time-limit 1e-6");
    EXPECT_EQ(limited.exitCode, 1);
    EXPECT_THAT(limited.err, HasSubstr("stopped after 0 of 1 objects"));
}

Outcome runGrasp(const std::string& words)
{
    return runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " " + words);
}

TEST(GraspTaskBimanual, WritesThePlanAsJsonModelAndPicture)
{
    const tests::TempFolder temp;
    const fs::path folder = temp.path() / "out";
    const Outcome outcome = runGrasp(
        "task bimanual large/pot --arm seven_joint_arm --hand three_finger_gripper -n 120 -o '" +
        folder.string() + "'");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.out << outcome.err;
    const auto plan = nlohmann::json::parse(contentOf(folder / "plan.json"));
    EXPECT_EQ(plan.at("schema"), "bullet_ccd.two_hands/1");
    EXPECT_EQ(plan.at("legs").size(), 4U);
    EXPECT_EQ(plan.at("epsilon_of_one_hand"), nlohmann::json({0.0, 0.0}));
    EXPECT_GT(plan.at("internal_force_N"), 0.0);
    EXPECT_EQ(plan.at("joints").size(), 22U);  // two arms of 7, two hands of 4 that follow no other
    EXPECT_EQ(contentOf(folder / "plan.glb").substr(0, 4), "glTF");
    EXPECT_EQ(contentOf(folder / "plan.png").substr(1, 3), "PNG");
    EXPECT_THAT(contentOf(folder / "report.html"), HasSubstr("Two hands on pot"));
    const Outcome far = runGrasp(
        "task bimanual large/pot --arm seven_joint_arm --hand three_finger_gripper -n 4 --place "
        "5,0,0.4");
    EXPECT_EQ(far.exitCode, 1);
    EXPECT_THAT(far.out, HasSubstr("brings its hand to no candidate"));
}

TEST(GraspTaskClutter, ScenesThatShipCanBeReadByBothPrograms)
{
    for (const std::string scene : {"clutter_10", "clutter_20", "clutter_40", "narrow_shelf"})
    {
        const Outcome read =
            runGrasp("task pick-place " + scene +
                     " --arm seven_joint_arm --hand parallel_gripper --object apple "
                     "--time-limit 1e-6");
        EXPECT_EQ(read.exitCode, 1) << read.err;
        EXPECT_THAT(read.err, HasSubstr("stopped after 0 of 1 objects"));
        const fs::path share =
            fs::path(BULLET_CCD_GRASP_PROGRAM).parent_path().parent_path() / "share/bullet_ccd";
        const tests::TempFolder temp;
        std::ofstream(temp.path() / "rest.csv")
            << "time,shoulder_turn_joint,shoulder_bend_joint,elbow_joint,wrist_bend_joint\n"
               "0,0,-0.3,-1.6,1.2\n1,0.1,-0.3,-1.6,1.2\n";
        const Outcome certified =
            runProgram(std::string(BULLET_CCD_PROGRAM) + " certify '" +
                       (share / "robots/arms/seven_joint_arm.urdf").string() + "' --trajectory '" +
                       (temp.path() / "rest.csv").string() + "' --no-distance --obstacles '" +
                       (share / "robots/scenes" / (scene + ".yaml")).string() + "'");
        EXPECT_EQ(certified.exitCode, 0) << certified.out << certified.err;
    }
}

TEST(GraspTaskClutter, WritesASceneThatCanBeRead)
{
    const tests::TempFolder temp;
    const fs::path scene = temp.path() / "clutter.yaml";
    const Outcome made = runGrasp("task clutter apple box -n 3 -o '" + scene.string() + "'");
    ASSERT_EQ(made.exitCode, 0) << made.err;
    EXPECT_THAT(contentOf(scene), HasSubstr("name: apple 2"));
    EXPECT_EQ(contentOf(temp.path() / "clutter.png").substr(1, 3), "PNG");
    const fs::path drawn = temp.path() / "drawn";
    const Outcome both =
        runGrasp("task scene shelf '" + scene.string() + "' -o '" + drawn.string() + "'");
    ASSERT_EQ(both.exitCode, 0) << both.err;
    EXPECT_THAT(both.out, HasSubstr("shelf: 7 obstacles, 3 objects\n"));
    for (const char* name : {"shelf.png", "clutter.png", "scenes.png"})
    {
        EXPECT_EQ(contentOf(drawn / name).substr(1, 3), "PNG") << name;
    }
    EXPECT_EQ(contentOf(drawn / "clutter.png"), contentOf(temp.path() / "clutter.png"));
    EXPECT_EQ(runGrasp("task scene shelff -o '" + drawn.string() + "'").exitCode, 3);
    const Outcome read = runGrasp("task pick-place '" + scene.string() +
                                  "' --arm seven_joint_arm --hand parallel_gripper --object apple "
                                  "--time-limit 1e-6");
    EXPECT_EQ(read.exitCode, 1);
    EXPECT_THAT(read.err, HasSubstr("stopped after 0 of 1 objects"));
}

TEST(GraspPlanWithArm, RejectsWhatTheArmDoesNotReach)
{
    const tests::TempFolder temp;
    const auto plan = [&](const std::string& pose)
    {
        return runGrasp(
            "plan --hand parallel_gripper --object box -n 6 --pictures 0 --models 0 -q "
            "--robot seven_joint_arm --robot-pose " +
            pose + " -o '" + (temp.path() / "out").string() + "'");
    };
    const Outcome far = plan("1,0,0,0,-5,0,0");
    EXPECT_EQ(far.exitCode, 1) << far.err;
    EXPECT_THAT(contentOf(temp.path() / "out/grasps.jsonl"), HasSubstr("\"out of reach\""));
    EXPECT_THAT(contentOf(temp.path() / "out/grasps.jsonl"),
                HasSubstr("\"seven_joint_arm at 1,0,0,0,-5,0,0"));
    const Outcome near = plan("1,0,0,0,-0.5,0,-0.2");
    EXPECT_EQ(near.exitCode, 0) << near.err;
}
}  // namespace
}  // namespace bullet_ccd::tools
