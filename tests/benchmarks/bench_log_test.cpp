#include "benchmarks/grasp/bench_log.h"

#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using nlohmann::json;

class BenchLogTest : public ::testing::Test
{
protected:
    static json row(const char* hand, const char* object)
    {
        return {{"hand", hand}, {"object", object}, {"value", 1}};
    }

    tests::TempFolder m_temp;
    std::filesystem::path m_file = m_temp.path() / "rows.jsonl";
    json m_settings = {{"seed", 1}};
};

TEST_F(BenchLogTest, GoesOnWithTheRowsThatAreThere)
{
    BenchLog(m_file, m_settings, false).add(row("a", "x"));
    {
        BenchLog log(m_file, m_settings, true);
        EXPECT_TRUE(log.has("a", "x"));
        EXPECT_FALSE(log.has("x", "a"));
        log.add(row("a", "y"));
    }
    const BenchLog log(m_file, m_settings, true);
    ASSERT_EQ(log.rows().size(), 2U);
    EXPECT_EQ(log.rows()[1], row("a", "y"));
}

TEST_F(BenchLogTest, DropsALineThatWasCutOff)
{
    {
        BenchLog log(m_file, m_settings, false);
        log.add(row("a", "x"));
        log.add(row("a", "y"));
    }
    std::filesystem::resize_file(m_file, std::filesystem::file_size(m_file) - 5);
    BenchLog log(m_file, m_settings, true);
    EXPECT_TRUE(log.has("a", "x"));
    EXPECT_FALSE(log.has("a", "y"));
    log.add(row("a", "y"));
    EXPECT_EQ(BenchLog(m_file, m_settings, true).rows().size(), 2U);
}

TEST_F(BenchLogTest, RefusesWhatItMustNotTouch)
{
    BenchLog(m_file, m_settings, false).add(row("a", "x"));
    const auto messageOf = [&](const json& settings, bool resume) -> std::string
    {
        try
        {
            BenchLog(m_file, settings, resume);
        }
        catch (const std::runtime_error& error)
        {
            return error.what();
        }
        return "";
    };
    EXPECT_NE(messageOf(m_settings, false).find("--resume"), std::string::npos);
    EXPECT_NE(messageOf({{"seed", 2}}, true).find("rows.jsonl:1: begun with other settings"),
              std::string::npos);
    EXPECT_TRUE(BenchLog(m_file, m_settings, true).has("a", "x")) << "something was lost";
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
