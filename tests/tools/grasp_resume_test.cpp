// `grasp plan` stopped by a time limit or killed, and gone on with: it ends as if nothing had been.
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
using ::testing::HasSubstr;
using ::testing::Not;

/// Over before the second candidate.
constexpr const char* kNoTime = " --time-limit 1e-9";

class GraspResume : public ::testing::Test
{
protected:
    void SetUp() override { writeObj(makeSphere(0.03, 2), m_ball); }

    [[nodiscard]] std::string command(const fs::path& folder, const std::string& more) const
    {
        return std::string(BULLET_CCD_GRASP_PROGRAM) +
               " plan --hand three_finger_gripper --object '" + m_ball.string() +
               "' --pictures 0 -o '" + folder.string() + "' " + more;
    }
    [[nodiscard]] Outcome plan(const fs::path& folder, const std::string& more) const
    {
        return runProgram(command(folder, more));
    }
    static std::ptrdiff_t lines(const fs::path& file)
    {
        const std::string text = contentOf(file);
        return std::count(text.begin(), text.end(), '\n');
    }
    /// Both folders hold the same results, and nothing else.
    static void expectSameFiles(const fs::path& a, const fs::path& b)
    {
        for (const fs::path& folder : {a, b})
        {
            EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 3) << folder;
        }
        for (const char* name : {"grasps.jsonl", "grasps.isaac.yaml", "report.html"})
        {
            EXPECT_FALSE(contentOf(a / name).empty());
            EXPECT_EQ(contentOf(a / name), contentOf(b / name));
        }
    }

    tests::TempFolder m_temp;
    fs::path m_folder = m_temp.path();
    fs::path m_ball = m_folder / "ball.obj";
    fs::path m_out = m_folder / "out";
    fs::path m_journal = m_out / "grasps.journal.jsonl";
};

TEST_F(GraspResume, ATimeLimitIsSaidAndResumingGetsToTheSameEnd)
{
    const Outcome stopped = plan(m_out, std::string("-n 5") + kNoTime);
    EXPECT_THAT(stopped.out,
                HasSubstr("time limit reached: 1 of 5 candidates tried, not 1 to 4; --resume"));
    EXPECT_THAT(stopped.out, HasSubstr(m_journal.string()));
    EXPECT_EQ(lines(m_journal), 1);
    EXPECT_EQ(lines(m_out / "grasps.jsonl"), 1);
    const Outcome further = plan(m_out, std::string("-n 5 --resume") + kNoTime);
    EXPECT_THAT(further.err, HasSubstr("1 of 5 candidates were tried before"));
    EXPECT_THAT(further.out, HasSubstr("2 of 5 candidates tried, not 2 to 4"));
    const Outcome ended = plan(m_out, "-n 5 --resume --jobs 2 --time-limit 1e6");
    EXPECT_EQ(ended.exitCode, 0) << ended.err;
    EXPECT_THAT(ended.out, Not(HasSubstr("time limit")));
    ASSERT_EQ(plan(m_folder / "whole", "-n 5 -q").exitCode, 0);
    expectSameFiles(m_out, m_folder / "whole");
}

TEST_F(GraspResume, AKilledRunLosesWhatItWasWorkingOnAlone)
{
    constexpr int kCandidates = 100;
    const std::string options = "-n " + std::to_string(kCandidates) + " -q --volumes 1";
    const std::string wait = "while [ \"$(cat '" + m_journal.string() +
                             "' 2>/dev/null | wc -l)\" -lt 5 ]; do sleep 0.01; done";
    const Outcome killed = runProgram("{ " + command(m_out, options) + " >/dev/null & " + wait +
                                      "; kill -9 $!; wait $!; }");
    ASSERT_EQ(killed.exitCode, 128 + 9) << killed.err;
    const std::ptrdiff_t recorded = lines(m_journal);
    ASSERT_GE(recorded, 5);
    ASSERT_LT(recorded, kCandidates);
    EXPECT_FALSE(fs::exists(m_out / "grasps.jsonl"));
    // Worse than that: killed while it wrote.
    std::ofstream(m_journal, std::ios::app) << contentOf(m_journal).substr(0, 1000);
    const Outcome ended = plan(m_out, "-n 100 --volumes 1 --resume");
    EXPECT_EQ(ended.exitCode, 0) << ended.err;
    EXPECT_THAT(ended.err,
                HasSubstr(std::to_string(recorded) + " of 100 candidates were tried before"));
    ASSERT_EQ(plan(m_folder / "whole", options).exitCode, 0);
    expectSameFiles(m_out, m_folder / "whole");
}

TEST_F(GraspResume, AnInterruptedRunWritesWhatItFoundAndCanBeGoneOnWith)
{
    const std::string options = "-n 100 -q --volumes 1";
    const std::string wait = "while [ \"$(cat '" + m_journal.string() +
                             "' 2>/dev/null | wc -l)\" -lt 5 ]; do sleep 0.01; done";
    const Outcome stopped = runProgram("{ env --default-signal=INT " + command(m_out, options) +
                                       " & " + wait + "; kill -INT $!; wait $!; }");
    EXPECT_EQ(stopped.exitCode, 130) << stopped.err;
    const std::ptrdiff_t recorded = lines(m_journal);
    ASSERT_GE(recorded, 5);
    ASSERT_LT(recorded, 100);
    EXPECT_EQ(lines(m_out / "grasps.jsonl"), recorded);
    EXPECT_THAT(stopped.out,
                HasSubstr("interrupted: " + std::to_string(recorded) + " of 100 candidates tried"));
    EXPECT_THAT(stopped.err,
                HasSubstr("grasp plan: stopped after " + std::to_string(recorded) +
                          " of 100 candidates\n"));
    EXPECT_EQ(plan(m_out, "-n 100 --volumes 1 --resume").exitCode, 0);
    ASSERT_EQ(plan(m_folder / "whole", options).exitCode, 0);
    expectSameFiles(m_out, m_folder / "whole");
}

