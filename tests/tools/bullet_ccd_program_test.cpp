// Runs the program as a user does and looks at exit codes, messages, files and answers.
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/make_mesh.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "tests/support/random.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"
#include "tests/tools/query_text.h"
#include "tests/tools/run_program.h"
#include "tools/ccd_cli/csv_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using Row = std::map<std::string, std::string>;

constexpr double kTolerance = 1e-4;  // of the program if nothing else is asked for

/// Rows of a CSV file by the names of their columns.
std::vector<Row> rowsOf(const fs::path& path)
{
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    const std::vector<std::string> names = *csvCells(line);
    std::vector<Row> rows;
    while (std::getline(file, line))
    {
        const std::vector<std::string> cells = *csvCells(line);
        Row row;
        for (std::size_t k = 0; k < names.size(); ++k)
        {
            row[names[k]] = cells.at(k);
        }
        rows.push_back(row);
    }
    return rows;
}

double number(const Row& row, const std::string& column)
{
    return std::stod(row.at(column));
}

Row withoutTimes(Row row)
{
    row.erase("microseconds");
    row.erase("warm_microseconds");
    return row;
}

class BulletCcdProgram : public ::testing::Test
{
protected:
    void SetUp() override
    {
        writeObj(makeBox({1.0, 1.0, 1.0}), m_cube);
        writeObj(makeBox({10.0, 10.0, 0.1}), m_plate);
    }

    [[nodiscard]] static Outcome run(const std::string& arguments)
    {
        return runProgram(std::string(BULLET_CCD_PROGRAM) + " " + arguments);
    }

    [[nodiscard]] std::string cubeAndPlate() const
    {
        return "'" + m_cube.string() + "' '" + m_plate.string() + "' ";
    }

    /// Answers the queries in `text`.
    [[nodiscard]] Outcome batch(const std::string& text, const std::string& more = "") const
    {
        const fs::path queries = m_temp.write("queries.csv", text);
        return run("batch " + cubeAndPlate() + "'" + queries.string() + "' -o '" +
                   m_results.string() + "' " + more);
    }

    [[nodiscard]] std::vector<Row> rows() const { return rowsOf(m_results); }

    tests::TempFolder m_temp;
    fs::path m_cube = m_temp.path() / "cube.obj";
    fs::path m_plate = m_temp.path() / "plate.obj";
    fs::path m_results = m_temp.path() / "results.csv";
};

/// A cube of edge 2 whose lower face starts 0.9 above the upper face of the plate.
RigidMotion fallingCube(double speed)
{
    RigidMotion motion{.v_W = {0.0, 0.0, -speed}};
    motion.X_W0.translation().z() = 2.0;
    return motion;
}

/// Motions of the cube around the plate, about half of which hit it.
std::vector<RigidMotion> randomMotions(std::size_t count)
{
    tests::Random random(77);
    std::vector<RigidMotion> motions;
    for (std::size_t k = 0; k < count; ++k)
    {
        Eigen::Isometry3d start = random.pose(3.0);
        Eigen::Isometry3d end = random.pose(3.0);
        start.translation().z() = random.uniform(2.0, 5.0);
        end.translation().z() = random.uniform(-2.0, 6.0);
        motions.push_back(motionBetween(start, end));
    }
    return motions;
}

