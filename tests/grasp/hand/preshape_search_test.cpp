#include "grasp/hand/preshape_search.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/approach/approach_sampler.h"
#include "grasp/closing/closing.h"
#include "grasp/formats/content_hash.h"
#include "grasp/hand/hand_model.h"
#include "grasp/hand/searched_hand.h"
#include "grasp/hand/self_pairs.h"
#include "grasp/hand/srdf_writer.h"
#include "grasp/hand/trial_grasps.h"
#include "grasp/planner/grasp_planner.h"
#include "tests/grasp/hand/urdf_text.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <gmock/gmock.h>
#include <numbers>
#include <random>

namespace bullet_ccd::grasp
{
namespace
{
using testing::Contains;
using testing::HasSubstr;
using tests::boxLink;
using tests::hinge;
using tests::TempFolder;

TEST(TrialBody, DistanceIsThatOfBallBarAndBox)
{
    const TrialBody ball{.half = Eigen::Vector3d::Zero(), .round = 0.03};
    const TrialBody bar{.half = {0.0, 0.06, 0.0}, .round = 0.02};
    const TrialBody box{.half = {0.02, 0.03, 0.04}, .round = 0.0};
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> coordinate(-0.1, 0.1);
    int inside = 0;
    for (int k = 0; k < 300; ++k)
    {
        const Eigen::Vector3d p(coordinate(random), coordinate(random), coordinate(random));
        EXPECT_NEAR(ball.distance(p), p.norm() - 0.03, 1e-12);
        const Eigen::Vector3d onAxis(0.0, std::clamp(p.y(), -0.06, 0.06), 0.0);
        EXPECT_NEAR(bar.distance(p), (p - onAxis).norm() - 0.02, 1e-12);
        const Eigen::Vector3d nearest = p.cwiseMax(-box.half).cwiseMin(box.half);
        const bool isInside = nearest == p;
        inside += isInside ? 1 : 0;
        EXPECT_NEAR(box.distance(p),
                    isInside ? (p.cwiseAbs() - box.half).maxCoeff() : (p - nearest).norm(),
                    1e-12);
        // The normal is the gradient of the distance.
        for (const TrialBody& body : {ball, bar, box})
        {
            EXPECT_NEAR(body.distance(p + 1e-7 * body.normal(p)) - body.distance(p), 1e-7, 1e-10);
        }
    }
    EXPECT_GT(inside, 3);
}

/// Two jaws that slide towards each other; a bumper on one of them may meet the other one after 1
/// cm, where they are still 2 cm from a cube of 4 cm that stands between them.
std::string jaws(bool hasBumper)
{
    const std::string jaw = boxLink("right", "0.01 0.1 0.06", "0 0 0");
    std::string left = boxLink("left", "0.01 0.1 0.06", "0 0 0");
    if (hasBumper)
    {
        left.insert(left.find("</link>"),
                    "<collision><origin xyz=\"0.045 0.035 0\"/><geometry><box size=\"0.08 0.01 "
                    "0.02\"/></geometry></collision>");
    }
    std::string text =
        "<?xml version=\"1.0\"?><robot name=\"jaws\">" +
        boxLink("palm", "0.1 0.1 0.02", "0 0 -0.05") + left + jaw +
        hinge("to_right", "palm", "left", "-0.055 0 0", "1 0 0", "lower=\"0\" upper=\"0.05\"") +
        hinge("to_left", "palm", "right", "0.055 0 0", "-1 0 0", "lower=\"0\" upper=\"0.05\"") +
        "</robot>";
    for (std::size_t at = text.find("revolute"); at != std::string::npos;
         at = text.find("revolute"))
    {
        text.replace(at, 8, "prismatic");
    }
    return text;
}

TEST(TrialGrasps, LinksStopWhereTheyTouchEachOther)
{
    const TempFolder folder;
    const auto score = [&](bool hasBumper)
    {
        const HandModel hand = loadHand(folder.write("jaws.urdf", jaws(hasBumper)));
        EXPECT_EQ(std::ranges::count(hand.closingDirections, 1), 2);
        return TrialGrasps(hand)(hand.preshapes[0].positions,
                                 Eigen::Isometry3d::Identity(),
                                 {.half = Eigen::Vector3d::Constant(0.018), .round = 0.002},
                                 Eigen::Isometry3d::Identity());
    };
    EXPECT_GT(score(false), 0.5);  // a force closure
    EXPECT_EQ(score(true), 0.0);   // no contact
}

TEST(PreshapeSearch, JawsOnOneMotorGetOpenings)
{
    const TempFolder folder;
    EXPECT_EQ(loadHand(folder.write("jaws.urdf", jaws(false))).preshapes.size(), 1U);
    std::string text = jaws(false);
    text.insert(text.rfind("</joint>"), "<mimic joint=\"to_right\"/>");
    const HandModel hand = loadHand(folder.write("coupled.urdf", text));
    ASSERT_EQ(hand.preshapes.size(), 3U);
    const double shares[] = {1.0, 0.5, 0.25};
    const char* names[] = {"open", "half", "near"};
    for (std::size_t k = 0; k < 3; ++k)
    {
        EXPECT_EQ(hand.preshapes[k].name, names[k]);
        EXPECT_NEAR(openHand(hand, hand.preshapes[k]).opening, 0.1 * shares[k], 1e-9);
        EXPECT_NEAR(graspFrame(hand, hand.preshapes[k]).translation().x(), 0.0, 1e-9);
    }
}

/// A palm in the plane x-z that looks along +x; two fingers on its upper end that bend towards +x,
/// and a thumb beside its lower end whose base turns about z. At 0 the thumb bends towards +x, too,
/// as the fingers do, beside them. Turned by a right angle it stands in front of the palm.
std::string thumbedHand()
{
    std::string text = "<?xml version=\"1.0\"?><robot name=\"thumbed\">" +
                       boxLink("palm", "0.02 0.08 0.09", "0 0 0.045");
    for (const std::string& name : {std::string("fore"), std::string("ring")})
    {
        const std::string y = name == "fore" ? "0.022" : "-0.022";
        text += boxLink(name + "_1", "0.016 0.018 0.045", "0 0 0.024") +
                boxLink(name + "_2", "0.016 0.018 0.035", "0 0 0.019") +
                hinge(name + "1",
                      "palm",
                      name + "_1",
                      "0 " + y + " 0.095",
                      "0 1 0",
                      "lower=\"0\" upper=\"1.5\"") +
                hinge(name + "2",
                      name + "_1",
                      name + "_2",
                      "0 0 0.05",
                      "0 1 0",
                      "lower=\"0\" upper=\"1.5\"");
    }
    text +=
        boxLink("base", "0.016 0.016 0.016", "0 0.05 0") +
        boxLink("thumb_1", "0.016 0.018 0.045", "0 0 0.024") +
        boxLink("thumb_2", "0.016 0.018 0.035", "0 0 0.019") +
        hinge("turn", "palm", "base", "0.02 0 0.02", "0 0 -1", "lower=\"0\" upper=\"1.8\"") +
        hinge("thumb1", "base", "thumb_1", "0 0.05 0.01", "0 1 0", "lower=\"0\" upper=\"1.3\"") +
        hinge("thumb2", "thumb_1", "thumb_2", "0 0 0.05", "0 1 0", "lower=\"0\" upper=\"1.5\"");
    return text + "</robot>";
}

/// What the planner holds says more than the trials by which preshapes were searched.
int closuresOnABall(const HandModel& hand, std::int64_t candidates)
{
    const GraspObject ball = makeGraspObject("ball", makeSphere(0.037, 3));
    const std::vector<Grasp> grasps = planGrasps(
        hand,
        ball,
        {.candidates = candidates, .approach = {.source = ApproachSource::Sphere}, .volumes = 0},
        [] { return kinematicClosing(); });
    return static_cast<int>(
        std::ranges::count(grasps, RejectReason::None, [](const Grasp& g) { return g.reject; }));
}

TEST(PreshapeSearch, TheThumbIsTurnedInFrontOfThePalmEveryTime)
{
    const TempFolder folder;
    const auto urdf = folder.write("thumbed.urdf", thumbedHand());
    const HandModel hand = loadHand(urdf);
    const auto turn = static_cast<std::size_t>(hand.robot.tree.findJoint("turn"));
    EXPECT_EQ(hand.closingDirections[turn], 0);
    EXPECT_THAT(hand.notes, Contains(HasSubstr("preshapes inferred by trial grasps")));
    for (const Preshape& preshape : hand.preshapes)
    {
        EXPECT_GT(preshape.positions[turn], 0.7) << preshape.name;
        ASSERT_TRUE(preshape.X_RG);
        // The hand comes with its palm behind.
        EXPECT_GT(preshape.X_RG->linear().col(2).x(), 0.3) << preshape.name;
        EXPECT_FALSE(selfOverlaps(
            hand, preshape.positions, std::vector<double>(hand.robot.tree.size(), 0.0)));
    }
    EXPECT_EQ(hand.X_RG.matrix(), hand.preshapes[0].X_RG->matrix());
    EXPECT_EQ(contentHash(hand), contentHash(inferHand(urdf)));  // whatever the threads did

    // What was found can be written, and is understood as it was.
    const auto written = folder.write("written.srdf", handSrdf(hand));
    const HandModel again = loadHand(urdf, written);
    EXPECT_TRUE(again.notes.empty()) << again.notes.front();
    EXPECT_EQ(again.closingDirections, hand.closingDirections);
    EXPECT_EQ(again.selfPairs, hand.selfPairs);
    ASSERT_EQ(again.fingers.size(), hand.fingers.size());
    for (std::size_t k = 0; k < hand.fingers.size(); ++k)
    {
        EXPECT_EQ(again.fingers[k].name, hand.fingers[k].name);
        EXPECT_EQ(again.fingers[k].links, hand.fingers[k].links);
    }
    ASSERT_EQ(again.preshapes.size(), hand.preshapes.size());
    for (std::size_t k = 0; k < hand.preshapes.size(); ++k)
    {
        EXPECT_EQ(again.preshapes[k].name, hand.preshapes[k].name);
        EXPECT_THAT(again.preshapes[k].positions,
                    testing::Pointwise(testing::DoubleNear(1e-6), hand.preshapes[k].positions));
        EXPECT_TRUE(graspFrame(again, again.preshapes[k])
                        .isApprox(graspFrame(hand, hand.preshapes[k]), 1e-5));
    }

    // With the thumb at rest beside the fingers next to nothing is held.
    folder.write("thumbed.srdf",
                 "<robot name=\"thumbed\"><group name=\"t\"><chain base_link=\"palm\" "
                 "tip_link=\"thumb_2\"/></group><group name=\"f\"><chain base_link=\"palm\" "
                 "tip_link=\"fore_2\"/></group><group name=\"r\"><chain base_link=\"palm\" "
                 "tip_link=\"ring_2\"/></group><group_state name=\"open\" group=\"t\"/></robot>");
    const HandModel rest = loadHand(urdf);
    EXPECT_EQ(rest.preshapes[0].positions[turn], 0.0);
    const int atRest = closuresOnABall(rest, 12);
    const int turned = closuresOnABall(hand, 12);
    EXPECT_LE(atRest, 3);
    EXPECT_GE(turned, 9);
}

TEST(PreshapeSearch, WhatIsFoundIsKeptByItsContent)
{
    const TempFolder folder;
    const auto urdf = folder.write("thumbed.urdf", thumbedHand());
    const auto cache = folder.path() / "cache";
    const std::string hash = contentHash(inferHand(urdf, cache));
    const auto kept = std::filesystem::directory_iterator(cache)->path();
    const std::optional<SearchedHand> found = loadSearchedHand(kept, loadRobot(urdf).tree.size());
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->preshapes.empty());

