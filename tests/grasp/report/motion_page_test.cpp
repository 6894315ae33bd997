/// Pages of motions: what is said stands there as text, and what moves as data.
#include "grasp/report/motion_page.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/grasp/report/report_scene.h"

#include <gtest/gtest.h>

#include <fstream>
#include <gmock/gmock.h>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace bullet_ccd::grasp
{
namespace
{
using ::testing::HasSubstr;
using ::testing::Not;

std::string textOf(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

MotionPage pageOfABox(const SsvTree& box)
{
    MotionPage page{
        .title = "a <b>box</b>",
        .subtitle = "goes & comes",
        .isGood = false,
        .tables = {{.title = "Ways", .header = {"way", "mm"}, .rows = {{"up", "-1.5"}}},
                   {.title = "Facts", .header = {}, .rows = {{"name", "2 < 3"}}},
                   {.title = "Empty", .header = {"never"}, .rows = {}}},
        .files = {"my plan.json"},
        .times = {0.0F, 0.5F},
        .tracks = {{.name = "</script>",
                    .tree = &box,
                    .color = Color::Zero(),
                    .poses = {Eigen::Isometry3d::Identity(),
                              Eigen::Isometry3d(Eigen::Translation3d(0.1234567, 0.0, -1.0))},
                    .kind = "robot"}},
        .stages = {{"lift", 0.25}}};
    return page;
}

TEST(MotionPage, WithoutATemplateShowsThePictureAndTables)
{
    const SsvTree box = buildSsvTree(makeBox({0.1, 0.2, 0.3}));
    const std::filesystem::path file = tests::outputFile("motion.html");
    writeMotionPage(pageOfABox(box), {}, "a picture.png", file);
    const std::string text = textOf(file);
    EXPECT_THAT(text, HasSubstr("<h1>a &lt;b&gt;box&lt;/b&gt;</h1>"));
    EXPECT_THAT(text, HasSubstr("goes &amp; comes"));
    EXPECT_THAT(text, HasSubstr("<img src=\"a%20picture.png\""));
    EXPECT_THAT(text, HasSubstr("<td class=\"text\">up</td><td>-1.5</td>"));
    EXPECT_THAT(text, HasSubstr("2 &lt; 3"));
    EXPECT_THAT(text, HasSubstr("<a href=\"my%20plan.json\">my plan.json</a>"));
    EXPECT_THAT(text, Not(HasSubstr("Empty")));
    EXPECT_THAT(text, Not(HasSubstr("http")));
    EXPECT_THAT(text, Not(HasSubstr("<script")));
}

TEST(MotionPage, FillsTheTemplateWithPosesAtTheTimes)
{
    const SsvTree box = buildSsvTree(makeBox({0.1, 0.2, 0.3}));
    const std::filesystem::path file = tests::outputFile("motion.html");
    const std::filesystem::path viewer = tests::outputFile("template.html");
    std::ofstream(viewer) << "<title>@TITLE@</title>@HEAD@|@BODY@|<data>@DATA@</data>";
    writeMotionPage(pageOfABox(box), viewer, "", file);
    const std::string text = textOf(file);
    EXPECT_EQ(text.find("</script>"), std::string::npos);  // a name ends no script
    const std::size_t begin = text.find("<data>") + 6;
    const auto data = nlohmann::json::parse(text.substr(begin, text.find("</data>") - begin));
    EXPECT_EQ(data.at("times"), nlohmann::json({0.0, 0.5}));
    EXPECT_EQ(data.at("stages").at(0).at("from"), 0.25);
    const auto& track = data.at("tracks").at(0);
    EXPECT_EQ(track.at("name"), "</script>");
    EXPECT_EQ(track.at("kind"), "robot");
    EXPECT_EQ(track.at("poses").at(1), nlohmann::json({0.12346, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0}));
    EXPECT_EQ(data.at("meshes").size(), 1U);
    std::ofstream(viewer) << "something else";
    EXPECT_THROW(writeMotionPage(pageOfABox(box), viewer, "", file), std::runtime_error);
}
}  // namespace
}  // namespace bullet_ccd::grasp