TEST_F(GraspResume, OtherVerbsStopAtTheirTimeLimits)
{
    ASSERT_EQ(plan(m_out, "-n 4 -q").exitCode, 0);
    const std::string file = " '" + (m_out / "grasps.jsonl").string() + "'";
    for (const std::string verb : {"check", "force", "quality"})
    {
        const Outcome stopped =
            runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " " + verb + file + kNoTime);
        EXPECT_EQ(stopped.exitCode, 1) << verb;
        EXPECT_THAT(stopped.err, HasSubstr("grasp " + verb + ": stopped after 0 of ")) << verb;
    }
}

TEST_F(GraspResume, RecordsOfAnotherPlanAreRefusedAndNamed)
{
    const std::string stop = std::string("-n 4 -q") + kNoTime;
    ASSERT_THAT(plan(m_out, stop).exitCode, ::testing::AnyOf(0, 1));
    const std::string journal = contentOf(m_journal);
    struct Case
    {
        const char* options;
        const char* complaint;
    };
    for (const Case& c : {Case{"-n 4 --seed 2", "seed 1, now 2"},
                          Case{"-n 7", "candidates 4, now 7"},
                          Case{"-n 4 --friction 0.25", "friction 0.5, now 0.25"},
                          Case{"-n 4 --cone-edges 4", "cone edges 0, now 4"},
                          Case{"-n 4 --min-epsilon 0.1", "least epsilon 0.005, now 0.1"},
                          Case{"-n 4 --reach 2", "reach 0, now from mixed"},
                          Case{"-n 4 --fingers finger_2", "fingers together, now finger_2"},
                          Case{"-n 4 --engine simulated", "engine kinematic, now simulated"},
                          Case{"-n 4 --object-scale 2", "object with content hash "},
                          Case{"-n 4 --hand parallel_gripper", "hand with content hash "}})
    {
        std::string arguments = command(m_out, std::string("-q --resume ") + c.options);
        if (std::string(c.options).find("--hand") != std::string::npos)
        {
            const std::string shipped = "--hand three_finger_gripper ";
            arguments.erase(arguments.find(shipped), shipped.size());
        }
        const Outcome refused = runProgram(arguments);
        EXPECT_EQ(refused.exitCode, 3) << c.options << refused.out;
        EXPECT_THAT(refused.err, HasSubstr(m_journal.string() + ": the stopped run had "));
        EXPECT_THAT(refused.err, HasSubstr(c.complaint));
        EXPECT_THAT(refused.err, HasSubstr("or plan afresh without --resume"));
        EXPECT_EQ(contentOf(m_journal), journal) << c.options;
    }
    const Outcome scene = plan(m_out, "-n 4 -q --resume --scene '" + m_ball.string() + "'");
    EXPECT_THAT(scene.err, HasSubstr("obstacles with content hash none, now "));
    // Options that no candidate depends on may change.
    EXPECT_EQ(plan(m_out, "-n 4 -q --resume --models 1 --volumes 9 -j 2").exitCode, 0);
    EXPECT_FALSE(fs::exists(m_journal));
}

TEST_F(GraspResume, WithoutItTheJournalOfAStoppedRunIsSetAside)
{
    ASSERT_THAT(plan(m_out, std::string("-n 3 -q") + kNoTime).exitCode, ::testing::AnyOf(0, 1));
    const std::string journal = contentOf(m_journal);
    const Outcome afresh = plan(m_out, "-n 2");
    EXPECT_THAT(afresh.err, HasSubstr("now grasps.journal.jsonl.old"));
    EXPECT_EQ(contentOf(m_journal.string() + ".old"), journal);
    EXPECT_FALSE(fs::exists(m_journal));
    const Outcome nothing = plan(m_out, "-n 2 --resume");
    EXPECT_EQ(nothing.exitCode, afresh.exitCode);
    EXPECT_THAT(nothing.err, HasSubstr("no stopped run here: starting at the first candidate"));
}

TEST_F(GraspResume, ADamagedJournalAndOneInUseAreErrors)
{
    ASSERT_THAT(plan(m_out, std::string("-n 3 -q") + kNoTime).exitCode, ::testing::AnyOf(0, 1));
    const std::string record = contentOf(m_journal);
    std::ofstream(m_journal) << record << "garbage\n";
    const Outcome damaged = plan(m_out, "-n 3 -q --resume");
    EXPECT_EQ(damaged.exitCode, 3);
    EXPECT_THAT(damaged.err, HasSubstr(m_journal.string() + ":2: not a JSON record"));
    std::ofstream(m_journal) << record << record;
    const Outcome twice = plan(m_out, "-n 3 -q --resume");
    EXPECT_EQ(twice.exitCode, 3);
    EXPECT_THAT(twice.err, HasSubstr("candidate 0 is there twice"));
    const Outcome used =
        runProgram("flock '" + m_journal.string() + "' " + command(m_out, "-n 3 -q --resume"));
    EXPECT_EQ(used.exitCode, 3);
    EXPECT_THAT(used.err, HasSubstr("another run is writing it"));
    EXPECT_EQ(contentOf(m_journal), record + record);
}
}  // namespace
}  // namespace bullet_ccd::tools
