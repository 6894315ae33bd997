// Runs the program as a user does and looks at exit codes, messages and answers.
#include "tests/tools/bullet_ccd_program.h"

#include "bullet_ccd/toi/rigid_toi.h"

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(BulletCcdProgram, HelpNamesVerbsUnitsAndExitCodes)
{
    const Outcome help = run("--help");
    EXPECT_EQ(help.exitCode, 0);
    for (const char* word : {"toi", "batch", "Exit codes", "unit of the meshes", "rad"})
    {
        EXPECT_THAT(help.out, HasSubstr(word));
    }
    const Outcome toi = run("toi --help");
    EXPECT_EQ(toi.exitCode, 0);
    for (const char* word :
         {"absolute distance", "unit of the meshes", "rad per interval", "QW,QX,QY,QZ"})
    {
        EXPECT_THAT(toi.out, HasSubstr(word));
    }
    const Outcome batchHelp = run("batch --help");
    EXPECT_EQ(batchHelp.exitCode, 0);
    for (const char* word : {"absolute distance", "rad", "touching_leaving", "lower", "--strict"})
    {
        EXPECT_THAT(batchHelp.out, HasSubstr(word));
    }
    for (const char* verb : {"", "toi", "batch", "articulated", "deformable", "elementary"})
    {
        expectReadableHelp(run(std::string(verb) + " --help").out);
    }
    EXPECT_EQ(run("--version").exitCode, 0);
}

TEST_F(BulletCcdProgram, UsageErrorsExitWith2AndNameTheOption)
{
    EXPECT_EQ(run("").exitCode, 2);
    EXPECT_EQ(run("juggle").exitCode, 2);
    struct Case
    {
        const char* arguments;
        const char* word;
    };
    for (const Case& c :
         {Case{"toi a.obj", "B is required"},
          Case{"batch a.obj b.obj q.csv", "--output"},
          Case{"toi a.obj b.obj --colour red", "--colour"},
          Case{"toi a.obj b.obj --tolerance 0", "--tolerance"},
          Case{"toi a.obj b.obj --tolerance nan", "--tolerance"},
          Case{"toi a.obj b.obj --minimum-separation -1", "--minimum-separation"},
          Case{"toi a.obj b.obj --strategy fast", "--strategy: fast is not one of c2a, interval"},
          Case{"toi a.obj b.obj --a0 1,0,0", "--a0: '1,0,0' has 3 numbers"},
          Case{"toi a.obj b.obj --b1 2,0,0,0,0,0,0", "--b1: quaternion 2,0,0,0"},
          Case{"toi a.obj b.obj --a-angular 1,x,0", "--a-angular: 'x'"},
          Case{"toi a.obj b.obj --a1 1,0,0,0,0,0,0 --a-velocity 1,0,0", "excludes"},
          Case{"toi a.obj b.obj --motion screw", "give --a1 or --b1"},
          Case{"batch a.obj b.obj q.csv -o r.csv --repeat 0", "--repeat"},
          Case{"batch a.obj b.obj q.csv -o r.csv --jobs -1", "--jobs"}})
    {
        const Outcome refused = run(c.arguments);
        EXPECT_EQ(refused.exitCode, 2) << c.arguments;
        EXPECT_THAT(refused.err, HasSubstr(c.word));
    }
}

TEST_F(BulletCcdProgram, BadInputExitsWith3AndNamesTheFile)
{
    const Outcome mesh = run(fmt::format("toi absent.obj '{}'", m_plate.string()));
    EXPECT_EQ(mesh.exitCode, 3);
    EXPECT_THAT(mesh.err, HasSubstr("bullet-ccd: absent.obj: "));
}

TEST_F(BulletCcdProgram, OneQueryGivesTheAnswerOfTheLibrary)
{
    const SsvTree cube = buildSsvTree(makeBox({1.0, 1.0, 1.0}));
    const SsvTree plate = buildSsvTree(makeBox({10.0, 10.0, 0.1}));
    RigidMotion motion = fallingCube(4.0);
    motion.w_W = {1.5, 7.0, -0.25};
    ToiWorkspace work;
    const ToiResult expected =
        rigidToi({.tree = &cube, .motion = motion},
                 {.tree = &plate, .motion = {.v_W = {0.0, 0.5, 0.0}}},
                 {.tolerance = 1e-6, .minimumSeparation = 0.125, .strategy = ToiStrategy::Interval},
                 work);
    ASSERT_EQ(expected.status, ToiStatus::Hit);
    const Outcome shown = run("toi " + cubeAndPlate() +
                              "--a0 -1,0,0,0,0,0,2 --a-velocity 0,0,-4 --a-angular 1.5,7,-0.25 "
                              "--b-velocity 0,0.5,0 --tolerance 1e-6 --minimum-separation 0.125 "
                              "--strategy interval --json");
    EXPECT_EQ(shown.exitCode, 0) << shown.err;
    EXPECT_THAT(shown.out, HasSubstr("\"status\": \"hit\""));
    const std::string word = "\"toi\": ";
    const std::size_t at = shown.out.find(word);
    ASSERT_NE(at, std::string::npos);
    EXPECT_DOUBLE_EQ(std::stod(shown.out.substr(at + word.size())), expected.time);
    for (const char* key : {"\"gap\": ",
                            "\"point_a\": [",
                            "\"point_b\": [",
                            "\"normal\": [",
                            "\"node_pairs\": ",
                            "\"microseconds\": "})
    {
        EXPECT_THAT(shown.out, HasSubstr(key));
    }
}

