/// The judge itself: right answers are acquitted, every kind of wrong answer is convicted.
#include "benchmarks/reference/oracles/toi_certificate.h"

#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <cmath>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kTolerance = 1e-6;

Verdict judged(const RigidScene& scene, const ToiResult& result, double separation = 0.0)
{
    return judgeToi(scene, {.tolerance = kTolerance, .minimumSeparation = separation}, result)
        .verdict;
}

/// A cube falls on the plane; the gap closes at t = 0.5.
RigidScene fallingCube()
{
    return {.meshA = cube(1.0),
            .meshB = floorAt(0.0, 10.0),
            .motionA = {.X_W0 = poseOf({0, 0, 5}), .v_W = {0, 0, -8}}};
}

ToiResult answer(ToiStatus status, double time, double gap)
{
    ToiResult result;
    result.status = status;
    result.time = time;
    result.gap = gap;
    return result;
}

ToiResult hit(double time, double gap)
{
    return answer(ToiStatus::Hit, time, gap);
}

ToiResult separated(double gap = 0.0)
{
    return answer(ToiStatus::Separated, 1.0, gap);
}

TEST(ToiCertificate, AcquitsTheRightAnswer)
{
    const double gap = 4e-7;
    EXPECT_EQ(judged(fallingCube(), hit(0.5 - gap / 8.0, gap)), Verdict::Right);
}

TEST(ToiCertificate, ConvictsLateAnswersHoweverSmallTheDelay)
{
    for (const double delay : {1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15})
    {
        EXPECT_EQ(judged(fallingCube(), hit(0.5 + delay, 1e-9)), Verdict::Late) << delay;
    }
}

TEST(ToiCertificate, ConvictsMissedContacts)
{
    EXPECT_EQ(judged(fallingCube(), separated()), Verdict::Missed);
    // A plate thinner than 1e-4 of the motion.
    RigidScene bullet{.meshA = cube(0.5),
                      .meshB = quad({0, -2, -2}, {0, 2, -2}, {0, 2, 2}, {0, -2, 2}),
                      .motionA = {.X_W0 = poseOf({5, 0, 0}), .v_W = {-30000, 0, 0}}};
    EXPECT_EQ(judged(bullet, separated()), Verdict::Missed);
}

TEST(ToiCertificate, ConvictsContactsBeyondTheTolerance)
{
    for (const double gap : {1.01e-6, 1e-5, 1e-2})
    {
        EXPECT_EQ(judged(fallingCube(), hit(0.5 - gap / 8.0, gap)), Verdict::False) << gap;
    }
}

TEST(ToiCertificate, ConvictsWrongGapsAndStatuses)
{
    EXPECT_EQ(judged(fallingCube(), hit(0.5 - 4e-7 / 8.0, 3e-7)), Verdict::WrongGap);
    EXPECT_EQ(judged(fallingCube(), answer(ToiStatus::Overlapping, 0.0, 0.0)),
              Verdict::WrongStatus);
    EXPECT_EQ(judged(fallingCube(), answer(ToiStatus::TouchingPressing, 0.5 - 4e-7 / 8.0, 4e-7)),
              Verdict::WrongStatus);

    RigidScene rising = fallingCube();
    rising.motionA.v_W = {0, 0, 1};
    EXPECT_EQ(judged(rising, separated(3.9)), Verdict::Right);
    EXPECT_EQ(judged(rising, separated(4.1)), Verdict::WrongGap);
    rising.motionA.X_W0.translation().z() = 1.0 + 0.5e-6;
    EXPECT_EQ(judged(rising, answer(ToiStatus::TouchingLeaving, 1.0, 0.0)), Verdict::Right);
    EXPECT_EQ(judged(rising, separated()), Verdict::WrongStatus);
}

TEST(ToiCertificate, MeasuresFromTheMinimumSeparation)
{
    const double gap = 4e-7;
    const double stop = 0.5 - (0.5 + gap) / 8.0;
    EXPECT_EQ(judged(fallingCube(), hit(stop, 0.5 + gap), 0.5), Verdict::Right);
    EXPECT_EQ(judged(fallingCube(), hit(stop + 1e-6, 0.5), 0.5), Verdict::Late);
    EXPECT_EQ(judged(fallingCube(), hit(stop - 1e-6, 0.5 + gap + 8e-6), 0.5), Verdict::False);
}

TEST(ToiCertificate, ProvesTheAnswersOfTheMarchingOracleOnRandomScenes)
{
    Random random(90);
    int contacts = 0;
    const int kScenes = longTests() ? 400 : 160;
    for (int i = 0; i < kScenes; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const OracleToi toi = bruteForceToi(oracleBody(scene.meshA, scene.motionA),
                                            oracleBody(scene.meshB, scene.motionB));
        if (!toi.contact || *toi.contact < 1e-3)
        {
            continue;
        }
        ++contacts;
        const Judgement late = judgeToi(
            scene, {.tolerance = kTolerance}, hit(std::min(1.0, *toi.contact + 1e-9), 1e-9));
        EXPECT_EQ(late.verdict, Verdict::Late) << i << ": " << late.text();
        // Where it is within the tolerance just before the contact, that is a right answer.
        const double before = *toi.contact - 1e-8;
        const double distance = instantDistance(scene, before).distance;
        if (distance > 0.0 && distance < kTolerance)
        {
            const Judgement right =
                judgeToi(scene, {.tolerance = kTolerance}, hit(before, distance));
            EXPECT_EQ(right.verdict, Verdict::Right) << i << ": " << right.text();
        }
    }
    EXPECT_GT(contacts, kScenes / 4);
}
}  // namespace
}  // namespace bullet_ccd::tests
