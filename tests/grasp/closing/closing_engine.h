/// What the tests of closing engines share: engines as parameters, and hands and objects for which
/// the joint angles at contact are known in closed form.
#pragma once

#include "grasp/closing/closing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
inline constexpr double kTolerance = 1e-6;  // [m]
inline constexpr double kRounding = 1e-11;  // of angles and places computed along different ways

// A finger of length L hinged at the origin sweeps down to a cylinder of radius r about z at
// (D, 0); stability catalogue G12, G13.
inline constexpr double kL1 = 0.12;
inline constexpr double kL2 = 0.06;
inline constexpr double kD = 0.10;
inline constexpr double kR = 0.03;
inline constexpr double kStart = 1.2;
inline const Eigen::Isometry3d kAtOrigin = Eigen::Isometry3d::Identity();
inline const Eigen::Vector3d kAxis = Eigen::Vector3d::UnitZ();
inline const double kTouch = std::asin(kR / kD);  // angle of the finger when it is tangent

struct Engine
{
    const char* name;
    grasp::MakeCloseHand make;
};

/// What holds for every engine. A test program has the tests of closing_engines_test.cpp and names
/// the engines that it has.
class ClosingEngine : public testing::TestWithParam<Engine>
{
protected:
    static grasp::ClosingResult closeOnce(const grasp::HandModel& hand,
                                          const grasp::GraspObject& object,
                                          const std::vector<double>& positions,
                                          double tolerance = kTolerance)
    {
        return GetParam().make()(hand, object, kAtOrigin, positions, {.tolerance = tolerance});
    }
};

[[nodiscard]] std::string nameOf(const testing::TestParamInfo<Engine>& test);

/// `value` is on the near side of `contact`, by what the tolerance allows at `slope` metres a
/// radian.
void expectJustBefore(double value, double contact, double sense, double slope);

[[nodiscard]] grasp::GraspObject objectOf(const TriangleMesh& mesh);
[[nodiscard]] grasp::GraspObject farAway();

/// Cylinder at (D, y) with vertices at the given angles as seen from its axis.
[[nodiscard]] TriangleMesh cylinder(std::initializer_list<double> angles, double y = 0.0);

[[nodiscard]] grasp::HandModel oneFinger(double lower = 0.0);

/// Jaws with faces at x = -0.04 and x = +0.04 that move towards each other, and a block of 50 mm.
[[nodiscard]] grasp::HandModel parallelJaw();
[[nodiscard]] grasp::GraspObject blockAt(double x);

/// Two fingers of length L at (+-gap/2, 0) that swing towards each other, mirrored about x = 0.
[[nodiscard]] grasp::HandModel mirroredFingers(double length, double gap, bool paired);
}  // namespace bullet_ccd::tests
