#include "grasp/hand/hand_model.h"
#include "grasp/hand/srdf_writer.h"
#include "tests/grasp/hand/urdf_text.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>
#include <random>
#include <stdexcept>

namespace bullet_ccd::grasp
{
namespace
{
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;
using tests::boxLink;
using tests::hinge;
using tests::TempFolder;

/// Two fingers of two phalanges each on a palm on a wrist, all boxes. The fingers stand on +z at
/// x = -0.05 and 0.05 and turn about y: the left one closes to positive, the right one to negative
/// angles. The last joint of the right finger follows the one below it.
std::string pincer()
{
    const std::string phalanx = "0.02 0.02 0.05";
    const std::string up = "0 0 0.03";
    return "<?xml version=\"1.0\"?><robot name=\"pincer\">" +
           boxLink("arm", "0.05 0.05 0.05", "0 0 -0.1") +
           boxLink("palm", "0.14 0.06 0.02", "0 0 0") + boxLink("left_1", phalanx, up) +
           boxLink("left_2", phalanx, up) + boxLink("right_1", phalanx, up) +
           boxLink("right_2", phalanx, up) +
           hinge("wrist", "arm", "palm", "0 0 0", "0 0 1", "lower=\"-1\" upper=\"1\"") +
           hinge("l1", "palm", "left_1", "-0.05 0 0.01", "0 1 0", "lower=\"-0.2\" upper=\"1\"") +
           hinge("l2", "left_1", "left_2", "0 0 0.06", "0 1 0", "lower=\"0\" upper=\"1.2\"") +
           hinge("r1", "palm", "right_1", "0.05 0 0.01", "0 1 0", "lower=\"-1\" upper=\"0.2\"") +
           "<joint name=\"r2\" type=\"revolute\"><parent link=\"right_1\"/><child "
           "link=\"right_2\"/>"
           "<origin xyz=\"0 0 0.06\"/><axis xyz=\"0 -1 0\"/><limit lower=\"0\" upper=\"1.2\" "
           "effort=\"1\" velocity=\"1\"/><mimic joint=\"r1\" multiplier=\"-1.1\"/></joint></robot>";
}

const std::string kFingers =
    "<group name=\"left\"><chain base_link=\"palm\" tip_link=\"left_2\"/></group>"
    "<group name=\"right\"><chain base_link=\"palm\" tip_link=\"right_2\"/></group>";

std::string srdf(const std::string& body)
{
    return "<?xml version=\"1.0\"?>\n<robot name=\"pincer\">\n" + body + "\n</robot>\n";
}

HandModel load(const TempFolder& folder, const std::string& srdfBody)
{
    const auto urdf = folder.write("pincer.urdf", pincer());
    folder.write("pincer.srdf", srdf(srdfBody));
    return loadHand(urdf);
}

std::size_t linkBelow(const HandModel& hand, const std::string& joint)
{
    return static_cast<std::size_t>(hand.robot.tree.findJoint(joint));
}

std::vector<std::string> namesOf(const HandModel& hand, const std::vector<std::int32_t>& links)
{
    std::vector<std::string> names;
    for (const std::int32_t link : links)
    {
        names.push_back(hand.robot.tree.links[static_cast<std::size_t>(link)].name);
    }
    return names;
}

TEST(HandFile, WithoutSrdfThePincerIsUnderstood)
{
    const TempFolder folder;
    const HandModel hand = loadHand(folder.write("pincer.urdf", pincer()));
    EXPECT_EQ(hand.robot.tree.links[static_cast<std::size_t>(hand.palm)].name, "palm");
    ASSERT_EQ(hand.fingers.size(), 2U);
    EXPECT_THAT(namesOf(hand, hand.fingers[0].links), ElementsAre("left_1", "left_2"));
    EXPECT_THAT(namesOf(hand, hand.fingers[1].links), ElementsAre("right_1", "right_2"));
    EXPECT_EQ(hand.closingDirections[linkBelow(hand, "wrist")], 0);
    EXPECT_EQ(hand.closingDirections[linkBelow(hand, "l1")], 1);
    EXPECT_EQ(hand.closingDirections[linkBelow(hand, "l2")], 1);
    EXPECT_EQ(hand.closingDirections[linkBelow(hand, "r1")], -1);
    EXPECT_EQ(hand.closingDirections[linkBelow(hand, "r2")], 1);
    ASSERT_EQ(hand.preshapes.size(), 1U);
    EXPECT_DOUBLE_EQ(hand.preshapes[0].positions[linkBelow(hand, "l1")], -0.2);
    EXPECT_DOUBLE_EQ(hand.preshapes[0].positions[linkBelow(hand, "r1")], 0.2);
    EXPECT_DOUBLE_EQ(hand.preshapes[0].positions[linkBelow(hand, "r2")], -0.22);
    // Approach away from the palm, opposition along x (half closed, the two fingers differ in
    // height), between the fingers.
    EXPECT_GT(hand.X_RG.linear().col(2).z(), 0.8);
    EXPECT_GT(std::abs(hand.X_RG.linear().col(0).x()), 0.8);
    EXPECT_LT(std::abs(hand.X_RG.translation().x()), 0.01);
    EXPECT_NEAR(hand.X_RG.linear().determinant(), 1.0, 1e-12);
    for (const char* what : {"fingers inferred",
                             "closing directions inferred",
                             "preshape inferred",
                             "grasp frame inferred",
                             "no SRDF"})
    {
        EXPECT_THAT(hand.notes, Contains(HasSubstr(what)));
    }
}

TEST(HandFile, SrdfIsTakenAtItsWord)
{
    const TempFolder folder;
    const HandModel hand =
        load(folder,
             kFingers +
                 "<group name=\"arm\"><joint name=\"wrist\"/></group>"
                 "<group_state name=\"half\" group=\"left\"><joint name=\"l1\" value=\"0.3\"/>"
                 "</group_state>"
                 "<group_state name=\"open\" group=\"left\"><joint name=\"l1\" value=\"-0.1\"/>"
                 "</group_state>"
                 "<group_state name=\"open\" group=\"right\"><joint name=\"r1\" value=\"0.1\"/>"
                 "</group_state>"
                 "<passive_joint name=\"l2\"/>"
                 "<closing joint=\"l1\" direction=\"-1\"/>"
                 "<closing joint=\"r1\" direction=\"-1\" speed=\"0.25\"/>"
                 "<disable_collisions link1=\"right_2\" link2=\"left_2\" reason=\"User\"/>"
                 "<grasp_frame link=\"palm\" xyz=\"0 0 0.1\" rpy=\"0 0 1.5707963267948966\"/>");
    EXPECT_EQ(hand.fingers[0].name, "left");
    EXPECT_EQ(hand.closingDirections[linkBelow(hand, "l1")], -1);
    EXPECT_EQ(hand.closingDirections[linkBelow(hand, "l2")], 0);
    ASSERT_EQ(hand.closingSpeeds.size(), hand.robot.tree.size());
    EXPECT_EQ(hand.closingSpeeds[linkBelow(hand, "l1")], 1.0);
    EXPECT_EQ(hand.closingSpeeds[linkBelow(hand, "r1")], 0.25);
    // What is written for it is read back.
    const HandModel again = loadHand(hand.robot.file, folder.write("again.srdf", handSrdf(hand)));
    EXPECT_EQ(again.closingSpeeds, hand.closingSpeeds);
    ASSERT_EQ(hand.preshapes.size(), 2U);
    EXPECT_EQ(hand.preshapes[0].name, "open");
    EXPECT_EQ(hand.preshapes[1].name, "half");
    EXPECT_EQ(hand.preshapes[0].positions[linkBelow(hand, "l1")], -0.1);
    EXPECT_EQ(hand.preshapes[0].positions[linkBelow(hand, "r1")], 0.1);
    EXPECT_DOUBLE_EQ(hand.preshapes[0].positions[linkBelow(hand, "r2")], -0.11);
    EXPECT_TRUE(hand.X_RG.translation().isApprox(Eigen::Vector3d(0, 0, 0.1), 1e-12));
    EXPECT_TRUE(hand.X_RG.linear().col(0).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
    const std::pair<std::int32_t, std::int32_t> tips(hand.robot.tree.findLink("left_2"),
                                                     hand.robot.tree.findLink("right_2"));
    EXPECT_THAT(hand.selfPairs, testing::Not(Contains(tips)));
    EXPECT_TRUE(hand.notes.empty()) << hand.notes.front();
}

TEST(HandFile, APreshapeMayHaveItsOwnGraspFrame)
{
    const TempFolder folder;
    const HandModel hand =
        load(folder,
             kFingers +
                 "<group_state name=\"half\" group=\"left\"><joint name=\"l1\" value=\"0.3\"/>"
                 "</group_state><group_state name=\"open\" group=\"left\"/>"
                 "<grasp_frame preshape=\"half\" link=\"left_1\" xyz=\"0 0 0.1\" rpy=\"0 0 0\"/>"
                 "<grasp_frame link=\"palm\" xyz=\"0 0 0.2\" rpy=\"0 0 0\"/>");
    ASSERT_EQ(hand.preshapes[1].name, "half");
    EXPECT_TRUE(hand.X_RG.translation().isApprox(Eigen::Vector3d(0.0, 0.0, 0.2), 1e-12));
    EXPECT_TRUE(graspFrame(hand, hand.preshapes[0]).isApprox(hand.X_RG, 1e-12));
    // On a link that l1 has turned by 0.3 about y.
    EXPECT_TRUE(
        graspFrame(hand, hand.preshapes[1])
            .translation()
            .isApprox(Eigen::Vector3d(-0.05 + 0.1 * std::sin(0.3), 0.0, 0.01 + 0.1 * std::cos(0.3)),
                      1e-12));
}

TEST(HandFile, SelfPairsLeaveOutNeighboursAndWhatCannotMove)
{
    const TempFolder folder;
    const HandModel hand = load(folder, kFingers);
    std::vector<std::string> pairs;
    for (const auto& [a, b] : hand.selfPairs)
    {
        EXPECT_LT(a, b);
        const std::vector<std::string> names = namesOf(hand, {a, b});
        pairs.push_back(names[0] + "-" + names[1]);
    }
    // Neighbours of the palm (and of the arm, which the frozen wrist ties to it) are the first
    // phalanges.
    EXPECT_THAT(pairs,
                testing::UnorderedElementsAre("arm-left_2",
                                              "palm-left_2",
                                              "arm-right_2",
                                              "palm-right_2",
                                              "left_1-right_1",
                                              "left_1-right_2",
                                              "left_2-right_1",
                                              "left_2-right_2"));
}

TEST(HandFile, LinksThatOverlapInEveryPreshapeAreNotTested)
{
    const TempFolder folder;
    std::string text = pincer();
    // A second phalanx so long that it reaches into the palm.
    const std::string from = boxLink("left_2", "0.02 0.02 0.05", "0 0 0.03");
    text.replace(text.find(from), from.size(), boxLink("left_2", "0.02 0.02 0.30", "0 0 0"));
    const auto urdf = folder.write("pincer.urdf", text);
    folder.write("pincer.srdf",
                 srdf(kFingers + "<closing joint=\"l1\" direction=\"1\"/>"
                                 "<closing joint=\"l2\" direction=\"1\"/>"));
    const HandModel hand = loadHand(urdf);
    const std::pair<std::int32_t, std::int32_t> pair(hand.robot.tree.findLink("palm"),
                                                     hand.robot.tree.findLink("left_2"));
    EXPECT_THAT(hand.selfPairs, testing::Not(Contains(pair)));
    EXPECT_THAT(hand.notes,
                Contains(AllOf(HasSubstr("overlap in every preshape"), HasSubstr("palm/left_2"))));
}

TEST(HandFile, StatesWithClosedFingersAreNoPreshapes)
{
    const TempFolder folder;
    const HandModel hand =
        load(folder,
             kFingers +
                 "<group_state name=\"close\" group=\"left\"><joint name=\"l1\" value=\"1\"/>"
                 "<joint name=\"l2\" value=\"1.2\"/><joint name=\"r1\" value=\"-1\"/>"
                 "</group_state>"
                 "<group_state name=\"wide\" group=\"left\"/>");
    ASSERT_EQ(hand.preshapes.size(), 1U);
    EXPECT_EQ(hand.preshapes[0].name, "wide");
    EXPECT_THAT(hand.notes, Contains(HasSubstr("'close' is no preshape")));
}

TEST(HandFile, GroupsThatCarryOthersAreNoFingers)
{
    const TempFolder folder;
    const HandModel hand =
        load(folder,
             kFingers + "<group name=\"arm\"><chain base_link=\"arm\" tip_link=\"palm\"/></group>");
    EXPECT_EQ(hand.fingers.size(), 2U);
    EXPECT_THAT(hand.notes, Contains(HasSubstr("group 'arm' is no finger")));
}

TEST(HandFile, ClosedPositionsAreTheLimitsAndMimicsFollow)
{
    const TempFolder folder;
    const HandModel hand = load(folder, kFingers);
    const std::vector<double> closed = closedPositions(hand, hand.preshapes[0].positions);
    EXPECT_EQ(closed[linkBelow(hand, "wrist")], 0.0);
    EXPECT_EQ(closed[linkBelow(hand, "l1")], 1.0);
    EXPECT_EQ(closed[linkBelow(hand, "l2")], 1.2);
    EXPECT_EQ(closed[linkBelow(hand, "r1")], -1.0);
    EXPECT_DOUBLE_EQ(closed[linkBelow(hand, "r2")], 1.1);
}

TEST(HandFile, AContinuousJointClosesByAFullTurn)
{
    const TempFolder folder;
    std::string text = pincer();
    const std::string from = "<joint name=\"l2\" type=\"revolute\">";
    text.replace(text.find(from), from.size(), "<joint name=\"l2\" type=\"continuous\">");
    const auto urdf = folder.write("pincer.urdf", text);
    folder.write("pincer.srdf", srdf("<closing joint=\"l2\" direction=\"1\"/>"));
    const HandModel hand = loadHand(urdf);
    std::vector<double> from0(hand.robot.tree.size(), 0.5);
    EXPECT_DOUBLE_EQ(closedPositions(hand, from0)[linkBelow(hand, "l2")],
                     0.5 + 2.0 * std::numbers::pi);
}

TEST(HandFile, ShareFolderIsSearchedByStemAndByRobotName)
{
    const TempFolder share;
    const TempFolder folder;
    share.write("robots/srdf/pincer.srdf", srdf(kFingers));
    for (const char* name : {"pincer.urdf", "pincer_mesh.urdf", "other.urdf"})
    {
        const HandModel hand = loadHand(folder.write(name, pincer()), std::nullopt, share.path());
        EXPECT_EQ(hand.fingers[0].name, "left") << name;
        EXPECT_EQ(hand.srdfFile, share.path() / "robots" / "srdf" / "pincer.srdf") << name;
    }
}

TEST(HandFile, KnowsWhichSrdfItWasUnderstoodBy)
{
    const TempFolder folder;
    const auto urdf = folder.write("pincer.urdf", pincer());
    EXPECT_TRUE(loadHand(urdf).srdfFile.empty());
    const auto named = folder.write("named.srdf", srdf(kFingers));
    EXPECT_EQ(loadHand(urdf, named).srdfFile, named);
    const auto beside = folder.write("pincer.srdf", srdf(kFingers));
    EXPECT_EQ(loadHand(urdf).srdfFile, beside);
    EXPECT_EQ(loadHand(urdf, named).srdfFile, named);
}

TEST(HandFile, SharedSrdfThatDoesNotFitIsPutAside)
{
    const TempFolder share;
    const TempFolder folder;
    share.write("robots/srdf/pincer.srdf", srdf("<passive_joint name=\"somebody\"/>"));
    const HandModel hand =
        loadHand(folder.write("pincer.urdf", pincer()), std::nullopt, share.path());
    EXPECT_EQ(hand.fingers.size(), 2U);
    EXPECT_THAT(hand.notes, Contains(AllOf(HasSubstr("put aside"), HasSubstr("somebody"))));
    EXPECT_TRUE(hand.srdfFile.empty());
}

TEST(HandFile, MovingTheModelKeepsItsHierarchies)
{
    const TempFolder folder;
    HandModel first = load(folder, kFingers);
    const SsvTree* const tree = first.linkTrees[0];
    const HandModel second = std::move(first);
    EXPECT_EQ(second.linkTrees[0], tree);
    EXPECT_EQ(second.linkTrees[0], &second.trees[0]);
}

/// SRDF body and what the message must say.
struct BrokenSrdf
{
    std::string body;
    std::vector<std::string> message;
};

void PrintTo(const BrokenSrdf& broken, std::ostream* stream)
{
    *stream << broken.body;
}

class BrokenSrdfFile : public testing::TestWithParam<BrokenSrdf>
{
};

TEST_P(BrokenSrdfFile, NamesTheElementAndTheNearestName)
{
    const TempFolder folder;
    try
    {
        static_cast<void>(load(folder, GetParam().body));
        FAIL() << "loaded";
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_THAT(error.what(), StartsWith((folder.path() / "pincer.srdf").string() + ": "));
        for (const std::string& part : GetParam().message)
        {
            EXPECT_THAT(error.what(), HasSubstr(part));
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    All,
    BrokenSrdfFile,
    testing::Values(
        BrokenSrdf{"<group>", {"not XML"}},
        BrokenSrdf{"<group/>", {"line 3", "<group>", "'name'"}},
        BrokenSrdf{"<group name=\"g\"><chain base_link=\"palm\"/></group>", {"'tip_link'"}},
        BrokenSrdf{"<group name=\"g\"><chain base_link=\"palm\" tip_link=\"leftt_2\"/></group>",
                   {"group 'g'", "link 'leftt_2' does not exist", "did you mean 'left_2'"}},
        BrokenSrdf{"<group name=\"g\"><chain base_link=\"left_2\" tip_link=\"palm\"/></group>",
                   {"group 'g'", "does not hang from"}},
        BrokenSrdf{"<passive_joint name=\"wrst\"/>", {"passive_joint", "did you mean 'wrist'"}},
        BrokenSrdf{"<closing joint=\"l3\" direction=\"1\"/>", {"closing", "'l3'"}},
        BrokenSrdf{"<closing joint=\"l1\" direction=\"1\" speed=\"0\"/>",
                   {"<closing>", "'0'", "ratio > 0"}},
        BrokenSrdf{"<closing joint=\"l1\" direction=\"up\"/>", {"<closing>", "'up'", "+1 or -1"}},
        BrokenSrdf{"<closing joint=\"r2\" direction=\"1\"/>", {"'r2'", "mimics"}},
        BrokenSrdf{"<passive_joint name=\"l1\"/><closing joint=\"l1\" direction=\"1\"/>",
                   {"'l1' is passive"}},
        BrokenSrdf{"<disable_collisions link1=\"palm\" link2=\"plam\" reason=\"User\"/>",
                   {"disable_collisions", "did you mean 'palm'"}},
        BrokenSrdf{kFingers + "<group_state name=\"open\" group=\"lift\"/>",
                   {"group_state 'open'", "group 'lift' does not exist", "did you mean 'left'"}},
        BrokenSrdf{kFingers + "<group_state name=\"open\" group=\"left\"><joint name=\"l1\" "
                              "value=\"7\"/></group_state>",
                   {"group_state 'open'", "'l1'", "7.0", "outside its limits"}},
        BrokenSrdf{kFingers + "<group_state name=\"open\" group=\"left\"><joint name=\"l1\" "
                              "value=\"nan\"/></group_state>",
                   {"<joint>", "value is 'nan'"}},
        BrokenSrdf{"<grasp_frame link=\"hand\" xyz=\"0 0 0\" rpy=\"0 0 0\"/>", {"'hand'"}},
        BrokenSrdf{"<grasp_frame link=\"palm\" xyz=\"0 0\" rpy=\"0 0 0\"/>",
                   {"<grasp_frame>", "xyz is '0 0'", "three finite numbers"}},
        BrokenSrdf{"<grasp_frame preshape=\"opne\" link=\"palm\" xyz=\"0 0 0\" rpy=\"0 0 0\"/>",
                   {"grasp_frame", "preshape 'opne' does not exist", "did you mean 'open'"}},
        BrokenSrdf{"<grasp_frame link=\"palm\" xyz=\"0 0 0\" rpy=\"0 0 0\"/>"
                   "<grasp_frame link=\"palm\" xyz=\"0 0 1\" rpy=\"0 0 0\"/>",
                   {"<grasp_frame>", "a second one"}},
        BrokenSrdf{"<passive_joint name=\"l1\"/><passive_joint name=\"l2\"/>"
                   "<passive_joint name=\"r1\"/>",
                   {"no joint closes the hand", "<closing"}}));

TEST(HandFile, SrdfThatIsNamedButMissingIsAnError)
{
    const TempFolder folder;
    const auto urdf = folder.write("pincer.urdf", pincer());
    EXPECT_THROW(static_cast<void>(loadHand(urdf, folder.path() / "no.srdf")), std::runtime_error);
}

TEST(HandFile, RobotWithoutFingersSaysWhatIsMissing)
{
    const TempFolder folder;
    try
    {
        static_cast<void>(loadHand(
            folder.write("stone.urdf", "<robot name=\"stone\"><link name=\"a\"/></robot>")));
        FAIL();
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_THAT(error.what(), AllOf(HasSubstr("stone.urdf"), HasSubstr("no finger")));
    }
}

TEST(HandFile, MutatedSrdfFilesAreUsableOrRefusedWithAMessage)
{
    const TempFolder folder;
    const auto urdf = folder.write("pincer.urdf", pincer());
    const std::string whole =
        srdf(kFingers +
             "<group_state name=\"open\" group=\"left\"><joint name=\"l1\" "
             "value=\"-0.1\"/></group_state>"
             "<passive_joint name=\"wrist\"/><closing joint=\"l1\" direction=\"+1\"/>"
             "<disable_collisions link1=\"palm\" link2=\"left_2\" reason=\"User\"/>"
             "<grasp_frame link=\"palm\" xyz=\"0 0 0.1\" rpy=\"0 0 1\"/>");
    std::mt19937_64 random(5);
    int good = 0;
    int refused = 0;
    for (int round = 0; round < 400; ++round)
    {
        std::string text = whole;
        if (round % 4 == 0)
        {
            text.resize(random() % text.size());
        }
        for (std::size_t k = 0; k < 1 + random() % 3 && round % 4 != 0; ++k)
        {
            text[random() % text.size()] = static_cast<char>(random());
        }
        try
        {
            const HandModel hand = loadHand(urdf, folder.write("mutated.srdf", text));
            EXPECT_FALSE(hand.fingers.empty());
            EXPECT_FALSE(hand.preshapes.empty());
            EXPECT_TRUE(hand.X_RG.matrix().allFinite());
            ++good;
        }
        catch (const std::runtime_error& error)
        {
            EXPECT_THAT(error.what(),
                        testing::AnyOf(HasSubstr("mutated.srdf"), HasSubstr("pincer.urdf")));
            ++refused;
        }
    }
    EXPECT_GT(good, 25);
    EXPECT_GT(refused, 100);
}
}  // namespace
}  // namespace bullet_ccd::grasp
