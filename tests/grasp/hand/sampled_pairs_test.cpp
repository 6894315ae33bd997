/// Pairs of links sorted by sampling, against shares of a turn that are known.
#include "grasp/hand/sampled_pairs.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "grasp/hand/hand_model.h"
#include "grasp/hand/srdf_file.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace bullet_ccd::grasp
{
namespace
{
using reference::poseOf;

/// Part of a flat ring about z, from one angle to another [deg], of radius about 3/4.
TriangleMesh ringPart(double from, double to)
{
    TriangleMesh mesh;
    const int parts = static_cast<int>(std::ceil((to - from) / 5.0));
    const auto at = [](double degrees, double radius)
    {
        const double angle = degrees * std::numbers::pi / 180.0;
        return Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    };
    for (int i = 0; i < parts; ++i)
    {
        const double a = from + (to - from) * i / parts;
        const double b = from + (to - from) * (i + 1) / parts;
        mesh = reference::merged(
            {mesh, reference::quad(at(a, 0.7), at(b, 0.7), at(b, 0.8), at(a, 0.8))});
    }
    return mesh;
}

/// A pointer that turns about z over flat parts of rings that are fixed to its base: the share of
/// the turn in which they overlap is that of the ring.
struct Dial
{
    Dial()
    {
        add("base", kNone, reference::shifted(reference::cube(0.1), {0, 0, 0.5}));
        add("pointer", 0, reference::segment({0.5, 0, 0}, {1, 0, 0}));
        tree.links[1].joint.type = JointType::Revolute;
        tree.links[1].joint.axis = Eigen::Vector3d::UnitZ();
        add("sixth", 0, ringPart(30, 90));
        add("at rest", 0, ringPart(-10, 10));
        add("nearly all", 0, ringPart(5, 355));
        add("not quite", 0, ringPart(15, 345));
        add("above", 0, reference::shifted(ringPart(0, 360), {0, 0, 1e-2}));
        // Turns along with the pointer, half a turn ahead.
        add("follower", 0, reference::segment({-0.5, 0, 0}, {-1, 0, 0}));
        tree.links[7].joint = tree.links[1].joint;
        tree.links[7].joint.mimicOf = 1;
        // Hangs on the pointer.
        add("mount", 1, {});
        add("flag", 8, reference::segment({0.9, 0, 0}, {0.9, 0, 0.1}));
        for (const TriangleMesh& mesh : meshes)
        {
            trees.push_back(buildSsvTree(mesh.triangles.empty() ? reference::cube(1.0) : mesh));
        }
        for (std::size_t i = 0; i < meshes.size(); ++i)
        {
            linkTrees.push_back(meshes[i].triangles.empty() ? nullptr : &trees[i]);
        }
    }

    void add(const char* name, std::int32_t parent, const TriangleMesh& mesh)
    {
        tree.links.push_back({.name = name, .parent = parent});
        meshes.push_back(mesh);
    }

    /// What was found of a pair, by names.
    [[nodiscard]] SampledPair find(const char* first,
                                   const char* second,
                                   const PairSampling& sampling = {.samples = 2000}) const
    {
        for (const SampledPair& pair : samplePairs(tree, linkTrees, sampling))
        {
            if (pair.first == tree.findLink(first) && pair.second == tree.findLink(second))
            {
                return pair;
            }
        }
        ADD_FAILURE() << "no pair " << first << ", " << second;
        return {};
    }

    KinematicTree tree;
    std::vector<TriangleMesh> meshes;
    std::vector<SsvTree> trees;
    std::vector<const SsvTree*> linkTrees;
};

TEST(SampledPairs, SortsPairsByWhatTheSamplesSay)
{
    const Dial dial;
    EXPECT_EQ(dial.find("base", "pointer").finding, PairFinding::Adjacent);
    EXPECT_EQ(dial.find("pointer", "sixth").finding, PairFinding::Sometimes);
    EXPECT_EQ(dial.find("pointer", "at rest").finding, PairFinding::Default);
    EXPECT_EQ(dial.find("pointer", "nearly all").finding, PairFinding::Always);
    EXPECT_EQ(dial.find("pointer", "not quite").finding, PairFinding::Sometimes);
    EXPECT_EQ(dial.find("pointer", "above").finding, PairFinding::Never);
    EXPECT_FALSE(dial.find("pointer", "sixth").canBeDisabled());
    EXPECT_TRUE(dial.find("pointer", "above").canBeDisabled());
}

TEST(SampledPairs, SharesAreThoseOfTheTurn)
{
    // Within four standard deviations.
    const Dial dial;
    const SampledPair most = dial.find("pointer", "nearly all", {.samples = 10'000});
    EXPECT_EQ(most.samples, 10'000);
    EXPECT_NEAR(most.overlaps / 10'000.0, 350.0 / 360.0, 4 * 0.0017);
    // A pair is looked at until it can be neither always nor never: until 5 % of all samples were
    // free of an overlap, which takes about 6/5 times as many.
    const SampledPair sixth = dial.find("pointer", "sixth", {.samples = 10'000});
    EXPECT_NEAR(static_cast<double>(sixth.overlaps) / sixth.samples, 1.0 / 6.0, 4 * 0.016);
    EXPECT_EQ(sixth.samples - sixth.overlaps, 501);
}

TEST(SampledPairs, MimicJointsFollow)
{
    const Dial dial;
    EXPECT_EQ(dial.find("pointer", "follower").finding, PairFinding::Never);
    EXPECT_EQ(dial.find("sixth", "follower").finding, PairFinding::Sometimes);
}

TEST(SampledPairs, LinksWithoutGeometryDoNotSeparateNeighbours)
{
    const Dial dial;
    EXPECT_EQ(dial.find("pointer", "flag").finding, PairFinding::Adjacent);
    // The pointer lies between.
    EXPECT_EQ(dial.find("base", "flag").finding, PairFinding::Never);
}

TEST(SampledPairs, LimitsAreKept)
{
    Dial dial;
    dial.tree.links[1].joint.lower = -0.2;
    dial.tree.links[1].joint.upper = 0.5;  // 28.6 degrees: the sixth begins at 30
    EXPECT_EQ(dial.find("pointer", "sixth").finding, PairFinding::Never);
    dial.tree.links[1].joint.upper = 0.6;
    EXPECT_EQ(dial.find("pointer", "sixth").finding, PairFinding::Sometimes);
    // Rest is the limit next to 0.
    dial.tree.links[1].joint.lower = 0.55;
    EXPECT_EQ(dial.find("pointer", "sixth").finding, PairFinding::Default);
}

TEST(SampledPairs, TheSeedDecidesAndNothingElse)
{
    const Dial dial;
    const int first = dial.find("pointer", "nearly all", {.samples = 500, .seed = 7}).overlaps;
    EXPECT_EQ(dial.find("pointer", "nearly all", {.samples = 500, .seed = 7}).overlaps, first);
    bool differs = false;
    for (std::uint64_t seed = 8; seed < 12; ++seed)
    {
        differs =
            differs ||
            dial.find("pointer", "nearly all", {.samples = 500, .seed = seed}).overlaps != first;
    }
    EXPECT_TRUE(differs);
}

TEST(SampledPairs, RefusesOptionsOutOfRange)
{
    const Dial dial;
    const auto sample = [&](const PairSampling& sampling)
    { (void)samplePairs(dial.tree, dial.linkTrees, sampling); };
    EXPECT_THROW(sample({.samples = 0}), std::invalid_argument);
    EXPECT_THROW(sample({.always = 0.0}), std::invalid_argument);
    EXPECT_THROW(sample({.always = 1.5}), std::invalid_argument);
    EXPECT_THROW(sample({.reach = 0.0}), std::invalid_argument);
    EXPECT_THROW((void)samplePairs(dial.tree, {}, {}), std::invalid_argument);
}

TEST(SampledPairs, TheSrdfIsReadBackWithItsNames)
{
    Dial dial;
    dial.tree.links[2].name = R"(a "sixth" & more)";
    const std::vector<SampledPair> pairs{
        {.first = 1, .second = 2, .finding = PairFinding::Never},
        {.first = 0, .second = 1, .finding = PairFinding::Adjacent}};
    const std::string text = disabledPairsSrdf("dial", dial.tree, pairs);
    EXPECT_NE(text.find(R"(<disable_collisions link1="base" link2="pointer" reason="Adjacent"/>)"),
              std::string::npos)
        << text;
    const tests::TempFolder folder;
    const Srdf srdf = readSrdf(folder.write("dial.srdf", text));
    using Names = std::pair<std::string, std::string>;
    EXPECT_EQ(srdf.disabledPairs,
              (std::vector{Names{"pointer", dial.tree.links[2].name}, Names{"base", "pointer"}}));
}

TEST(SampledPairs, OnKnownHandsRestAndJointsAreSeenAsBruteForceSeesThem)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(hands, "hands");
    for (const char* name : {"barrett/barrett.urdf", "schunk_sdh/schunk_sdh.urdf"})
    {
        SCOPED_TRACE(name);
        const HandModel hand = loadHand(hands / name);
        const KinematicTree& tree = hand.robot.tree;
        const PairSampling sampling{.samples = 300};
        std::vector<double> rest(tree.size(), 0.0);
        for (std::size_t i = 1; i < tree.size(); ++i)
        {
            rest[i] = std::clamp(0.0, tree.links[i].joint.lower, tree.links[i].joint.upper);
        }
        applyMimics(tree, rest);
        const std::vector<Eigen::Isometry3d> X_R =
            linkPoses(tree, Eigen::Isometry3d::Identity(), rest);
        int joined = 0;
        for (const SampledPair& pair : samplePairs(tree, hand.linkTrees, sampling))
        {
            const auto a = static_cast<std::size_t>(pair.first);
            const auto b = static_cast<std::size_t>(pair.second);
            const bool isChild = tree.links[b].parent == pair.first;
            joined += isChild ? 1 : 0;
            EXPECT_TRUE(!isChild || pair.finding == PairFinding::Adjacent);
            const double distance =
                reference::bruteForceMeshDistance(
                    hand.linkTrees[a]->mesh(), hand.linkTrees[b]->mesh(), X_R[b].inverse() * X_R[a])
                    .distance;
            const bool isDefault = pair.finding == PairFinding::Default;
            if (pair.finding != PairFinding::Adjacent)
            {
                EXPECT_EQ(distance < sampling.reach, isDefault)
                    << tree.links[a].name << ", " << tree.links[b].name;
            }
        }
        EXPECT_GE(joined, static_cast<int>(hand.fingers.size()));
    }
}
}  // namespace
}  // namespace bullet_ccd::grasp
