// Answers files of queries as a user does.
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/toi/toi.h"
#include "tests/support/test_data.h"
#include "tests/tools/bullet_ccd_program.h"
#include "tests/tools/query_text.h"
#include "tools/support/csv_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gmock/gmock.h>
#include <map>
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

constexpr double kTolerance = kDefaultTolerance;  // of the program if nothing else is asked for

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

class BulletCcdBatch : public BulletCcdProgram
{
protected:
    /// Answers the queries in `text`.
    [[nodiscard]] Outcome batch(const std::string& text, const std::string& more = "") const
    {
        const std::filesystem::path queries = m_temp.write("queries.csv", text);
        return run(fmt::format("batch {} '{}' -o '{}' {}",
                               cubeAndPlate(),
                               queries.string(),
                               m_results.string(),
                               more));
    }

    [[nodiscard]] std::vector<Row> rows() const { return rowsOf(m_results); }

    fs::path m_results = m_temp.path() / "results.csv";
};

/// Motions of the cube around the plate, about half of which hit it.
std::vector<RigidMotion> randomMotions(std::size_t count)
{
    reference::Random random(77);
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
        text += posesRow(std::to_string(k), motions[k], {});
    }
    return text;
}

TEST_F(BulletCcdBatch, AnAccuracySaysWhatAllQueriesNeededWhateverTheThreads)
{
    const std::string text = posesOf(randomMotions(40));
    const auto neededOf = [&](const std::string& more)
    {
        const Outcome done = batch(text, more);
        EXPECT_EQ(done.exitCode, 0) << done.err;
        const std::size_t at = done.out.find("needed: ");
        return at == std::string::npos ? std::string() : done.out.substr(at);
    };
    const std::string needed = neededOf("--summary --accuracy 1e-2");
    EXPECT_THAT(needed, HasSubstr("needed: 2 of 2 bodies, "));
    EXPECT_THAT(needed, HasSubstr(" of 24 triangles\n"));
    EXPECT_EQ(neededOf("--summary --accuracy 1e-2 --jobs 3 --repeat 2 --warm"), needed);
    EXPECT_EQ(neededOf("--summary --tolerance 1e-2"), "");
    // One that passes at a distance needs nothing.
    EXPECT_THAT(
        batch(twistsHeader() + twistsRow("miss", fallingCube(0.1), {}), "--summary --accuracy 1e-2")
            .out,
        HasSubstr("needed: 0 of 2 bodies, 0 of 24 triangles\n"));
}

TEST_F(BulletCcdBatch, AFallingCubeHitsThePlateAtTheClosedFormTimeInBothForms)
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

TEST_F(BulletCcdBatch, BothFormsGiveTheSameAnswersForTheSameMotions)
{
    const std::vector<RigidMotion> motions = randomMotions(40);
    std::string twists = twistsHeader();
    for (std::size_t k = 0; k < motions.size(); ++k)
    {
        twists += twistsRow(std::to_string(k), motions[k], {});
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

TEST_F(BulletCcdBatch, AnswersDependNeitherOnThreadsNorOnRepeats)
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

TEST_F(BulletCcdBatch, AWrongFirstLineExitsWith3AndWritesNothing)
{
    const Outcome header = batch("id,a,b\n");
    EXPECT_EQ(header.exitCode, 3);
    EXPECT_THAT(header.err, HasSubstr("queries.csv:1: "));
    EXPECT_FALSE(fs::exists(m_results));
}

TEST_F(BulletCcdBatch, BadRowsAreReportedAndDoNotStopTheOthers)
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

TEST_F(BulletCcdBatch, StrictStopsBeforeAnythingIsComputedOrOverwritten)
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

TEST_F(BulletCcdBatch, ResultsThatCannotBeWrittenAreSaidBeforeTheWork)
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

TEST_F(BulletCcdBatch, TheSummaryCountsAndKeepsLoadingApart)
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

TEST_F(BulletCcdBatch, AQueryThatGivesUpSaysSo)
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

TEST_F(BulletCcdBatch, NoCollisionOfThePublishedBunnySetIsMissedOrLate)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(bunny, "motions/c2a_torusknot/bunny_noholes.ply");
    BULLET_CCD_TEST_DATA_OR_SKIP(queries, "rigid_queries/poses/bunny_ident.csv");
    BULLET_CCD_TEST_DATA_OR_SKIP(answers, "rigid_queries/reference/bunny_ident.csv");
    const Outcome done = run(fmt::format(
        "batch '{0}' '{0}' '{1}' -o '{2}'", bunny.string(), queries.string(), m_results.string()));
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

TEST_F(BulletCcdBatch, ATimeLimitKeepsWhatWasAnsweredAndSaysHowMuch)
{
    const std::string text = twistsHeader() + twistsRow("first", fallingCube(4.0), {}) +
                             twistsRow("second", fallingCube(0.5), {}) +
                             twistsRow("third", fallingCube(4.0), {});
    const Outcome stopped = batch(text, "--time-limit 1e-9 --summary");
    EXPECT_EQ(stopped.exitCode, 0);
    EXPECT_EQ(stopped.err, "bullet-ccd batch: stopped after 0 of 3 queries\n");
    EXPECT_THAT(stopped.out, HasSubstr("rows: 1\nhit: 0\n"));
    EXPECT_THAT(stopped.out, HasSubstr("stopped: 1\n"));
    ASSERT_EQ(rows().size(), 1U);
    EXPECT_EQ(rows()[0].at("id"), "first");
    EXPECT_EQ(rows()[0].at("status"), "stopped");
    EXPECT_EQ(number(rows()[0], "toi"), 0.0);
    EXPECT_EQ(batch(text, "--time-limit 1e6").err, "");
    EXPECT_EQ(rows().size(), 3U);
}

TEST_F(BulletCcdBatch, CtrlCKeepsWhatWasAnswered)
{
    std::string text = twistsHeader();
    for (int k = 0; k < 1000; ++k)
    {
        text += twistsRow(std::to_string(k), fallingCube(4.0), {});
    }
    const fs::path queries = m_temp.write("queries.csv", text);
    // A shell without job control lets its background programs ignore SIGINT: `env` undoes that.
    // Until it is the program and not the shell before it, and catches SIGINT (bit 2).
    const std::string wait =
        "until [ ! -e /proc/$! ] || { grep -q bullet-ccd /proc/$!/comm && "
        "grep -q 'SigCgt:.*[2367abef]$' /proc/$!/status; }; do sleep 0.01; done";
    const Outcome stopped = runProgram(fmt::format(
        "{{ env --default-signal=INT {} batch {} '{}' -o '{}' --repeat 1000 & {}; kill -INT $!; "
        "wait $!; }}",
        BULLET_CCD_PROGRAM,
        cubeAndPlate(),
        queries.string(),
        m_results.string(),
        wait));
    EXPECT_EQ(stopped.exitCode, 130);
    EXPECT_THAT(stopped.err, HasSubstr("bullet-ccd batch: stopped after "));
    EXPECT_THAT(stopped.err, HasSubstr(" of 1000000 queries\n"));
    ASSERT_FALSE(rows().empty());
    EXPECT_LE(rows().size(), 1000U);
    for (const Row& row : rows())
    {
        const bool isLast = row.at("id") == rows().back().at("id");
        EXPECT_TRUE(row.at("status") == "hit" || (isLast && row.at("status") == "stopped"));
        EXPECT_TRUE(number(row, "microseconds") > 0.0 || isLast);
    }
}
}  // namespace
}  // namespace bullet_ccd::tools