std::string posesOf(const std::vector<RigidMotion>& motions)
{
    std::string text = posesHeader();
    for (std::size_t k = 0; k < motions.size(); ++k)
    {
        text += posesRow("query " + std::to_string(k), motions[k], {});
    }
    return text;
}

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
    for (const char* word : {"absolute distance", "mesh units", "rad per interval", "QW,QX,QY,QZ"})
    {
        EXPECT_THAT(toi.out, HasSubstr(word));
    }
    const Outcome batchHelp = run("batch --help");
    EXPECT_EQ(batchHelp.exitCode, 0);
    for (const char* word : {"absolute distance", "rad", "touching_leaving", "lower", "--strict"})
    {
        EXPECT_THAT(batchHelp.out, HasSubstr(word));
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
    for (const Case& c : {Case{"toi a.obj", "B is required"},
                          Case{"batch a.obj b.obj q.csv", "--output"},
                          Case{"toi a.obj b.obj --colour red", "--colour"},
                          Case{"toi a.obj b.obj --tolerance 0", "--tolerance"},
                          Case{"toi a.obj b.obj --tolerance nan", "--tolerance"},
                          Case{"toi a.obj b.obj --minimum-separation -1", "--minimum-separation"},
                          Case{"toi a.obj b.obj --strategy fast", "c2a, interval or best-first"},
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
    const Outcome mesh = run("toi absent.obj '" + m_plate.string() + "'");
    EXPECT_EQ(mesh.exitCode, 3);
    EXPECT_THAT(mesh.err, HasSubstr("bullet-ccd: absent.obj: "));
    const Outcome header = batch("id,a,b\n");
    EXPECT_EQ(header.exitCode, 3);
    EXPECT_THAT(header.err, HasSubstr("queries.csv:1: "));
    EXPECT_FALSE(fs::exists(m_results));
}

TEST_F(BulletCcdProgram, AFallingCubeHitsThePlateAtTheClosedFormTimeInBothForms)
{
    // 0.9 above the plate: at speed 4 contact is at 0.225; at speed 0.5 a distance of 0.4 is left.
    const std::string twists = twistsHeader() + twistsRow("hit", fallingCube(4.0), {}) +
                               twistsRow("miss", fallingCube(0.5), {});
    const std::string poses = posesHeader() + posesRow("hit", fallingCube(4.0), {}) +
                              posesRow("miss", fallingCube(0.5), {});
    for (const std::string& text : {twists, poses})
    {
        for (const char* strategy : {"c2a", "interval", "best-first"})
        {
            const Outcome done = batch(text, std::string("--strategy ") + strategy);
            ASSERT_EQ(done.exitCode, 0) << done.err;
            EXPECT_EQ(done.out + done.err, "");
            const std::vector<Row> table = rows();
            ASSERT_EQ(table.size(), 2U);
            EXPECT_EQ(table[0].at("status"), "hit");
            EXPECT_LT(number(table[0], "toi"), 0.225);
            EXPECT_GE(number(table[0], "toi"), 0.225 - kTolerance / 4.0 - 1e-12);
            EXPECT_GT(number(table[0], "gap"), 0.0);
            EXPECT_LE(number(table[0], "gap"), kTolerance);
            EXPECT_NEAR(number(table[0], "pz"), 0.1, kTolerance);
            EXPECT_LE(std::abs(number(table[0], "px")), 1.0 + 1e-12);
            EXPECT_NEAR(number(table[0], "nz"), -1.0, 1e-9);
            EXPECT_GT(number(table[0], "iterations"), 0.0);
            EXPECT_GT(number(table[0], "microseconds"), 0.0);
            EXPECT_EQ(table[1].at("status"), "separated");
            EXPECT_EQ(table[1].at("toi"), "1");
            EXPECT_LE(number(table[1], "gap"), 0.4);
            EXPECT_EQ(table[1].at("px") + table[1].at("nz"), "");
        }
    }
}

TEST_F(BulletCcdProgram, BothFormsGiveTheSameAnswersForTheSameMotions)
{
    const std::vector<RigidMotion> motions = randomMotions(40);
    std::string twists = twistsHeader();
    for (std::size_t k = 0; k < motions.size(); ++k)
    {
        twists += twistsRow("query " + std::to_string(k), motions[k], {});
    }
    ASSERT_EQ(batch(posesOf(motions)).exitCode, 0);
    const std::vector<Row> fromPoses = rows();
    ASSERT_EQ(batch(twists).exitCode, 0);
    const std::vector<Row> fromTwists = rows();
    ASSERT_EQ(fromPoses.size(), motions.size());
    ASSERT_EQ(fromTwists.size(), motions.size());
    int hits = 0;
    for (std::size_t k = 0; k < motions.size(); ++k)
    {
        EXPECT_EQ(fromPoses[k].at("id"), fromTwists[k].at("id"));
        EXPECT_EQ(fromPoses[k].at("status"), fromTwists[k].at("status"));
        EXPECT_NEAR(number(fromPoses[k], "toi"), number(fromTwists[k], "toi"), 1e-6);
        hits += fromPoses[k].at("status") == "hit" ? 1 : 0;
    }
    EXPECT_GE(hits, 12);
    EXPECT_LE(hits, 28);
}

TEST_F(BulletCcdProgram, AnswersDependNeitherOnThreadsNorOnRepeats)
{
    const std::string queries = posesOf(randomMotions(40));
    ASSERT_EQ(batch(queries).exitCode, 0);
    const std::vector<Row> reference = rows();
    ASSERT_EQ(reference.size(), 40U);
    for (const char* more : {"--jobs 2", "--jobs 0 --repeat 3", "--warm --repeat 2"})
    {
        ASSERT_EQ(batch(queries, more).exitCode, 0);
        const std::vector<Row> again = rows();
        ASSERT_EQ(again.size(), reference.size());
        for (std::size_t k = 0; k < reference.size(); ++k)
        {
            EXPECT_EQ(withoutTimes(again[k]), withoutTimes(reference[k])) << more;
        }
    }
    EXPECT_GT(number(rows()[0], "warm_microseconds"), 0.0);
}

TEST_F(BulletCcdProgram, BadRowsAreReportedAndDoNotStopTheOthers)
{
    const std::string good = twistsRow("good", fallingCube(4.0), {});
    std::string text = twistsHeader() + good + "bad,1,2\n" + good;
    text.replace(text.rfind(",-4,"), 4, ",fast,");
    const Outcome done = batch(text + good, "--summary");
    EXPECT_EQ(done.exitCode, 0);
    EXPECT_THAT(done.err, HasSubstr("queries.csv:3: 3 cells instead of 27"));
    EXPECT_THAT(done.err, HasSubstr("queries.csv:4: a_vz: 'fast' is not a number: write it like"));
    EXPECT_EQ(std::count(done.err.begin(), done.err.end(), '\n'), 2);
    EXPECT_THAT(done.out, HasSubstr("bad_row: 2\n"));
    std::string statuses;
    for (const Row& row : rows())
    {
        statuses += row.at("id") + " " + row.at("status") + ";";
    }
    EXPECT_EQ(statuses, "good hit;bad bad_row;good bad_row;good hit;");
}

TEST_F(BulletCcdProgram, StrictStopsBeforeAnythingIsComputedOrOverwritten)
{
    std::ofstream(m_results) << "precious";
    const std::string text = twistsHeader() + twistsRow("good", fallingCube(4.0), {}) + "bad,1,2\n";
    const Outcome stopped = batch(text, "--strict");
    EXPECT_EQ(stopped.exitCode, 3);
    EXPECT_THAT(stopped.err, HasSubstr("queries.csv:3: "));
    EXPECT_THAT(stopped.err, HasSubstr("1 bad row, nothing was computed"));
    EXPECT_EQ(contentOf(m_results), "precious");
    EXPECT_EQ(batch(twistsHeader() + twistsRow("good", fallingCube(4.0), {}), "--strict").exitCode,
              0);
}

TEST_F(BulletCcdProgram, ResultsThatCannotBeWrittenAreSaidBeforeTheWork)
{
    const std::string text = twistsHeader() + twistsRow("good", fallingCube(4.0), {});
    m_results = m_temp.path() / "absent" / "results.csv";
    const Outcome folder = batch(text);
    EXPECT_EQ(folder.exitCode, 3);
    EXPECT_THAT(folder.err, HasSubstr("cannot be written (No such file"));
    m_results = m_temp.path();
    EXPECT_EQ(batch(text).exitCode, 3);
    m_results = m_cube;
    const Outcome input = batch(text);
    EXPECT_EQ(input.exitCode, 3);
    EXPECT_THAT(input.err, HasSubstr("is also an input"));
    m_results = "/dev/stdout";
    EXPECT_THAT(batch(text).out, HasSubstr("good,hit,"));
    // Nothing unfinished is left behind.
    for (const fs::directory_entry& entry : fs::directory_iterator(m_temp.path()))
    {
        EXPECT_THAT(entry.path().string(), Not(HasSubstr("unfinished")));
    }
}

TEST_F(BulletCcdProgram, TheSummaryCountsAndKeepsLoadingApart)
{
    const std::string text = twistsHeader() + twistsRow("a", fallingCube(4.0), {}) +
                             twistsRow("b", fallingCube(0.5), {}) + twistsRow("c", {}, {});
    const Outcome done = batch(text, "--summary --warm");
    EXPECT_EQ(done.exitCode, 0);
    for (const char* line : {"rows: 3\n",
                             "\nhit: 1\n",
                             "\nseparated: 1\n",
                             "\noverlapping: 1\n",
                             "\nbad_row: 0\n",
                             "\nmicroseconds: mean ",
                             ", median ",
                             ", p95 ",
                             "\nwarm_microseconds: mean ",
                             "loading meshes ",
                             "building hierarchies "})
    {
        EXPECT_THAT(done.out, HasSubstr(line));
    }
    const Outcome none = batch(posesHeader(), "--summary");
    EXPECT_EQ(none.exitCode, 0);
    EXPECT_THAT(none.out, HasSubstr("microseconds: none"));
    EXPECT_TRUE(rows().empty());
}

TEST_F(BulletCcdProgram, AQueryThatGivesUpSaysSo)
{
    ASSERT_EQ(batch(posesOf(randomMotions(40)), "--max-iterations 1").exitCode, 0);
    const std::vector<Row> table = rows();
    EXPECT_TRUE(std::any_of(table.begin(),
                            table.end(),
                            [](const Row& row) {
                                return row.at("status") == "iteration_limit" &&
                                       row.at("px").empty();
                            }));
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
    for (const char* key : {"gap", "point_a", "point_b", "normal", "node_pairs", "microseconds"})
    {
        EXPECT_THAT(shown.out, HasSubstr("\"" + std::string(key) + "\": "));
    }
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

TEST_F(BulletCcdProgram, AScrewGoesRoundItsAxisWhereALineCutsThrough)
{
    // Half a turn about z from (0, 3.5, 0.5) to (0, -3.5, 0.5): the line runs over the plate's
    // middle, the arc by (+-3.5, 0, 0.5), where only it meets the post.
    writeObj(makeBox({0.1, 0.1, 5.0}), m_plate);
    const std::string poses = "--a0 1,0,0,0,3.5,0,0.5 --a1 0.7071068,0,0,0.7071068,0,3.5,0.5 ";
    const std::string post = "--b0 1,0,0,0,2.474873734152916,2.474873734152916,0 ";
    EXPECT_THAT(run("toi " + cubeAndPlate() + poses + post + "--motion screw").out,
                HasSubstr("hit: "));
    const std::string corner = "--b0 1,0,0,0,3.3,3.3,0 ";
    EXPECT_THAT(run("toi " + cubeAndPlate() + poses + corner + "--motion screw").out,
                HasSubstr("hit: "));
    EXPECT_THAT(run("toi " + cubeAndPlate() + poses + corner).out, HasSubstr("separated: "));
}

TEST_F(BulletCcdProgram, NoCollisionOfThePublishedBunnySetIsMissedOrLate)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(bunny, "motions/c2a_torusknot/bunny_noholes.ply");
    BULLET_CCD_TEST_DATA_OR_SKIP(queries, "rigid_queries/poses/bunny_ident.csv");
    BULLET_CCD_TEST_DATA_OR_SKIP(answers, "rigid_queries/reference/bunny_ident.csv");
    const Outcome done = run("batch '" + bunny.string() + "' '" + bunny.string() + "' '" +
                             queries.string() + "' -o '" + m_results.string() + "'");
    ASSERT_EQ(done.exitCode, 0) << done.err;
    const std::vector<Row> table = rows();
    const std::vector<Row> reference = rowsOf(answers);
    ASSERT_EQ(table.size(), reference.size());
    // The mesh went through single precision, the reference did not.
    constexpr double kMeshRounding = 1e-5;
    int hits = 0;
    for (std::size_t k = 0; k < table.size(); ++k)
    {
        ASSERT_EQ(table[k].at("id"), reference[k].at("id"));
        const bool hit = reference[k].at("collide") == "1";
        EXPECT_EQ(table[k].at("status"), hit ? "hit" : "separated");
        EXPECT_LE(
            number(table[k], "toi"),
            number(reference[k], "toi") + kMeshRounding / number(reference[k], "speed_bound"));
        hits += hit ? 1 : 0;
    }
    EXPECT_EQ(hits, 120);
}
}  // namespace
}  // namespace bullet_ccd::tools
