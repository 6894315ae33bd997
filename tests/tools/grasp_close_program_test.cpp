// `grasp close`: the shipped parallel gripper, whose joint position is the distance of its pads
// from the middle, on a box. So all that comes out is known beforehand.
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/run_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kHalfWidth = 0.02;  // of the box, along the jaws' way [m]
constexpr double kTolerance = 2e-5;  // links stop at most this far from the box [m]
constexpr double kOpen = 0.05;       // preshape "open" [m]
constexpr double kHalfOpen = 0.025;  // preshape "half_open" [m]
constexpr double kSpeed = 0.1;       // of closing sliders [m/s]
constexpr double kAround = -0.13;    // z of the hand that has the box between its pads
constexpr const char* kUpright = " 1 0 0 0";

class GraspClose : public ::testing::Test
{
protected:
    void SetUp() override { writeObj(makeBox({kHalfWidth, 0.015, 0.015}), m_box); }

    [[nodiscard]] Outcome close(const std::string& pose, const std::string& more = "") const
    {
        return runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) +
                          " close --hand parallel_gripper --object '" + m_box.string() +
                          "' --pose " + pose + " " + more);
    }
    [[nodiscard]] static std::string at(double x, double z)
    {
        return std::to_string(x) + " 0 " + std::to_string(z) + kUpright;
    }

    tests::TempFolder m_temp;
    fs::path m_box = m_temp.path() / "box.obj";
};

double jawOf(const Json& record)
{
    return record.at("joints").at("left_jaw_joint");
}

TEST_F(GraspClose, JawsStopAtTheSidesOfABoxBetweenThem)
{
    for (const char* engine : {"kinematic", "simulated"})
    {
        const Outcome closed = close(at(0.0, kAround), std::string("--json -q --engine ") + engine);
        EXPECT_EQ(closed.exitCode, 0) << closed.err;
        EXPECT_EQ(closed.err, "");
        const Json record = Json::parse(closed.out);
        EXPECT_TRUE(record["reject"].is_null()) << engine;
        EXPECT_TRUE(record["quality"]["force_closure"]);
        EXPECT_TRUE(record["squeeze"]["reason"].is_null());
        EXPECT_FALSE(record["squeeze"]["joints"].empty());
        EXPECT_GT(jawOf(record), kHalfWidth);
        EXPECT_LE(jawOf(record), kHalfWidth + kTolerance + 1e-6);
        ASSERT_FALSE(record["stops"].empty());
        EXPECT_NEAR(
            record["stops"][0]["time_s"].get<double>(), (kOpen - kHalfWidth) / kSpeed, 1e-3);
        EXPECT_EQ(record["stops"][0]["by"], "object");
        std::set<std::string> flat;
        for (const Json& contact : record["contacts"])
        {
            // The left jaw is the one on the side of positive x.
            const double side = contact["link"] == "left_jaw" ? 1.0 : -1.0;
            EXPECT_NEAR(contact["point_m"][0].get<double>(), side * kHalfWidth, 1e-9);
            // Where an edge of the box meets the rim of a pad the normal is between the two.
            const double along = -side * contact["normal_into_object"][0].get<double>();
            EXPECT_GT(along, 0.0);
            if (along > 1.0 - 1e-6)
            {
                flat.insert(contact["link"]);
            }
            EXPECT_LE(contact["gap_m"].get<double>(), 1e-4);
        }
        EXPECT_THAT(flat, ::testing::ElementsAre("left_jaw", "right_jaw")) << engine;
    }
}

TEST_F(GraspClose, AnAccuracySaysHowNearIsNearEnough)
{
    const double accuracy = 2e-3;
    const Outcome closed = close(at(0.0, kAround), "--json -q --accuracy 2e-3");
    EXPECT_EQ(closed.exitCode, 0) << closed.err;
    const Json record = Json::parse(closed.out);
    EXPECT_TRUE(record["reject"].is_null());
    EXPECT_TRUE(record["quality"]["force_closure"]);
    EXPECT_GT(jawOf(record), kHalfWidth);
    EXPECT_LE(jawOf(record), kHalfWidth + accuracy);
    for (const char* wrong : {"0", "-1", "1e-10", "nan"})
    {
        const Outcome refused = close(at(0.0, kAround), std::string("--accuracy ") + wrong);
        EXPECT_EQ(refused.exitCode, 2) << wrong;
        EXPECT_THAT(refused.err, HasSubstr("from 1e-09 to"));
    }
}

