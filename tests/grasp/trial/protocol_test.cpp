#include "grasp/trial/protocol.h"

#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <gmock/gmock.h>
#include <stdexcept>

namespace bullet_ccd::grasp
{
namespace
{
using ::testing::HasSubstr;

class ProtocolFile : public ::testing::Test
{
protected:
    [[nodiscard]] TrialProtocol read(const std::string& text) const
    {
        const std::filesystem::path file = m_folder.path() / "push.yaml";
        std::ofstream(file) << text;
        return readProtocol(file);
    }
    [[nodiscard]] std::string errorOf(const std::string& text) const
    {
        try
        {
            (void)read(text);
        }
        catch (const std::runtime_error& error)
        {
            return error.what();
        }
        return "none";
    }

private:
    tests::TempFolder m_folder;
};

TEST_F(ProtocolFile, SaysWhatHappens)
{
    const TrialProtocol protocol = read(
        "start: table\nerror_mm: 2\nheld_mm: 5\nphases:\n"
        "  - lift: {mm: 100, seconds: 2}\n"
        "  - load: {direction: [0, 1, 0], weights: 3, seconds: 0.5}\n"
        "  - shake: {direction: [1, 0, 0], mm: 10, hz: 4, seconds: 1}\n"
        "  - pull: {force: [0, 0, 2]}\n"
        "  - pull: {random: 3, seed: 7}\n");
    EXPECT_EQ(protocol.name, "push");
    EXPECT_EQ(protocol.start, TrialStart::Table);
    EXPECT_DOUBLE_EQ(protocol.shift, 0.002);
    EXPECT_DOUBLE_EQ(protocol.heldWay, 0.005);
    ASSERT_EQ(protocol.phases.size(), 7U);
    EXPECT_EQ(protocol.phases[0].kind, TrialPhase::Kind::Lift);
    EXPECT_DOUBLE_EQ(protocol.phases[0].amount, 0.1);
    EXPECT_DOUBLE_EQ(protocol.phases[1].amount, 3.0);
    EXPECT_EQ(protocol.phases[1].direction, Eigen::Vector3d::UnitY());
    EXPECT_DOUBLE_EQ(protocol.phases[2].frequency, 4.0);
    EXPECT_DOUBLE_EQ(protocol.phases[3].wrench[2], 2.0);
    EXPECT_NEAR(protocol.phases[6].wrench.norm(), 1.0, 1e-12);
    EXPECT_NE(protocol.phases[5].wrench, protocol.phases[6].wrench);
}

TEST_F(ProtocolFile, NamesTheLineTheKeyAndARemedy)
{
    const std::string start = "name: x\n";
    EXPECT_THAT(errorOf(start + "fases: []\n"),
                HasSubstr("push.yaml:2: fases: no such key: did you mean phases?"));
    EXPECT_THAT(errorOf(start), HasSubstr("phases"));
    EXPECT_THAT(errorOf(start + "start: lying\nphases: [load: {}]\n"),
                HasSubstr("push.yaml:2: start: \"lying\": write held, open or table"));
    EXPECT_THAT(errorOf(start + "phases:\n  - load: {}\n  - load: {seconds: soon}\n"),
                HasSubstr("push.yaml:4: seconds: soon: not a number"));
    EXPECT_THAT(errorOf(start + "phases:\n  - load: {seconds: -1}\n"),
                HasSubstr("push.yaml:3: seconds: -1: write a number from 1e-06 to 600"));
    EXPECT_THAT(errorOf(start + "phases:\n  - load: {direction: [0, 0]}\n"),
                HasSubstr("push.yaml:3: direction: [0, 0]: not three numbers"));
    EXPECT_THAT(errorOf(start + "phases:\n  - load: {direction: [0, 0, 0]}\n"),
                HasSubstr("push.yaml:3: load: the direction is 0"));
    EXPECT_THAT(errorOf(start + "phases:\n  - pull: {}\n"),
                HasSubstr("push.yaml:3: pull: the wrench is 0"));
    EXPECT_THAT(errorOf(start + "error_mm: 3\nphases: [load: {}]\n"),
                HasSubstr("needs a start with the open hand"));
    EXPECT_THAT(errorOf("phases: [\n"), HasSubstr("not YAML"));
    // What two keys say together has the line of one of them.
    EXPECT_THAT(errorOf(start + "phases: [load: {}]\nheld_mm: 200\n"),
                HasSubstr("push.yaml:3: held_mm: 200: thresholds"));
    EXPECT_THAT(errorOf(start + "phases: [load: {}]\nerror_deg: 3\n"),
                HasSubstr("push.yaml:3: error_deg: 3: an error of the pose"));
    EXPECT_THAT(errorOf(start + "start: open\nerror_mm: -3\nphases: [load: {}]\n"),
                HasSubstr("push.yaml:3: error_mm: -3: write a number from 0 to 1000"));
    EXPECT_THAT(errorOf(start + "phases:\n  - load:\n"), HasSubstr("push.yaml:3: load: nothing"));
    EXPECT_THAT(errorOf(start + "phases:\n  - load: 3\n"),
                HasSubstr("push.yaml:3: load: 3: not a map"));
    EXPECT_THAT(errorOf(start + "held_mm: nan\nphases: [load: {}]\n"),
                HasSubstr("push.yaml:2: held_mm: nan: not a number"));
    EXPECT_THAT(errorOf(start + "start: [table]\nphases: [load: {}]\n"),
                HasSubstr("push.yaml:2: start: [table]: not a word"));
    EXPECT_THAT(errorOf(start + "phases:\n  - lift: {mm: -50}\n"),
                HasSubstr("push.yaml:3: mm: -50"));
}

TEST_F(ProtocolFile, CountsAndSeedsAreWholeNumbers)
{
    for (const char* pull : {"random: 2.5",
                             "random: 0",
                             "random: -3",
                             "random: 3, seed: -1",
                             "random: 3, seed: 1.5",
                             "random: 3, seed: 18446744073709551616"})
    {
        EXPECT_THAT(errorOf("phases:\n  - pull: {" + std::string(pull) + "}\n"),
                    HasSubstr("write a whole number from "))
            << pull;
    }
    EXPECT_EQ(read("phases:\n  - pull: {random: 3, seed: 18446744073709551615}\n").phases.size(),
              3U);
}

// Films and rows are called so.
TEST_F(ProtocolFile, NamesAreOfLettersAndDigits)
{
    const std::string phases = "\nphases: [load: {}]\n";
    EXPECT_EQ(read("name: Push-2_b" + phases).name, "Push-2_b");
    for (const char* name : {"a/../../b", "a b", "..", "a\\tb"})
    {
        EXPECT_THAT(errorOf("start: held\nname: \"" + std::string(name) + "\"" + phases),
                    HasSubstr("push.yaml:2: name: "))
            << name;
    }
    EXPECT_THROW((void)readProtocol(std::filesystem::temp_directory_path()), std::runtime_error);
    EXPECT_THROW((void)namedProtocol("no_such_protocol"), std::runtime_error);
}

TEST(Protocol, ThoseThatShipAreInOrder)
{
    for (const std::string& name : shippedProtocols())
    {
        EXPECT_NO_THROW(checkProtocol(namedProtocol(name))) << name;
        EXPECT_EQ(namedProtocol(name).name, name);
    }
    EXPECT_THROW((void)shippedProtocol("seven"), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::grasp
