#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/io/mjcf_texts.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <gmock/gmock.h>
#include <numbers>
#include <stdexcept>

namespace bullet_ccd
{
namespace
{
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using tests::mjcf;
using tests::TempFolder;

constexpr double kDegree = std::numbers::pi / 180.0;

const Link& mjcfLink(const RobotModel& robot, const std::string& name)
{
    const std::int32_t link = robot.tree.findLink(name);
    if (link == kNone)
    {
        throw std::runtime_error("no link " + name);
    }
    return robot.tree.links[static_cast<std::size_t>(link)];
}

RobotModel loadMjcfText(const std::string& text)
{
    const TempFolder folder;
    return loadRobot(folder.write("m.xml", text));
}

std::string mjcfError(const std::string& text)
{
    try
    {
        static_cast<void>(loadMjcfText(text));
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return "";
}

TEST(MjcfFile, ClassesGiveWhatElementsDoNotSay)
{
    const RobotModel robot = loadMjcfText(tests::kMjcfHand);
    EXPECT_EQ(robot.name, "odd_hand");
    std::vector<std::string> names;
    for (const Link& link : robot.tree.links)
    {
        names.push_back(link.name);
    }
    EXPECT_THAT(names,
                testing::ElementsAre("palm", "a/a1", "a/a2", "a", "a_tip", "b", "b_tip", "c", "d"));
    const Joint& a1 = mjcfLink(robot, "a/a1").joint;
    EXPECT_EQ(a1.axis, Eigen::Vector3d::UnitX());
    EXPECT_NEAR(a1.lower, -30 * kDegree, 1e-12);
    EXPECT_NEAR(a1.upper, 60 * kDegree, 1e-12);
    // The class of the joint has the axis, the class around it the range, the joint its own.
    const Joint& a2 = mjcfLink(robot, "a/a2").joint;
    EXPECT_EQ(a2.axis, Eigen::Vector3d::UnitY());
    EXPECT_NEAR(a2.upper, 80 * kDegree, 1e-12);
    const Joint& a3 = mjcfLink(robot, "a").joint;
    EXPECT_EQ(a3.type, JointType::Prismatic);
    EXPECT_NEAR((a3.axis - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 0.0, 1e-15);
    EXPECT_EQ(a3.lower, -0.01);
    EXPECT_TRUE(std::isinf(mjcfLink(robot, "a_tip").joint.upper));
    // The sphere that is only to be seen is not there: it would reach 0.5 m.
    EXPECT_LT(bounds(robot.linkMeshes[0]).max().norm(), 0.05);
    EXPECT_NEAR(robot.tree.links[0].mass, 0.3, 1e-12);
}

TEST(MjcfFile, EffortsAreTheLeastOfAllRanges)
{
    const RobotModel robot = loadMjcfText(tests::kMjcfHand);
    EXPECT_EQ(mjcfLink(robot, "a/a1").joint.maxEffort, 4.0);  // of the class
    EXPECT_EQ(mjcfLink(robot, "a/a2").joint.maxEffort,
              6.0);  // 3 * 2 by its control, 3 * 4 by force
    EXPECT_EQ(mjcfLink(robot, "a").joint.maxEffort, 9.0);
    EXPECT_TRUE(std::isinf(mjcfLink(robot, "a_tip").joint.maxEffort));
    EXPECT_EQ(mjcfLink(robot, "c").joint.maxEffort, 5.0);
    EXPECT_EQ(mjcfLink(robot, "d").joint.maxEffort, 10.0);
}

TEST(MjcfFile, EqualitiesAndTendonsCouple)
{
    const RobotModel robot = loadMjcfText(tests::kMjcfHand);
    // b2 = 0.1 + 2 (b1 - ref), angles in rad.
    const Joint& b2 = mjcfLink(robot, "b_tip").joint;
    EXPECT_EQ(b2.mimicOf, robot.tree.findJoint("b1"));
    EXPECT_EQ(b2.mimicMultiplier, 2.0);
    EXPECT_NEAR(b2.mimicOffset, 0.1 + 2.0 * 7.0 * kDegree, 1e-12);
    // The tendon pulls d1 twice as fast as c1, from where both are at rest.
    const Joint& d1 = mjcfLink(robot, "d").joint;
    EXPECT_EQ(d1.mimicOf, robot.tree.findJoint("c1"));
    EXPECT_EQ(d1.mimicMultiplier, 2.0);
    EXPECT_NEAR(d1.mimicOffset, -2.0 * 5.0 * kDegree, 1e-12);
    EXPECT_THAT(robot.notes, Contains(HasSubstr("one tendon move in proportion")));
}

TEST(MjcfFile, CouplingsTurnRoundAndFixAndChain)
{
    const std::string body = R"(<body name="p"><geom size="0.01"/>
      <body name="x"><joint name="x"/><geom size="0.01"/></body>
      <body name="y"><joint name="y"/><geom size="0.01"/></body>
      <body name="z"><joint name="z"/><geom size="0.01"/></body>
      <body name="w"><joint name="w" axis="0 0 1"/><geom size="0.01"/></body></body>)";
    const RobotModel robot =
        loadMjcfText(mjcf(body,
                          R"(<equality><joint joint1="x" joint2="y" polycoef="1 4 0 0 0"/>
                <joint joint1="y" joint2="z" polycoef="0 -1 0 0 0"/>
                <joint joint1="w" polycoef="0.5 0 0 0 0"/>
                <joint joint1="z" joint2="x" active="false"/>
                <connect body1="x" body2="y" anchor="0 0 0"/></equality>
                <actuator><motor joint="x" ctrllimited="true" ctrlrange="-2 2"/></actuator>)"));
    // The motor is at x, so y follows it: y = (x - 1) / 4; and z = -y.
    const Joint& y = mjcfLink(robot, "y").joint;
    EXPECT_EQ(y.mimicOf, robot.tree.findJoint("x"));
    EXPECT_EQ(y.mimicMultiplier, 0.25);
    EXPECT_EQ(y.mimicOffset, -0.25);
    const Joint& z = mjcfLink(robot, "z").joint;
    EXPECT_EQ(z.mimicOf, robot.tree.findJoint("x"));
    EXPECT_EQ(z.mimicMultiplier, -0.25);
    EXPECT_EQ(z.mimicOffset, 0.25);
    const Link& w = mjcfLink(robot, "w");
    EXPECT_EQ(w.joint.type, JointType::Fixed);
    EXPECT_NEAR(w.X_PL0.linear()(0, 0), std::cos(0.5), 1e-12);
    EXPECT_THAT(robot.notes, Contains(AllOf(HasSubstr("left out"), HasSubstr("<connect>"))));
}

TEST(MjcfFile, JointsTurnAboutTheirAnchors)
{
    // The body's centre is on a circle of 0.1 m about the anchor; at ref it is where pos says.
    const RobotModel robot = loadMjcfText(mjcf(R"(<body name="p"><geom size="0.01"/>
        <body name="x" pos="0.3 0 0"><joint name="x" axis="0 0 1" pos="-0.1 0 0" ref="90"/>
        <geom size="0.01"/></body></body>)"));
    for (const double degrees : {90.0, 180.0, 0.0, 45.0})
    {
        const std::vector<double> q{0.0, degrees * kDegree};
        const auto X = linkPoses(robot.tree, Eigen::Isometry3d::Identity(), q);
        const Eigen::Vector3d center = X[1] * bounds(robot.linkMeshes[1]).center();
        const double angle = (degrees - 90.0) * kDegree;
        const Eigen::Vector3d expected(0.2 + 0.1 * std::cos(angle), 0.1 * std::sin(angle), 0.0);
        EXPECT_NEAR((center - expected).norm(), 0.0, 1e-12);
    }
    EXPECT_THAT(robot.notes, Contains(HasSubstr("link frames moved")));
}

TEST(MjcfFile, OrientationsMeanWhatTheyMeanInMuJoCo)
{
    const auto turned = [](const std::string& attribute, const std::string& compiler = "")
    {
        const RobotModel robot =
            loadMjcfText(mjcf("<body name=\"p\"><geom size=\"0.01\"/><body name=\"x\" " +
                                  attribute + "><geom size=\"0.01\"/></body></body>",
                              "<compiler " + compiler + "/>"));
        return Eigen::Matrix3d(robot.tree.links[1].X_PL0.linear());
    };
    const auto rot = [](double degrees, const Eigen::Vector3d& axis)
    { return Eigen::Matrix3d(Eigen::AngleAxisd(degrees * kDegree, axis.normalized())); };
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
    const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
    const auto expectNear = [](const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
        EXPECT_NEAR((a - b).norm(), 0.0, 1e-12) << a << "\n\n" << b;
    };
    expectNear(turned("quat=\"2 0 0 2\""), rot(90, z));
    expectNear(turned("axisangle=\"0 3 0 30\""), rot(30, y));
    expectNear(turned("axisangle=\"0 3 0 0.5\"", "angle=\"radian\""), rot(0.5 / kDegree, y));
    expectNear(turned("euler=\"10 20 30\""), rot(10, x) * rot(20, y) * rot(30, z));
    expectNear(turned("euler=\"10 20 30\"", "eulerseq=\"XYZ\""),
               rot(30, z) * rot(20, y) * rot(10, x));
    expectNear(turned("euler=\"10 20 30\"", "eulerseq=\"zyx\""),
               rot(10, z) * rot(20, y) * rot(30, x));
    expectNear(turned("xyaxes=\"0 2 0 -1 5 0\""), rot(90, z));
    expectNear(turned("zaxis=\"0 -1 0\""), rot(90, x));
    expectNear(turned("zaxis=\"0 0 -1\""), rot(180, x));
}

TEST(MjcfFile, MeshAssetsHaveScaleAndReference)
{
    const TempFolder folder;
    writeObj(makeBox({1.0, 2.0, 3.0}), folder.path() / "box.obj");
    std::filesystem::create_directories(folder.path() / "assets");
    std::filesystem::rename(folder.path() / "box.obj", folder.path() / "assets/box.obj");
    const auto path = folder.write(
        "m.xml",
        mjcf(R"(<body name="p"><geom type="mesh" mesh="box" pos="0 0 1"/></body>)",
             R"(<compiler meshdir="assets"/><default><mesh scale="0.1 -0.1 0.1"/></default>
                <asset><mesh file="box.obj" refpos="1 0 0"/></asset>)"));
    const RobotModel robot = loadMjcf(path);
    const Eigen::AlignedBox3d box = bounds(robot.linkMeshes[0]);
    EXPECT_NEAR((box.min() - Eigen::Vector3d(-0.2, -0.2, 0.7)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((box.max() - Eigen::Vector3d(0.0, 0.2, 1.3)).norm(), 0.0, 1e-12);
    EXPECT_NEAR(massProperties(robot.linkMeshes[0]).volume, 0.2 * 0.4 * 0.6, 1e-12);

    // The reference comes before the scale: the box is turned, x is its 2, and then x is scaled.
    const auto turned =
        folder.write("t.xml",
                     mjcf(R"(<body name="p"><geom type="mesh" mesh="box" contype="1e300"/></body>)",
                          R"(<compiler meshdir="assets"/><asset><mesh file="box.obj" scale="10 1 1"
                refpos="0 0 1" refquat="1 0 0 1"/></asset>)"));
    const Eigen::AlignedBox3d wide = bounds(loadMjcf(turned).linkMeshes[0]);
    EXPECT_NEAR((wide.min() - Eigen::Vector3d(-20, -1, -4)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((wide.max() - Eigen::Vector3d(20, 1, 2)).norm(), 0.0, 1e-12);
    const auto none = folder.write(
        "n.xml",
        mjcf(R"(<body name="p"><geom type="mesh" mesh="box"/></body>)",
             R"(<compiler meshdir="assets"/><asset><mesh file="box.obj" refquat="0 0 0 0"/>
                </asset>)"));
    EXPECT_NEAR(massProperties(loadMjcf(none).linkMeshes[0]).volume, 48.0, 1e-9);
}

TEST(MjcfFile, IncludesStandWhereTheyAreNamed)
{
    const TempFolder folder;
    folder.write(
        "parts/joint.xml",
        "<mujocoinclude><joint name=\"j\" class=\"c\"/><geom size=\"0.01\"/></mujocoinclude>");
    folder.write("hand.xml",
                 mjcf("<body name=\"p\"><geom size=\"0.01\"/><body name=\"x\">"
                      "<include file=\"parts/joint.xml\"/></body></body>",
                      "<default><default class=\"c\"><joint axis=\"1 0 0\"/></default></default>"));
    const auto scene = folder.write("scene.xml",
                                    "<mujoco><include file=\"hand.xml\"/><worldbody><geom "
                                    "type=\"plane\" size=\"1 1 1\"/></worldbody></mujoco>");
    const RobotModel robot = loadRobot(scene);
    ASSERT_EQ(robot.tree.size(), 2U);
    EXPECT_EQ(robot.tree.links[1].joint.axis, Eigen::Vector3d::UnitX());
    EXPECT_FALSE(robot.linkMeshes[1].triangles.empty());
    EXPECT_THAT(robot.notes, Contains(HasSubstr("1 geoms of the world")));

    // Each file is shallow, and all of them together are not.
    const auto nested = [](const std::string& inner)
    {
        std::string text = inner;
        for (int i = 0; i < 80; ++i)
        {
            text = "<body>" + text + "</body>";
        }
        return text;
    };
    folder.write("deepest.xml", "<mujocoinclude>" + nested("") + "</mujocoinclude>");
    folder.write(
        "deeper.xml",
        "<mujocoinclude>" + nested("<include file=\"deepest.xml\"/>") + "</mujocoinclude>");
    const auto deep = folder.write("deep.xml", mjcf(nested("<include file=\"deeper.xml\"/>")));
    EXPECT_THAT(
        [&] { static_cast<void>(loadRobot(deep)); },
        testing::ThrowsMessage<std::runtime_error>(HasSubstr("more than 200 nested elements")));
}

TEST(MjcfFile, RepeatedClassesAreRefused)
{
    for (const char* const inner : {R"(<default class="main"/>)",
                                    R"(<default class="a"><default class="a"/></default>)",
                                    R"(<default class="a"><default class="b"><default class="a"/>
                                       </default></default>)"})
    {
        EXPECT_THAT(mjcfError(mjcf(R"(<body name="p"><geom size="0.01"/></body>)",
                                   std::string("<default>") + inner + "</default>")),
                    HasSubstr("is there twice: give each class its own name"));
    }
}

TEST(MjcfFile, FramesMoveAndTurnJoints)
{
    const RobotModel robot = loadMjcfText(mjcf(R"(<body name="p"><geom size="0.01"/>
        <body name="s"><frame euler="0 90 0"><joint name="s" type="slide"/></frame>
        <geom size="0.01"/></body>
        <body name="h"><frame pos="1 0 0"><frame euler="0 0 90"><joint name="h" pos="1 0 0"
        axis="1 0 0"/></frame></frame><geom size="0.01"/></body></body>)"));
    const auto centers = [&](double way, double angle)
    {
        const std::vector<double> q{0.0, way, angle};
        const auto X = linkPoses(robot.tree, Eigen::Isometry3d::Identity(), q);
        return std::pair<Eigen::Vector3d, Eigen::Vector3d>(
            X[1] * bounds(robot.linkMeshes[1]).center(),
            X[2] * bounds(robot.linkMeshes[2]).center());
    };
    EXPECT_NEAR((centers(0.5, 0.0).first - Eigen::Vector3d(0.5, 0, 0)).norm(), 0.0, 1e-12);
    // A quarter about y through (1, 1, 0) takes the origin to (1, 0, 1), as z goes to x.
    EXPECT_NEAR((centers(0.0, 90 * kDegree).second - Eigen::Vector3d(1, 0, 1)).norm(), 0.0, 1e-12);
}

TEST(MjcfFile, RangesWithoutWidthLimitOnlyWhatSaysSo)
{
    const std::string body = R"(<body name="p"><geom size="0.01"/>
      <body name="x"><joint name="x" range="0 0" actuatorfrcrange="0 0"/><geom size="0.01"/></body>
      </body>)";
    const RobotModel robot = loadMjcfText(
        mjcf(body, R"(<actuator><motor joint="x" forcerange="0 0" ctrlrange="0 0"/></actuator>)"));
    EXPECT_TRUE(std::isinf(mjcfLink(robot, "x").joint.upper));
    EXPECT_TRUE(std::isinf(mjcfLink(robot, "x").joint.maxEffort));
    const RobotModel still = loadMjcfText(mjcf(
        body, R"(<actuator><motor joint="x" forcelimited="true" forcerange="0 0"/></actuator>)"));
    EXPECT_EQ(mjcfLink(still, "x").joint.maxEffort, 0.0);
}

TEST(MjcfFile, JointsThatFollowAHeldOneAreHeld)
{
    const std::string body = R"(<body name="p"><geom size="0.01"/>
      <body name="a"><joint name="a"/><geom size="0.01"/></body>
      <body name="b"><joint name="b"/><geom size="0.01"/></body>
      <body name="c"><joint name="c"/><geom size="0.01"/></body></body>)";
    const std::string hold = R"(<joint joint1="b" polycoef="0.2 0 0 0 0"/>)";
    const std::string follow = R"(<joint joint1="a" joint2="b" polycoef="0.1 2 0 0 0"/>
      <joint joint1="b" joint2="c" polycoef="0 4 0 0 0"/>)";
    for (const std::string& both : {hold + follow, follow + hold})
    {
        const RobotModel robot = loadMjcfText(mjcf(body, "<equality>" + both + "</equality>"));
        for (const auto& [name, angle] :
             {std::pair{"a", 0.5}, std::pair{"b", 0.2}, std::pair{"c", 0.05}})
        {
            const Link& link = mjcfLink(robot, name);
            EXPECT_EQ(link.joint.type, JointType::Fixed) << name;
            EXPECT_NEAR(link.X_PL0.linear()(1, 0), std::sin(angle), 1e-12) << name;
        }
    }
}

TEST(MjcfFile, ObjectsOfTheSceneAreLeftOutAndArmsKeepTheWorld)
{
    const std::string hand = R"(<body name="p"><freejoint/><geom size="0.01"/>
        <body name="x"><joint name="x"/><geom size="0.01"/></body></body>)";
    const RobotModel free =
        loadMjcfText(mjcf(hand + R"(<body name="ball"><freejoint/><geom size="0.01"/></body>)"));
    EXPECT_EQ(free.tree.size(), 2U);
    EXPECT_EQ(free.tree.links[0].name, "p");
    EXPECT_THAT(free.notes, Contains(HasSubstr("object 'ball'")));
    const RobotModel lamp = loadMjcfText(
        mjcf(hand + R"(<body name="lamp"><joint type="ball"/><geom size="0.01"/></body>)"));
    EXPECT_EQ(lamp.tree.size(), 2U);
    EXPECT_THAT(lamp.notes, Contains(HasSubstr("object 'lamp'")));
    const RobotModel fixed = loadMjcfText(
        mjcf(R"(<geom size="0.1"/><body name="x"><joint name="x"/><geom size="0.01"/></body>)"));
    ASSERT_EQ(fixed.tree.size(), 2U);
    EXPECT_EQ(fixed.tree.links[0].name, "world");
    EXPECT_FALSE(fixed.linkMeshes[0].triangles.empty());
}

TEST(MjcfFile, WhatIsNotUnderstoodIsNamed)
{
    const RobotModel robot =
        loadMjcfText(mjcf(R"(<body name="p" glow="1"><geom size="0.01"/><composite type="grid"/>
                <geom type="hfield" hfield="h"/></body>)",
                          R"(<tendon><spatial name="s"/></tendon>)"));
    EXPECT_THAT(robot.notes,
                Contains(AllOf(HasSubstr("attribute glow of <body>"),
                               HasSubstr("<composite> of body 'p'"),
                               HasSubstr("geom of type hfield"),
                               HasSubstr("<spatial> of <tendon>"))));
}

TEST(MjcfFile, CouplingsThatAreObeyedAreNotNoted)
{
    const RobotModel robot = loadMjcfText(mjcf(
        R"(<body name="p"><geom size="0.01"/><body name="x"><joint name="x"/><geom size="0.01"/>
           </body><body name="y"><joint name="y"/><geom size="0.01"/></body></body>)",
        R"(<equality><joint joint1="x" joint2="y" polycoef="0 1 0 0 0" solref="0.01 1"/></equality>
           <tendon><fixed name="t"><joint joint="x" coef="0"/><joint joint="y" coef="1"/></fixed>
           </tendon><actuator><motor tendon="t" forcerange="-2 2"/></actuator>)"));
    EXPECT_THAT(robot.notes, testing::Not(Contains(HasSubstr("of <joint>"))));
    // What a tendon takes with the coefficient 0 it does not take.
    EXPECT_TRUE(std::isinf(mjcfLink(robot, "x").joint.maxEffort));
    EXPECT_EQ(mjcfLink(robot, "y").joint.maxEffort, 2.0);
}

TEST(MjcfFile, SizesReplaceTheFirstNumbersOfTheirClasses)
{
    const RobotModel robot = loadMjcfText(
        mjcf(R"(<body name="p"><geom class="b" type="box" size="0.1"/></body>)",
             R"(<default><geom size="1 2 0.3"/><default class="b"><geom size="0.4 0.2"/></default>
                </default>)"));
    EXPECT_NEAR(
        (bounds(robot.linkMeshes[0]).max() - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 0.0, 1e-12);
}

TEST(MjcfFile, ErrorsNameElementValueAndRemedy)
{
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"><geom size=\"1\" pos=\"1 2 3 4\"/></body>")),
                HasSubstr("geom: pos holds 4 numbers: give 3"));
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"><geom size=\"1 2 3 4\"/></body>")),
                HasSubstr("geom: size holds 4 numbers: give 1 to 3"));
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"><geom size=\"-1\"/></body>")),
                HasSubstr("geom: size is -1.000000: give a finite number > 0"));
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"><geom name=\"g\" size=\"a\"/></body>")),
                HasSubstr("geom 'g': size holds 'a': give finite numbers"));
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"><geom class=\"mian\" size=\"0.01\"/></body>")),
                HasSubstr("class 'mian' does not exist: did you mean 'main'?"));
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"><geom type=\"mesh\" mesh=\"m\"/></body>")),
                HasSubstr("mesh 'm' is no asset: add a <mesh> to <asset>"));
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"><body name=\"q\"><joint type=\"ball\"/>"
                               "<geom size=\"0.01\"/></body></body>")),
                HasSubstr("type is 'ball': write it as three hinges"));
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"/>", "<include file=\"no.xml\"/>")),
                HasSubstr("no.xml: no such file"));
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"/>", "<include file=\"m.xml\"/>")),
                HasSubstr("included already"));
    EXPECT_THAT(mjcfError(mjcf("")), HasSubstr("worldbody: no body"));
    EXPECT_THAT(mjcfError("<mujoco><worldbody>"), HasSubstr("not XML"));
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"><body name=\"p\"/></body>")),
                HasSubstr("is there twice"));
}

