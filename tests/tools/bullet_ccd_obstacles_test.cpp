// Scenes of obstacles in CSV and YAML, right and wrong.
#include "benchmarks/reference/scenes/random.h"
#include "tests/tools/articulated_program.h"
#include "tools/support/csv_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <gmock/gmock.h>
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
namespace fs = std::filesystem;

/// The arm swings down from a right angle.
class ObstacleScenes : public ArticulatedProgram
{
protected:
    [[nodiscard]] Outcome swingAt(const std::string& scene) const
    {
        const std::string from =
            joints("q0.csv", fmt::format("shoulder,elbow\n{},0\n", 0.5 * std::numbers::pi));
        const std::string to = joints("q1.csv", "shoulder,elbow\n0,0\n");
        return ask("--from " + from + "--to " + to + "--obstacles " + file(scene) +
                   "--tolerance 1e-7 --json");
    }

    /// The answer without the time that it took.
    [[nodiscard]] Json answerOf(const std::string& scene) const
    {
        const Outcome done = swingAt(scene);
        EXPECT_EQ(done.exitCode, 0) << done.err;
        Json json = Json::parse(done.out);
        json.erase("microseconds");
        return json;
    }
};

TEST_F(ObstacleScenes, CsvAndYamlGiveTheSameAnswers)
{
    // A post in mm, turned by 0.6 rad about z, and a wall that is met later.
    writeObj(makeBox({50.0, 200.0, 1000.0}), m_temp.path() / "post.obj");
    m_temp.write("turned.csv",
                 "mesh,name,scale,qw,qx,qy,qz,tx,ty,tz\n"
                 "post.obj,post,0.001,0.955336489125606,0,0,0.29552020666133955,1.2,0.9,0\n"
                 "wall.obj,,1,1,0,0,0,1.6,0,0\n");
    const std::string wall = "  - {mesh: wall.obj, position: [1.6, 0, 0]}\n";
    const std::string post =
        "obstacles:\n"
        "  - mesh: post.obj\n"
        "    name: post\n"
        "    scale: 1e-3\n"
        "    position: [1.2, 0.9, 0]\n";
    m_temp.write("turned.yaml",
                 post + "    quaternion: [0.955336489125606, 0, 0, 0.29552020666133955]\n" + wall);
    m_temp.write("turned.yml", post + "    rpy: [0, 0, 0.6]\n" + wall);
    const Json csv = answerOf("turned.csv");
    EXPECT_EQ(csv["status"], "hit");
    EXPECT_EQ(csv["contacts"][0]["obstacle"], "post");
    EXPECT_EQ(csv, answerOf("turned.yaml"));
    // The same up to the last digit of the sine.
    const Json rpy = answerOf("turned.yml");
    EXPECT_EQ(rpy["contacts"][0]["obstacle"], "post");
    EXPECT_NEAR(rpy["toi"].get<double>(), csv["toi"].get<double>(), 1e-12);
}

TEST_F(ObstacleScenes, RollPitchAndYawTurnAboutFixedAxesAsInUrdf)
{
    // A bar along x that a pitch by a right angle sets upright; a yaw after it turns it about
    // itself. The other way round it would lie along y and be met by the tip of the arm before.
    writeObj(makeBox({1.0, 0.02, 0.02}), m_temp.path() / "bar.obj");
    m_temp.write("bar.yaml",
                 "obstacles:\n"
                 "  - mesh: bar.obj\n"
                 "    position: [1.2, 1.2, 0]\n"
                 "    rpy: [0, 1.5707963267948966, 1.5707963267948966]\n");
    const Json json = answerOf("bar.yaml");
    ASSERT_EQ(json["status"], "hit");
    // The lower side of the arm, 0.01 off its middle, comes down on the corner (1.18, 1.22).
    const double angle = std::atan2(1.22, 1.18) + std::asin(0.01 / std::hypot(1.18, 1.22));
    EXPECT_NEAR(json["toi"].get<double>(), 1.0 - angle / (0.5 * std::numbers::pi), 1e-6);
}

struct BadScene
{
    const char* name;
    const char* text;
    int line;
    const char* says;
};

class BadYaml : public ObstacleScenes, public testing::WithParamInterface<BadScene>
{
};

