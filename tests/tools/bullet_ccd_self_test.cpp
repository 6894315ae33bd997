// Self-collision and wrong input of robots, as a user meets them.
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

/// Two fingers, half thickness 0.01, 0.2 apart on a palm below them, that turn towards each other
/// about z; the palm reaches up to the joints, into both.
std::string pincer()
{
    const auto finger = [](const char* name, double y, int axis)
    {
        return fmt::format(R"(
  <link name="{0}"><collision><origin xyz="0.5 0 0"/>
    <geometry><box size="1.04 0.02 0.02"/></geometry></collision></link>
  <joint name="{0}_joint" type="revolute"><parent link="palm"/><child link="{0}"/>
    <origin xyz="0 {1} 0"/><axis xyz="0 0 {2}"/>
    <limit lower="0" upper="0.3" effort="1" velocity="1"/></joint>)",
                           name,
                           y,
                           axis);
    };
    std::string text =
        R"(<robot name="pincer"><link name="palm"><collision><origin xyz="-0.05 0 0"/>
    <geometry><box size="0.1 0.3 0.1"/></geometry></collision></link>)";
    text += finger("left", 0.1, -1);
    text += finger("right", -0.1, 1);
    return text + "</robot>\n";
}

/// A forearm, half thickness 0.01, that overlaps the upper arm about its elbow at (1, 0); the upper
/// arm carries a post at x = 0.19 to 0.21 that reaches up to y = 0.5. Up to 2.5 rad, the limit, the
/// forearm stays clear of it.
std::string foldingArm(double limit)
{
    return fmt::format(R"(<robot name="folding"><link name="upper">
  <collision><origin xyz="0.5 0 0"/><geometry><box size="1.04 0.02 0.02"/></geometry></collision>
  <collision><origin xyz="0.2 0.26 0"/><geometry><box size="0.02 0.48 0.02"/></geometry></collision>
  </link><link name="fore">
  <collision><origin xyz="0.48 0 0"/><geometry><box size="1.04 0.02 0.02"/></geometry></collision>
  </link><joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/>
  <origin xyz="1 0 0"/><axis xyz="0 0 1"/>
  <limit lower="0" upper="{}" effort="1" velocity="1"/></joint></robot>)",
                       limit);
}

class SelfCollision : public ArticulatedProgram
{
protected:
    void SetUp() override
    {
        ArticulatedProgram::SetUp();
        m_temp.write("pincer.urdf", pincer());
    }

    [[nodiscard]] Outcome close(const std::string& more) const
    {
        return run("articulated " + file("pincer.urdf") + "--from " +
                   joints("open.csv", "left_joint,right_joint\n0,0\n") + "--to " +
                   joints("closed.csv", "left_joint,right_joint\n0.3,0.3\n") + more);
    }
};

TEST_F(SelfCollision, FingersMeetAtTheirTipsAlthoughTheyOverlapThePalmAtTheirJoints)
{
    const Outcome done = close("--self --tolerance 1e-7 --json");
    ASSERT_EQ(done.exitCode, 0) << done.err;
    const Json json = Json::parse(done.out);
    EXPECT_EQ(json["status"], "hit");
    const Json& contact = json["contacts"][0];
    EXPECT_EQ(contact["link"], "left");
    EXPECT_EQ(contact["other_link"], "right");
    // The inner corner of a tip, at (1.02, -0.01) from the joint, comes down to the middle line.
    const double angle = std::asin(0.1 / std::hypot(1.02, 0.01)) - std::atan2(0.01, 1.02);
    EXPECT_NEAR(json["toi"].get<double>(), angle / 0.3, 1e-5);
}

