/// The judge of articulated answers itself: right answers are acquitted, every kind of wrong answer
/// is convicted.
#include "benchmarks/reference/oracles/articulated_judge.h"

#include "benchmarks/reference/queries/chain_queries.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <gtest/gtest.h>

#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kChainTolerance = 1e-6;

/// An upright plate whose edge an arm along the diagonal of x and y meets at radius 1/2; it lies
/// across the arm, on the side of y.
TriangleMesh plateAtDiagonal()
{
    const Eigen::Vector3d edge = 0.25 * std::numbers::sqrt2 * Eigen::Vector3d(1, 1, 0);
    const Eigen::Vector3d beyond = edge + Eigen::Vector3d(-0.1, 0.1, 0);
    const Eigen::Vector3d up(0, 0, 1);
    return quad(edge - up, edge + up, beyond + up, beyond - up);
}

/// An arm of length 1 turns from x to y and meets the plate at t = 1/2; a post stands where it does
/// not come.
ArticulatedScene turningArm()
{
    ArticulatedScene scene;
    scene.tree = planarChain({1.0});
    scene.linkMeshes = {{}, segment({0, 0, 0}, {1, 0, 0})};
    scene.motion = {.root = {}, .positions = {0, 0}, .rates = {0, 0.5 * std::numbers::pi}};
    scene.obstacles = {plateAtDiagonal(), segment({0.5, -1.0, -1}, {0.5, -1.0, 1})};
    scene.obstacleMotions = {{}, {}};
    return scene;
}

Judgement judged(const ArticulatedScene& scene, const ArticulatedToiResult& result)
{
    return judgeArticulated(scene, {.tolerance = kChainTolerance}, result);
}

ArticulatedToiResult rightAnswer()
{
    return query(turningArm(), kChainTolerance);
}

/// The answer that an engine would give that stops that much later, with the gap of before.
ArticulatedToiResult later(ArticulatedToiResult result, double delay)
{
    result.time += delay;
    for (LinkContact& contact : result.contacts)
    {
        contact.time = result.time;
    }
    return result;
}

TEST(ArticulatedJudge, AcquitsTheRightAnswer)
{
    const ArticulatedToiResult result = rightAnswer();
    ASSERT_EQ(result.status, ToiStatus::Hit);
    EXPECT_NEAR(result.time, 0.5, 1e-5);
    EXPECT_EQ(judged(turningArm(), result).verdict, Verdict::Right);
}

TEST(ArticulatedJudge, ConvictsLateAnswersHoweverSmallTheDelay)
{
    for (const double delay : {1e-1, 1e-4, 1e-9, 1e-12})
    {
        const ArticulatedToiResult result = later(rightAnswer(), 0.5 - rightAnswer().time + delay);
        const Judgement judgement = judged(turningArm(), result);
        EXPECT_EQ(judgement.verdict, Verdict::Late) << delay;
        EXPECT_NEAR(judgement.time, 0.5, 1e-12);
        EXPECT_EQ(judgement.pair, "link 1 and obstacle 0");
    }
}

TEST(ArticulatedJudge, ConvictsMissedContacts)
{
    EXPECT_EQ(judged(turningArm(), {}).verdict, Verdict::Missed);
    // A plate that is crossed and left again within a thousandth of the motion.
    ArticulatedScene fast = turningArm();
    fast.motion.rates[1] = 1000.0;
    EXPECT_EQ(judged(fast, {}).verdict, Verdict::Missed);
}

TEST(ArticulatedJudge, ConvictsContactsThatAreNotNamed)
{
    // Two plates are met at the same time.
    ArticulatedScene scene = turningArm();
    scene.obstacles[1] = shifted(scene.obstacles[0], {0, 0, 0.5});
    ArticulatedToiResult result = query(scene, kChainTolerance);
    ASSERT_EQ(result.contacts.size(), 2U);
    EXPECT_EQ(judged(scene, result).verdict, Verdict::Right);
    result.contacts.pop_back();
    EXPECT_EQ(judged(scene, result).verdict, Verdict::Missed);
}

