// What a long run goes on from: kept whole, and refused where it does not fit.
#include "benchmarks/support/checkpoint.h"

#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using nlohmann::json;

class Checkpoint : public ::testing::Test
{
protected:
    [[nodiscard]] std::string messageOf(const json& run) const
    {
        try
        {
            static_cast<void>(loadCheckpoint(m_file, run));
        }
        catch (const std::runtime_error& error)
        {
            return error.what();
        }
        return "";
    }

    tests::TempFolder m_temp;
    std::string m_file = (m_temp.path() / "rows.json").string();
    json m_run = {{"seed", 1}};
};

TEST_F(Checkpoint, HasTheLastStateOrNone)
{
    EXPECT_FALSE(loadCheckpoint(m_file, m_run));
    for (const json& state : {json{1}, json{1, 2}})
    {
        saveCheckpoint(m_file, m_run, state);
        EXPECT_EQ(loadCheckpoint(m_file, m_run), state);
    }
}

TEST_F(Checkpoint, RefusesThatOfAnotherRunAndOneThatWasCutOff)
{
    saveCheckpoint(m_file, m_run, {1, 2});
    EXPECT_NE(messageOf({{"seed", 2}}).find("rows.json: belongs to another run"),
              std::string::npos);
    EXPECT_TRUE(loadCheckpoint(m_file, m_run)) << "something was lost";
    std::filesystem::resize_file(m_file, std::filesystem::file_size(m_file) - 5);
    EXPECT_NE(messageOf(m_run).find("damaged"), std::string::npos);
}

TEST_F(Checkpoint, SaysThatAFileCannotBeWritten)
{
    EXPECT_THROW(saveCheckpoint(m_file + "/none", m_run, {}), std::runtime_error);
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
