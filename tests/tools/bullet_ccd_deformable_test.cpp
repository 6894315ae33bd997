// The verb deformable, as a user runs it: contacts between frames, bodies, and bad frames.
#include "tests/tools/bullet_ccd_program.h"

#include <gtest/gtest.h>

#include <gmock/gmock.h>
#include <sstream>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::HasSubstr;

constexpr const char* kFaces = "f 1 2 3\nf 4 5 6\n";

/// Two triangles, the first of them at that height over the second one, which is larger.
std::string twoTriangles(double height)
{
    return fmt::format("v 0 0 {0}\nv 0.3 0 {0}\nv 0 0.3 {0}\nv -1 -1 0\nv 2 -1 0\nv -1 2 0\n",
                       height) +
           kFaces;
}

class DeformableProgram : public BulletCcdProgram
{
protected:
    [[nodiscard]] Outcome deformable(const std::string& arguments) const
    {
        return run("deformable " + arguments + " -o '" + m_output.string() + "'");
    }
    [[nodiscard]] std::string frame(const std::string& name, const std::string& content) const
    {
        return " '" + m_temp.write(name, content).string() + "' ";
    }
    [[nodiscard]] std::vector<std::string> rows() const
    {
        std::istringstream text(contentOf(m_output));
        std::vector<std::string> lines;
        for (std::string line; std::getline(text, line);)
        {
            lines.push_back(line);
        }
        return lines;
    }

    std::filesystem::path m_output = m_temp.path() / "out.csv";
};

TEST_F(DeformableProgram, WritesTheContactsOfEveryStep)
{
    const std::string high = frame("f_2.obj", twoTriangles(1.0));
    const std::string low = frame("f_10.obj", twoTriangles(-1.0));
    const Outcome outcome = deformable(high + low + low + high + " --summary --tolerance 1e-9");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("step 1: 2 triangles, 3 contacts"));
    const std::vector<std::string> lines = rows();
    ASSERT_EQ(lines.size(), 7U);  // three vertices come to the face, twice
    EXPECT_EQ(lines[0], "frame,toi,kind,a0,a1,a2,a3,body_a,body_b,gap");
    for (std::size_t i = 1; i < lines.size(); ++i)
    {
        const std::string pattern = fmt::format(
            "{},0\\.49999[0-9]*,vertex_face,{},3,4,5,0,1,[0-9.e-]+", (i - 1) / 3, (i - 1) % 3);
        EXPECT_THAT(lines[i], ::testing::MatchesRegex(pattern));
    }
    // The same as a sequence: 10 comes after 2.
    const Outcome sequence =
        deformable("--sequence '" + (m_temp.path() / "f_*.obj").string() + "' --tolerance 1e-9");
    EXPECT_EQ(sequence.exitCode, 0) << sequence.err;
    EXPECT_EQ(rows().size(), 4U);
    EXPECT_EQ(deformable(high + low + "--first --tolerance 1e-9 -j 2").exitCode, 0);
    EXPECT_EQ(rows().size(), 4U) << "all three at the same time";
}

TEST_F(DeformableProgram, KnowsObstaclesAndBodies)
{
    // One strip of two triangles that folds onto itself: only --self sees it.
    const std::string flat = frame("flat.obj",
                                   "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.2 0.5 1\nv 0.2 0.6 1\n"
                                   "f 1 2 3\nf 1 3 4\nf 3 5 6\n");
    const std::string folded =
        frame("folded.obj",
              "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.2 0.5 -1\nv 0.2 0.6 -1\n"
              "f 1 2 3\nf 1 3 4\nf 3 5 6\n");
    EXPECT_EQ(deformable(flat + folded).exitCode, 0);
    EXPECT_EQ(rows().size(), 1U);
    EXPECT_EQ(deformable(flat + folded + "--self").exitCode, 0);
    EXPECT_GT(rows().size(), 2U);
    EXPECT_THAT(rows()[1], HasSubstr(",0,0,"));

    // The plate's upper face is at z = 0.1.
    const std::string high = frame("high.obj", twoTriangles(1.1));
    const std::string low = frame("low.obj", twoTriangles(0.05));
    EXPECT_EQ(deformable(high + low + "--obstacle '" + m_plate.string() + "'").exitCode, 0);
    ASSERT_GT(rows().size(), 3U);
    // The second triangle, which is at z = 0, is inside the plate and rests.
    EXPECT_THAT(rows()[1], ::testing::MatchesRegex("0,0\\.952[0-9]*,vertex_face,.*,0,2,.*"));
}

