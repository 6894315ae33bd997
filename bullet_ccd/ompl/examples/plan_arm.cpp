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
    TriangleMesh box = makeBox({0.18, 0.02, 0.02});
    std::for_each(box.vertices.begin(), box.vertices.end(), [](auto& v) { v.x() += 0.2; });
    const SsvTree rod = buildSsvTree(box);
    const SsvTree post = buildSsvTree(makeBox({0.05, 0.05, 0.5}));
    KinematicTree arm{.links = std::vector<Link>(4)};  // three links of 0.4 m in a plane
    for (std::size_t i = 1; i < 4; ++i)
    {
        arm.links[i].parent = static_cast<std::int32_t>(i) - 1;
        arm.links[i].X_PL0.translation().x() = i == 1 ? 0.0 : 0.4;
        arm.links[i].joint.type = JointType::Revolute;
        arm.links[i].joint.axis = Eigen::Vector3d::UnitZ();
    }
    RigidBody obstacle{.tree = &post};
    obstacle.motion.X_W0.translation() = Eigen::Vector3d(0.7, 0.3, 0.0);
    const Environment environment(std::span(&obstacle, 1));
    const std::vector<const SsvTree*> links{nullptr, &rod, &rod, &rod};
    ompl::geometric::SimpleSetup setup(certifiedSpace(std::make_shared<const CertifiedRobot>(
        PlanningScene{.body = {.tree = &arm, .linkTrees = links, .selfPairs = {}},
                      .environment = &environment,
                      .joints = {1, 2, 3}})));
    ompl::base::ScopedState<> start(setup.getStateSpace());
    start = std::vector<double>{0.0, 0.0, 0.0};
    ompl::base::ScopedState<> goal(setup.getStateSpace());
    goal = std::vector<double>{0.9, 0.0, 0.0};
    setup.setStartAndGoalStates(start, goal);
    setup.setPlanner(std::make_shared<ompl::geometric::RRTConnect>(setup.getSpaceInformation()));
    const bool isSolved = setup.solve(10.0) == ompl::base::PlannerStatus::EXACT_SOLUTION;
    std::puts(isSolved ? "solved, and every motion of the path is certified" : "failed");
    return isSolved ? 0 : 1;
}
