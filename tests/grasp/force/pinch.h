/// Grasps whose forces have closed forms.
#pragma once

#include "grasp/force/grasp_forces.h"

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

namespace bullet_ccd::tests
{
/// `fingers` contacts spaced equally around an upright cylinder of that radius; two make a pinch.
inline grasp::ForceProblem aroundCylinder(int fingers, double radius, const grasp::ContactLaw& law)
{
    grasp::ForceProblem problem;
    problem.law = law;
    for (int k = 0; k < fingers; ++k)
    {
        const double angle = 2.0 * std::numbers::pi * k / fingers;
        const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0.0);
        problem.contacts.push_back({.link = k + 1, .point = radius * out, .normal = -out});
    }
    return problem;
}

/// Gives every contact a prismatic joint of its own that pushes along the normal, with that limit
/// [N].
inline void pushByPrismaticJoints(grasp::ForceProblem& problem, double limit)
{
    const std::size_t count = problem.contacts.size();
    problem.jacobian.assign(count * count, grasp::Twist::Zero());
    for (std::size_t i = 0; i < count; ++i)
    {
        problem.jacobian[count * i + i].head<3>() = problem.contacts[i].normal;
        problem.jointNames.push_back("push_" + std::to_string(i));
    }
    problem.torqueLimits.assign(count, limit);
}
}  // namespace bullet_ccd::tests