const char* const kTwoJoints = R"(<body name="p"><geom size="0.01"/>
  <body name="x"><joint name="x"/><geom size="0.01"/></body>
  <body name="y"><joint name="y"/><geom size="0.01"/></body></body>)";

TEST(MjcfFile, NamesOfJointsAndTendonsThatNothingHasAreErrors)
{
    const auto error = [](const std::string& sections)
    { return mjcfError(mjcf(kTwoJoints, sections)); };
    EXPECT_THAT(
        error("\n<equality>\n<joint name=\"e\" joint1=\"x\" joint2=\"yy\"/></equality>"),
        HasSubstr("m.xml:4: joint 'e': joint2 is 'yy', which is no joint: did you mean 'y'?"));
    EXPECT_THAT(error("<equality><joint joint2=\"y\"/></equality>"),
                HasSubstr("m.xml:2: joint: joint1 is missing: did you mean 'x'?"));
    EXPECT_THAT(error("<actuator>\n<motor name=\"a\" joint=\"z\"/></actuator>"),
                HasSubstr("m.xml:3: motor 'a': joint is 'z', which is no joint"));
    const std::string tendon =
        "<tendon><fixed name=\"both\"><joint joint=\"x\" coef=\"1\"/></fixed></tendon>";
    EXPECT_THAT(error(tendon + "<actuator><motor tendon=\"bth\"/></actuator>"),
                HasSubstr("tendon is 'bth', which is no tendon: did you mean 'both'?"));
    EXPECT_THAT(error(tendon + "<equality><tendon tendon1=\"bth\"/></equality>"),
                HasSubstr("tendon1 is 'bth', which is no tendon: did you mean 'both'?"));
    EXPECT_THAT(
        error("<tendon><fixed name=\"t\"><joint joint=\"x\" coef=\"one\"/></fixed></tendon>"),
        HasSubstr("coef is 'one': give a finite number"));
    // Joints of what is left out have names, and what is replicated gets them.
    const std::string ball = R"(<body name="ball"><freejoint name="f"/><geom size="0.01"/></body>)";
    const std::string follows = R"(<actuator><motor joint="f"/></actuator>)";
    EXPECT_THAT(loadMjcfText(mjcf(kTwoJoints + ball, follows)).notes,
                Contains(HasSubstr("line 2: motor of joint 'f', which no link has")));
    EXPECT_NE(mjcfError(mjcf(kTwoJoints, follows)), "");
    EXPECT_EQ(mjcfError(mjcf(std::string(kTwoJoints) + "<replicate count=\"2\"/>", follows)), "");
}

