// Runs the program as a user does and looks at exit codes, messages and files.
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/run_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <gmock/gmock.h>
#include <string>

namespace bullet_ccd::benchmarks
{
namespace
{
namespace fs = std::filesystem;
using ::testing::HasSubstr;
using tools::contentOf;
using tools::Outcome;

class BenchGrasps : public ::testing::Test
{
protected:
    void SetUp() override { writeObj(makeSphere(0.03, 3), m_ball); }

    [[nodiscard]] static Outcome run(const std::string& arguments)
    {
        return tools::runProgram(std::string(BULLET_CCD_BENCH_GRASPS) + " " + arguments);
    }

    tests::TempFolder m_temp;
    fs::path m_folder = m_temp.path();
    fs::path m_ball = m_folder / "ball.obj";
};

TEST_F(BenchGrasps, TablesEveryPair)
{
    const fs::path out = m_folder / "out";
    const Outcome table =
        run("table --hand three_finger_gripper --hand parallel_gripper --object '" +
            m_ball.string() + "' -n 3 -q -o '" + out.string() + "'");
    EXPECT_EQ(table.exitCode, 0) << table.err;
    EXPECT_THAT(table.out, HasSubstr("postures penetrate"));
    EXPECT_TRUE(fs::exists(out / "table.md"));
    EXPECT_TRUE(fs::exists(out / "parallel_gripper_ball.jsonl"));
    EXPECT_THAT(contentOf(out / "parallel_gripper_ball.jsonl"),
                HasSubstr("parallel_gripper.srdf\",\"root_link\""));
    const std::string csv = contentOf(out / "table.csv");
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
}

TEST_F(BenchGrasps, ATableThatFailsACriterionExitsWith1)
{
    // One of two objects can be held: less than two thirds.
    const fs::path house = m_folder / "house.obj";
    writeObj(makeSphere(3.0, 3), house);
    const std::string table =
        "table --hand three_finger_gripper --object '" + m_ball.string() + "' -n 3 -q";
    const Outcome good = run(table);
    EXPECT_EQ(good.exitCode, 0) << good.out << good.err;
    EXPECT_THAT(good.out, ::testing::Not(HasSubstr("FAIL")));
    const Outcome bad = run(table + " --object '" + house.string() + "'");
    EXPECT_EQ(bad.exitCode, 1) << bad.out << bad.err;
    EXPECT_THAT(bad.out, HasSubstr("force closure on 1 of 2 objects"));
    EXPECT_THAT(bad.out, HasSubstr("FAIL  0 of 1 hands"));
    EXPECT_THAT(run("table --help").out, HasSubstr("no contact is wider than 0.2 mm"));
}

TEST_F(BenchGrasps, JudgesClosingsAndGoesOnWhereItWas)
{
    const std::string closing = "closing --hand parallel_gripper --object '" + m_ball.string() +
                                "' -n 4 -o '" + (m_folder / "rows.json").string() + "'";
    const Outcome first = run(closing);
    EXPECT_EQ(first.exitCode, 0) << first.out << first.err;
    EXPECT_THAT(first.out, HasSubstr("pass"));
    const std::string rows = contentOf(m_folder / "rows.json");
    EXPECT_THAT(rows, HasSubstr("\"hand\": \"parallel_gripper\""));
    const Outcome again = run(closing);
    EXPECT_EQ(again.exitCode, 2);
    EXPECT_THAT(again.err, HasSubstr("--resume goes on with it"));
    EXPECT_EQ(run(closing + " --resume").out, first.out);
    EXPECT_EQ(contentOf(m_folder / "rows.json"), rows);
    EXPECT_THAT(run(closing + " --resume --seed 5").err, HasSubstr("belongs to another run"));
}

TEST_F(BenchGrasps, CountsForceClosures)
{
    const Outcome plans = run("planning --hand three_finger_gripper --object '" + m_ball.string() +
                              "' -n 3 -o '" + (m_folder / "rows.json").string() + "'");
    EXPECT_EQ(plans.exitCode, 0) << plans.out << plans.err;
    EXPECT_THAT(plans.out, HasSubstr("1 of 1 objects are held"));
}

TEST_F(BenchGrasps, HandsWithoutTheirSrdfMustHoldMost)
{
    const fs::path house = m_folder / "house.obj";
    writeObj(makeSphere(3.0, 3), house);
    const std::string thumbed = "thumbed --hand three_finger_gripper -n 4 --object '" +
                                m_ball.string() + "' -o '" + (m_folder / "rows.json").string() +
                                "'";
    const Outcome good = run(thumbed);
    EXPECT_EQ(good.exitCode, 0) << good.out << good.err;
    EXPECT_THAT(good.out, HasSubstr("three_finger_gripper, inferred"));
    EXPECT_THAT(good.out, HasSubstr("100.0 % force closures; 1 of 1 pairs held: pass"));
    const Outcome bad = run(thumbed + " --resume --object '" + house.string() + "'");
    EXPECT_EQ(bad.exitCode, 1) << bad.out << bad.err;
    EXPECT_THAT(bad.out, HasSubstr("50.0 % force closures; 1 of 2 pairs held: FAIL"));
}

TEST_F(BenchGrasps, NumbersThatMakeNoSenseExitWith2AndAreNamed)
{
    for (const std::string option : {"--friction", "--object-scale"})
    {
        const Outcome refused = run("table --hand a --object b " + option + " nan");
        EXPECT_EQ(refused.exitCode, 2);
        EXPECT_THAT(refused.err, HasSubstr(option));
    }
    EXPECT_THAT(run("closing --object b").err, HasSubstr("--hand"));
}

TEST_F(BenchGrasps, WhatIsPrintedCanBeFedBack)
{
    const Outcome first = run("table --hand a --hand b --object c -n 7 --print-config");
    ASSERT_EQ(first.exitCode, 0) << first.err;
    EXPECT_THAT(first.out, HasSubstr("hand: [a, b]\nobject: [c]\n"));
}

TEST_F(BenchGrasps, RunsWhereItsVerbsWereInTheProgramGrasp)
{
    const Outcome table = tools::runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) +
                                            " table --hand three_finger_gripper --object '" +
                                            m_ball.string() + "' -n 3 -q");
    EXPECT_EQ(table.exitCode, 0) << table.out << table.err;
    EXPECT_THAT(table.err, HasSubstr("bench_grasps"));
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
