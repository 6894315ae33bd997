// Options from a file, --config: the same as on the command line, or an error that names the line.
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/run_program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class GraspConfig : public ::testing::Test
{
protected:
    void SetUp() override { writeObj(makeSphere(0.03, 2), m_ball); }

    [[nodiscard]] static Outcome run(const std::string& arguments)
    {
        return runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " " + arguments);
    }
    /// Runs a verb with the text as its file, which --print-config does not get to plan.
    [[nodiscard]] Outcome runWith(const std::string& verb,
                                  const std::string& config,
                                  const std::string& more = "--print-config") const
    {
        std::ofstream(m_config) << config;
        return run(verb + " --config '" + m_config.string() + "' " + more);
    }
    [[nodiscard]] std::string at(int line) const
    {
        return m_config.string() + ":" + std::to_string(line) + ": ";
    }

    tests::TempFolder m_temp;
    fs::path m_folder = m_temp.path();
    fs::path m_ball = m_folder / "ball.obj";
    fs::path m_config = m_folder / "plan.yaml";
};

TEST_F(GraspConfig, AFileGivesTheSameGraspsAsTheCommandLine)
{
    const std::string options = "--hand three_finger_gripper --object '" + m_ball.string() +
                                "' -n 3 --seed 7 --friction 0.7 --pictures 0 -q -o '";
    ASSERT_EQ(run("plan " + options + (m_folder / "a").string() + "'").exitCode, 0);
    const Outcome planned =
        runWith("plan",
                "hand: three_finger_gripper\nobject: \"" + m_ball.string() +
                    "\"\ncandidates: 3\nseed: 7  # comment\nfriction: 0.7\npictures: 0\n"
                    "quiet: true\noutput: " +
                    (m_folder / "b").string() + "\n",
                "");
    EXPECT_EQ(planned.exitCode, 0) << planned.err;
    EXPECT_EQ(planned.err, "");
    const std::string records = contentOf(m_folder / "a" / "grasps.jsonl");
    EXPECT_THAT(records, HasSubstr("\"seed\":7"));
    EXPECT_EQ(records, contentOf(m_folder / "b" / "grasps.jsonl"));
}

TEST_F(GraspConfig, TheCommandLineWins)
{
    const std::string config = "hand: a\nobject: b\nscene: [one.obj, two.obj]\nquiet: true\n";
    const Outcome file = runWith("plan", config);
    EXPECT_EQ(file.exitCode, 0) << file.err;
    EXPECT_THAT(file.out, HasSubstr("hand: a\nobject: b\n"));
    EXPECT_THAT(file.out, HasSubstr("scene: [one.obj, two.obj]\n"));
    EXPECT_THAT(file.out, HasSubstr("quiet: true\n"));
    const Outcome both =
        runWith("plan", config, "--print-config --hand c --scene three.obj --quiet=false -n 9");
    EXPECT_THAT(both.out, HasSubstr("hand: c\nobject: b\n"));
    EXPECT_THAT(both.out, HasSubstr("scene: [three.obj]\n"));
    EXPECT_THAT(both.out, HasSubstr("quiet: false\n"));
    EXPECT_THAT(both.out, HasSubstr("candidates: 9\n"));
}

TEST_F(GraspConfig, WhatIsPrintedCanBeFedBackForEveryVerb)
{
    for (const std::string arguments :
         {"plan --hand a --object b --scene 's p.yaml' --engine simulated --models 3",
          "close --hand a --object 'null' --pose 0 0 -1e-3 1 0 0 0 --approach 0 0 1 .1 --json",
          "check f.jsonl --max-gap 1e-3",
          "force f.jsonl --mass 0.4 --gravity 0 1 0 --effort 5 --effort j=2 --objective firm",
          "quality f.jsonl --model soft --rank 1 --rank 3",
          "hand h.urdf",
          "hand check h.urdf --samples 50"})
    {
        const std::size_t verb = arguments.find(arguments.starts_with("hand check") ? " h." : " ");
        const Outcome first = run(arguments + " --print-config");
        ASSERT_EQ(first.exitCode, 0) << arguments << first.err;
        EXPECT_EQ(first.err, "");
        const Outcome second = runWith(arguments.substr(0, verb), first.out);
        EXPECT_EQ(second.exitCode, 0) << arguments << second.err;
        EXPECT_EQ(first.out, second.out);
    }
    EXPECT_THAT(run("plan --hand a --object b --engine simulated --print-config").out,
                HasSubstr("engine: simulated"));
}

TEST_F(GraspConfig, WrongFilesExitWith3AndNameLineKeyAndRemedy)
{
    struct Case
    {
        const char* config;
        int line;
        const char* complaint;
    };
    for (const Case& c :
         {Case{"hand: a\n\ncandidats: 9\n", 3, "candidats: no such key: did you mean candidates?"},
          Case{"config: a\n", 1, "config: no such key: did you mean "},
          Case{"n: 9\n", 1, "n: no such key"},
          Case{"seed: 1\nfriction: -1\n", 2, "--friction: -1 is not a number from 0.001 to 10"},
          Case{"candidates: many\n", 1, "--candidates: many is not a number from 1 to 1000000"},
          Case{"engine: warp\n", 1, "--engine: "},
          Case{"seed: 1\nseed: 2\n", 2, "seed: there twice: drop one"},
          Case{"seed: [1, 2]\n", 1, "seed: 2 values where 1 is needed: write one"},
          Case{"scene: []\n", 1, "scene: 0 values where at least 1 are needed: write"},
          Case{"seed:\n", 1, "seed: no value: write one or drop the key"},
          Case{"scene:\n  - a.obj\n  - {mesh: b}\n", 3, "scene: no value"},
          Case{"quiet: loud\n", 1, "quiet: neither true nor false"},
          Case{"- hand\n", 1, "not a map: write KEY: VALUE"},
          Case{"hand: [a\nseed: 2\n", 2, "not YAML: "}})
    {
        const Outcome refused = runWith("plan", c.config);
        EXPECT_EQ(refused.exitCode, 3) << c.config;
        EXPECT_THAT(refused.err, HasSubstr("grasp: " + at(c.line) + c.complaint)) << c.config;
        EXPECT_EQ(refused.out, "") << c.config;
    }
    EXPECT_THAT(runWith("close", "pose: [1, 2, 3]\n").err,
                HasSubstr("pose: 3 values where 7 are needed: write a list"));
    const Outcome missing = run("plan --config '" + (m_folder / "no.yaml").string() + "'");
    EXPECT_EQ(missing.exitCode, 3);
    EXPECT_THAT(missing.err, HasSubstr("no.yaml: cannot be read: give a YAML file"));
}

TEST_F(GraspConfig, RequiredOptionsAreStillRequired)
{
    const Outcome refused = runWith("plan", "hand: a\n", "");
    EXPECT_EQ(refused.exitCode, 2);
    EXPECT_THAT(refused.err, HasSubstr("--object is required"));
    // Nothing but comments is a file without options.
    EXPECT_EQ(runWith("plan", "# nothing\n").exitCode, 0);
    EXPECT_THAT(runWith("plan", "# nothing\n").out, Not(HasSubstr("hand:")));
}
}  // namespace
}  // namespace bullet_ccd::tools
