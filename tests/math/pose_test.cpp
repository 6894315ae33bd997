#include "bullet_ccd/math/pose.h"

#include "benchmarks/reference/scenes/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

void expectTurns(const Vector3d& from, const Vector3d& to)
{
    const Eigen::Quaterniond turn = rotationBetween(from, to);
    EXPECT_NEAR(turn.norm(), 1.0, 1e-15);
    EXPECT_LT((turn * from.normalized() - to.normalized()).norm(), 5e-8);
    // The least angle: the axis is across both.
    EXPECT_NEAR(turn.vec().dot(from.normalized()), 0.0, 1e-15);
    const double angle = std::atan2(from.cross(to).norm(), from.dot(to));
    EXPECT_NEAR(2.0 * std::acos(std::min(std::abs(turn.w()), 1.0)), angle, 5e-8);
}

TEST(RotationBetween, TurnsOneDirectionIntoTheOther)
{
    Random random(1);
    for (int i = 0; i < 1000; ++i)
    {
        expectTurns(random.uniform(1e-3, 1e3) * random.direction(), random.direction());
    }
}

TEST(RotationBetween, HoldsForEqualOppositeAndNearlyOppositeDirections)
{
    Random random(2);
    for (int i = 0; i < 1000; ++i)
    {
        const Vector3d direction = random.direction();
        expectTurns(direction, direction);
        expectTurns(direction, -direction);
        const double off = std::pow(10.0, random.uniform(-17.0, -1.0));
        expectTurns(direction, -direction + off * random.direction());
    }
    for (int axis = 0; axis < 3; ++axis)
    {
        expectTurns(Vector3d::Unit(axis), -Vector3d::Unit(axis));
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
