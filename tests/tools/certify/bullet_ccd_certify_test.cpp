// Certificates of trajectories, as a user meets them.
#include "tests/tools/articulated_program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <numbers>
#include <regex>
#include <sstream>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// The stretched arm reaches to 1.98 and is 0.01 thick on either side: from its far corner to x = 0
/// at the angle `q` of the shoulder.
double reachOf(double q)
{
    return 1.98 * std::cos(q) + 0.01 * std::sin(q);
}

/// The angle at which that corner is at x = 1.5.
double contactAngle()
{
    return std::acos(1.5 / std::hypot(1.98, 0.01)) + std::atan2(0.01, 1.98);
}

class CertifyProgram : public ArticulatedProgram
{
protected:
    void SetUp() override
    {
        ArticulatedProgram::SetUp();
        m_temp.write("hit.csv", "time,shoulder,elbow\n1,1.5,0\n5,0.5,0\n");
        m_temp.write("free.yaml", freeYaml());
    }

    /// From 1.5 to 1.2 and back to 1.4, at rest at each point.
    static std::string freeYaml()
    {
        return "joint_names: [shoulder, elbow]\n"
               "points:\n"
               "  - {positions: [1.5, 0], velocities: [0, 0], time_from_start: {sec: 0, nanosec: "
               "0}}\n"
               "  - {positions: [1.2, 0], velocities: [0, 0], time_from_start: {sec: 1, nanosec: "
               "500000000}}\n"
               "  - {positions: [1.4, 0], velocities: [0, 0], time_from_start: 2.5}\n";
    }

    [[nodiscard]] Outcome certify(const std::string& arguments) const
    {
        return run("certify " + file("arm.urdf") + "--obstacles " + file("scene.csv") + arguments);
    }

    /// A trajectory in a file is wrong: the message and the exit code.
    void expectRefused(const std::string& name,
                       const std::string& text,
                       const std::string& message) const
    {
        const Outcome done = certify("--trajectory " + joints(name, text));
        EXPECT_EQ(done.exitCode, 3) << text;
        EXPECT_THAT(done.err, HasSubstr(name));
        EXPECT_THAT(done.err, HasSubstr(message));
    }

    /// The number behind a word.
    [[nodiscard]] static double numberAfter(const std::string& text, const std::string& word)
    {
        const std::size_t at = text.find(word);
        return at == std::string::npos ? NAN
                                       : std::strtod(text.c_str() + at + word.size(), nullptr);
    }
};

TEST_F(CertifyProgram, FindsTheFirstContactAtItsClosedForm)
{
    const Outcome done = certify("--trajectory " + file("hit.csv") + "--tolerance 1e-8");
    EXPECT_EQ(done.exitCode, 1) << done.err;
    EXPECT_THAT(done.out, StartsWith("contact: contact at "));
    EXPECT_THAT(done.out, HasSubstr("in segment 0: link fore and obstacle wall"));
    EXPECT_NEAR(
        numberAfter(done.out, "contact: contact at "), 1.0 + 4.0 * (1.5 - contactAngle()), 1e-7);
}

TEST_F(CertifyProgram, CertifiesAFreeTrajectoryWithItsLeastDistance)
{
    const Outcome done = certify("--trajectory " + file("free.yaml") + "--tolerance 1e-8");
    EXPECT_EQ(done.exitCode, 0) << done.err;
    EXPECT_THAT(done.out, StartsWith("free: contact is never reached from 0 to 2.5 s, 2 segments"));
    EXPECT_THAT(done.out, HasSubstr("link fore and obstacle wall"));
    EXPECT_NEAR(numberAfter(done.out, "least distance "), 1.5 - reachOf(1.2), 2e-8);
    EXPECT_NEAR(numberAfter(done.out, " at "), 1.5, 1e-3);
    // A margin just below that is kept, one just above is not; so is that of an obstacle allowed.
    const double least = 1.5 - reachOf(1.2);
    const std::string question = "--no-distance --trajectory " + file("free.yaml");
    EXPECT_EQ(certify(question + fmt::format("--margin {}", least - 1e-4)).exitCode, 0);
    EXPECT_EQ(certify(question + fmt::format("--margin {}", least + 1e-4)).exitCode, 1);
    EXPECT_EQ(
        certify(question + fmt::format("--margin {} --allow fore,wall", least + 1e-4)).exitCode, 0);
}

TEST_F(CertifyProgram, WhatALinkCarriesIsTestedToo)
{
    // A ball as a cube of edge 2 at the end of the forearm reaches to x = 2.98 cos + sin.
    const Outcome done = certify("--trajectory " + file("free.yaml") + "--attach '" +
                                 m_cube.string() + "@fore@1,0,0,0,1.98,0,0'");
    EXPECT_EQ(done.exitCode, 1) << done.err;
    EXPECT_THAT(done.out, HasSubstr("link cube.obj and obstacle wall"));
    // Held half a metre from the elbow, it meets the upper arm, which is 0.98 long, as it folds.
    const Outcome self = run("certify " + file("arm.urdf") + "--self --trajectory " +
                             joints("fold.csv", "shoulder,elbow\n0,0\n0,3\n") + "--attach '" +
                             m_cube.string() + "@fore@1,0,0,0,1.5,0,0'");
    EXPECT_EQ(self.exitCode, 1) << self.err;
    EXPECT_THAT(self.out, HasSubstr("link cube.obj and link upper"));
}

