#include "tools/support/help_format.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <gmock/gmock.h>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Wrapped, BreaksAtSpacesBeforeColumn81)
{
    const std::string forty(40, 'x');
    const std::string thirtyNine(39, 'y');
    EXPECT_EQ(wrapped(forty + ' ' + thirtyNine, 0), forty + ' ' + thirtyNine);
    EXPECT_EQ(wrapped(forty + ' ' + forty, 0), forty + '\n' + forty);
    EXPECT_EQ(wrapped(forty + ' ' + thirtyNine, 1), forty + "\n " + thirtyNine);
    EXPECT_EQ(wrapped(std::string(90, 'z') + " a", 2), std::string(90, 'z') + "\n  a");
}

TEST(Wrapped, KeepsParagraphsAndWhatBeginsWithASpace)
{
    const std::string example = "  program " + std::string(80, 'x') + " y";
    EXPECT_EQ(wrapped("One.\n\nTwo:\n" + example, 0), "One.\n\nTwo:\n" + example);
    EXPECT_EQ(wrapped("One.\nTwo.", 3), "One.\n   Two.");
    EXPECT_EQ(wrapped("", 3), "");
}

/// A program with one verb.
class CommandLine : public ::testing::Test
{
protected:
    CommandLine() : m_app("Does things.", "program")
    {
        m_app.formatter(helpFormat());
        m_app.require_subcommand(1);
        CLI::App* verb = m_app.add_subcommand("turn", "Turns a thing.");
        verb->add_option("THING", m_text, "The thing to turn.")->type_name("FILE")->required();
        verb->add_option("--angle", m_angle, "The angle [rad].")
            ->type_name("A")
            ->capture_default_str();
        verb->add_flag("--back", m_back, "Turn back.")->excludes("--angle");
    }

    [[nodiscard]] std::string helpOfVerb() { return m_app.get_subcommand("turn")->help(); }

    /// The message of a command line that is wrong.
    std::string complaintOf(const std::string& arguments)
    {
        try
        {
            m_app.parse(arguments);
        }
        catch (const CLI::ParseError& error)
        {
            return usageError(m_app, error);
        }
        return "no error";
    }

    CLI::App m_app;
    std::string m_text;
    double m_angle = 0.5;
    bool m_back = false;
};

TEST_F(CommandLine, HelpSaysDefaultsAndWhatExcludesWhat)
{
    EXPECT_THAT(helpOfVerb(),
                HasSubstr("  --angle A               The angle [rad]. Default: 0.5. "
                          "Not with --back.\n"));
    EXPECT_THAT(helpOfVerb(), HasSubstr("  THING FILE              The thing to turn.\n"));
    EXPECT_THAT(m_app.help(), HasSubstr("  turn                    Turns a thing.\n"));
    EXPECT_THAT(helpOfVerb(), Not(HasSubstr("REQUIRED")));
}

TEST_F(CommandLine, ErrorsNameTheVerbTheWordAndARemedy)
{
    EXPECT_EQ(complaintOf("turn cup --angel 1"),
              "program turn: --angel: no such option: did you mean --angle?\n"
              "'program turn --help' shows all options.\n");
    EXPECT_THAT(complaintOf("tern cup"),
                HasSubstr("program: tern: no such verb: did you mean turn?"));
    EXPECT_THAT(complaintOf("turn cup saucer"), HasSubstr("saucer: one argument too many"));
    EXPECT_THAT(complaintOf("turn"), HasSubstr("program turn: THING is required"));
    EXPECT_THAT(complaintOf(""), HasSubstr("program: no verb: give one of turn"));
    EXPECT_THAT(complaintOf("turn cup --angle"),
                HasSubstr("--angle: too few or too many values: give --angle A"));
    EXPECT_THAT(complaintOf("turn cup --angle wide"),
                HasSubstr("--angle: wide is no value for it"));
    EXPECT_THAT(complaintOf("turn cup --angle 1 --back"), HasSubstr(": leave out one of them"));
    EXPECT_EQ(complaintOf("turn cup --angle 1"), "no error");
}
}  // namespace
}  // namespace bullet_ccd::tools
