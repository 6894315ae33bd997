#include "grasp/task/joint_path.h"

#include "bullet_ccd/ompl/certified_planning.h"
#include "grasp/approach/draws.h"

#include <algorithm>
#include <cmath>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/terminationconditions/IterationTerminationCondition.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

namespace bullet_ccd::grasp
{
namespace
{
namespace ob = ::ompl::base;
namespace og = ::ompl::geometric;

JointPositions pointAt(const JointPositions& from, const JointPositions& to, double part)
{
    JointPositions q(from.size());
    for (std::size_t k = 0; k < q.size(); ++k)
    {
        q[k] = std::lerp(from[k], to[k], part);
    }
    return q;
}

/// Replaces parts of the path by straight motions, where they are free.
void shorten(const CertifiedRobot& robot,
             const JointPathOptions& options,
             std::vector<JointPositions>& path)
{
    Draws draws(options.seed, 0);
    for (int i = 0; i < options.shortcuts && path.size() > 2; ++i)
    {
        const double segments = double(path.size() - 1);
        double a = draws.between(0.0, segments);
        double b = draws.between(0.0, segments);
        if (i < std::ssize(path))
        {
            // First whole waypoints are left out, one after the other.
            a = double(i % (path.size() - 1));
            b = std::min(a + 2.0, segments);
        }
        if (a > b)
        {
            std::swap(a, b);
        }
        const auto first = std::min(static_cast<std::size_t>(a), path.size() - 2);
        const auto last = std::min(static_cast<std::size_t>(b), path.size() - 2);
        if (first == last)
        {
            continue;
        }
        const JointPositions from = pointAt(path[first], path[first + 1], a - double(first));
        const JointPositions to = pointAt(path[last], path[last + 1], b - double(last));
        // The pieces that are left of the two segments are parts of certified motions; they are
        // asked about anew, since their numbers are rounded.
        if (robot.isFreeMotion(path[first], from) && robot.isFreeMotion(from, to) &&
            robot.isFreeMotion(to, path[last + 1]))
        {
            std::vector<JointPositions> shorter(path.begin(),
                                                path.begin() + std::ptrdiff_t(first) + 1);
            for (const JointPositions& q : {from, to, path[last + 1]})
            {
                if (q != shorter.back())
                {
                    shorter.push_back(q);
                }
            }
            shorter.insert(shorter.end(), path.begin() + std::ptrdiff_t(last) + 2, path.end());
            path = std::move(shorter);
        }
    }
}
}  // namespace

JointPathResult planJointPath(const JointProblem& problem,
                              const JointPositions& from,
                              const JointPositions& to,
                              const JointPathOptions& options)
{
    // OMPL seeds every generator by one of the whole process; a seed set anew is obeyed, though it
    // says that this is late.
    ::ompl::msg::noOutputHandler();
    ::ompl::RNG::setSeed(static_cast<std::uint_fast32_t>(options.seed % 1'000'000'007U + 1U));
    PlanningScene scene{.body = problem.body,
                        .environment = problem.environment,
                        .joints = {problem.joints.begin(), problem.joints.end()},
                        .positions = problem.positions,
                        .X_WR = problem.X_WR};
    scene.toi.tolerance = problem.toi.tolerance;
    scene.toi.minimumSeparation = problem.toi.minimumSeparation;
    const auto robot = std::make_shared<const CertifiedRobot>(std::move(scene));
    JointPathResult result;
    if (!robot->isFree(from) || !robot->isFree(to))
    {
        result.failure =
            robot->isFree(from) ? "its end is in collision" : "its start is in collision";
        return result;
    }
    result.waypoints = {from, to};
    if (robot->isFreeMotion(from, to))
    {
        return result;
    }
    og::SimpleSetup setup(certifiedSpace(robot));
    const auto stateOf = [&](const JointPositions& q)
    {
        ob::ScopedState<> state(setup.getSpaceInformation());
        state = q;
        return state;
    };
    setup.setStartAndGoalStates(stateOf(from), stateOf(to));
    setup.setPlanner(std::make_shared<og::RRTConnect>(setup.getSpaceInformation()));
    ob::IterationTerminationCondition limit(static_cast<unsigned>(options.iterations));
    const ob::PlannerTerminationCondition isOver([&]
                                                 { return limit.eval() || options.stop.isDue(); });
    result.waypoints.clear();
    if (setup.solve(isOver) != ob::PlannerStatus::EXACT_SOLUTION)
    {
        result.failure =
            options.stop.isDue()
                ? "stopped while a path was looked for"
                : "no path was found in " + std::to_string(options.iterations) + " iterations";
        return result;
    }
    for (const ob::State* state : setup.getSolutionPath().getStates())
    {
        const double* q = state->as<ob::RealVectorStateSpace::StateType>()->values;
        result.waypoints.emplace_back(q, q + from.size());
    }
    shorten(*robot, options, result.waypoints);
    return result;
}
}  // namespace bullet_ccd::grasp
