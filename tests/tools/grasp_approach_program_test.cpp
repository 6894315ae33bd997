// `grasp plan` with options of approach, and `grasp close` along a path.
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/run_program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::HasSubstr;

class GraspApproach : public ::testing::Test
{
protected:
    void SetUp() override { writeObj(makeBox({0.02, 0.015, 0.015}), m_box); }

    [[nodiscard]] Outcome run(const std::string& verb, const std::string& more) const
    {
        return runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " " + verb +
                          " --hand parallel_gripper --object '" + m_box.string() + "' -q " + more);
    }
    /// Closes on the path that the file says.
    [[nodiscard]] Outcome close(const std::string& rows, const std::string& more = "") const
    {
        std::ofstream(m_path) << rows;
        return run("close", "--path '" + m_path.string() + "' " + more);
    }

    tests::TempFolder m_temp;
    fs::path m_box = m_temp.path() / "box.obj";
    fs::path m_path = m_temp.path() / "path.csv";
};

TEST_F(GraspApproach, PlansKeepToItsOptionsAndRecordThem)
{
    const fs::path out = m_temp.path() / "out";
    const Outcome planned = run("plan",
                                "-n 6 --pictures 0 -o '" + out.string() +
                                    "' --approach-from boxes --table-top --max-tilt 0.5 --up 0 -2 0"
                                    " --standoff 0.125 --reach 3 --roll -0.25 0.25");
    EXPECT_NE(planned.exitCode, 2) << planned.err;
    std::istringstream lines(contentOf(out / "grasps.jsonl"));
    int records = 0;
    for (std::string line; std::getline(lines, line); ++records)
    {
        const Json record = Json::parse(line);
        // Straight down, where down is +y.
        EXPECT_NEAR(record["approach"]["direction"][1].get<double>(), 1.0, 1e-9);
        EXPECT_EQ(record["plan"]["approach"],
                  Json({{"from", "boxes"},
                        {"table_top", true},
                        {"up", {0.0, -2.0, 0.0}},
                        {"max_tilt_rad", 0.5},
                        {"standoff_m", 0.125},
                        {"reach_m", 3.0},
                        {"roll_rad", {-0.25, 0.25}}}));
    }
    EXPECT_EQ(records, 6);
}

TEST_F(GraspApproach, PlansFromAboveKeepOutOfTheTable)
{
    // So low that jaws which close about its middle reach below it.
    writeObj(makeBox({0.03, 0.015, 0.004}), m_box);
    const fs::path protocol = m_temp.path() / "stand.yaml";
    std::ofstream(protocol) << "start: table\nphases:\n  - load: {seconds: 0.05}\n";
    const std::string out = (m_temp.path() / "out").string();
    const auto countOf = [&](const std::string& options, const std::string& words)
    {
        const Outcome planned = run("plan",
                                    "-n 40 --pictures 0 --mass 0.05 --min-epsilon 1e-3 -o '" + out +
                                        "' --trial '" + protocol.string() + "' " + options);
        EXPECT_NE(planned.exitCode, 2) << planned.err;
        const std::string records = contentOf(out + "/grasps.jsonl");
        int count = 0;
        for (auto at = records.find(words); at != std::string::npos;
             at = records.find(words, at + 1))
        {
            ++count;
        }
        return count;
    };
    const std::string refused = "the hand would be in the table";
    EXPECT_GT(countOf("", refused), 0);
    EXPECT_EQ(countOf("--table-top", refused), 0);
    EXPECT_GT(countOf("--table-top", "\"outcome\":\"held\""), 0);
    EXPECT_GT(countOf("--table-top", "obstacle in the way"), 0);
    // Too low for any jaw.
    writeObj(makeBox({0.03, 0.03, 5e-4}), m_box);
    EXPECT_THAT(run("plan", "-n 8 --table-top --pictures 0 -o '" + out + "'").out,
                HasSubstr("decrease --max-tilt"));
    const Outcome simulated = run("plan", "-n 1 --table-top --engine simulated -o '" + out + "'");
    EXPECT_EQ(simulated.exitCode, 3);
    EXPECT_THAT(simulated.err, HasSubstr("--table-top"));
}

TEST_F(GraspApproach, OptionsThatCannotBeExitWith2)
{
    for (const char* wrong : {"--approach-from moon",
                              "--max-tilt 4 --table-top",
                              "--max-tilt 1",
                              "--up 0 0 0",
                              "--up 0 1",
                              "--standoff -1",
                              "--reach nan",
                              "--roll 1",
                              "--roll 1 0.5"})
    {
        const Outcome planned = run("plan", wrong);
        EXPECT_EQ(planned.exitCode, 2) << wrong;
        EXPECT_THAT(planned.err,
                    HasSubstr(std::string(wrong).substr(0, std::string(wrong).find(' '))));
    }
}

