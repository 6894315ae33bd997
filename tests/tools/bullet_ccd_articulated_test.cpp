// Queries of robots as a user asks them.
#include "tests/tools/articulated_program.h"
#include "tools/support/csv_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gmock/gmock.h>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::HasSubstr;
using Json = nlohmann::json;

constexpr double kHalfTurn = std::numbers::pi / 2.0;

/// Angle at which the straight arm, a bar that ends at x = 1.98 with a half thickness of 0.01,
/// reaches the wall when it comes down from a right angle: its lower corner is first.
double angleAtWall()
{
    return std::acos(1.5 / std::hypot(1.98, 0.01)) + std::atan2(0.01, 1.98);
}

std::vector<std::map<std::string, std::string>> namedRowsOf(const std::filesystem::path& path)
{
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    const std::vector<std::string> names = *csvCells(line);
    std::vector<std::map<std::string, std::string>> rows;
    while (std::getline(file, line))
    {
        const std::vector<std::string> cells = *csvCells(line);
        EXPECT_EQ(cells.size(), names.size()) << line;
        std::map<std::string, std::string>& row = rows.emplace_back();
        for (std::size_t k = 0; k < names.size(); ++k)
        {
            row[names[k]] = cells.at(k);
        }
    }
    return rows;
}

TEST_F(ArticulatedProgram, ATwoLinkArmReachesTheWallAtTheClosedFormTime)
{
    const std::string from = joints("q0.csv", fmt::format("shoulder,elbow\n{},0\n", kHalfTurn));
    const std::string to = joints("q1.csv", "elbow,shoulder\n0,0\n");
    const Outcome done = ask("--from " + from + "--to " + to + "--obstacles " + file("scene.csv") +
                             "--tolerance 1e-7 --json");
    ASSERT_EQ(done.exitCode, 0) << done.err;
    const Json json = Json::parse(done.out);
    EXPECT_EQ(json["status"], "hit");
    // The wall is met a tolerance early at most; there the corner comes at a speed above 1.
    EXPECT_NEAR(json["toi"].get<double>(), 1.0 - angleAtWall() / kHalfTurn, 1e-6);
    ASSERT_EQ(json["contacts"].size(), 1U);
    const Json& contact = json["contacts"][0];
    EXPECT_EQ(contact["link"], "fore");
    EXPECT_EQ(contact["obstacle"], "wall");
    EXPECT_EQ(contact["stop_joint"], "shoulder");
    EXPECT_NEAR(contact["normal"][0].get<double>(), 1.0, 1e-4);
    EXPECT_NEAR(contact["point_other"][0].get<double>(), 1.5, 1e-9);
    EXPECT_GE(contact["triangle_link"].get<int>(), 0);
    EXPECT_EQ(json["pairs"].get<int>(), 2);
}

TEST_F(ArticulatedProgram, PeopleSeeLinksObstaclesAndTheJointThatMustStop)
{
    const std::string from = joints("q0.csv", "shoulder,elbow\n0,1.5\n");
    const std::string to = joints("q1.csv", "shoulder,elbow\n0,0\n");
    const Outcome done = ask("--from " + from + "--to " + to + "--obstacles " + file("scene.csv"));
    ASSERT_EQ(done.exitCode, 0) << done.err;
    for (const char* word : {"hit: contact is not reached before t = ",
                             "link fore and obstacle wall, gap",
                             "must stop  elbow",
                             "culled by space 0",
                             "microseconds"})
    {
        EXPECT_THAT(done.out, HasSubstr(word));
    }
    const Outcome away =
        ask("--from " + from + "--to " + from + "--obstacles " + file("scene.csv"));
    EXPECT_THAT(away.out, HasSubstr("separated: contact is never reached"));
}

TEST_F(ArticulatedProgram, FurtherContactsFollowWhereJointsGoOn)
{
    // The upper arm stops on a post, the forearm goes on to another one.
    writeObj(makeBox({0.05, 0.05, 1.0}), m_temp.path() / "post.obj");
    m_temp.write("posts.csv",
                 "mesh,name,qw,qx,qy,qz,tx,ty,tz\n"
                 "post.obj,near,1,0,0,0,0.5,-0.3,0\n"
                 "post.obj,far,1,0,0,0,0.77,-1.01,0\n");
    const std::string motion = "--from " + joints("q0.csv", "shoulder,elbow\n0,0\n") + "--to " +
                               joints("q1.csv", "shoulder,elbow\n-0.8,-1.6\n") + "--obstacles " +
                               file("posts.csv");
    const Outcome first = ask(motion + "--json");
    ASSERT_EQ(first.exitCode, 0) << first.err;
    EXPECT_EQ(Json::parse(first.out)["contacts"].size(), 1U);
    const Json all = Json::parse(ask(motion + "--contacts 10 --json").out);
    ASSERT_GE(all["contacts"].size(), 2U);
    EXPECT_EQ(all["contacts"][0]["obstacle"], "near");
    EXPECT_EQ(all["contacts"][0]["stop_joint"], "shoulder");
    EXPECT_EQ(all["contacts"][1]["obstacle"], "far");
    EXPECT_EQ(all["contacts"][1]["link"], "fore");
    EXPECT_GT(all["contacts"][1]["time"].get<double>(), all["contacts"][0]["time"].get<double>());
    EXPECT_NEAR(all["stop_times"]["shoulder"].get<double>(),
                all["contacts"][0]["time"].get<double>(),
                1e-12);
    EXPECT_THAT(ask(motion + "--contacts 2").out, HasSubstr("stopped     shoulder at "));
}