    // It is not searched again: what stands there is believed.
    SearchedHand other = *found;
    other.preshapes.resize(1);
    other.preshapes[0].name = "from_the_file";
    saveSearchedHand(other, kept);
    EXPECT_EQ(inferHand(urdf, cache).preshapes[0].name, "from_the_file");
    saveSearchedHand(*found, kept);
    const HandModel again = loadHand(urdf, std::nullopt, {}, cache);
    EXPECT_EQ(contentHash(again), hash);
    EXPECT_THAT(again.notes, Contains(HasSubstr("preshapes inferred by trial grasps")));

    // What is damaged is searched again, and replaced.
    std::filesystem::resize_file(kept, std::filesystem::file_size(kept) / 2);
    EXPECT_EQ(contentHash(inferHand(urdf, cache)), hash);
    EXPECT_TRUE(loadSearchedHand(kept, again.robot.tree.size()));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(cache), {}), 1);
    // Where nothing can be kept, all is as without a folder.
    EXPECT_EQ(contentHash(inferHand(urdf, kept)), hash);
}

TEST(PreshapeSearch, FingersReachRoundTheObjectBeforeTheirEndsCurl)
{
    const TempFolder folder;
    const HandModel hand = loadHand(folder.write("thumbed.urdf", thumbedHand()));
    const auto link = [&](const char* joint)
    { return static_cast<std::size_t>(hand.robot.tree.findJoint(joint)); };
    ASSERT_EQ(hand.closingSpeeds.size(), hand.robot.tree.size());
    const double ratio = hand.closingSpeeds[link("fore2")];
    EXPECT_LT(ratio, 1.0);
    for (const char* const outer : {"ring2", "thumb2"})
    {
        EXPECT_EQ(hand.closingSpeeds[link(outer)], ratio) << outer;
    }
    for (const char* const inner : {"turn", "fore1", "ring1", "thumb1"})
    {
        EXPECT_EQ(hand.closingSpeeds[link(inner)], 1.0) << inner;
    }
    EXPECT_THAT(hand.notes, Contains(HasSubstr("closing speeds inferred by trial grasps: ")));
    // And with it fingers hold what they hold otherwise, and more.
    HandModel alike = loadHand(hand.robot.file);
    alike.closingSpeeds.clear();
    EXPECT_GE(closuresOnABall(hand, 12), closuresOnABall(alike, 12));

    // What says how joints close says how fast.
    folder.write("thumbed.srdf",
                 "<robot name=\"thumbed\"><closing joint=\"fore1\" direction=\"1\"/></robot>");
    EXPECT_TRUE(loadHand(hand.robot.file).closingSpeeds.empty());
}