TEST(MjcfFile, RangesThatAreTurnedRoundAreErrors)
{
    const auto body = [](const std::string& attributes)
    {
        return mjcf("<body name=\"p\"><geom size=\"0.01\"/><body name=\"q\"><joint name=\"q\" " +
                    attributes + "/><geom size=\"0.01\"/></body></body>");
    };
    EXPECT_THAT(
        mjcfError(body("range=\"60 -30\"")),
        HasSubstr("m.xml:2: joint 'q': range is '60 -30', and its first number is above its "
                  "second: give the lower limit first"));
    EXPECT_THAT(mjcfError(body("actuatorfrcrange=\"1 -1\"")), HasSubstr("actuatorfrcrange is"));
    EXPECT_EQ(mjcfError(body("range=\"60 -30\" limited=\"false\"")), "");
    for (const char* const attribute : {"forcerange", "ctrlrange"})
    {
        EXPECT_THAT(mjcfError(mjcf(kTwoJoints,
                                   std::string("<actuator><position joint=\"x\" ") + attribute +
                                       "=\"4 -4\"/></actuator>")),
                    HasSubstr(std::string("position: ") + attribute + " is '4 -4', and its first"));
    }
}

TEST(MjcfFile, UnknownElementsAndAttributesAreNotedWithLineValueAndRemedy)
{
    const TempFolder folder;
    folder.write("default.xml",
                 "<mujocoinclude>\n<default>\n<joint ranje=\"0 1\"/><jiont range=\"0 1\"/>"
                 "</default></mujocoinclude>");
    const RobotModel robot = loadRobot(
        folder.write("m.xml",
                     mjcf(kTwoJoints,
                          "\n<include file=\"default.xml\"/><actuators/>\n<asset><mehs/></asset>"
                          "<actuator><motr joint=\"x\"/></actuator>")));
    for (const char* const note :
         {"default.xml line 3: attribute ranje of <joint> ('0 1'; did you mean range?)",
          "default.xml line 3: unknown element <jiont> of <default> (did you mean <joint>?)",
          "line 3: unknown element <actuators> of <mujoco> (did you mean <actuator>?)",
          "line 4: unknown element <mehs> of <asset> (did you mean <mesh>?)",
          "line 4: unknown element <motr> of <actuator> (did you mean <motor>?)"})
    {
        EXPECT_THAT(robot.notes, Contains(HasSubstr(note)));
    }
}

