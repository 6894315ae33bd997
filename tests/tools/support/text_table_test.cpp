#include "tools/support/text_table.h"

#include <gtest/gtest.h>

namespace bullet_ccd::tools
{
namespace
{
const TextTable kTable{.header = {"name", "some value"}, .rows = {{"a", "1.5"}, {"b,\"c\"", "-"}}};

TEST(TextTable, AlignsNumbersToTheRight)
{
    EXPECT_EQ(alignedText(kTable),
              "name   some value\n"
              "a             1.5\n"
              "b,\"c\"           -\n");
}

TEST(TextTable, QuotesCommasInCsv)
{
    EXPECT_EQ(csvText(kTable),
              "name,some_value\n"
              "a,1.5\n"
              "\"b,\"\"c\"\"\",-\n");
}

TEST(TextTable, SaysInMarkdownWhatIsANumber)
{
    EXPECT_EQ(markdownText(kTable),
              "| name | some value |\n"
              "|---|---:|\n"
              "| a | 1.5 |\n"
              "| b,\"c\" | - |\n");
}

TEST(TextTable, JoinsWithSeparators)
{
    EXPECT_EQ(joined({}, ", "), "");
    EXPECT_EQ(joined({"a", "b", "c"}, ", "), "a, b, c");
}
}  // namespace
}  // namespace bullet_ccd::tools
