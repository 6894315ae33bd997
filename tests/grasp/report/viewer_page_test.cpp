#include "grasp/report/viewer_page.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/report/closing_spans.h"
#include "grasp/report/packed_mesh.h"
#include "tests/grasp/report/report_scene.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace bullet_ccd::grasp
{
namespace
{
/// The bytes that a text of base64 stands for, by their definition: six bits a letter.
std::vector<std::uint8_t> bytesOfBase64(const std::string& text)
{
    constexpr std::string_view kLetters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<std::uint8_t> bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char letter : text)
    {
        if (letter == '=')
        {
            break;
        }
        bits = bits << 6U | static_cast<std::uint32_t>(kLetters.find(letter));
        count += 6;
        if (count >= 8)
        {
            count -= 8;
            bytes.push_back(static_cast<std::uint8_t>(bits >> static_cast<unsigned>(count)));
        }
    }
    return bytes;
}

TEST(PackedMesh, Base64IsThatOfTheStandard)
{
    // The test vectors of RFC 4648, section 10.
    const std::array<std::pair<std::string, std::string>, 4> vectors = {
        {{"", ""}, {"fo", "Zm8="}, {"foob", "Zm9vYg=="}, {"foobar", "Zm9vYmFy"}}};
    for (const auto& [plain, coded] : vectors)
    {
        EXPECT_EQ(base64(std::vector<std::uint8_t>(plain.begin(), plain.end())), coded);
    }
}

TEST(PackedMesh, VerticesAreOffByHalfAStepAtMostAndTrianglesNotAtAll)
{
    TriangleMesh mesh = makeSphere(0.04, 3);
    for (Eigen::Vector3d& vertex : mesh.vertices)
    {
        vertex += Eigen::Vector3d(0.3, -2.0, 0.01);
    }
    const PackedMesh packed = packMesh(mesh);
    const std::vector<std::uint8_t> points = bytesOfBase64(packed.points);
    ASSERT_EQ(points.size(), 6 * mesh.vertices.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < 3 * mesh.vertices.size(); ++i)
    {
        const auto axis = static_cast<Eigen::Index>(i % 3);
        const double value =
            packed.origin[axis] + packed.step[axis] * (points[2 * i] + 256 * points[2 * i + 1]);
        worst = std::max(worst, std::abs(value - mesh.vertices[i / 3][axis]));
    }
    EXPECT_LE(worst, 0.5 * packed.step.maxCoeff() * (1.0 + 1e-9));
    EXPECT_GT(worst, 0.1 * packed.step.maxCoeff());  // they are rounded indeed
    EXPECT_NEAR(packed.step.maxCoeff(), 0.08 / 65535.0, 1e-9);
    const std::vector<std::uint8_t> corners = bytesOfBase64(packed.triangles);
    ASSERT_EQ(corners.size(), 12 * mesh.triangles.size());
    for (std::size_t i = 0; i < 3 * mesh.triangles.size(); ++i)
    {
        const int corner = corners[4 * i] + 256 * corners[4 * i + 1] + 65536 * corners[4 * i + 2];
        EXPECT_EQ(corner, mesh.triangles[i / 3][i % 3]);
    }
}

TEST(PackedMesh, AFlatMeshKeepsItsPlane)
{
    const TriangleMesh mesh{.vertices = {{0, 0, 0.5}, {1, 0, 0.5}, {0, 1, 0.5}},
                            .triangles = {{0, 1, 2}}};
    const PackedMesh packed = packMesh(mesh);
    EXPECT_EQ(packed.origin.z(), 0.5);
    EXPECT_EQ(packed.step.z(), 0.0);
}

/// Both fingers of the box hand turn about y by up to one radian, or slide by up to 0.05 m.
HandModel closingBoxHand()
{
    HandModel hand = tests::makeBoxHand();
    Joint& left = hand.robot.tree.links[1].joint;
    left = {.name = "left", .type = JointType::Revolute, .lower = -1.0, .upper = 1.0};
    Joint& right = hand.robot.tree.links[2].joint;
    right = {.name = "right", .type = JointType::Prismatic, .lower = -0.05, .upper = 0.05};
    hand.closingDirections = {0, 1, -1};
    hand.linkTrees.assign(3, nullptr);
    return hand;
}

TEST(ClosingSpans, JointsMoveFromTheStartUntilTheyAreStoppedOrAtTheirLimits)
{
    const HandModel hand = closingBoxHand();
    Grasp grasp = tests::makeBoxGrasp(2);
    grasp.positions = {0.0, 0.3, -0.05};
    grasp.stops = {{.link = 1, .time = 0.3}};
    const ClosingSpans together = closingSpans(hand, grasp, {});
    EXPECT_EQ(together.from, (std::vector<double>{0.0, 0.0, 0.0}));
    EXPECT_EQ(together.joints[1].begin, 0.0);
    EXPECT_EQ(together.joints[1].end, 0.3);  // by the stop: 1 rad/s
    EXPECT_EQ(together.joints[2].begin, 0.0);
    EXPECT_DOUBLE_EQ(together.joints[2].end, 0.5);  // at the limit: 0.1 m/s
    EXPECT_DOUBLE_EQ(together.end, 0.5);
}

TEST(ClosingSpans, AFingerThatWaitsBeginsWhenTheOneBeforeItHasStopped)
{
    const HandModel hand = closingBoxHand();
    Grasp grasp = tests::makeBoxGrasp(2);
    grasp.positions = {0.0, 0.3, -0.02};
    grasp.stops = {{.link = 1, .time = 0.3}, {.link = 2, .time = 0.5}};
    const ClosingSpans inTurns = closingSpans(hand, grasp, {.order = ClosingOrder::OneByOne});
    EXPECT_EQ(inTurns.joints[1].begin, 0.0);
    EXPECT_EQ(inTurns.joints[1].end, 0.3);
    EXPECT_EQ(inTurns.joints[2].begin, 0.3);
    EXPECT_EQ(inTurns.joints[2].end, 0.5);
    EXPECT_EQ(inTurns.end, 0.5);
}

TEST(ClosingSpans, SlowJointsAreShownAtTheUsualSpeed)
{
    HandModel hand = closingBoxHand();
    hand.closingSpeeds = {1.0, 1.0, 0.1};
    Grasp grasp = tests::makeBoxGrasp(2);
    grasp.positions = {0.0, 0.3, -0.05};
    grasp.stops = {{.link = 1, .time = 0.3}};
    const ClosingSpans spans = closingSpans(hand, grasp, {});
    EXPECT_DOUBLE_EQ(spans.end, 5.0);  // at the limit: 0.01 m/s
    ASSERT_EQ(spans.pace.size(), 3U);
    EXPECT_EQ(spans.pace[0], (std::array{0.0, 0.0}));
    EXPECT_EQ(spans.pace[1], (std::array{0.3, 0.3}));     // the left finger runs at its usual speed
    EXPECT_DOUBLE_EQ(spans.pace[2][0], 0.3 + 0.1 * 4.7);  // the right one alone, at a tenth
    EXPECT_DOUBLE_EQ(spans.pace[2][1], 5.0);
}

TEST(ClosingSpans, AGraspThatNeverClosedRestsInItsPreshape)
{
    const HandModel hand = closingBoxHand();
    Grasp grasp = tests::makeBoxGrasp(0);
    grasp.positions.clear();
    const ClosingSpans spans = closingSpans(hand, grasp, {});
    EXPECT_EQ(spans.from, (std::vector<double>{0.0, 0.0, 0.0}));
    EXPECT_EQ(spans.end, 0.0);
}

std::string contentOfPage(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// A page of a viewer that is nothing but its two marks.
std::string viewerPage(const std::string& objectName, const PageExtras& extras)
{
    const std::filesystem::path viewer = tests::outputFile("viewer.html");
    std::ofstream(viewer) << "<title>@TITLE@</title><script>@DATA@</script>";
    const HandModel hand = closingBoxHand();
    std::vector<Grasp> grasps = {tests::makeBoxGrasp(2), tests::makeBoxGrasp(0)};
    grasps[1].reject = RejectReason::OverlapAtStart;
    grasps[1].positions.clear();
    grasps[1].preshape = "of another hand";
    const GraspObject object = makeGraspObject(objectName, makeBox({0.05, 0.05, 0.05}));
    const std::filesystem::path file = tests::outputFile("page.html");
    writeViewerPage({}, hand, object, grasps, extras, viewer, file);
    return contentOfPage(file);
}

nlohmann::json dataOfPage(const std::string& page)
{
    const std::size_t begin = page.find("<script>") + 8;
    return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

TEST(ViewerPage, NamesCannotLeaveTheirPlaces)
{
    const std::string page = viewerPage("</script><b>@DATA@", {});
    EXPECT_EQ(page.find("<b>"), std::string::npos);
    EXPECT_NE(page.find("Grasps of &lt;/script&gt;&lt;b&gt;@DATA@ by box_hand"), std::string::npos);
    EXPECT_EQ(dataOfPage(page)["object"]["name"], "</script><b>@DATA@");
}

TEST(ViewerPage, EqualMeshesAreThereOnce)
{
    const SsvTree tree = buildSsvTree(makeBox({0.05, 0.05, 0.05}));
    const std::array<RigidBody, 2> obstacles = {RigidBody{.tree = &tree, .motion = {}},
                                                RigidBody{.tree = &tree, .motion = {}}};
    const nlohmann::json data = dataOfPage(viewerPage("box", {.obstacles = obstacles}));
    EXPECT_EQ(data["meshes"].size(), 3U);  // palm, finger, object
    EXPECT_EQ(data["links"][1]["mesh"], data["links"][2]["mesh"]);
    EXPECT_NE(data["links"][0]["mesh"], data["links"][1]["mesh"]);
    for (const nlohmann::json& obstacle : data["obstacles"])
    {
        EXPECT_EQ(obstacle["mesh"], data["object"]["mesh"]);
    }
}

TEST(ViewerPage, AGraspThatNeverClosedHasAStartAlone)
{
    const nlohmann::json data =
        dataOfPage(viewerPage("box", {.command = "grasp close", .graspFiles = {{"a.png"}}}));
    EXPECT_EQ(data["command"], "grasp close");
    EXPECT_EQ(data["grasps"][0]["files"][0], "a.png");
    EXPECT_EQ(data["grasps"][0]["contacts"].size(), 2U);
    EXPECT_TRUE(data["grasps"][0]["volume"].is_null());  // it was not computed
    EXPECT_TRUE(data["grasps"][1]["hand"].is_null());
    EXPECT_FALSE(data["grasps"][1].contains("joints"));
    EXPECT_EQ(data["grasps"][1]["start"].size(), 7U);
    EXPECT_EQ(data["preshapes"].size(), 1U);
}

TEST(ViewerPage, AFileThatIsNoViewerIsNamedInTheError)
{
    const std::filesystem::path viewer = tests::outputFile("no_viewer.html");
    std::ofstream(viewer) << "@DATA@ before @TITLE@";
    const GraspObject object = makeGraspObject("box", makeBox({0.05, 0.05, 0.05}));
    try
    {
        writeViewerPage(
            {}, tests::makeBoxHand(), object, {}, {}, viewer, tests::outputFile("none.html"));
        FAIL() << "no exception";
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_NE(std::string(error.what()).find(viewer.string()), std::string::npos);
    }
}
}  // namespace
}  // namespace bullet_ccd::grasp
