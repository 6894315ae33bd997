#include "tools/ccd_cli/files/query_file.h"

#include "benchmarks/reference/scenes/random.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/query_text.h"
#include "tools/ccd_cli/run/query_run.h"
#include "tools/support/csv_text.h"
#include "tools/support/pose_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <gmock/gmock.h>
#include <stdexcept>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Poses go through 17 digits, a quaternion and a normalisation.
constexpr double kRounding = 1e-13;

const std::string kRest = ",1,0,0,0,0,0,0";

std::string restRow(const std::string& id)
{
    return id + kRest + kRest + kRest + kRest + "\n";
}

class QueryFileTest : public ::testing::Test
{
protected:
    [[nodiscard]] QueryFile read(const std::string& content) const
    {
        return readQueryFile(m_folder.write("queries.csv", content));
    }

    [[nodiscard]] std::string errorOf(const std::string& content) const
    {
        try
        {
            (void)read(content);
        }
        catch (const std::runtime_error& error)
        {
            return error.what();
        }
        return "no error";
    }

    tests::TempFolder m_folder;
};

void expectSame(const RigidMotion& read, const RigidMotion& expected)
{
    EXPECT_TRUE(read.X_W0.isApprox(expected.X_W0, kRounding));
    EXPECT_LT((read.v_W - expected.v_W).norm(), kRounding * 10.0);
    EXPECT_LT((read.w_W - expected.w_W).norm(), kRounding * 10.0);
    EXPECT_TRUE(read.reference_B.isZero(0.0));
}

TEST_F(QueryFileTest, BothFormsOfTheSameMotionAreRead)
{
    reference::Random random(41);
    std::vector<RigidMotion> motions;
    std::string poses = posesHeader();
    std::string twists = twistsHeader();
    for (int k = 0; k < 20; ++k)
    {
        const RigidMotion a = motionBetween(random.pose(3.0), random.pose(3.0));
        const RigidMotion b = motionBetween(random.pose(3.0), random.pose(3.0));
        poses += posesRow(std::to_string(k), a, b);
        twists += twistsRow(std::to_string(k), a, b);
        motions.insert(motions.end(), {a, b});
    }
    const QueryFile fromPoses = read(poses);
    const QueryFile fromTwists = read(twists);
    EXPECT_EQ(fromPoses.form, QueryForm::Poses);
    EXPECT_EQ(fromTwists.form, QueryForm::Twists);
    for (const QueryFile& file : {fromPoses, fromTwists})
    {
        ASSERT_EQ(file.queries.size(), 20U);
        EXPECT_TRUE(file.badRows.empty());
        for (std::size_t k = 0; k < file.queries.size(); ++k)
        {
            EXPECT_EQ(file.queries[k].id, std::to_string(k));
            EXPECT_EQ(file.queries[k].line, k + 2);
            expectSame(file.queries[k].motionA, motions[2 * k]);
            expectSame(file.queries[k].motionB, motions[2 * k + 1]);
        }
    }
}

TEST_F(QueryFileTest, ColumnsMayComeInAnyOrder)
{
    reference::Random random(42);
    const RigidMotion a = motionBetween(random.pose(3.0), random.pose(3.0));
    const RigidMotion b = motionBetween(random.pose(3.0), random.pose(3.0));
    const auto reversed = [](const std::string& line)
    {
        std::vector<std::string> cells = *csvCells(line);
        std::reverse(cells.begin(), cells.end());
        std::string text;
        for (const std::string& cell : cells)
        {
            text += (text.empty() ? "" : ",") + cell;
        }
        return text + "\n";
    };
    for (const bool poses : {true, false})
    {
        const QueryFile file =
            read(reversed(trimmed(poses ? posesHeader() : twistsHeader()).data()) +
                 reversed(trimmed(poses ? posesRow("x", a, b) : twistsRow("x", a, b)).data()));
        ASSERT_EQ(file.queries.size(), 1U);
        expectSame(file.queries[0].motionA, a);
        expectSame(file.queries[0].motionB, b);
    }
}

TEST_F(QueryFileTest, FilesOfOtherProgramsAndSystemsAreRead)
{
    std::string text = posesHeader() + restRow("\"a \"\"b\"\", c\"") + "\n  \n" + restRow("last");
    std::string spaced;
    for (const char c : text)
    {
        spaced += c == ',' ? " ,\t" : (c == '\n' ? "\r\n" : std::string(1, c));
    }
    const QueryFile file = read("\xEF\xBB\xBF" + spaced);
    EXPECT_TRUE(file.badRows.empty());
    ASSERT_EQ(file.queries.size(), 2U);
    EXPECT_EQ(file.queries[0].id, "a \"b\" ,\t c");
    EXPECT_EQ(file.queries[1].line, 5U);

    std::replace(text.begin(), text.end(), '\n', '\r');
    text.pop_back();  // no line end behind the last row
    EXPECT_EQ(read(text).queries.size(), 2U);
    EXPECT_TRUE(read(posesHeader()).queries.empty());
}

