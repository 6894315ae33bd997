// The verb elementary, as a user runs it: answers against the truth in the files, and bad files.
#include "tests/support/test_data.h"
#include "tests/tools/bullet_ccd_program.h"

#include <gtest/gtest.h>

#include <gmock/gmock.h>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::HasSubstr;

/// A vertex that falls through a face at t = 1/2.
constexpr const char* kFalling =
    "0,1,0,1,1,1,1\n-1,1,-1,1,0,1,1\n2,1,-1,1,0,1,1\n-1,1,2,1,0,1,1\n"
    "0,1,0,1,-1,1,1\n-1,1,-1,1,0,1,1\n2,1,-1,1,0,1,1\n-1,1,2,1,0,1,1\n";
/// Two edges that pass each other 1/8388608 apart.
constexpr const char* kPassing =
    "-1,1,0,1,1,8388608,0\n1,1,0,1,1,8388608,0\n0,1,-9,1,0,1,0\n0,1,-8,1,0,1,0\n"
    "-1,1,0,1,1,8388608,0\n1,1,0,1,1,8388608,0\n0,1,8,1,0,1,0\n0,1,9,1,0,1,0\n";

class ElementaryProgram : public BulletCcdProgram
{
protected:
    [[nodiscard]] Outcome elementary(const std::string& arguments) const
    {
        return run("elementary " + arguments + " -o '" + m_output.string() + "'");
    }

    std::filesystem::path m_output = m_temp.path() / "out.csv";
};

TEST_F(ElementaryProgram, AnswersInTheOrderOfTheFiles)
{
    (void)m_temp.write("q/vertex-face/a.csv", kFalling);
    (void)m_temp.write("q/edge-edge/a.csv", std::string(kPassing) + kPassing);
    const std::string folder = "'" + (m_temp.path() / "q").string() + "'";
    const Outcome coarse = elementary(folder + " --summary --tolerance 1e-6");
    EXPECT_EQ(coarse.exitCode, 0) << coarse.err;
    EXPECT_THAT(coarse.out, HasSubstr("with a truth: 3, of which 1 touch\nmissed: 0\nfalse: 2\n"));

    const Outcome decided = elementary(folder + " --summary --tolerance 1e-6 --decide");
    EXPECT_THAT(decided.out, HasSubstr("missed: 0\nfalse: 0\n"));
    EXPECT_THAT(contentOf(m_output),
                ::testing::MatchesRegex("query,hit,toi,microseconds\n0,0,1,[0-9.]+\n1,0,1,[0-9.]+\n"
                                        "2,1,0\\.49999[0-9]*,[0-9.]+\n"));
    // Closer than the separation at once.
    const Outcome kept = elementary(folder + " --summary --minimum-separation 0.1");
    EXPECT_THAT(kept.out, HasSubstr("hits: 3\n"));
}

TEST_F(ElementaryProgram, MissesNothingAndIsExactOnTheGroundTruth)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(data, "ccd_queries");
    const std::string folder = "'" + data.string() + "' --summary --tolerance 1e-6 ";
    const Outcome exact = elementary(folder + "--exact");
    EXPECT_EQ(exact.exitCode, 0) << exact.err;
    EXPECT_THAT(exact.out,
                HasSubstr("with a truth: 3656, of which 223 touch\nmissed: 0\nfalse: 0\n"));
    const Outcome decided = elementary(folder + "--decide");
    EXPECT_THAT(decided.out, HasSubstr("missed: 0\n"));
    const std::size_t at = decided.out.find("false: ");
    ASSERT_NE(at, std::string::npos);
    EXPECT_LE(std::stoi(decided.out.substr(at + 7)), 140);
}

// Numerators and denominators beyond the range of a double; what they say is within it.
TEST_F(ElementaryProgram, TakesNumbersOfAnyLength)
{
    const std::string zeros(400, '0');
    std::string longer;  // the same places: "-1,1" becomes "-1000...,1000..."
    std::string line;
    for (const char c : std::string(kFalling))
    {
        line += c;
        if (c != '\n')
        {
            continue;
        }
        int cells = 0;
        for (const char inLine : line)
        {
            longer += inLine == ',' && cells++ < 6 ? zeros + ',' : std::string(1, inLine);
        }
        line.clear();
    }
    const std::string file = "'" + m_temp.write("long.csv", longer).string() + "' --vertex-face";
    const Outcome answered = elementary(file + " --summary --exact");
    EXPECT_EQ(answered.exitCode, 0) << answered.err;
    EXPECT_THAT(answered.out, HasSubstr("with a truth: 1, of which 1 touch\nmissed: 0\n"));
    EXPECT_THAT(contentOf(m_output), ::testing::HasSubstr("\n0,1,0.4999"));

    const std::string large = "'" +
                              m_temp.write("large.csv", "1" + zeros + ",1,0,1,1,1,1\n").string() +
                              "' --vertex-face";
    const Outcome refused = elementary(large);
    EXPECT_EQ(refused.exitCode, 3);
    EXPECT_THAT(refused.err, HasSubstr("large.csv:1: a coordinate is too large for a double"));
}

TEST_F(ElementaryProgram, SaysWhatIsWrongWithAFile)
{
    struct Case
    {
        std::string content;
        const char* word;
    };
    std::string zero = kFalling;
    zero.replace(0, 3, "0,0");
    std::string letter = kFalling;
    letter.replace(0, 1, "x");
    std::string truth = kFalling;
    truth.replace(12, 1, "0");
    for (const Case& c : {Case{zero, "a.csv:1: a denominator is 0"},
                          Case{letter, "a.csv:1: column 1: 'x' is not a whole number"},
                          Case{truth, "a.csv:2: another truth than in the line before"},
                          Case{"1,1,1\n", "a.csv:1: 3 cells"},
                          Case{"0,1,0,1,0,1,1\n", "a.csv: 1 lines: write eight lines a query"},
                          Case{"", "a.csv: 0 lines: write eight lines a query"}})
    {
        const std::filesystem::path file = m_temp.write("edge-edge/a.csv", c.content);
        const Outcome outcome = elementary("'" + file.string() + "'");
        EXPECT_EQ(outcome.exitCode, 3) << c.word;
        EXPECT_THAT(outcome.err, HasSubstr(c.word));
    }
    const Outcome absent = elementary("no.csv");
    EXPECT_EQ(absent.exitCode, 3);
    EXPECT_THAT(absent.err, HasSubstr("no.csv: no such file"));
    const std::filesystem::path loose = m_temp.write("loose.csv", kFalling);
    const Outcome unknown = elementary("'" + loose.string() + "'");
    EXPECT_EQ(unknown.exitCode, 3);
    EXPECT_THAT(unknown.err, HasSubstr("give --edge-edge or --vertex-face"));
    EXPECT_EQ(elementary("'" + loose.string() + "' --vertex-face").exitCode, 0);
}
}  // namespace
}  // namespace bullet_ccd::tools
