#include "tests/grasp/closing/closing_engine.h"

#include "benchmarks/reference/scenes/shapes.h"
#include "tests/grasp/closing/finger_hand.h"

#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

using Eigen::Vector3d;
using grasp::GraspObject;
using grasp::HandModel;

std::string nameOf(const testing::TestParamInfo<Engine>& test)
{
    return test.param.name;
}

void expectJustBefore(double value, double contact, double sense, double slope)
{
    const double short_ = sense * (contact - value);
    EXPECT_GE(short_, -kRounding);
    EXPECT_LE(short_, kTolerance / slope * 1.01 + kRounding);
}

GraspObject objectOf(const TriangleMesh& mesh)
{
    return grasp::makeGraspObject("object", mesh);
}

GraspObject farAway()
{
    return objectOf(shifted(cube(0.01), {0.0, 0.0, 5.0}));
}

TriangleMesh cylinder(std::initializer_list<double> angles, double y)
{
    return shifted(prism(circlePoints(kR, circleAngles(48, 0.01, angles)), -0.05, 0.05),
                   {kD, y, 0.0});
}

HandModel oneFinger(double lower)
{
    HandBuilder builder;
    builder.add(0, kAtOrigin, revolute(kAxis, lower, 2.0), -1, finger(kL1));
    return builder.take();
}

HandModel parallelJaw()
{
    HandBuilder builder;
    builder.add(0,
                kAtOrigin,
                prismatic(Vector3d::UnitX(), 0.0, 0.04),
                1,
                box({-0.05, -0.01, -0.01}, {-0.04, 0.01, 0.01}));
    builder.add(0,
                kAtOrigin,
                prismatic(-Vector3d::UnitX(), 0.0, 0.04),
                1,
                box({0.04, -0.01, -0.01}, {0.05, 0.01, 0.01}));
    return builder.take();
}

GraspObject blockAt(double x)
{
    return objectOf(box({x - 0.025, -0.02, -0.02}, {x + 0.025, 0.02, 0.02}));
}

HandModel mirroredFingers(double length, double gap, bool paired)
{
    HandBuilder builder;
    const auto left =
        builder.add(0, poseOf({-gap / 2, 0.0, 0.0}), revolute(kAxis, 0.0, 2.0), -1, finger(length));
    const Eigen::Isometry3d turned =
        poseOf({gap / 2, 0.0, 0.0}, std::numbers::pi, Vector3d::UnitY());
    const auto right = builder.add(0, turned, revolute(kAxis, 0.0, 2.0), -1, finger(length));
    if (paired)
    {
        builder.selfPair(left, right);
    }
    return builder.take();
}
}  // namespace bullet_ccd::tests