TEST(RobotFile, SizesOfNoRobotNameTheirFile)
{
    EXPECT_THAT(mjcfError(mjcf("<body name=\"p\"><geom name=\"g\" type=\"box\" size=\"1e30 1 1\"/>"
                               "</body>")),
                HasSubstr("m.xml:2: geom 'g': its geometry reaches 1e+30 m"));
    const TempFolder folder;
    const auto urdf =
        folder.write("r.urdf",
                     "<robot name=\"r\"><link name=\"a\"><collision><geometry>"
                     "<box size=\"1e30 1 1\"/></geometry></collision></link></robot>");
    EXPECT_THAT([&] { static_cast<void>(loadRobot(urdf)); },
                testing::ThrowsMessage<std::runtime_error>(
                    AllOf(HasSubstr("r.urdf"), HasSubstr("reaches 5e+29 m"))));
}

TEST(RobotFile, FormatsAreToldByTheirContent)
{
    const TempFolder folder;
    const std::string urdf = "<robot name=\"r\"><link name=\"a\"/></robot>";
    EXPECT_EQ(loadRobot(folder.write("r.xml", urdf)).name, "r");
    const auto error = [&](const std::string& text, const auto& load)
    {
        try
        {
            static_cast<void>(load(folder.write("e.urdf", text)));
        }
        catch (const std::runtime_error& thrown)
        {
            return std::string(thrown.what());
        }
        return std::string();
    };
    const std::string xacro =
        "<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\"><link name=\"${1}\"/></robot>";
    EXPECT_THAT(error(mjcf(""), loadUrdf), HasSubstr("this is MJCF, and a URDF is expected"));
    EXPECT_THAT(error(xacro, loadUrdf), HasSubstr("this is xacro, and a URDF is expected: run"));
    EXPECT_THAT(error("<sdf version=\"1.6\"/>", loadRobot), HasSubstr("this is SDF"));
    // What xacro has expanded still declares its namespace.
    EXPECT_EQ(loadRobot(folder.write("x.urdf",
                                     "<robot name=\"r\" xmlns:xacro=\"x\"><link name=\"a\"/>"
                                     "</robot>"))
                  .name,
              "r");
    // Comments and text do not make a file xacro.
    EXPECT_EQ(loadRobot(folder.write("c.urdf",
                                     "<robot name=\"r\" xmlns:xacro=\"x\"><!-- <xacro:a/> ${1} "
                                     "--><link name=\"a\"/><gazebo>${2}</gazebo></robot>"))
                  .name,
              "r");
}