TEST_F(CertifyProgram, AFolderBecomesATable)
{
    m_temp.write("paths/a.csv", contentOf(m_temp.path() / "hit.csv"));
    m_temp.write("paths/b.yml", freeYaml());
    m_temp.write("paths/c.csv", "shoulder\n0\nfast\n");
    m_temp.write("paths/notes.txt", "not a trajectory");
    const Outcome done = certify("--trajectory " + file("paths") + "-o " + file("out.csv"));
    EXPECT_EQ(done.exitCode, 3);
    EXPECT_THAT(done.err, HasSubstr("c.csv:3: shoulder: 'fast'"));
    std::istringstream lines(contentOf(m_temp.path() / "out.csv"));
    std::vector<std::string> rows;
    for (std::string line; std::getline(lines, line);)
    {
        rows.push_back(line);
        EXPECT_EQ(std::count(line.begin(), line.end(), ','), 20) << line;
    }
    ASSERT_EQ(rows.size(), 4U);
    EXPECT_THAT(rows[1], HasSubstr("a.csv,contact,"));
    EXPECT_THAT(rows[1], HasSubstr(",0,fore,wall,,"));
    EXPECT_THAT(rows[2], HasSubstr("b.yml,free,2.5,,"));
    EXPECT_THAT(rows[3], HasSubstr("c.csv,bad_input,"));
}

/// What no time was left for is not free, and has a code of its own.
TEST_F(CertifyProgram, WhatWasNotDoneIsNotFree)
{
    const Outcome done =
        certify("--trajectory " + file("free.yaml") + file("hit.csv") + "--time-limit 1e-9");
    EXPECT_EQ(done.exitCode, 1);
    EXPECT_THAT(done.err, HasSubstr("stopped after 0 of 2 trajectories"));
}

/// However early the search for the least distance gives up, the truth is between the two numbers.
TEST_F(CertifyProgram, ALeastDistanceThatIsNotKnownIsAnInterval)
{
    const double truth = 1.5 - reachOf(1.2);
    int gaveUp = 0;
    for (const int iterations : {1, 3, 10, 30, 100, 300, 1000, 1'000'000})
    {
        const Outcome done =
            certify("--trajectory " + file("free.yaml") + "-o " + file("interval.csv") +
                    fmt::format("--max-iterations {}", iterations));
        std::istringstream lines(contentOf(m_temp.path() / "interval.csv"));
        std::string row;
        std::getline(lines, row);
        std::getline(lines, row);
        std::vector<std::string> cells;
        std::istringstream parts(row);
        for (std::string cell; std::getline(parts, cell, ',');)
        {
            cells.push_back(cell);
        }
        ASSERT_EQ(cells.size(), 21U) << row;
        if (done.exitCode == 1)
        {
            EXPECT_EQ(cells[1], "unknown");
            continue;
        }
        ASSERT_EQ(done.exitCode, 0) << done.err;
        const double low = std::stod(cells[14]);
        const double high = std::stod(cells[15]);
        EXPECT_LE(low, truth + 1e-12) << row;
        EXPECT_GE(high, truth - 1e-12) << row;
        gaveUp += high - low > 1e-4 ? 1 : 0;
    }
    EXPECT_GT(gaveUp, 0);
}

TEST_F(CertifyProgram, SaysWhatIsWrongAndWhere)
{
    expectRefused(
        "a.csv", "shoulder,elbo\n0,0\n1,0\n", "a.csv:1: elbo: the robot has no such joint");
    expectRefused("b.csv", "shoulder\n0\nnan\n", "b.csv:3: shoulder: 'nan'");
    expectRefused("c.csv", "time,shoulder\n0,0\n1,1\n1,2\n", "c.csv:4: time: 1 s is not after");
    expectRefused("d.csv", "shoulder\n0\n", "one waypoint");
    expectRefused("e.txt", "shoulder\n0\n", "give a file that ends in .csv, .yaml or .yml");
    expectRefused("f.yaml",
                  "joint_names: [sholder]\npoints:\n  - {positions: [0], time_from_start: 0}\n",
                  "f.yaml:1: joint_names: sholder: the robot has no such joint");
    const std::string start =
        "joint_names: [shoulder]\npoints:\n"
        "  - {positions: [0], time_from_start: 1}\n";
    expectRefused("g.yaml", start + "  - {positions: [.nan], time_from_start: 2}\n", "g.yaml:4:");
    expectRefused("h.yaml",
                  start + "  - {positions: [1], time_from_start: 0.5}\n",
                  "h.yaml:4: time_from_start: 0.5 s is not after the 1 s");
    expectRefused("i.yaml",
                  start + "  - {positions: [1, 2], time_from_start: 2}\n",
                  "i.yaml:4: positions: not a list of 1 numbers");
    expectRefused("j.yaml",
                  start + "  - {position: [1], time_from_start: 2}\n",
                  "j.yaml:4: position: no such key: did you mean positions?");
    const std::string path = "--trajectory " + file("hit.csv");
    const Outcome unknown = certify(path + "--attach '" + m_cube.string() + "@for'");
    EXPECT_EQ(unknown.exitCode, 3);
    EXPECT_THAT(unknown.err, HasSubstr("the robot has no link for: did you mean fore?"));
    EXPECT_EQ(certify(path + "--attach cube.obj").exitCode, 2);
    const Outcome allowed = certify(path + "--allow fore,wal");
    EXPECT_EQ(allowed.exitCode, 3);
    EXPECT_THAT(allowed.err, HasSubstr("did you mean wall?"));
    EXPECT_EQ(certify(path + "--margin -1").exitCode, 2);
    EXPECT_EQ(run("certify " + file("arm.urdf") + path).exitCode, 2);
    EXPECT_EQ(certify("--trajectory " + file("")).exitCode, 3);
}

TEST_F(CertifyProgram, HelpIsReadable)
{
    const Outcome help = run("certify --help");
    EXPECT_EQ(help.exitCode, 0);
    expectReadableHelp(help.out);
}
}  // namespace
}  // namespace bullet_ccd::tools