TEST_F(SelfCollision, TheSrdfSaysWhichLinksAreNotTested)
{
    const std::string srdf =
        quoted(m_temp.write("pincer.srdf",
                            R"(<robot name="pincer"><disable_collisions link1="right" link2="left"/>
           <disable_collisions link1="palm" link2="tail"/></robot>)"));
    const Outcome done = close("--self --srdf " + srdf);
    ASSERT_EQ(done.exitCode, 0) << done.err;
    EXPECT_THAT(done.out, HasSubstr("separated: "));
    EXPECT_THAT(done.err, HasSubstr("robot does not have are ignored: tail"));
}

class JoinedLinks : public ArticulatedProgram
{
protected:
    /// The elbow bends from 0 to `to`.
    [[nodiscard]] Outcome fold(double limit, double to, const std::string& more = "") const
    {
        m_temp.write("folding.urdf", foldingArm(limit));
        return run("articulated " + file("folding.urdf") + "--from " +
                   joints("from.csv", "elbow\n0\n") + "--to " +
                   joints("to.csv", fmt::format("elbow\n{}\n", to)) +
                   "--self --tolerance 1e-7 --json " + more);
    }
};

TEST_F(JoinedLinks, MeetWhereNeitherIsPartOfTheJoint)
{
    const Outcome done = fold(2.5, 3.0);
    ASSERT_EQ(done.exitCode, 0) << done.err;
    const Json json = Json::parse(done.out);
    ASSERT_EQ(json["status"], "hit") << done.out;
    const Json& contact = json["contacts"][0];
    EXPECT_EQ(contact["link"], "upper");
    EXPECT_EQ(contact["other_link"], "fore");
    EXPECT_EQ(contact["stop_joint"], "elbow");
    // The leading side of the forearm, 0.01 off its middle, comes down on the corner (0.21, 0.5).
    const double angle =
        std::numbers::pi - std::atan2(0.5, 0.79) - std::asin(0.01 / std::hypot(0.79, 0.5));
    const double toi = json["toi"].get<double>();
    EXPECT_LE(toi, angle / 3.0);
    EXPECT_NEAR(toi, angle / 3.0, 1e-6);
    EXPECT_NEAR(contact["point_link"][0].get<double>(), 0.21, 1e-6);
    EXPECT_NEAR(contact["point_link"][1].get<double>(), 0.5, 1e-6);
}

TEST_F(JoinedLinks, AreExemptAboutTheirJointAndWhereAnSrdfDisablesThem)
{
    const auto statusOf = [](const Outcome& done)
    {
        EXPECT_EQ(done.exitCode, 0) << done.err;
        return Json::parse(done.out)["status"].get<std::string>();
    };
    // They overlap about the elbow all the way.
    EXPECT_EQ(statusOf(fold(2.5, 2.4)), "separated");
    const std::string srdf = quoted(m_temp.write(
        "folding.srdf",
        R"(<robot name="folding"><disable_collisions link1="upper" link2="fore"/></robot>)"));
    EXPECT_EQ(statusOf(fold(2.5, 3.0, "--srdf " + srdf)), "separated");
}

TEST_F(ArticulatedProgram, ArticulatedUsageErrorsExitWith2)
{
    struct Case
    {
        const char* arguments;
        const char* word;
    };
    for (const Case& c :
         {Case{"--from a.csv --to b.csv", "nothing to touch"},
          Case{"--from a.csv --self", "give --from and --to, or --path"},
          Case{"--path p.csv --from a.csv --self -o r.csv", "give --from and --to, or --path"},
          Case{"--path p.csv --self", "give -o"},
          Case{"--path p.csv --self -o r.csv --json", "leave out"},
          Case{"--from a.csv --to b.csv --self --contacts 0", "--contacts"},
          Case{"--from a.csv --to b.csv --srdf s.srdf --obstacles c.obj", "--self as well"},
          Case{"--from a.csv --to b.csv --self --base-to 1,0,0", "--base-to"},
          Case{"--from a.csv --to b.csv --self --stop wrist", "--stop"}})
    {
        const Outcome refused = ask(c.arguments);
        EXPECT_EQ(refused.exitCode, 2) << c.arguments << refused.err;
        EXPECT_THAT(refused.err, HasSubstr(c.word));
    }
    const Outcome help = run("articulated --help");
    EXPECT_EQ(help.exitCode, 0);
    for (const char* word :
         {"--obstacles", "--path", "joint positions", "rad", "SRDF", "--contacts"})
    {
        EXPECT_THAT(help.out, HasSubstr(word));
    }
}

TEST_F(ArticulatedProgram, WrongFilesAreNamedWithLineValueAndRemedy)
{
    struct Case
    {
        const char* joints;
        const char* word;
    };
    for (const Case& c :
         {Case{"shoulder,wrist\n0,0\n", "q0.csv:1: wrist: the robot has no such joint: name"},
          Case{"shoulder,shoulder\n0,0\n", "q0.csv:1: column shoulder is there twice"},
          Case{"shoulder,elbow\n0\n", "q0.csv:2: 1 cells instead of 2"},
          Case{"shoulder,elbow\n\n0,much\n", "q0.csv:3: elbow: 'much'"},
          Case{"shoulder,elbow\n", "q0.csv:1: no row"},
          Case{"", "q0.csv:1: no row"},
          Case{"shoulder,base_qw\n0,1\n", "not base_qx, base_qy"},
          Case{"shoulder\n0\n", "other columns than"}})
    {
        const Outcome refused =
            ask("--from " + joints("q0.csv", c.joints) + "--to " +
                joints("q1.csv", "shoulder,elbow\n0,0\n") + "--obstacles " + file("scene.csv"));
        EXPECT_EQ(refused.exitCode, 3) << c.joints;
        EXPECT_THAT(refused.err, HasSubstr(c.word));
    }
    const std::string motion = "--from " + joints("q0.csv", "shoulder,elbow\n0,3.5\n") + "--to " +
                               joints("q1.csv", "shoulder,elbow\n0,0\n") + "--obstacles ";
    for (const Case& c : {Case{"mesh,size\nwall.obj,1\n", "bad.csv:1: size: no such column"},
                          Case{"name\nwall\n", "bad.csv:1: no column mesh"},
                          Case{"mesh,scale\nwall.obj,-1\n", "bad.csv:2: scale: -1 is not above 0"},
                          Case{"mesh,qw,qx,qy,qz,tx,ty,tz\nwall.obj,2,0,0,0,0,0,0\n",
                               "bad.csv:2: qw: quaternion 2,0,0,0"},
                          Case{"mesh\nabsent.obj\n", "absent.obj: "}})
    {
        const Outcome refused = ask(motion + joints("bad.csv", c.joints));
        EXPECT_EQ(refused.exitCode, 3) << c.joints;
        EXPECT_THAT(refused.err, HasSubstr(c.word));
    }
    const Outcome outside = ask(motion + file("scene.csv"));
    EXPECT_EQ(outside.exitCode, 0);
    EXPECT_THAT(outside.err, HasSubstr("q0.csv:2: elbow: 3.5 is outside its limits -3.2 to 3.2"));
    EXPECT_EQ(ask("--from absent.csv --to absent.csv --self").exitCode, 3);
}
}  // namespace
}  // namespace bullet_ccd::tools
