// Scenes of obstacles in CSV and YAML, right and wrong.
#include "tests/tools/articulated_program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::HasSubstr;
using Json = nlohmann::json;

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
