#include "grasp/hand/searched_hand.h"

#include "tests/grasp/hand/urdf_text.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>

namespace bullet_ccd::grasp
{
namespace
{
using tests::TempFolder;

constexpr std::size_t kLinks = 4;

SearchedHand someHand()
{
    SearchedHand hand;
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).matrix();
    X.translation() = Eigen::Vector3d(0.1, 1.0 / 3.0, -1e-17);
    hand.preshapes = {{.name = "wrap", .positions = {0.0, 0.1, -0.0, 1.0 / 7.0}, .X_RG = X},
                      {.name = "precision",
                       .positions = {std::numeric_limits<double>::denorm_min(),
                                     -std::numeric_limits<double>::max(),
                                     std::nextafter(1.0, 2.0),
                                     1e22}}};
    hand.frames = {X.inverse()};
    hand.speeds = {1.0, 0.1, 0.1 * 0.1, 1.0};
    return hand;
}

/// Bit for bit, so that -0 is not 0.
template <typename Numbers>
void expectSameBits(const Numbers& a, const Numbers& b, std::size_t count)
{
    for (std::size_t k = 0; k < count; ++k)
    {
        EXPECT_TRUE(a[k] == b[k] && std::signbit(a[k]) == std::signbit(b[k])) << k;
    }
}

void expectSame(const SearchedHand& a, const SearchedHand& b)
{
    ASSERT_EQ(a.preshapes.size(), b.preshapes.size());
    for (std::size_t k = 0; k < a.preshapes.size(); ++k)
    {
        EXPECT_EQ(a.preshapes[k].name, b.preshapes[k].name);
        ASSERT_EQ(a.preshapes[k].positions.size(), kLinks);
        expectSameBits(a.preshapes[k].positions, b.preshapes[k].positions, kLinks);
        ASSERT_EQ(a.preshapes[k].X_RG.has_value(), b.preshapes[k].X_RG.has_value());
        if (a.preshapes[k].X_RG)
        {
            expectSameBits(
                a.preshapes[k].X_RG->matrix().data(), b.preshapes[k].X_RG->matrix().data(), 16);
        }
    }
    ASSERT_EQ(a.frames.size(), b.frames.size());
    for (std::size_t k = 0; k < a.frames.size(); ++k)
    {
        expectSameBits(a.frames[k].matrix().data(), b.frames[k].matrix().data(), 16);
    }
    ASSERT_EQ(a.speeds.size(), b.speeds.size());
    expectSameBits(a.speeds, b.speeds, a.speeds.size());
}

TEST(SearchedHand, IsReadAsItWasWritten)
{
    const TempFolder folder;
    const auto file = folder.path() / "new" / "a.hand";
    for (const SearchedHand& hand :
         {someHand(), SearchedHand{}, SearchedHand{.speeds = {1, 1, 1, 2}}})
    {
        saveSearchedHand(hand, file);
        const std::optional<SearchedHand> read = loadSearchedHand(file, kLinks);
        ASSERT_TRUE(read);
        expectSame(*read, hand);
    }
    // Nothing else is left behind.
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(file.parent_path()), {}), 1);
}

TEST(SearchedHand, DamagedFilesAndThoseOfOtherRobotsAreNone)
{
    const TempFolder folder;
    const auto file = folder.path() / "a.hand";
    EXPECT_FALSE(loadSearchedHand(file, kLinks));
    saveSearchedHand(someHand(), file);
    EXPECT_FALSE(loadSearchedHand(file, kLinks + 1));
    EXPECT_FALSE(loadSearchedHand(file, kLinks - 1));
    std::ifstream stream(file, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    ASSERT_GT(whole.size(), 200U);
    // All of the first line, and a sample of the rest.
    for (std::size_t k = 0; k < whole.size(); k += k < 60 ? 1 : 7)
    {
        EXPECT_FALSE(loadSearchedHand(folder.write("b.hand", whole.substr(0, k)), kLinks)) << k;
        std::string changed = whole;
        changed[k] = static_cast<char>(changed[k] ^ 1);
        EXPECT_FALSE(loadSearchedHand(folder.write("b.hand", changed), kLinks)) << k << changed;
    }
    EXPECT_FALSE(loadSearchedHand(folder.write("b.hand", whole + " "), kLinks));
    EXPECT_FALSE(loadSearchedHand(folder.path(), kLinks));
}

TEST(SearchedHand, TheNameOfItsFileFollowsFromTheContent)
{
    const TempFolder folder;
    const auto pincer = [](const std::string& size, const std::string& limits)
    {
        return "<?xml version=\"1.0\"?><robot name=\"pincer\">" +
               tests::boxLink("palm", "0.14 0.06 0.02", "0 0 0") +
               tests::boxLink("left", size, "0 0 0.05") +
               tests::hinge("left_joint", "palm", "left", "-0.05 0 0.02", "0 1 0", limits) +
               "</robot>";
    };
    const std::string limits = "lower=\"0\" upper=\"1\"";
    const auto usual = folder.write("a.urdf", pincer("0.01 0.02 0.1", limits));
    const auto srdf = folder.write("a.srdf", "<robot/>");
    const auto nameOf = [](const std::filesystem::path& urdf, const std::filesystem::path& other)
    { return searchedHandFileName(loadRobot(urdf), other); };
    const std::string name = nameOf(usual, srdf);
    EXPECT_EQ(name,
              nameOf(folder.write("elsewhere/b.urdf", pincer("0.01 0.02 0.1", limits)), srdf));
    const std::set<std::string> names{
        name,
        nameOf(usual, folder.write("other.srdf", "<robot><passive_joint name=\"a\"/></robot>")),
        nameOf(folder.write("mesh.urdf", pincer("0.01 0.02 0.11", limits)), srdf),
        nameOf(
            folder.write("limit.urdf", pincer("0.01 0.02 0.1", "lower=\"0\" upper=\"1.000001\"")),
            srdf)};
    EXPECT_EQ(names.size(), 4U);
}
}  // namespace
}  // namespace bullet_ccd::grasp