TEST(ArticulatedJudge, ConvictsFalseContacts)
{
    for (const double early : {1e-5, 1e-3, 0.4})
    {
        EXPECT_EQ(judged(turningArm(), later(rightAnswer(), -early)).verdict, Verdict::False)
            << early;
    }
    ArticulatedToiResult other = rightAnswer();
    other.contacts[0].obstacle = 1;
    EXPECT_EQ(judged(turningArm(), other).verdict, Verdict::False);
    other.contacts[0].obstacle = kNone;
    other.contacts[0].otherLink = 0;
    EXPECT_EQ(judged(turningArm(), other).verdict, Verdict::False);
}

TEST(ArticulatedJudge, ConvictsWrongGapsAndWitnesses)
{
    const ArticulatedToiResult right = rightAnswer();
    const auto changed = [&](auto&& change)
    {
        ArticulatedToiResult result = right;
        change(result.contacts[0]);
        return judged(turningArm(), result).verdict;
    };
    EXPECT_EQ(changed([](LinkContact&) {}), Verdict::Right);
    EXPECT_EQ(changed([](LinkContact& c) { c.gap += 1e-9; }), Verdict::WrongGap);
    EXPECT_EQ(changed([](LinkContact& c) { c.gap = 0.0; }), Verdict::WrongGap);
    EXPECT_EQ(changed([](LinkContact& c) { c.pointLink.z() += 1e-9; }), Verdict::WrongGap);
    EXPECT_EQ(changed([](LinkContact& c) { c.normal = -c.normal; }), Verdict::WrongGap);
    EXPECT_EQ(changed([](LinkContact& c) { c.triangleOther = 7; }), Verdict::WrongGap);
    EXPECT_EQ(changed([](LinkContact& c) { c.time = 0.25; }), Verdict::WrongGap);
}

TEST(ArticulatedJudge, ConvictsWrongStatuses)
{
    ArticulatedToiResult result = rightAnswer();
    result.status = ToiStatus::Separated;
    EXPECT_EQ(judged(turningArm(), result).verdict, Verdict::WrongStatus);
    result = rightAnswer();
    result.contacts.clear();
    EXPECT_EQ(judged(turningArm(), result).verdict, Verdict::WrongStatus);
    result = rightAnswer();
    result.status = ToiStatus::Overlapping;
    result.time = 0.0;
    EXPECT_EQ(judged(turningArm(), result).verdict, Verdict::WrongStatus);
    result.status = ToiStatus::IterationLimit;
    EXPECT_EQ(judged(turningArm(), result).verdict, Verdict::GaveUp);
}

/// Right answers of the random chains of the soak, spoiled by hand.
TEST(ArticulatedJudge, ConvictsSpoiledAnswersOfRandomChains)
{
    int spoiled = 0;
    for (std::uint64_t seed = 0; seed < 72; ++seed)
    {
        const ChainQuery chain = chainQuery(seed);
        const ChainOutcome outcome = runChainQuery(chain);
        if (outcome.result.status != ToiStatus::Hit)
        {
            continue;
        }
        const ToiOptions& options = chain.options.toi;
        const Judgement missed = judgeArticulated(chain.scene, options, {});
        // What comes within the tolerance need not touch.
        if (missed.verdict != Verdict::Missed)
        {
            EXPECT_EQ(missed.verdict, Verdict::Right) << seed;
            continue;
        }
        ++spoiled;
        ASSERT_GE(missed.time, outcome.result.time) << seed;
        const double delay = missed.time - outcome.result.time + 1e-9;
        if (outcome.result.time + delay <= 1.0)
        {
            EXPECT_EQ(judgeArticulated(chain.scene, options, later(outcome.result, delay)).verdict,
                      Verdict::Late)
                << seed;
        }
    }
    EXPECT_GT(spoiled, 18);
}
}  // namespace
}  // namespace bullet_ccd::tests
