/// Times at which balls of random trees may be near boxes and each other, against samples of the
/// distance.
#include "bullet_ccd/toi/articulated/near_times.h"

#include "benchmarks/reference/scenes/random_trees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;
using Times = std::optional<std::pair<double, double>>;

/// How windows of time turned out, and what contradicts them.
struct Windows
{
    int never = 0;
    int narrow = 0;   ///< less than half of the motion
    int touched = 0;  ///< within reach at some sample
    int wrong = 0;    ///< samples within reach at another time

    template <typename Distance>
    void check(const Times& times, double reach, const Distance& distanceAt)
    {
        constexpr int kSamples = 400;
        never += times.has_value() ? 0 : 1;
        narrow += times.has_value() && times->second - times->first < 0.5 ? 1 : 0;
        bool isNear = false;
        for (int k = 0; k <= kSamples; ++k)
        {
            const double t = double(k) / kSamples;
            if (distanceAt(t) <= reach)
            {
                isNear = true;
                wrong += times.has_value() && times->first <= t && t <= times->second ? 0 : 1;
            }
        }
        touched += isNear ? 1 : 0;
    }
};

double distanceOf(const Vector3d& point, const OrientedBox& box)
{
    const Vector3d apart = (box.axes.transpose() * (point - box.center)).cwiseAbs() - box.half;
    return apart.cwiseMax(0.0).norm() - box.radius;
}

TEST(NearTimes, NothingIsNearAtOtherTimes)
{
    Random random(2601);
    Windows ofBoxes;
    Windows ofBalls;
    for (int i = 0; i < 3000; ++i)
    {
        const KinematicTree tree = randomBallTree(random, random.integer(2, 7), 0.2);
        JointMotion motion = randomJointMotion(random, tree, random.logUniform(1.0, 4.0));
        if (i % 2 == 1)
        {
            addRandomCurves(random, 2.0, motion);
        }
        MovingFrames frames;
        frames.reset(tree, motion);
        const auto last = static_cast<std::int32_t>(frames.frames().size()) - 1;
        std::array<FrameBall, 2> balls;
        for (FrameBall& ball : balls)
        {
            ball = {.frame = std::max(last - random.integer(0, 2), 0),
                    .center = random.inBox(0.3),
                    .radius = random.logUniform(0.01, 0.3)};
        }
        const auto centerAt = [&](const FrameBall& ball, double t)
        { return Vector3d(frames.stateAt(0, ball.frame, t).X_W * ball.center); };
        // Near each other at some time, so that they meet in many cases.
        const Vector3d middle = centerAt(balls[0], 0.5);
        balls[1].center = frames.stateAt(0, balls[1].frame, 0.5).X_W.inverse() *
                          Vector3d(middle + random.inBox(0.4));
        OrientedBox box{.center = middle + random.inBox(0.4),
                        .axes = random.rotation(),
                        .half = Vector3d(0.01, random.uniform(0.0, 0.1), 0.2),
                        .radius = random.chance(0.5) ? 0.0 : 0.05};
        const double reach = random.chance(0.5) ? 1e-5 : 0.02;
        NearTimes near;
        near.reset(frames, 0, balls);
        ofBoxes.check(near.near(0, box, reach),
                      reach,
                      [&](double t)
                      { return distanceOf(centerAt(balls[0], t), box) - balls[0].radius; });
        ofBalls.check(near.near(0, 1, reach),
                      reach,
                      [&](double t)
                      {
                          return (centerAt(balls[0], t) - centerAt(balls[1], t)).norm() -
                                 balls[0].radius - balls[1].radius;
                      });
        for (std::size_t k = 0; k < balls.size(); ++k)
        {
            const Vector3d place = centerAt(balls[k], random.uniform(0.0, 1.0));
            const Vector3d wide = Vector3d::Constant(balls[k].radius);
            const Eigen::AlignedBox3d around = near.boxOf(k);
            EXPECT_TRUE(around.contains(Eigen::AlignedBox3d(place - wide, place + wide))) << i;
        }
    }
    for (const Windows& windows : {ofBoxes, ofBalls})
    {
        EXPECT_EQ(windows.wrong, 0);
        EXPECT_GT(windows.never, 300);
        EXPECT_GT(windows.narrow, 100);
        EXPECT_GT(windows.touched, 300);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