TEST_F(DeformableProgram, KnowsObstaclesThatMove)
{
    // The small triangle rests at z = 1. A triangle comes up to it from z = 0.5 by 1 in each of two
    // steps, by its frames and by its poses.
    const auto at = [](double z)
    { return fmt::format("v -1 -1 {0}\nv 2 -1 {0}\nv -1 2 {0}\nf 1 2 3\n", z); };
    const std::string cloth = frame("cloth_0.obj", "v 0 0 1\nv 0.3 0 1\nv 0 0.3 1\nf 1 2 3\n");
    const std::string steps = cloth + cloth + cloth + cloth + "--tolerance 1e-9 ";
    (void)frame("lift_0.obj", at(-0.5));
    (void)frame("lift_1.obj", at(0.5));
    (void)frame("lift_2.obj", at(0.5));
    (void)frame("lift_3.obj", at(1.5));
    const std::string pattern = "'" + (m_temp.path() / "lift_*.obj").string() + "'";
    const std::string lift = frame("lift.obj", at(0.0));
    const std::string poses = frame("poses.csv",
                                    "qw,qx,qy,qz,tx,ty,tz\n1,0,0,0,0,0,-0.5\n1,0,0,0,0,0,0.5\n"
                                    "1,0,0,0,0,0,0.5\n1,0,0,0,0,0,1.5\n");
    for (const std::string& option : {"--obstacle " + pattern, "--moving-obstacle " + lift + poses})
    {
        const Outcome outcome = deformable(steps + option);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
        ASSERT_EQ(rows().size(), 4U) << option;
        for (int i = 0; i < 3; ++i)
        {
            EXPECT_THAT(rows()[static_cast<std::size_t>(i) + 1],
                        ::testing::MatchesRegex(
                            fmt::format("1,0\\.49999[0-9]*,vertex_face,{},0,1,2,0,1,.*", i)));
        }
    }
    // A quarter turn about the line x = -1, z = 1 takes a blade through the triangle.
    const std::string turning = frame("turn.csv",
                                      "qw,qx,qy,qz,tx,ty,tz\n0.92388,0,-0.38268,0,-1,0,1\n"
                                      "0.92388,0,0.38268,0,-1,0,1\n");
    const std::string blade = frame("blade.obj", "v 0.5 -1 0\nv 2 -1 0\nv 1.2 3 0\nf 1 2 3\n");
    const std::string turned = cloth + cloth + "--moving-obstacle " + blade + turning;
    EXPECT_EQ(deformable(turned).exitCode, 0);
    EXPECT_GT(rows().size(), 1U);
    EXPECT_THAT(deformable(turned + " --exact").err, HasSubstr("needs straight paths"));

    EXPECT_THAT(deformable(cloth + cloth + "--obstacle " + pattern).err,
                HasSubstr("4 frames, but the mesh has 2"));
    EXPECT_THAT(deformable(cloth + cloth + "--moving-obstacle " + lift + poses).err,
                HasSubstr("4 poses, but the mesh has 2 frames"));
    EXPECT_THAT(deformable(cloth + cloth + "--moving-obstacle " + lift + lift).err,
                HasSubstr("qw, qx, qy, qz, tx, ty, tz"));
    std::filesystem::remove(m_temp.path() / "lift_3.obj");
    (void)frame("lift_3.obj", at(1.5) + "f 1 3 2\n");
    EXPECT_THAT(deformable(steps + "--obstacle " + pattern).err, HasSubstr("2 faces instead of 1"));
}