TEST(RobotFile, XacroIsExpandedByTheProgramOfThatName)
{
    const TempFolder folder;
    const auto path =
        folder.write("my robot's.xacro",
                     "<robot name=\"r\" xmlns:xacro=\"x\"><xacro:include filename=\"y\"/></robot>");
    const std::string before = std::getenv("PATH");
    ::setenv("PATH", folder.path().c_str(), 1);
    std::string error;
    try
    {
        static_cast<void>(loadRobot(path));
    }
    catch (const std::runtime_error& thrown)
    {
        error = thrown.what();
    }
    EXPECT_THAT(error, AllOf(HasSubstr("not on the PATH"), HasSubstr("xacro '")));
    // A stand-in for the program: it shows the name that it was given.
    const auto program = folder.write(
        "xacro", "#!/bin/sh\necho \"<robot name=\\\"${1##*/}\\\"><link name='a'/></robot>\"\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    ::setenv("PATH", (folder.path().string() + ":" + before).c_str(), 1);
    EXPECT_EQ(loadRobot(path).name, "my robot's.xacro");
    folder.write("xacro", "#!/bin/sh\nexit 3\n");
    EXPECT_THROW(static_cast<void>(loadRobot(path)), std::runtime_error);
    ::setenv("PATH", before.c_str(), 1);
}

}  // namespace
}  // namespace bullet_ccd