TEST_F(BulletCcdProgram, AnAccuracySaysWhatWasNeededAndIsNeverBelowRounding)
{
    const std::string motion = "--a0 1,0,0,0,0,0,2 --a-velocity 0,0,-4 --a-angular 1.5,7,-0.25 ";
    const Outcome shown = run("toi " + cubeAndPlate() + motion + "--accuracy 1e-3");
    EXPECT_EQ(shown.exitCode, 0) << shown.err;
    EXPECT_THAT(shown.out, HasSubstr("hit: "));
    EXPECT_THAT(shown.out, HasSubstr("needed      2 of 2 bodies, "));
    EXPECT_THAT(shown.out, HasSubstr(" of 24 triangles"));
    const Outcome json = run("toi " + cubeAndPlate() + motion + "--accuracy 1e-3 --json");
    EXPECT_THAT(json.out, HasSubstr("\"of_triangles\": 24}"));
    EXPECT_THAT(run("toi " + cubeAndPlate() + motion).out, Not(HasSubstr("needed")));
    const std::filesystem::path picture = m_temp.path() / "needed.ply";
    const std::string draw = "--draw '" + picture.string() + "'";
    EXPECT_EQ(run("toi " + cubeAndPlate() + motion + draw).exitCode, 2) << "needs an accuracy";
    EXPECT_EQ(run("toi " + cubeAndPlate() + motion + "--accuracy 1e-3 " + draw).exitCode, 0);
    EXPECT_THAT(contentOf(picture),
                AllOf(HasSubstr("element face 24\n"), HasSubstr("\xE6\x6E\x14")));
    // The plate is 20 across.
    for (const char* accuracy : {"0", "-1", "1e-12"})
    {
        const Outcome refused = run("toi " + cubeAndPlate() + "--accuracy " + accuracy);
        EXPECT_EQ(refused.exitCode, 3) << accuracy;
        EXPECT_THAT(refused.err, HasSubstr("--accuracy"));
        EXPECT_THAT(refused.err, HasSubstr("2e-09")) << accuracy;
    }
    // Both are one number; it may be said twice.
    const Outcome same =
        run("toi " + cubeAndPlate() + motion + "--accuracy 1e-3 --tolerance 0.001");
    EXPECT_EQ(same.exitCode, 0) << same.err;
    EXPECT_THAT(same.out, HasSubstr("needed      2 of 2 bodies, "));
    const Outcome both = run("toi " + cubeAndPlate() + "--accuracy 1e-3 --tolerance 1e-4");
    EXPECT_EQ(both.exitCode, 2);
    EXPECT_THAT(both.err, HasSubstr("0.001 is not the --tolerance of 0.0001"));
}

TEST_F(BulletCcdProgram, OneQueryIsShownToPeople)
{
    const Outcome hit = run("toi " + cubeAndPlate() + "--a0 1,0,0,0,0,0,2 --a1 1,0,0,0,0,0,-2");
    EXPECT_EQ(hit.exitCode, 0) << hit.err;
    for (const char* word : {"hit: ", "toi", "gap", "point on A", "(from A to B)", "microseconds"})
    {
        EXPECT_THAT(hit.out, HasSubstr(word));
    }
    EXPECT_THAT(run("toi " + cubeAndPlate()).out, HasSubstr("overlapping: "));
}

TEST_F(BulletCcdProgram, AHitListsAllItsContactFeatures)
{
    const std::string falling = "toi " + cubeAndPlate() + "--a0 1,0,0,0,0.5,0,2 ";
    const Outcome flat = run(falling + "--a-velocity 0,0,-4");
    EXPECT_EQ(flat.exitCode, 0) << flat.err;
    EXPECT_THAT(flat.out, HasSubstr(fmt::format("contacts    4 within {}", kDefaultTolerance)));
    EXPECT_THAT(flat.out, HasSubstr("0.0000 0.0000 -1.0000"));
    const Outcome json = run(falling + "--a-velocity 0,0,-4 --json");
    std::size_t count = 0;
    for (std::size_t at = json.out.find("{\"a\": {\"kind\": \"vertex\""); at != std::string::npos;
         at = json.out.find("{\"a\": {\"kind\": \"vertex\"", at + 1))
    {
        ++count;
    }
    EXPECT_EQ(count, 4U);
    EXPECT_THAT(run(falling + "--json").out, HasSubstr("\"contacts\": null"));
    EXPECT_THAT(run(falling).out, Not(HasSubstr("contacts")));
}

TEST_F(BulletCcdProgram, AScrewGoesRoundWhereALineCutsTheCorner)
{
    // A quarter turn about the z axis with the cube's centre 3.5 from it: on the arc the cube
    // reaches out to 4.5 half way, on the line to 3.5. A thin post stands at 4.2.
    writeObj(makeBox({0.1, 0.1, 5.0}), m_plate);
    const std::string query = "toi " + cubeAndPlate() +
                              "--a0 1,0,0,0,3.5,0,0.5 --a1 0.7071068,0,0,0.7071068,0,3.5,0.5 "
                              "--b0 1,0,0,0,3,3,0 ";
    EXPECT_THAT(run(query + "--motion screw").out, HasSubstr("hit: "));
    EXPECT_THAT(run(query + "--motion linear").out, HasSubstr("separated: "));
    EXPECT_THAT(run(query).out, HasSubstr("separated: "));
}
}  // namespace
}  // namespace bullet_ccd::tools