TEST_F(DeformableProgram, EndsAtTheTimeLimit)
{
    const std::string high = frame("high.obj", twoTriangles(1.0));
    const std::string low = frame("low.obj", twoTriangles(-1.0));
    const Outcome outcome = deformable(high + low + "--time-limit 1e-9");
    EXPECT_EQ(outcome.exitCode, 1) << "not every step was checked";
    EXPECT_THAT(outcome.err, HasSubstr("stopped after 0 of 1 steps"));
    EXPECT_EQ(rows().size(), 1U);
    EXPECT_EQ(deformable(high + low + "--time-limit 100").err, "");
}

TEST_F(DeformableProgram, KeepsTheStepsBeforeABadFrame)
{
    (void)frame("f_0.obj", twoTriangles(1.0));
    (void)frame("f_1.obj", twoTriangles(-1.0));
    (void)frame("f_2.obj", "v nan 0 0\n" + twoTriangles(1.0).substr(8));
    const Outcome outcome = deformable("--sequence '" + (m_temp.path() / "f_*.obj").string() + "'");
    EXPECT_EQ(outcome.exitCode, 3);
    EXPECT_THAT(outcome.err, HasSubstr("f_2.obj"));
    EXPECT_THAT(outcome.err, HasSubstr("has the first 1 of 2 steps"));
    EXPECT_EQ(rows().size(), 4U);
}

TEST_F(DeformableProgram, SaysWhatIsWrongWithFrames)
{
    const std::string good = frame("good.obj", twoTriangles(1.0));
    struct Case
    {
        std::string arguments;
        int exitCode;
        const char* word;
    };
    const std::string more = frame("more.obj", twoTriangles(1.0) + "v 1 2 3\n");
    const std::string other =
        frame("other.obj", twoTriangles(1.0).replace(twoTriangles(1.0).find(kFaces), 7, "f 1 3 2"));
    const std::string fewer =
        frame("fewer.obj", twoTriangles(1.0).erase(twoTriangles(1.0).find("f 4")));
    const std::string nan = frame("nan.obj", "v nan 0 0\n" + twoTriangles(1.0).substr(8));
    const std::string far = frame("far.obj", "v 1e15 0 0\n" + twoTriangles(1.0).substr(8));
    const std::string twice = frame(
        "twice.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 1 0 1\nv 0 1 1\nf 1 2 3\nf 4 5 6\n");
    const std::string empty = frame("empty.obj", "");
    for (const Case& c :
         {Case{good + more, 3, "more.obj: 7 vertices instead of 6 as in "},
          Case{good + other, 3, "other.obj: face 1 has other corners than in "},
          Case{good + fewer, 3, "fewer.obj: 1 faces instead of 2 as in "},
          Case{good + nan, 3, "nan.obj: vertex 1 (from 1) is at (nan, 0, 0): give finite"},
          Case{good + far, 3, "give finite coordinates within 1e+12"},
          Case{far + good,
               3,
               "far.obj: vertex 1 (from 1) is at (1000000000000000, 0, 0): give finite"},
          Case{twice + twice, 3, "vertices 0 and 3 are both at (0.0"},
          Case{good + empty, 3, "empty.obj: has no faces: give a mesh"},
          Case{good + "no.obj", 3, "no.obj"},
          Case{good + "a.stl", 3, "a.stl: is no OBJ file"},
          Case{good, 2, "1 file: give two per step"},
          Case{"--sequence 'x_*.obj'", 3, "x_*.obj: 0 files of that name"}})
    {
        const Outcome outcome = deformable(c.arguments);
        EXPECT_EQ(outcome.exitCode, c.exitCode) << c.word;
        EXPECT_THAT(outcome.err, HasSubstr(c.word));
    }
    EXPECT_EQ(deformable(twice + twice + "--weld").exitCode, 0);
    const Outcome given =
        deformable(good + frame("low.obj", twoTriangles(-1.0)) + "--max-iterations 1");
    EXPECT_EQ(given.exitCode, 1);
    EXPECT_THAT(given.err, HasSubstr("step 0 was NOT checked"));
}
}  // namespace
}  // namespace bullet_ccd::tools