TEST_F(GraspClose, SaysWhatAnAccuracyNeededAndLoadsOnlyWhatIsInReach)
{
    EXPECT_THAT(close(at(0.0, kAround), "-q").out, Not(HasSubstr("needed")));
    // A bar that passes by, in a box that the hand is in, and a bar far away.
    writeObj(makeBox({0.5, 0.005, 0.005}), m_temp.path() / "bar.obj");
    m_temp.write("scene.csv",
                 "mesh,name,qw,qx,qy,qz,tx,ty,tz\n"
                 "bar.obj,near,0.9238795325112867,0,0,0.3826834323650898,0.3,-0.3,0\n"
                 "bar.obj,far,1,0,0,0,3,0,0\n");
    const std::string folder = "'" + m_temp.path().string() + "/";
    const Outcome made = runProgram(std::string(BULLET_CCD_PROGRAM) + " manifest " + folder +
                                    "scene.csv' -o " + folder + "listed.csv'");
    ASSERT_EQ(made.exitCode, 0) << made.err;
    const auto withScene = [&](const char* scene)
    { return close(at(0.0, kAround), "-q --accuracy 1e-3 --scene " + folder + scene + "'"); };
    const Outcome whole = withScene("scene.csv");
    EXPECT_EQ(whole.exitCode, 0) << whole.err;
    EXPECT_THAT(whole.out, HasSubstr("\nclosing needed 2 of 6 bodies, 2 of "));
    const Outcome listed = withScene("listed.csv");
    const std::string note = "obstacles out of reach, not loaded: 1 of 2\n";
    EXPECT_THAT(listed.out, HasSubstr(note));
    std::string rest = listed.out;
    ASSERT_NE(rest.find(note), std::string::npos);
    rest.erase(rest.find(note), note.size());
    EXPECT_EQ(rest, whole.out);  // obstacles that share a mesh have its triangles once
}

TEST_F(GraspClose, WritesAndDrawsWhatAnAccuracyNeeded)
{
    const std::filesystem::path out = m_temp.path() / "out";
    const auto closeInto = [&](const std::string& options)
    { return close(at(0.0, kAround), options + " -q -o '" + out.string() + "'"); };
    const Outcome closed = closeInto("--accuracy 1e-3");
    ASSERT_EQ(closed.exitCode, 0) << closed.err;
    EXPECT_THAT(closed.out, HasSubstr("needed.json"));
    const Json report = Json::parse(contentOf(out / "needed.json"));
    EXPECT_EQ(report["accuracy"], 1e-3);
    std::size_t triangles = 0;
    std::size_t of = 0;
    for (const Json& part : report["parts"])
    {
        EXPECT_EQ(part.contains("object") + part.contains("link"), 1);
        triangles += part["triangles"].get<std::size_t>();
        of += part["of_triangles"].get<std::size_t>();
    }
    EXPECT_EQ(report["needed"]["triangles"], triangles);
    EXPECT_EQ(report["needed"]["of_triangles"], of);
    EXPECT_GT(triangles, 0u);
    // All triangles are drawn, and as many in orange as were looked at.
    const std::string picture = contentOf(out / "needed.ply");
    const std::size_t begin = picture.find("end_header\n") + 11;
    EXPECT_THAT(picture.substr(0, begin), HasSubstr("element face " + std::to_string(of) + "\n"));
    constexpr std::size_t kFaceBytes = 16;
    std::size_t orange = 0;
    for (std::size_t end = picture.size(); end > picture.size() - of * kFaceBytes;
         end -= kFaceBytes)
    {
        orange += picture.substr(end - 3, 3) == "\xE6\x6E\x14" ? 1 : 0;
    }
    EXPECT_EQ(orange, triangles);
    // A scene may state the accuracy, and it has one.
    m_temp.write("scene.yaml", "accuracy: 2e-3\nobstacles: []\n");
    const std::string scene = " --scene '" + (m_temp.path() / "scene.yaml").string() + "'";
    EXPECT_EQ(closeInto(scene).exitCode, 0);
    EXPECT_EQ(Json::parse(contentOf(out / "needed.json"))["accuracy"], 2e-3);
    EXPECT_EQ(closeInto("--accuracy 2e-3" + scene).exitCode, 0);
    const Outcome both = closeInto("--accuracy 1e-3" + scene);
    EXPECT_EQ(both.exitCode, 3);
    EXPECT_THAT(both.err, HasSubstr("0.002 is not the 0.001"));
    // They would be mistaken for those of a run that had none.
    EXPECT_EQ(closeInto("").exitCode, 0);
    EXPECT_FALSE(std::filesystem::exists(out / "needed.json"));
    EXPECT_FALSE(std::filesystem::exists(out / "needed.ply"));
}