TEST_F(GraspApproach, AStraightPathInTwoEndsWhereTheApproachDoes)
{
    const Outcome straight = run("close", "--json --pose 0 0 -0.33 1 0 0 0 --approach 0 0 1 0.5");
    const Outcome path = close(
        "# the box is ahead\n"
        "x,y,z,qw,qx,qy,qz\n"
        "0,0,-0.33,1,0,0,0\n\n"
        " 0, 0, -0.25, 1, 0, 0, 0\n"
        "0,0,0.17,1,0,0,0\n",
        "--json");
    EXPECT_EQ(path.exitCode, 0) << path.err;
    const Json a = Json::parse(straight.out);
    const Json b = Json::parse(path.out);
    const auto z = [](const Json& record)
    { return record["hand_pose_in_object"]["position_m"][2].get<double>(); };
    constexpr double kTolerance = 2e-5;
    EXPECT_NEAR(z(a), z(b), kTolerance);
    EXPECT_GT(z(b), -0.14);
    EXPECT_NEAR(b["approach"]["travel_to_contact_m"].get<double>(), z(b) + 0.33, 1e-9);
    EXPECT_NEAR(a["joints"]["left_jaw_joint"].get<double>(),
                b["joints"]["left_jaw_joint"].get<double>(),
                kTolerance);
}

TEST_F(GraspApproach, SaysHowFarThePathWasFollowed)
{
    const Outcome corner = close("0.3,0,-0.3,1,0,0,0\n0,0,-0.3,1,0,0,0\n0,0,0,1,0,0,0\n");
    EXPECT_EQ(corner.exitCode, 0) << corner.err;
    EXPECT_THAT(corner.out, HasSubstr("followed the path for "));
    EXPECT_THAT(corner.out, HasSubstr(" of leg 2\n"));
    const Outcome end = close("0.3,0,-0.3,1,0,0,0\n0,0,-0.3,1,0,0,0\n0,0,-0.13,1,0,0,0\n");
    EXPECT_EQ(end.exitCode, 0) << end.err;
    EXPECT_THAT(end.out, HasSubstr("followed the path for 470.000 mm, to its end\n"));
}

TEST_F(GraspApproach, ErrorsInPathsNameFileLineAndRemedy)
{
    const std::string at = m_path.string();
    const auto complaint = [&](const std::string& rows)
    {
        const Outcome closed = close(rows);
        EXPECT_EQ(closed.exitCode, 3) << rows;
        return closed.err;
    };
    const std::string good = "# way\n0,0,-0.33,1,0,0,0\n";
    EXPECT_THAT(complaint(good + "0,0,x,1,0,0,0\n"), HasSubstr(at + ":3: 'x' is not a number"));
    EXPECT_THAT(complaint(good + "0,0,1\n"),
                HasSubstr(at + ":3: 3 numbers instead of 7: give x,y"));
    EXPECT_THAT(complaint(good + "0,0,0,1,1,0,0\n"),
                HasSubstr(at + ":3: quaternion 1,1,0,0 has length 1.41421: normalise"));
    EXPECT_THAT(complaint(good + "0,0,-330,1,0,0,0\n0,0,5000,1,0,0,0\n"),
                HasSubstr(at + ":4: 5000 is farther than 1000 m: give metres"));
    EXPECT_THAT(complaint("x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,1\n"),
                HasSubstr(at + ":1: columns x,y,z,qx,qy,qz,qw: they must be x,y,z,qw,qx,qy,qz"));
    EXPECT_THAT(complaint(good + "\"0,0,0,1,0,0,0\n"), HasSubstr(at + ":3: a quote is not closed"));
    EXPECT_THAT(complaint("# nothing\n"), HasSubstr(at + ":1: no pose"));
    const Outcome missing = run("close", "--path /no/such.csv");
    EXPECT_EQ(missing.exitCode, 3);
    EXPECT_THAT(missing.err, HasSubstr("/no/such.csv: does not exist: give a CSV file of poses"));
}

TEST_F(GraspApproach, EitherAPoseOrAPathIsGiven)
{
    const Outcome neither = run("close", "");
    EXPECT_EQ(neither.exitCode, 2);
    EXPECT_THAT(neither.err, HasSubstr("--pose or --path is required"));
    std::ofstream(m_path) << "0,0,-0.13,1,0,0,0\n";
    const std::string path = " --path '" + m_path.string() + "'";
    EXPECT_EQ(run("close", "--pose 0 0 -0.13 1 0 0 0" + path).exitCode, 2);
    EXPECT_EQ(run("close", "--approach 0 0 1 0.1" + path).exitCode, 2);
    EXPECT_EQ(run("close", path).exitCode, 0);
}
}  // namespace
}  // namespace bullet_ccd::tools