TEST_P(BadYaml, IsRefusedWithFileAndLine)
{
    m_temp.write("bad.yaml", GetParam().text);
    const Outcome done = swingAt("bad.yaml");
    EXPECT_EQ(done.exitCode, 3);
    EXPECT_THAT(done.err, HasSubstr(fmt::format("bad.yaml:{}: ", GetParam().line)));
    EXPECT_THAT(done.err, HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    Scenes,
    BadYaml,
    testing::Values(
        BadScene{"NotYaml", "obstacles:\n  - mesh: [wall.obj\n", 3, "not YAML"},
        BadScene{"NotAMap", "- mesh: wall.obj\n", 1, "write obstacles:"},
        BadScene{"Empty", "", 1, "write obstacles:"},
        BadScene{
            "UnknownTopKey", "\nobstacle:\n  - mesh: wall.obj\n", 2, "did you mean obstacles?"},
        BadScene{"NoList", "obstacles:\n  mesh: wall.obj\n", 2, "no list"},
        BadScene{"NotAnItem", "obstacles:\n  - wall.obj\n", 2, "- mesh: FILE"},
        BadScene{"UnknownKey",
                 "obstacles:\n  - mesh: wall.obj\n    postion: [0, 0, 0]\n",
                 3,
                 "postion: no such key: did you mean position?"},
        BadScene{"TwiceTheSameKey",
                 "obstacles:\n  - mesh: wall.obj\n    scale: 1\n    scale: 2\n",
                 4,
                 "scale: there twice"},
        BadScene{"NoMesh", "obstacles:\n  - mesh: wall.obj\n  - name: wall\n", 3, "no such key"},
        BadScene{"EmptyMesh", "obstacles:\n  - mesh:\n", 2, "mesh: no value"},
        BadScene{"NoSuchMesh", "obstacles:\n  - mesh: door.obj\n", 2, "door.obj"},
        BadScene{"NoNumber",
                 "obstacles:\n  - mesh: wall.obj\n    position: [0, one, 0]\n",
                 3,
                 "position: 'one'"},
        BadScene{"NotFinite",
                 "obstacles:\n  - mesh: wall.obj\n    position: [0, .inf, 0]\n",
                 3,
                 "position: '.inf'"},
        BadScene{"TwoNumbers",
                 "obstacles:\n  - mesh: wall.obj\n    position: [0, 1]\n",
                 3,
                 "position: not a list of 3 numbers"},
        BadScene{"LongQuaternion",
                 "obstacles:\n  - mesh: wall.obj\n    quaternion: [1, 1, 0, 0]\n",
                 3,
                 "quaternion: "},
        BadScene{
            "TwoTurns",
            "obstacles:\n  - mesh: wall.obj\n    quaternion: [1, 0, 0, 0]\n    rpy: [0, 0, 0]\n",
            4,
            "rpy: there is a quaternion too"},
        BadScene{
            "NoScale", "obstacles:\n  - mesh: wall.obj\n    scale: 0\n", 3, "scale: 0 is not"}),
    [](const auto& tested) { return tested.param.name; });

TEST_F(ObstacleScenes, AnAccuracySaysWhichBodiesTrianglesAndJointsWereNeeded)
{
    const std::string swing =
        "--from " +
        joints("q0.csv", fmt::format("shoulder,elbow\n{},0\n", 0.5 * std::numbers::pi)) + "--to " +
        joints("q1.csv", "shoulder,elbow\n0,0\n") + "--obstacles " + file("scene.csv");
    const Outcome text = ask(swing + "--accuracy 1e-3");
    EXPECT_EQ(text.exitCode, 0) << text.err;
    EXPECT_THAT(text.out, HasSubstr("needed      2 of 3 bodies, "));
    EXPECT_THAT(text.out, HasSubstr(" of 36 triangles, 1 of 2 joints\n"));
    const Outcome json = ask(swing + "--accuracy 1e-3 --json");
    const Json needed = Json::parse(json.out)["needed"];
    EXPECT_EQ(needed["bodies"], 2);
    EXPECT_EQ(needed["of_triangles"], 36);
    EXPECT_EQ(needed["joints"], 1);
    EXPECT_EQ(needed["of_joints"], 2);
}

/// A wall that the arm meets, a post that it may meet, and a door far away, as a manifest.
class Manifest : public ObstacleScenes
{
protected:
    void SetUp() override
    {
        ObstacleScenes::SetUp();
        writeObj(makeBox({0.1, 3.0, 1.0}), m_door);
        m_temp.write("rooms.yaml",
                     "obstacles:\n"
                     "  - {mesh: wall.obj, position: [1.6, 0, 0]}\n"
                     "  - {mesh: door.obj, name: 'the \"door\", far', position: [60, 0, 0], "
                     "rpy: [0.1, 0.2, 0.3]}\n");
        const Outcome made = run("manifest " + file("rooms.yaml") + "-o " + file("rooms.csv"));
        EXPECT_EQ(made.exitCode, 0) << made.err;
        // As if it had been made a while after the meshes.
        setTime("rooms.csv", 10);
    }

    void setTime(const std::string& name, int seconds) const
    {
        fs::last_write_time(m_temp.path() / name,
                            fs::last_write_time(m_wall) + std::chrono::seconds(seconds));
    }

    /// Nothing that can be read, of the same size.
    void spoil(const fs::path& mesh) const
    {
        const auto bytes = fs::file_size(mesh);
        const auto time = fs::last_write_time(mesh);
        std::ofstream(mesh) << std::string(bytes, 'x');
        fs::last_write_time(mesh, time);
    }

    fs::path m_door = m_temp.path() / "door.obj";
};

TEST_F(Manifest, GivesTheAnswersOfItsSceneWithoutAReadOfWhatIsOutOfReach)
{
    Json whole = answerOf("rooms.yaml");
    spoil(m_door);
    Json listed = answerOf("rooms.csv");
    EXPECT_EQ(whole["status"], "hit");
    for (Json* answer : {&whole, &listed})
    {
        answer->erase("pairs");
        answer->erase("culled_by_space");
    }
    EXPECT_EQ(listed, whole);
    // All contacts may lie beyond the motion: everything is loaded.
    const Outcome all = ask("--from " + file("q0.csv") + "--to " + file("q1.csv") + "--obstacles " +
                            file("rooms.csv") + "--contacts 2");
    EXPECT_EQ(all.exitCode, 3);
    EXPECT_THAT(all.err, HasSubstr("door.obj"));
}

TEST_F(Manifest, NamesMeshesAsTheyAreSeenFromWhereItIs)
{
    const std::string program = std::string(BULLET_CCD_PROGRAM) + " manifest ";
    const std::string there = "cd '" + m_temp.path().string() + "' && ";
    EXPECT_EQ(runProgram(there + program + "rooms.yaml -o here.csv").exitCode, 0);
    EXPECT_EQ(
        runProgram(there + "mkdir below && " + program + "rooms.yaml -o below/lower.csv").exitCode,
        0);
    EXPECT_EQ(answerOf("here.csv"), answerOf("rooms.csv"));
    EXPECT_EQ(answerOf("below/lower.csv"), answerOf("rooms.csv"));
}

TEST_F(Manifest, RefusesMeshesThatHaveChanged)
{
    const auto isRefused = [&](const fs::path& mesh)
    {
        const Outcome done = swingAt("rooms.csv");
        EXPECT_EQ(done.exitCode, 3) << mesh;
        EXPECT_THAT(done.err, HasSubstr("rooms.csv:"));
        EXPECT_THAT(done.err, HasSubstr(mesh.filename().string() + ": is not what it was"));
        EXPECT_THAT(done.err, HasSubstr("bullet-ccd manifest"));
    };
    spoil(m_door);
    setTime("door.obj", 20);  // newer than the manifest, which is no more believed
    isRefused(m_door);
    writeObj(makeBox({0.1, 3.0, 1.25}), m_door);
    setTime("door.obj", 0);
    isRefused(m_door);  // by its size
    writeObj(makeBox({0.1, 3.0, 1.0}), m_door);
    setTime("door.obj", 20);
    EXPECT_EQ(swingAt("rooms.csv").exitCode, 0);  // the same content, only newer
    spoil(m_wall);
    isRefused(m_wall);  // in reach: by its content
    writeObj(makeBox({0.1, 3.0, 1.0}), m_wall);
    fs::remove(m_door);
    EXPECT_THAT(swingAt("rooms.csv").err, HasSubstr("door.obj: cannot be read"));
}

TEST_F(Manifest, RefusesWhatIsNoManifestOrNoScene)
{
    m_temp.write("part.csv", "mesh,triangles\nwall.obj,12\n");
    EXPECT_THAT(swingAt("part.csv").err, HasSubstr("only some columns of a manifest"));
    const std::string columns =
        "mesh,triangles,low_x,low_y,low_z,high_x,high_y,high_z,bytes,hash\n";
    m_temp.write("bad.csv", columns + "wall.obj,12,1,0,0,0,1,1,300,00ff\n");
    EXPECT_THAT(swingAt("bad.csv").err, HasSubstr("bad.csv:2: low_x: the low corner is above"));
    m_temp.write("bad.csv", columns + "wall.obj,12,0,0,0,1,1,1,-3,00ff\n");
    EXPECT_THAT(swingAt("bad.csv").err, HasSubstr("bad.csv:2: bytes: \"-3\""));
    EXPECT_EQ(run("manifest " + file("wall.obj") + "-o " + file("m.csv")).exitCode, 3);
    EXPECT_EQ(run("manifest " + file("rooms.yaml") + "-o " + file("m.yaml")).exitCode, 2);
    EXPECT_EQ(run("manifest " + file("rooms.csv") + "-o " + file("rooms.csv")).exitCode, 3);
}

TEST_F(Manifest, MissesNothingOnRandomPaths)
{
    reference::Random random(7);
    std::string scene = "mesh,name,scale,qw,qx,qy,qz,tx,ty,tz\n";
    writeObj(makeBox({1.0, 2.0, 3.0}), m_temp.path() / "brick.obj");
    for (int i = 0; i < 60; ++i)
    {
        const Eigen::Isometry3d X = random.pose(4.0);
        const Eigen::Quaterniond q(X.linear());
        scene += fmt::format("brick.obj,brick {},0.05,{},{},{},{},{},{},{}\n",
                             i,
                             q.w(),
                             q.x(),
                             q.y(),
                             q.z(),
                             X.translation().x(),
                             X.translation().y(),
                             0.05 * X.translation().z());
    }
    m_temp.write("bricks.csv", scene);
    ASSERT_EQ(run("manifest " + file("bricks.csv") + "-o " + file("listed.csv")).exitCode, 0);
    std::string path = "shoulder,elbow\n";
    for (int i = 0; i < 40; ++i)
    {
        path += fmt::format("{},{}\n", random.uniform(-1.0, 1.0), random.uniform(-3.0, 3.0));
    }
    const auto tableOf = [&](const char* obstacles)
    {
        const Outcome done = ask("--path " + joints("path.csv", path) + "--obstacles " +
                                 file(obstacles) + "-o " + file("table.csv"));
        EXPECT_EQ(done.exitCode, 0) << done.err;
        std::ifstream table(m_temp.path() / "table.csv");
        std::vector<std::string> rows;
        for (std::string line; std::getline(table, line);)
        {
            // But for the counts and the time at the end.
            std::vector<std::string> cells = *csvCells(line);
            cells.resize(17);
            rows.push_back(fmt::format("{}", fmt::join(cells, ",")));
        }
        return rows;
    };
    // The same digits of poses, without what makes it a manifest.
    std::ifstream listed(m_temp.path() / "listed.csv");
    std::string same;
    for (std::string line; std::getline(listed, line);)
    {
        std::vector<std::string> cells = *csvCells(line);
        cells.resize(10);
        same += fmt::format("{}\n", fmt::join(cells, ","));
    }
    m_temp.write("same.csv", same);
    const std::vector<std::string> rows = tableOf("same.csv");
    EXPECT_EQ(tableOf("listed.csv"), rows);
    const auto hits = std::count_if(rows.begin(),
                                    rows.end(),
                                    [](const std::string& row)
                                    { return row.find("brick") != std::string::npos; });
    EXPECT_GT(hits, 5);
    EXPECT_LT(hits, 35);
}

TEST_F(ObstacleScenes, AMeshThatIsNotThereIsNamedWithItsPlaceInTheCsv)
{
    m_temp.write("bad.csv", "mesh,name\nwall.obj,wall\ndoor.obj,door\n");
    const Outcome done = swingAt("bad.csv");
    EXPECT_EQ(done.exitCode, 3);
    EXPECT_THAT(done.err, HasSubstr("bad.csv:3: mesh: "));
    EXPECT_THAT(done.err, HasSubstr("door.obj"));
}

TEST_F(ObstacleScenes, ASceneThatIsNotThereIsNamed)
{
    const Outcome done = swingAt("nowhere.yaml");
    EXPECT_EQ(done.exitCode, 3);
    EXPECT_THAT(done.err, HasSubstr("nowhere.yaml: cannot be read"));
}
}  // namespace
}  // namespace bullet_ccd::tools
