// Disabled pairs that the program proposes and checks, and what bullet-ccd makes of them.
#include "grasp/hand/srdf_file.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/run_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

/// Two fingers that meet, one of them carries a nail that nothing reaches, on a palm with a badge
/// that lies in it.
std::string pincer()
{
    const auto link = [](const std::string& name, const std::string& size, const std::string& at)
    {
        return fmt::format(R"(<link name="{}"><collision><origin xyz="{}"/>
            <geometry><box size="{}"/></geometry></collision></link>)",
                           name,
                           at,
                           size);
    };
    const auto hinge = [](const std::string& name, const std::string& x, const std::string& axis)
    {
        return fmt::format(R"(<joint name="{0}_joint" type="revolute"><parent link="palm"/>
            <child link="{0}"/><origin xyz="{1} 0 0.02"/><axis xyz="{2}"/>
            <limit lower="0" upper="1" effort="1" velocity="1"/></joint>)",
                           name,
                           x,
                           axis);
    };
    const auto fixed = [](const std::string& name, const std::string& parent)
    {
        return fmt::format(R"(<joint name="{0}_joint" type="fixed"><parent link="{1}"/>
            <child link="{0}"/></joint>)",
                           name,
                           parent);
    };
    return R"(<robot name="pincer">)" + link("palm", "0.14 0.06 0.02", "0 0 0") +
           link("badge", "0.02 0.07 0.01", "0 0 0") + link("label", "0.01 0.08 0.005", "0 0 0") +
           link("left", "0.01 0.02 0.1", "0 0 0.05") +
           link("nail", "0.004 0.004 0.004", "-0.006 0 0.09") +
           link("right", "0.01 0.02 0.1", "0 0 0.05") + fixed("badge", "palm") +
           fixed("label", "badge") + hinge("left", "-0.05", "0 1 0") + fixed("nail", "left") +
           hinge("right", "0.05", "0 -1 0") + "</robot>";
}

double numberAfter(const std::string& text, const std::string& key)
{
    const std::size_t at = text.find(key);
    EXPECT_NE(at, std::string::npos) << text;
    return at == std::string::npos ? 0.0 : std::stod(text.substr(at + key.size()));
}

class HandCheck : public ::testing::Test
{
protected:
    [[nodiscard]] static Outcome grasp(const std::string& arguments)
    {
        return runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " " + arguments);
    }

    /// The pincer closes.
    [[nodiscard]] Outcome articulated(const std::string& more) const
    {
        const fs::path open = m_temp.write("open.csv", "left_joint,right_joint\n0,0\n");
        const fs::path closed = m_temp.write("closed.csv", "left_joint,right_joint\n1,1\n");
        return runProgram(fmt::format("{} articulated '{}' --from '{}' --to '{}' --self {}",
                                      BULLET_CCD_PROGRAM,
                                      m_urdf.string(),
                                      open.string(),
                                      closed.string(),
                                      more));
    }

    [[nodiscard]] std::string check(const std::string& more) const
    {
        return fmt::format("hand check '{}' --samples 500 {}", m_urdf.string(), more);
    }

    tests::TempFolder m_temp;
    fs::path m_urdf = m_temp.write("pincer.urdf", pincer());
    fs::path m_srdf = m_temp.path() / "found.srdf";
};

TEST_F(HandCheck, ProposesPairsWithTheirReasons)
{
    const Outcome shown = grasp(check(""));
    ASSERT_EQ(shown.exitCode, 0) << shown.err;
    for (const char* line : {R"(link1="palm" link2="left" reason="Adjacent")",
                             R"(link1="palm" link2="label" reason="Default")",
                             R"(link1="badge" link2="nail" reason="Never")",
                             "disabled pairs from nowhere"})
    {
        EXPECT_THAT(shown.out, HasSubstr(line));
    }
    EXPECT_THAT(shown.out, Not(HasSubstr(R"(link1="left" link2="right")")));
    EXPECT_THAT(shown.out, Not(HasSubstr(R"(reason="Sometimes")")));
}

