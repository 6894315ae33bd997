// Runs the program as a user does and looks at exit codes, messages and files.
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/run_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Names of all files, sorted.
std::vector<std::string> filesIn(const fs::path& folder)
{
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
    {
        names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

/// Two fingers of one box each, whose URDF leaves out what many leave out: inertials and efforts.
std::string bareGripper()
{
    const auto link = [](const std::string& name, const std::string& size, const std::string& at)
    {
        return "<link name=\"" + name + "\"><collision><origin xyz=\"" + at +
               "\"/><geometry><box size=\"" + size + "\"/></geometry></collision></link>";
    };
    const auto hinge = [](const std::string& name, const std::string& x, const std::string& axis)
    {
        return "<joint name=\"" + name + "_joint\" type=\"revolute\"><parent link=\"palm\"/>" +
               "<child link=\"" + name + "\"/><origin xyz=\"" + x + " 0 0.02\"/><axis xyz=\"" +
               axis + "\"/><limit lower=\"0\" upper=\"1\" effort=\"0\" velocity=\"1\"/></joint>";
    };
    return "<?xml version=\"1.0\"?><robot name=\"bare\">" +
           link("palm", "0.14 0.06 0.02", "0 0 0") + link("left", "0.01 0.02 0.1", "0 0 0.05") +
           link("right", "0.01 0.02 0.1", "0 0 0.05") + hinge("left", "-0.05", "0 1 0") +
           hinge("right", "0.05", "0 -1 0") + "</robot>";
}

class GraspProgram : public ::testing::Test
{
protected:
    void SetUp() override
    {
        m_ball = m_folder / "ball.obj";
        writeObj(makeSphere(0.03, 3), m_ball);
    }

    [[nodiscard]] static Outcome run(const std::string& arguments)
    {
        return runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " " + arguments);
    }

    /// Plans with the shipped gripper and the ball into `folder`.
    [[nodiscard]] Outcome plan(const fs::path& folder, const std::string& more = "") const
    {
        return run("plan --hand three_finger_gripper --object '" + m_ball.string() +
                   "' -n 4 --pictures 1 -o '" + folder.string() + "' " + more);
    }

    tests::TempFolder m_temp;
    fs::path m_folder = m_temp.path();
    fs::path m_ball;
};

TEST_F(GraspProgram, HelpNamesTheVerbsAndExitCodes)
{
    const Outcome help = run("--help");
    EXPECT_EQ(help.exitCode, 0);
    for (const char* word : {"plan",
                             "close",
                             "check",
                             "export",
                             "force",
                             "hand",
                             "quality",
                             "trial",
                             "Exit codes",
                             "Examples"})
    {
        EXPECT_THAT(help.out, HasSubstr(word));
    }
    for (const char* verb :
         {"plan", "close", "check", "export", "force", "hand", "quality", "trial"})
    {
        const Outcome ofVerb = run(std::string(verb) + " --help");
        EXPECT_EQ(ofVerb.exitCode, 0);
        EXPECT_THAT(ofVerb.out, HasSubstr(std::string("grasp ") + verb));
        expectReadableHelp(ofVerb.out);
    }
    expectReadableHelp(help.out);
    expectReadableHelp(run("hand check --help").out);
    EXPECT_EQ(run("--version").exitCode, 0);
}

TEST_F(GraspProgram, UsageErrorsExitWith2AndSayWhy)
{
    EXPECT_EQ(run("").exitCode, 2);
    EXPECT_EQ(run("juggle").exitCode, 2);
    const Outcome unknown = run("plan --hand a --object b --colour red");
    EXPECT_EQ(unknown.exitCode, 2);
    EXPECT_THAT(unknown.err, HasSubstr("--colour"));
    const Outcome missing = run("plan --object b");
    EXPECT_EQ(missing.exitCode, 2);
    EXPECT_THAT(missing.err, HasSubstr("--hand"));
    EXPECT_EQ(run("plan --hand a --object b -n 0").exitCode, 2);
    EXPECT_EQ(run("plan --hand a --object b --friction -1").exitCode, 2);
}

TEST_F(GraspProgram, NumbersThatMakeNoSenseExitWith2AndAreNamed)
{
    struct Case
    {
        const char* verb;
        const char* option;
        const char* value;
    };
    for (const Case& c : {Case{"plan", "--min-epsilon", "nan"},
                          Case{"plan", "--min-epsilon", "-0.1"},
                          Case{"plan", "--friction", "nan"},
                          Case{"plan", "--friction", "inf"},
                          Case{"plan", "--object-scale", "nan"},
                          Case{"plan", "--object-scale", "0"},
                          Case{"plan", "--seed", "-1"},
                          Case{"plan", "--seed", "1.5"},
                          Case{"plan", "--candidates", "many"},
                          Case{"plan", "--jobs", "-3"},
                          Case{"plan", "--cone-edges", "nan"},
                          Case{"plan", "--pictures", "-1"},
                          Case{"plan", "--models", "-1"},
                          Case{"plan", "--models", "100"},
                          Case{"plan", "--seed", "18446744073709551616"},
                          Case{"trial", "--seed", "-1"},
                          Case{"trial", "--seed", "18446744073709551616"},
                          Case{"check", "--max-gap", "nan"},
                          Case{"check", "--max-gap", "-1"}})
    {
        const std::string input =
            std::string(c.verb) != "plan" ? " file.jsonl " : " --hand a --object b ";
        const Outcome refused = run(c.verb + input + c.option + " " + c.value);
        EXPECT_EQ(refused.exitCode, 2) << c.verb << ' ' << c.option << ' ' << c.value;
        EXPECT_THAT(refused.err, HasSubstr(c.option)) << c.value;
        EXPECT_THAT(refused.err, HasSubstr(c.value)) << c.option;
    }
    // The ends of a range belong to it.
    EXPECT_EQ(run("check file.jsonl --max-gap 0").exitCode, 3);
    EXPECT_EQ(run("plan --hand a --object b --seed 18446744073709551615").exitCode, 3);
}

TEST_F(GraspProgram, UnknownNamesExitWith3AndListTheKnownOnes)
{
    const Outcome hand = run("plan --hand left_foot --object '" + m_ball.string() + "'");
    EXPECT_EQ(hand.exitCode, 3);
    EXPECT_THAT(hand.err, HasSubstr("left_foot"));
    EXPECT_THAT(hand.err, HasSubstr("anthropomorphic_hand"));
    const Outcome object = run("plan --hand three_finger_gripper --object unicorn");
    EXPECT_EQ(object.exitCode, 3);
    EXPECT_THAT(object.err, HasSubstr("unicorn"));
    const Outcome folder = run("hand '" + m_folder.string() + "'");
    EXPECT_EQ(folder.exitCode, 3);
    EXPECT_THAT(folder.err, HasSubstr("is a folder"));
}

TEST_F(GraspProgram, PlansWritesAndChecks)
{
    const fs::path out = m_folder / "out";
    const Outcome planned = plan(out);
    EXPECT_EQ(planned.exitCode, 0) << planned.err;
    EXPECT_THAT(planned.out, HasSubstr("force closures"));
    EXPECT_THAT(
        filesIn(out),
        ElementsAre(
            "grasp_01.glb", "grasp_01.png", "grasps.isaac.yaml", "grasps.jsonl", "report.html"));
    for (const std::string& name : filesIn(out))
    {
        EXPECT_THAT(planned.out, HasSubstr((out / name).string()));
    }
    const Outcome checked = run("check '" + (out / "grasps.jsonl").string() + "'");
    EXPECT_EQ(checked.exitCode, 0) << checked.out << checked.err;
    EXPECT_THAT(checked.out, HasSubstr("0 of them penetrate"));
}

TEST_F(GraspProgram, ModelsAreCountedApartFromPicturesAndEarlierOnesGo)
{
    const fs::path out = m_folder / "out";
    ASSERT_EQ(plan(out, "-q --models 2").exitCode, 0);
    EXPECT_THAT(filesIn(out),
                ElementsAre("grasp_01.glb",
                            "grasp_01.png",
                            "grasp_02.glb",
                            "grasps.isaac.yaml",
                            "grasps.jsonl",
                            "report.html"));
    EXPECT_EQ(contentOf(out / "grasp_02.glb").substr(0, 4), "glTF");
    ASSERT_EQ(plan(out, "-q --models 0").exitCode, 0);
    EXPECT_THAT(filesIn(out),
                ElementsAre("grasp_01.png", "grasps.isaac.yaml", "grasps.jsonl", "report.html"));
}

TEST_F(GraspProgram, ResultDoesNotDependOnJobs)
{
    EXPECT_EQ(plan(m_folder / "one", "-q --jobs 1").exitCode, 0);
    EXPECT_EQ(plan(m_folder / "two", "-q --jobs 2").exitCode, 0);
    const std::string one = contentOf(m_folder / "one" / "grasps.jsonl");
    EXPECT_FALSE(one.empty());
    EXPECT_EQ(one, contentOf(m_folder / "two" / "grasps.jsonl"));
}

TEST_F(GraspProgram, FingersCloseInTheOrderThatIsAskedFor)
{
    const auto recordsOf = [&](const std::string& fingers, const std::string& key)
    {
        const fs::path out = m_folder / fingers;
        EXPECT_EQ(plan(out, "-q --fingers " + fingers).exitCode, 0) << fingers;
        const std::string records = contentOf(out / "grasps.jsonl");
        EXPECT_THAT(records, HasSubstr(key));
        EXPECT_EQ(run("check '" + (out / "grasps.jsonl").string() + "'").exitCode, 0);
        return records.substr(records.find("\"stops\":"), 200);
    };
    const std::string together =
        recordsOf("together", "\"closing_order\":\"together\",\"first_fingers\":[]");
    const std::string inTurns =
        recordsOf("one-by-one", "\"closing_order\":\"one-by-one\",\"first_fingers\":[]");
    const std::string named = recordsOf("finger_3,finger_2",
                                        "\"closing_order\":\"one-by-one\","
                                        "\"first_fingers\":[\"finger_3\",\"finger_2\"]");
    EXPECT_NE(together, inTurns);
    EXPECT_NE(named, inTurns);
    const fs::path slow = m_folder / "slow";
    EXPECT_EQ(plan(slow, "-q --closing-speeds finger_1_proximal_joint=0.5").exitCode, 0);
    EXPECT_THAT(contentOf(slow / "grasps.jsonl"),
                HasSubstr("\"closing_speeds\":[[\"finger_1_proximal_joint\",0.5]]"));
    EXPECT_EQ(run("check '" + (slow / "grasps.jsonl").string() + "'").exitCode, 0);
    const Outcome speed = plan(m_folder / "out", "--closing-speeds finger_1_jont=2");
    EXPECT_EQ(speed.exitCode, 3);
    EXPECT_THAT(speed.err, HasSubstr("no joint \"finger_1_jont\" closes by itself: did you mean"));
    EXPECT_EQ(plan(m_folder / "out", "--closing-speeds finger_1_proximal_joint=fast").exitCode, 2);
    const Outcome unknown = plan(m_folder / "out", "--fingers finger_2,fingr_1");
    EXPECT_EQ(unknown.exitCode, 3);
    EXPECT_THAT(unknown.err, HasSubstr("--fingers: no finger \"fingr_1\": did you mean finger_1?"));
    EXPECT_FALSE(fs::exists(m_folder / "out"));
}

TEST_F(GraspProgram, QuietPlansSayNothingOnStderr)
{
    EXPECT_EQ(plan(m_folder / "out", "-q").err, "");
}

TEST_F(GraspProgram, ExitsWith1WhenNothingIsFound)
{
    // Nothing holds a ball as large as a house.
    const Outcome planned = plan(m_folder / "out", "--object-scale 100");
    EXPECT_EQ(planned.exitCode, 1) << planned.err;
    EXPECT_THAT(planned.out, HasSubstr("0 of 4 candidates"));
    EXPECT_THAT(planned.out, HasSubstr("rejected: "));
}

TEST_F(GraspProgram, BadInputLeavesEarlierOutputAlone)
{
    const fs::path out = m_folder / "out";
    ASSERT_EQ(plan(out, "-q").exitCode, 0);
    const std::string before = contentOf(out / "grasps.jsonl");
    std::ofstream(m_ball) << "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n";
    const Outcome broken = plan(out, "-q");
    EXPECT_EQ(broken.exitCode, 3);
    EXPECT_THAT(broken.err, HasSubstr("ball.obj"));
    EXPECT_EQ(contentOf(out / "grasps.jsonl"), before);
}

TEST_F(GraspProgram, AFolderThatCannotBeWrittenExitsWith3)
{
    std::ofstream(m_folder / "file") << "in the way";
    const Outcome planned = plan(m_folder / "file" / "out", "-q");
    EXPECT_EQ(planned.exitCode, 3);
    EXPECT_THAT(planned.err, HasSubstr("cannot be written"));
    const Outcome shown =
        run("hand show parallel_gripper -o '" + (m_folder / "file" / "out").string() + "'");
    EXPECT_EQ(shown.exitCode, 3);
    EXPECT_THAT(shown.err, HasSubstr("name another one with --output"));
    EXPECT_EQ(shown.out, "");
    EXPECT_EQ(contentOf(m_folder / "file"), "in the way");
}

TEST_F(GraspProgram, OptionsThatChangeNothingAreRefused)
{
    for (const char* option : {"--tried 3", "--refine 1", "--brief"})
    {
        const Outcome planned = plan(m_folder / "out", std::string("-q ") + option);
        EXPECT_EQ(planned.exitCode, 2) << option;
        EXPECT_THAT(planned.err, HasSubstr("--trial")) << option;
        EXPECT_FALSE(fs::exists(m_folder / "out")) << option;
    }
    const Outcome tried = run("trial none.jsonl --protocol six --pulls 3");
    EXPECT_EQ(tried.exitCode, 2);
    EXPECT_THAT(tried.err, HasSubstr("--pulls"));
}

TEST_F(GraspProgram, AListOfTrialsLacksNoName)
{
    const Outcome planned = plan(m_folder / "out", "-q --trial lift,,six");
    EXPECT_EQ(planned.exitCode, 3);
    EXPECT_THAT(planned.err, HasSubstr("--trial lift,,six: a name is missing"));
    const Outcome twice = plan(m_folder / "out", "-q --trial six,lift --trial six");
    EXPECT_EQ(twice.exitCode, 3);
    EXPECT_THAT(twice.err, HasSubstr("--trial six: two protocols are called \"six\""));
}

TEST_F(GraspProgram, CheckNoticesWhatWasTamperedWith)
{
    const fs::path out = m_folder / "out";
    ASSERT_EQ(plan(out, "-q").exitCode, 0);
    const fs::path file = out / "grasps.jsonl";
    std::string text = contentOf(file);
    // The best hand pose, moved a centimetre: something must penetrate or lose its contacts.
    const std::string key = "\"hand_pose_in_object\":{\"position_m\":[";
    const std::size_t place = text.find(key) + key.size();
    text.replace(place, text.find(',', place) - place, "0.01");
    std::ofstream(file) << text;
    const Outcome checked = run("check '" + file.string() + "'");
    EXPECT_EQ(checked.exitCode, 1) << checked.out;
    writeObj(makeSphere(0.031, 3), m_ball);
    const Outcome changed = run("check '" + file.string() + "'");
    EXPECT_EQ(changed.exitCode, 3);
    EXPECT_THAT(changed.err, HasSubstr("content hash"));
    std::ofstream(file) << "not json\n";
    const Outcome broken = run("check '" + file.string() + "'");
    EXPECT_EQ(broken.exitCode, 3);
    EXPECT_THAT(broken.err, HasSubstr("grasps.jsonl:1: "));
}

TEST_F(GraspProgram, ShowsAHand)
{
    const Outcome shown = run("hand anthropomorphic_hand");
    EXPECT_EQ(shown.exitCode, 0) << shown.err;
    for (const char* word : {"thumb", "closes to its upper limit", "grasp frame", "pairs of links"})
    {
        EXPECT_THAT(shown.out, HasSubstr(word));
    }
    // Its two jaws state 60 N each, and one motor moves both.
    const Outcome coupled = run("hand parallel_gripper");
    EXPECT_THAT(coupled.out, ::testing::ContainsRegex("left_jaw_joint .* 60 +120 +closes"));
    EXPECT_THAT(coupled.out, ::testing::ContainsRegex("right_jaw_joint .* 60 +- +follows"));
}

TEST_F(GraspProgram, WhatTheUrdfLeavesOutIsSaidEverywhere)
{
    const fs::path hand = m_folder / "bare.urdf";
    std::ofstream(hand) << bareGripper();
    const Outcome shown = run("hand '" + hand.string() + "'");
    EXPECT_EQ(shown.exitCode, 0) << shown.err;
    const std::string planOf = "plan --hand '" + hand.string() + "' --object '" + m_ball.string() +
                               "' -n 2 --pictures 0 -o '" + (m_folder / "out").string() + "'";
    const Outcome planned = run(planOf);
    EXPECT_THAT(planned.exitCode, ::testing::AnyOf(0, 1)) << planned.err;
    const std::string report = contentOf(m_folder / "out" / "report.html");
    for (const std::string& text : {shown.out, planned.err, report})
    {
        EXPECT_THAT(text, HasSubstr("effort limit 0 or missing: left_joint, right_joint"));
        // A squeeze assumes efforts that fingers have.
        EXPECT_THAT(text, ::testing::Not(HasSubstr("effort limit 0 or missing, taken")));
        EXPECT_THAT(text, HasSubstr("inertial"));
        EXPECT_THAT(text, HasSubstr("no SRDF found"));
    }
    EXPECT_THAT(shown.out, HasSubstr("no SRDF is used"));
    EXPECT_THAT(shown.out, ::testing::ContainsRegex("left_joint .* none +1[*] "));
    EXPECT_THAT(contentOf(m_folder / "out" / "grasps.jsonl"), HasSubstr("\"srdf\":null"));
    EXPECT_EQ(run(planOf + " -q").err, "");
}

TEST_F(GraspProgram, SaysWhichSrdfWasUsed)
{
    const std::string expected = "/robots/three_finger_gripper/three_finger_gripper.srdf";
    EXPECT_THAT(run("hand three_finger_gripper").out, HasSubstr(expected));
    const fs::path out = m_folder / "out";
    ASSERT_EQ(plan(out, "-q").exitCode, 0);
    EXPECT_THAT(contentOf(out / "report.html"), HasSubstr(expected));
    EXPECT_THAT(contentOf(out / "grasps.jsonl"), HasSubstr(expected + "\",\"root_link\""));
}

TEST_F(GraspProgram, RepairsOfAMeshAreSaidOnce)
{
    // A triangle without area.
    std::ofstream(m_ball, std::ios::app) << "f 1 1 2\n";
    const Outcome planned = plan(m_folder / "out");
    const std::string word = "degenerate";
    const std::size_t first = planned.err.find(word);
    ASSERT_NE(first, std::string::npos) << planned.err;
    EXPECT_EQ(planned.err.find(word, first + 1), std::string::npos) << planned.err;
}
}  // namespace
}  // namespace bullet_ccd::tools