TEST_F(GraspClose, PrintsWhatPeopleWantToKnow)
{
    const Outcome closed = close(at(0.0, kAround), "-q");
    EXPECT_EQ(closed.exitCode, 0) << closed.err;
    for (const char* text : {"stopped",
                             "left_jaw_joint",
                             "right_jaw_joint",
                             "0.0200",
                             "contact of",
                             ": force closure (mu 0.5",
                             "no penetration, by the independent check"})
    {
        EXPECT_THAT(closed.out, HasSubstr(text));
    }
}

TEST_F(GraspClose, TheFirstJawToTouchStopsBoth)
{
    // 5 mm off the middle the right pad touches at 25 mm; the left one is then 10 mm away.
    constexpr double kOff = 0.005;
    const Outcome closed = close(at(kOff, kAround), "--json -q");
    EXPECT_EQ(closed.exitCode, 0) << closed.err;
    const Json record = Json::parse(closed.out);
    EXPECT_NEAR(jawOf(record), kHalfWidth + kOff, kTolerance + 1e-6);
    EXPECT_NEAR(
        record["stops"][0]["time_s"].get<double>(), (kOpen - kHalfWidth - kOff) / kSpeed, 1e-3);
    EXPECT_EQ(record["stops"][0]["link"], "right_jaw");
    for (const Json& contact : record["contacts"])
    {
        EXPECT_EQ(contact["link"], "right_jaw");
    }
    EXPECT_FALSE(record["quality"]["force_closure"]);
    EXPECT_EQ(record["squeeze"]["reason"], "no force closure");
}

TEST_F(GraspClose, ThePreshapeIsChosenByName)
{
    const Json record = Json::parse(close(at(0.0, kAround), "--json -q --preshape half_open").out);
    EXPECT_EQ(record["preshape"], "half_open");
    EXPECT_NEAR(
        record["stops"][0]["time_s"].get<double>(), (kHalfOpen - kHalfWidth) / kSpeed, 1e-3);
    const Outcome unknown = close(at(0.0, kAround), "--preshape fist");
    EXPECT_EQ(unknown.exitCode, 3);
    EXPECT_THAT(
        unknown.err,
        HasSubstr("parallel_gripper.urdf: no preshape \"fist\": the hand has open, half_open"));
}

