// Plans a motion of an arm around a post with RRT-Connect. No motion is tested at samples.
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/ompl/certified_planning.h"

#include <algorithm>
#include <cstdio>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>

int main()
{
    using namespace bullet_ccd;
    KinematicTree arm;  // three links of 0.4 m in a plane
    arm.links.resize(4);
    TriangleMesh box = makeBox({0.18, 0.02, 0.02});
    std::for_each(box.vertices.begin(), box.vertices.end(), [](auto& v) { v.x() += 0.2; });
    const SsvTree rod = buildSsvTree(box);
    for (std::int32_t i = 1; i < 4; ++i)
    {
        Link& link = arm.links[static_cast<std::size_t>(i)];
        link.parent = i - 1;
        link.X_PL0.translation().x() = i == 1 ? 0.0 : 0.4;
        link.joint.type = JointType::Revolute;
        link.joint.axis = Eigen::Vector3d::UnitZ();
    }
    const std::vector<const SsvTree*> links{nullptr, &rod, &rod, &rod};
    const SsvTree post = buildSsvTree(makeBox({0.05, 0.05, 0.5}));
    RigidBody obstacle{.tree = &post};
    obstacle.motion.X_W0.translation() = Eigen::Vector3d(0.7, 0.3, 0.0);
    const Environment environment(std::span(&obstacle, 1));
    const auto robot = std::make_shared<const CertifiedRobot>(
        PlanningScene{.body = {.tree = &arm, .linkTrees = links, .selfPairs = {}},
                      .environment = &environment,
                      .joints = {1, 2, 3}});

    ompl::geometric::SimpleSetup setup(certifiedSpace(robot));
    ompl::base::ScopedState<> start(setup.getStateSpace());
    ompl::base::ScopedState<> goal(setup.getStateSpace());
    start = std::vector<double>{0.0, 0.0, 0.0};
    goal = std::vector<double>{0.9, 0.0, 0.0};
    setup.setStartAndGoalStates(start, goal);
    setup.setPlanner(std::make_shared<ompl::geometric::RRTConnect>(setup.getSpaceInformation()));
    const bool isSolved = setup.solve(10.0) == ompl::base::PlannerStatus::EXACT_SOLUTION;
    std::printf("%s\n", isSolved ? "solved, and every motion of the path is certified" : "failed");
    return isSolved ? 0 : 1;
}