TEST(PreshapeSearch, JointsThatAreAloneInTheirFingersHaveNoSpeedsOfTheirOwn)
{
    const TempFolder folder;
    std::string text = thumbedHand();
    for (const std::string& joint :
         {std::string("fore2"), std::string("ring2"), std::string("thumb2")})
    {
        const std::string from = "<joint name=\"" + joint + "\" type=\"revolute\">";
        const std::size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos);
        text.replace(at, from.size(), "<joint name=\"" + joint + "\" type=\"fixed\">");
    }
    EXPECT_TRUE(loadHand(folder.write("thumbed.urdf", text)).closingSpeeds.empty());
}

TEST(PreshapeSearch, AKnownGraspFrameIsKept)
{
    const TempFolder folder;
    folder.write("thumbed.srdf",
                 "<robot name=\"thumbed\"><grasp_frame link=\"palm\" xyz=\"0.05 0 0.1\" "
                 "rpy=\"0 1.2 0\"/></robot>");
    const HandModel hand = loadHand(folder.write("thumbed.urdf", thumbedHand()));
    EXPECT_TRUE(hand.X_RG.translation().isApprox(Eigen::Vector3d(0.05, 0.0, 0.1), 1e-12));
    for (const Preshape& preshape : hand.preshapes)
    {
        EXPECT_FALSE(preshape.X_RG);
        EXPECT_EQ(graspFrame(hand, preshape).matrix(), hand.X_RG.matrix());
    }
}