TEST_F(GraspClose, AnApproachEndsAtItsDistanceOrAtTheFirstContact)
{
    const Outcome all = close(at(0.0, kAround - 0.2), "--json -q --approach 0 0 2 0.2");
    EXPECT_EQ(all.exitCode, 0) << all.err;
    const Json record = Json::parse(all.out);
    EXPECT_NEAR(record["approach"]["travel_to_contact_m"].get<double>(), 0.2, 1e-12);
    EXPECT_NEAR(record["hand_pose_in_object"]["position_m"][2].get<double>(), kAround, 1e-12);
    EXPECT_NEAR(jawOf(record), kHalfWidth, kTolerance + 1e-6);

    const Outcome palm = close(at(0.0, kAround - 0.2), "--json -q --approach 0 0 1 0.5");
    EXPECT_EQ(palm.exitCode, 0) << palm.err;
    const Json deeper = Json::parse(palm.out);
    EXPECT_GT(deeper["approach"]["travel_to_contact_m"].get<double>(), 0.2);
    EXPECT_LT(deeper["approach"]["travel_to_contact_m"].get<double>(), 0.3);
    const Json& contacts = deeper["contacts"];
    EXPECT_TRUE(std::any_of(contacts.begin(),
                            contacts.end(),
                            [](const Json& contact) {
                                return contact["link"] == "base" &&
                                       contact["normal_into_object"][2].get<double>() > 0.999;
                            }))
        << contacts;
}

TEST_F(GraspClose, ExitsWith1WhenNothingIsTouched)
{
    const Outcome closed = close(at(0.0, -1.0));
    EXPECT_EQ(closed.exitCode, 1);
    EXPECT_THAT(closed.err, HasSubstr("nothing touched"));
    EXPECT_THAT(closed.out, HasSubstr("left_jaw_joint   0.000000"));
    EXPECT_THAT(closed.out, Not(HasSubstr("contact of")));
}

TEST_F(GraspClose, ExitsWith1AndNamesALinkThatOverlapsAtTheStart)
{
    // 10 mm off the middle the right pad of the half open jaws is at -15 mm: in the box.
    const Outcome jaw = close(at(0.01, kAround), "--preshape half_open");
    EXPECT_EQ(jaw.exitCode, 1);
    EXPECT_THAT(jaw.err, HasSubstr("overlap at start: link right_jaw intersects the object"));
    const Outcome base = close(at(0.0, -0.03), "--json");
    EXPECT_EQ(base.exitCode, 1);
    EXPECT_THAT(base.err, HasSubstr("overlap at start: link base"));
    EXPECT_EQ(Json::parse(base.out)["reject"], "overlap at start");
}

TEST_F(GraspClose, NumbersThatMakeNoSenseExitWith2)
{
    const Outcome quaternion = close("0 0 -0.13 1 1 0 0");
    EXPECT_EQ(quaternion.exitCode, 2);
    EXPECT_THAT(quaternion.err, HasSubstr("has length 1.41421: normalise it to 1"));
    EXPECT_EQ(close("0 0 -0.13").exitCode, 2);
    EXPECT_EQ(close("0 0 nan 1 0 0 0").exitCode, 2);
    EXPECT_EQ(close(at(0.0, kAround), "--approach 0 0 1").exitCode, 2);
    const Outcome direction = close(at(0.0, kAround), "--approach 0 0 0 0.1");
    EXPECT_EQ(direction.exitCode, 2);
    EXPECT_THAT(direction.err, HasSubstr("--approach"));
    EXPECT_EQ(close(at(0.0, kAround), "--approach 0 0 1 -0.1").exitCode, 2);
    EXPECT_EQ(close(at(0.0, kAround), "--engine steam").exitCode, 2);
}

TEST_F(GraspClose, WritesTheFilesOfAPlanThatTheCheckAccepts)
{
    const fs::path out = m_temp.path() / "out";
    const Outcome closed = close(at(0.0, kAround), "-q -o '" + out.string() + "'");
    EXPECT_EQ(closed.exitCode, 0) << closed.err;
    for (const char* name :
         {"grasps.jsonl", "grasps.isaac.yaml", "report.html", "grasp_01.png", "grasp_01.glb"})
    {
        EXPECT_TRUE(fs::exists(out / name)) << name;
        EXPECT_THAT(closed.out, HasSubstr((out / name).string()));
    }
    const Outcome checked = runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " check '" +
                                       (out / "grasps.jsonl").string() + "'");
    EXPECT_EQ(checked.exitCode, 0) << checked.out << checked.err;
}
}  // namespace
}  // namespace bullet_ccd::tools