TEST_F(HandCheck, TheSrdfSatisfiesTheCheckAndBulletCcd)
{
    const Outcome written = grasp(
        check(fmt::format("--reasons Adjacent,Default,Never --write-srdf '{}'", m_srdf.string())));
    ASSERT_EQ(written.exitCode, 0) << written.err;
    EXPECT_THAT(written.out, Not(HasSubstr("<robot")));
    const std::vector<std::pair<std::string, std::string>> pairs =
        bullet_ccd::grasp::readSrdf(m_srdf).disabledPairs;
    EXPECT_EQ(std::count(
                  pairs.begin(), pairs.end(), std::pair<std::string, std::string>{"palm", "label"}),
              1);
    const Outcome again = grasp(check(fmt::format("--srdf '{}'", m_srdf.string())));
    EXPECT_EQ(again.exitCode, 0) << again.out;
    EXPECT_THAT(again.out, Not(HasSubstr("FAIL")));

    const Outcome closed =
        articulated(fmt::format("--tolerance 1e-7 --json --srdf '{}'", m_srdf.string()));
    ASSERT_EQ(closed.exitCode, 0) << closed.err;
    EXPECT_THAT(closed.err, Not(HasSubstr("ignored")));
    for (const char* word : {"\"hit\"", "\"left\"", "\"right\""})
    {
        EXPECT_THAT(closed.out, HasSubstr(word));
    }
    // The inner upper corners, at (0.005, 0.1) from joints 0.05 off the middle, meet in it.
    const double angle = std::asin(0.05 / std::hypot(0.1, 0.005)) - std::atan2(0.005, 0.1);
    EXPECT_NEAR(numberAfter(closed.out, "\"toi\":"), angle, 1e-5);
}

TEST_F(HandCheck, ContradictionsFail)
{
    const fs::path careless = m_temp.write("careless.srdf",
                                           R"(<robot name="pincer">
        <disable_collisions link1="right" link2="left" reason="User"/></robot>)");
    const Outcome checked = grasp(check(fmt::format("--srdf '{}'", careless.string())));
    EXPECT_EQ(checked.exitCode, 1) << checked.err;
    EXPECT_THAT(checked.out, HasSubstr("overlap in some configurations only: left - right"));
    EXPECT_THAT(checked.out, HasSubstr("does not disable pairs that overlap at rest"));
    EXPECT_THAT(checked.out, HasSubstr("palm - label"));
}

TEST_F(HandCheck, ShippedHandsPass)
{
    for (const char* hand : {"three_finger_gripper", "parallel_gripper", "anthropomorphic_hand"})
    {
        const Outcome checked = grasp(fmt::format("hand check {} --samples 200", hand));
        EXPECT_EQ(checked.exitCode, 0) << checked.out << checked.err;
        EXPECT_THAT(checked.out, HasSubstr(R"(reason="Adjacent")"));
    }
}

TEST_F(HandCheck, TheSameSeedGivesTheSameText)
{
    EXPECT_EQ(grasp(check("--seed 3")).out, grasp(check("--seed 3")).out);
}

TEST_F(HandCheck, WrongInputIsNamed)
{
    EXPECT_EQ(grasp("hand").exitCode, 2);
    EXPECT_EQ(grasp("hand check").exitCode, 2);
    EXPECT_EQ(grasp(check("--samples 0")).exitCode, 2);
    const Outcome reason = grasp(check("--reasons Adjacent,Seldom"));
    EXPECT_EQ(reason.exitCode, 2);
    EXPECT_THAT(reason.err, HasSubstr("Seldom"));
    EXPECT_EQ(grasp("hand check left_foot").exitCode, 3);
    const Outcome overwrite = grasp(check(fmt::format("--write-srdf '{}'", m_urdf.string())));
    EXPECT_EQ(overwrite.exitCode, 3);
    EXPECT_EQ(contentOf(m_urdf), pincer());
    const Outcome nowhere = grasp(check("--write-srdf /nowhere/found.srdf"));
    EXPECT_EQ(nowhere.exitCode, 3);
    EXPECT_THAT(nowhere.err, HasSubstr("/nowhere/found.srdf"));
}
}  // namespace
}  // namespace bullet_ccd::tools