TEST(PreshapeSearch, AHandWithNothingToSearchHasNoSearchedPreshape)
{
    const TempFolder folder;
    std::string text = thumbedHand();
    const std::string from = "<joint name=\"turn\" type=\"revolute\">";
    text.replace(text.find(from), from.size(), "<joint name=\"turn\" type=\"fixed\">");
    const HandModel hand = loadHand(folder.write("thumbed.urdf", text));
    EXPECT_FALSE(searchPreshapes(hand, std::nullopt));
    ASSERT_EQ(hand.preshapes.size(), 1U);
    EXPECT_EQ(hand.preshapes[0].name, "open");
}

/// Before thumbs were searched for, these hands held 0.3 to 17 % of what they hold by their SRDF.
TEST(PreshapeSearch, ThumbedHandsOfOthersHoldABall)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(hands, "hands");
    std::vector<std::string> names{"schunk_sah/schunk_sah_right"};
    if (tests::longTests())
    {
        names.insert(names.end(),
                     {"allegro/allegro_left", "leap/leap_right", "shadow/shadow_right"});
    }
    for (const std::string& name : names)
    {
        const HandModel hand = inferHand(hands / (name + ".urdf"));
        EXPECT_GE(closuresOnABall(hand, 10), 8) << name;
    }
}
}  // namespace
}  // namespace bullet_ccd::grasp