TEST_F(QueryFileTest, ABadRowIsReportedWithLineColumnValueAndRemedy)
{
    struct Case
    {
        const char* row;
        const char* message;
    };
    const std::vector<Case> cases{
        {"r,one,0,0,0,0,0,0", "a0_qw: 'one' is not a number: write it like"},
        {"r,1,0,0,0,0,nan,0", "a0_ty: 'nan' is not a finite number"},
        {"r,1,0,0,0,0,0,inf", "a0_tz: 'inf' is not a finite number"},
        {"r,1,0,0,0,1e400,0,0", "a0_tx: '1e400' does not fit a double"},
        {"r,1,0,0,0,2e15,0,0", "a0_tx: '2e15' is not a finite number up to 1e15"},
        {"r,1,0,0,0,0.5m,0,0", "a0_tx: '0.5m' is not a number"},
        {"r,1,0,0,0,0x1,0,0", "a0_tx: '0x1' is not a number"},
        {"r,1,0,0,0,+-1,0,0", "a0_tx: '+-1' is not a number"},
        {"r,1,0,0,0,,0,0", "a0_tx: no value: write a number"},
        {"r,0,0,0,0,0,0,0", "a0_qw: quaternion 0,0,0,0 has length 0: normalise it"},
        {"r,1,0.05,0,0,0,0,0", "a0_qw: quaternion 1,0.05,0,0 has length 1.00125"},
        {"r,1,0,0,0,0,0", "28 cells instead of 29: write one for each column"},
        {"r,1,0,0,0,0,0,0,0", "30 cells instead of 29: write one for each column"},
        {",1,0,0,0,0,0,0", "id: no value: give the row a name"},
        {"\"r,1,0,0,0,0,0,0", "a quote is not closed"},
        {"\"r\"r,1,0,0,0,0,0,0", "a quote is not closed, or text follows it"},
    };
    std::string text = posesHeader();
    for (const Case& c : cases)
    {
        text += restRow("good") + c.row + kRest + kRest + kRest + "\n";
    }
    const QueryFile file = read(text);
    EXPECT_EQ(file.queries.size(), cases.size());
    ASSERT_EQ(file.badRows.size(), cases.size());
    for (std::size_t k = 0; k < cases.size(); ++k)
    {
        const BadRow& row = file.badRows[k];
        EXPECT_EQ(row.line, 2 * k + 3);
        EXPECT_THAT(row.message, HasSubstr("queries.csv:" + std::to_string(row.line) + ": "));
        EXPECT_THAT(row.message, HasSubstr(cases[k].message));
    }
    EXPECT_EQ(file.badRows[0].id, "r");
}

TEST_F(QueryFileTest, RoundedQuaternionsAreNormalised)
{
    const QueryFile file =
        read(posesHeader() + "x,0.7071,0,0.7075,0,1,2,3" + kRest + kRest + kRest);
    ASSERT_EQ(file.queries.size(), 1U);
    const Eigen::Matrix3d R = file.queries[0].motionA.X_W0.linear();
    EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-15);
    EXPECT_LT((R * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-3);
}

TEST_F(QueryFileTest, AFirstLineThatIsNotOneOfTheFormsIsExplained)
{
    const std::string header = posesHeader();
    const std::string names = header.substr(0, header.size() - 1);
    EXPECT_THAT(errorOf(""), HasSubstr("queries.csv:1: the file is empty"));
    EXPECT_THAT(errorOf("\n \n"), HasSubstr("the file is empty"));
    EXPECT_THAT(errorOf(names + ",mass,note\n"), HasSubstr("unknown column 'mass, note'"));
    EXPECT_THAT(errorOf(names.substr(3) + "\n"), HasSubstr("missing column id"));
    EXPECT_THAT(errorOf(names.substr(0, names.size() - 12) + "\n"),
                HasSubstr("missing column b1_ty, b1_tz"));
    EXPECT_THAT(errorOf(names + ",id\n"), HasSubstr("a column is named twice"));
    EXPECT_THAT(errorOf(names + ",a_vx\n"), HasSubstr("columns of both forms"));
    EXPECT_THAT(errorOf("v 1 2 3\n"), HasSubstr("columns of neither form"));
    EXPECT_THAT(errorOf(std::string("i\0d,\0", 5)), HasSubstr("save it as UTF-8"));
    std::string semicolons = header;
    std::replace(semicolons.begin(), semicolons.end(), ',', ';');
    EXPECT_THAT(errorOf(semicolons), HasSubstr("semicolons"));
    // All say what is expected.
    EXPECT_THAT(errorOf("x\n"), HasSubstr("a_vx,a_vy,a_vz,a_wx,a_wy,a_wz"));
}

TEST_F(QueryFileTest, AFileThatCannotBeReadIsNamed)
{
    EXPECT_THROW((void)readQueryFile(m_folder.path() / "absent.csv"), std::runtime_error);
    EXPECT_THROW((void)readQueryFile(m_folder.path()), std::runtime_error);
}

TEST(CsvText, CellsSurviveWritingAndReading)
{
    for (const std::string text : {"plain", "a,b", "say \"yes\"", "", "\"", ",\",\"", " x "})
    {
        const auto cells = csvCells("1," + csvCell(text) + ",2");
        ASSERT_TRUE(cells.has_value());
        EXPECT_THAT(*cells, ElementsAre("1", text, "2"));
    }
    EXPECT_THAT(*csvCells(""), ElementsAre(""));
    EXPECT_THAT(*csvCells("a,"), ElementsAre("a", ""));
    EXPECT_THAT(*csvCells(" \"a\" , b "), ElementsAre("a", "b"));
    EXPECT_FALSE(csvCells("\"a").has_value());
    EXPECT_FALSE(csvCells("\"a\" b,c").has_value());
}

TEST(Quantile, IsTheMiddleOfTheSortedValues)
{
    EXPECT_EQ(quantile({}, 0.5), 0.0);
    EXPECT_EQ(quantile({7.0}, 0.95), 7.0);
    EXPECT_EQ(quantile({3.0, 1.0, 2.0}, 0.5), 2.0);
    EXPECT_EQ(quantile({4.0, 1.0, 3.0, 2.0}, 0.5), 2.5);
    EXPECT_EQ(quantile({5.0, 4.0, 3.0, 2.0, 1.0}, 0.95), 5.0);
    EXPECT_EQ(quantile({5.0, 4.0, 3.0, 2.0, 1.0}, 0.0), 1.0);
}
}  // namespace
}  // namespace bullet_ccd::tools
