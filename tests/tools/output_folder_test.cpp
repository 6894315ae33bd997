#include "tools/grasp_cli/plan/output_folder.h"

#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

class OutputFolderTest : public ::testing::Test
{
protected:
    static void write(const fs::path& path, const char* text) { std::ofstream(path) << text; }
    [[nodiscard]] std::string read(const char* name) const
    {
        std::stringstream text;
        text << std::ifstream(m_folder / name).rdbuf();
        return text.str();
    }
    [[nodiscard]] long entries() const
    {
        return std::distance(fs::directory_iterator(m_folder), fs::directory_iterator());
    }

    tests::TempFolder m_temp;
    fs::path m_folder = m_temp.path() / "out";  // not made yet
};

TEST_F(OutputFolderTest, CommitReplacesFilesAndLeavesNothingElse)
{
    fs::create_directories(m_folder);
    write(m_folder / "a", "old");
    write(m_folder / "mine", "kept");
    OutputFolder output(m_folder);
    write(output.stage("a"), "new");
    write(output.stage("b"), "new too");
    EXPECT_EQ(read("a"), "old");
    output.commit();
    EXPECT_EQ(read("a"), "new");
    EXPECT_EQ(read("b"), "new too");
    EXPECT_EQ(read("mine"), "kept");
}

TEST_F(OutputFolderTest, WhatAKilledProcessLeftBehindGoes)
{
    const fs::path left = m_folder / ".unfinished-1";
    fs::create_directories(left);
    write(left / "a", "half");
    OutputFolder first(m_folder);
    EXPECT_FALSE(fs::exists(left));
    const fs::path inUse = first.stage("b").parent_path();
    write(inUse / "b", "half");
    // Another process looks at what this one has under way.
    const pid_t child = ::fork();
    if (child == 0)
    {
        {
            const OutputFolder second(m_folder);
        }
        ::_exit(fs::exists(inUse / "b") ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
    EXPECT_TRUE(fs::exists(inUse / "b"));
}

TEST_F(OutputFolderTest, WithoutCommitNothingChanges)
{
    fs::create_directories(m_folder);
    write(m_folder / "a", "old");
    {
        OutputFolder output(m_folder);
        write(output.stage("a"), "new");
    }
    EXPECT_EQ(read("a"), "old");
    EXPECT_EQ(entries(), 1);
}

TEST_F(OutputFolderTest, AFolderThatItMadeGoesAgainWithoutCommit)
{
    {
        const OutputFolder output(m_folder);
        EXPECT_TRUE(fs::exists(m_folder));
    }
    EXPECT_FALSE(fs::exists(m_folder));
}

TEST_F(OutputFolderTest, AMissingFileFailsTheWholeCommit)
{
    fs::create_directories(m_folder);
    write(m_folder / "a", "old");
    OutputFolder output(m_folder);
    write(output.stage("a"), "new");
    static_cast<void>(output.stage("never written"));
    EXPECT_THROW(output.commit(), std::runtime_error);
    EXPECT_EQ(read("a"), "old");
}

TEST_F(OutputFolderTest, AFileInThePlaceOfTheFolderIsAnError)
{
    write(m_folder, "a file");
    EXPECT_THROW(OutputFolder{m_folder}, std::runtime_error);
    EXPECT_THROW(OutputFolder{m_folder / "below"}, std::runtime_error);
}

/// What a scene calls an object does not lead out of the output folder.
TEST(FolderNameOf, StaysInside)
{
    EXPECT_EQ(folderNameOf("my red mug"), "my red mug");
    EXPECT_EQ(folderNameOf("../../escape"), "_._.._escape");
    EXPECT_EQ(folderNameOf("/tmp"), "_tmp");
    EXPECT_EQ(folderNameOf(".."), "_.");
}

TEST(FolderNameOf, IsNotSharedInSilence)
{
    EXPECT_NO_THROW(requireOwnFolders({"mug", "can", "a_b"}));
    EXPECT_THROW(requireOwnFolders({"mug", "a/b", "a_b"}), std::runtime_error);
    EXPECT_THROW(requireOwnFolders({"mug", "mug"}), std::runtime_error);
}
}  // namespace
}  // namespace bullet_ccd::tools