TEST_F(ArticulatedProgram, TheBaseMovesByOptionsOrColumns)
{
    // Stretched out along x the tip is at 1.98: 0.52 back it starts 0.04 from the wall at 1.5.
    const std::string rest = joints("q.csv", "shoulder,elbow\n0,0\n");
    const std::string byOptions = "--from " + rest + "--to " + rest +
                                  "--base-from 1,0,0,0,-0.52,0,0 --base-to 1,0,0,0,-0.42,0,0 ";
    const std::string names =
        "shoulder,elbow,base_qw,base_qx,base_qy,base_qz,base_tx,base_ty,base_tz\n";
    const std::string byColumns = "--from " + joints("b0.csv", names + "0,0,1,0,0,0,-0.52,0,0\n") +
                                  "--to " + joints("b1.csv", names + "0,0,1,0,0,0,-0.42,0,0\n");
    for (const std::string& motion : {byOptions, byColumns})
    {
        const Outcome done =
            ask(motion + "--obstacles " + file("scene.csv") + "--tolerance 1e-7 --json");
        ASSERT_EQ(done.exitCode, 0) << done.err;
        const Json json = Json::parse(done.out);
        EXPECT_NEAR(json["toi"].get<double>(), 0.4, 1e-5);
        EXPECT_EQ(json["contacts"][0]["stop_joint"], "base");
    }
}

TEST_F(ArticulatedProgram, APathAsksFromEveryRowToTheNext)
{
    const std::filesystem::path results = m_temp.path() / "results.csv";
    const std::string path = joints(
        "path.csv",
        fmt::format("id,time,shoulder,elbow\nup,0,{0},0\ndown,1,0,0\nagain,2,{0},0\n", kHalfTurn));
    const Outcome done = ask("--path " + path + "--obstacles " + file("scene.csv") + "-o " +
                             quoted(results) + "--tolerance 1e-7 --repeat 2 --summary");
    ASSERT_EQ(done.exitCode, 0) << done.err;
    EXPECT_THAT(done.out, HasSubstr("hit: 1\n"));
    const auto rows = namedRowsOf(results);
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[0].at("id"), "up");
    EXPECT_NEAR(std::stod(rows[0].at("toi")), 1.0 - angleAtWall() / kHalfTurn, 1e-6);
    EXPECT_EQ(rows[0].at("link"), "fore");
    EXPECT_EQ(rows[0].at("obstacle"), "wall");
    EXPECT_EQ(rows[0].at("other_link"), "");
    EXPECT_EQ(rows[0].at("stop_joint"), "shoulder");
    EXPECT_NEAR(std::stod(rows[0].at("px")), 1.5, 1e-6);
    EXPECT_GT(std::stod(rows[0].at("microseconds")), 0.0);
    // Straight out the arm is in the wall.
    EXPECT_EQ(rows[1].at("status"), "overlapping");
    EXPECT_EQ(rows[1].at("toi"), "0");
}

TEST_F(ArticulatedProgram, FilesOfManyRowsAskPairs)
{
    const std::filesystem::path results = m_temp.path() / "results.csv";
    const std::string from = joints("q0.csv", "shoulder\n1.5\n1.5\n1.5\n");
    const std::string to = joints("q1.csv", "shoulder\n1.4\n0\n1.3\n");
    const Outcome done = ask("--from " + from + "--to " + to + "--obstacles " + file("scene.csv") +
                             "-o " + quoted(results));
    ASSERT_EQ(done.exitCode, 0) << done.err;
    EXPECT_THAT(done.err, HasSubstr("joints without a column rest: elbow at 0"));
    const auto rows = namedRowsOf(results);
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_EQ(rows[0].at("status"), "separated");
    EXPECT_EQ(rows[1].at("status"), "hit");
    EXPECT_EQ(rows[2].at("status"), "separated");
    EXPECT_EQ(rows[1].at("id"), "1");
    const Outcome one = ask("--from " + from + "--to " + to + "--obstacles " + file("scene.csv"));
    EXPECT_EQ(one.exitCode, 3);
    EXPECT_THAT(one.err, HasSubstr("3 rows"));
}
}  // namespace
}  // namespace bullet_ccd::tools
