#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/report/grasp_picture.h"
#include "tests/grasp/report/report_scene.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace bullet_ccd::grasp
{
namespace
{
std::size_t countOf(const std::string& text, const std::string& part)
{
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    {
        ++count;
    }
    return count;
}

std::string readText(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<Grasp> threeGrasps()
{
    std::vector<Grasp> grasps = {
        tests::makeBoxGrasp(6), tests::makeBoxGrasp(3), tests::makeBoxGrasp(0)};
    grasps[0].quality = {.epsilon = 0.25, .volume = 1.5, .forceClosure = true};
    grasps[1].reject = RejectReason::NoForceClosure;
    grasps[2].reject = RejectReason::NoApproachHit;
    grasps[2].preshape = "flat & <wide>";
    return grasps;
}

std::string page(const std::string& objectName)
{
    HandModel hand = tests::makeBoxHand();
    hand.robot.name = "<b>hand</b>";
    hand.notes = {"closing of \"a\" < inferred & noted"};
    const GraspObject object = makeGraspObject(objectName, makeBox({0.05, 0.05, 0.05}));
    const std::filesystem::path file = tests::outputFile("report.html");
    const std::vector<std::filesystem::path> pictures = {tests::outputFile("pictures") /
                                                         "best #1 100%.png"};
    writeReport({}, hand, object, threeGrasps(), pictures, file);
    return readText(file);
}

TEST(Report, HasOneRowForEveryGrasp)
{
    const std::string text = page("box");
    const std::size_t begin = text.find("<tbody>", text.find("id=\"grasps\""));
    const std::string body = text.substr(begin, text.find("</tbody>", begin) - begin);
    EXPECT_EQ(countOf(body, "<tr>"), 3U);
    // Two volumes were not asked for.
    EXPECT_EQ(countOf(body, ">–</td>"), 2U);
    EXPECT_EQ(countOf(body, "force closure"), 2U);  // one has it, one has not
    EXPECT_EQ(countOf(body, "no approach hit"), 1U);
    EXPECT_NE(body.find(">0.2500<"), std::string::npos);
}

TEST(Report, TilesCountWhatWasFound)
{
    const std::string text = page("box");
    EXPECT_NE(text.find("<b>3</b><span>candidates</span>"), std::string::npos);
    EXPECT_NE(text.find("<b>1</b><span>force closures</span>"), std::string::npos);
    EXPECT_NE(text.find("<b>0.2500</b><span>best epsilon</span>"), std::string::npos);
    EXPECT_NE(text.find("<b>1</b><span>no force closure</span>"), std::string::npos);
    EXPECT_EQ(text.find("<span>penetration</span>"), std::string::npos);
}

TEST(Report, NamesAreEscaped)
{
    const std::string text = page("<script>alert(1)</script> & \"co\"");
    EXPECT_EQ(text.find("<script>alert"), std::string::npos);
    EXPECT_EQ(text.find("<b>hand</b>"), std::string::npos);
    EXPECT_NE(text.find("&lt;script&gt;alert(1)&lt;/script&gt; &amp; &quot;co&quot;"),
              std::string::npos);
    EXPECT_NE(text.find("flat &amp; &lt;wide&gt;"), std::string::npos);
    EXPECT_NE(text.find("closing of &quot;a&quot; &lt; inferred &amp; noted"), std::string::npos);
}

TEST(Report, PicturesAreLinkedRelativeToThePage)
{
    EXPECT_NE(page("box").find("<img src=\"pictures/best%20%231%20100%25.png\""),
              std::string::npos);
}

TEST(Report, PicturesAreFoundFromAReportInTheWorkingFolder)
{
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(tests::outputFile("here").parent_path());
    const GraspObject object = makeGraspObject("box", makeBox({0.05, 0.05, 0.05}));
    const std::vector<std::filesystem::path> pictures = {std::filesystem::absolute("a.png"),
                                                         "b.png"};
    writeReport({}, tests::makeBoxHand(), object, threeGrasps(), pictures, "report2.html");
    const std::string text = readText("report2.html");
    std::filesystem::current_path(before);
    EXPECT_NE(text.find("<img src=\"a.png\""), std::string::npos);
    EXPECT_NE(text.find("<img src=\"b.png\""), std::string::npos);
}

TEST(Report, NeedsNothingFromTheNetwork)
{
    const std::string text = page("box");
    EXPECT_EQ(text.find("http:"), std::string::npos);
    EXPECT_EQ(text.find("https:"), std::string::npos);
}

TEST(Report, AFolderThatIsMissingIsNamedInTheError)
{
    const GraspObject object = makeGraspObject("box", makeBox({0.05, 0.05, 0.05}));
    const std::filesystem::path file = tests::outputFile("missing") / "report.html";
    try
    {
        writeReport({}, tests::makeBoxHand(), object, {}, {}, file);
        FAIL() << "no exception";
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos);
    }
}
}  // namespace
}  // namespace bullet_ccd::grasp
