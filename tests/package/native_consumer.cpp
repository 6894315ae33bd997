/// What programs and the library hand to each other, in a program that is compiled for wider
/// instructions than the library: structures with poses, vectors of poses, forces.
#include "bullet_ccd/bullet_ccd.h"
#include "grasp/grasp.h"

#include <cmath>
#include <cstdio>

namespace
{
using namespace bullet_ccd;

bool expect(bool condition, const char* what)
{
    if (!condition)
    {
        std::fprintf(stderr, "wrong: %s\n", what);
    }
    return condition;
}

/// Three links, each a metre above the one before.
KinematicTree tower()
{
    KinematicTree tree;
    tree.links.resize(3);
    for (std::size_t i = 1; i < 3; ++i)
    {
        tree.links[i].parent = static_cast<std::int32_t>(i) - 1;
        tree.links[i].X_PL0.translation().z() = 1.0;
        tree.links[i].joint.type = JointType::Prismatic;
        tree.links[i].joint.axis = Eigen::Vector3d::UnitZ();
    }
    return tree;
}

/// Poses come back in a vector, so the library allocates it and the program frees it.
bool posesAreRight()
{
    const std::vector<double> positions{0.0, 0.25, 0.5};
    bool right = true;
    for (int repeat = 0; repeat < 100; ++repeat)
    {
        const std::vector<Eigen::Isometry3d> poses =
            linkPoses(tower(), Eigen::Isometry3d::Identity(), positions);
        const Eigen::Isometry3d tip = poses[0].inverse() * poses[2];
        right &= std::abs(tip.translation().z() - 2.75) < 1e-12;
    }
    return expect(right, "poses of links");
}

/// Structures with poses, alone and in a vector of the program's. Ball i is i metres farther from
/// the wall than ball 0.
bool contactsAreRight()
{
    const SsvTree ball = buildSsvTree(makeSphere(0.5, 3));
    const SsvTree wall = buildSsvTree(makeBox({0.5, 5.0, 5.0}));
    const ToiOptions options{.tolerance = 1e-6};
    ToiWorkspace work;
    std::vector<MovingBody> bodies{movingBody({.tree = &wall})};
    bool right = true;
    for (std::int32_t i = 0; i < 9; ++i)
    {
        RigidBody body{.tree = &ball};
        body.motion.X_W0.translation().x() = -2.0 - i;
        body.motion.v_W.x() = 20.0;
        const double expected = (1.0 + i) / 20.0;
        const ToiResult alone = rigidToi(body, {.tree = &wall}, options, work);
        right &= alone.status == ToiStatus::Hit && std::abs(alone.time - expected) < 1e-3;

        bodies.push_back(movingBody(body));
        const std::vector<BodyPair> last{{.bodyA = i + 1, .bodyB = 0}};
        right &= firstContact(bodies, last, options, work).time == alone.time;
    }
    return expect(right, "times of impact");
}

/// Two fingers hold a weight W by friction mu: their normal forces sum to W / mu.
bool forcesAreRight()
{
    constexpr double kWeight = 2.0;
    grasp::ForceProblem problem;
    problem.contacts = {{.link = 1, .point = {0.05, 0.0, 0.0}, .normal = {-1.0, 0.0, 0.0}},
                        {.link = 2, .point = {-0.05, 0.0, 0.0}, .normal = {1.0, 0.0, 0.0}}};
    problem.load << 0.0, 0.0, -kWeight, 0.0, 0.0, 0.0;
    const KinematicTree tree = tower();
    const std::vector<double> positions(3, 0.0);
    problem.jacobian =
        grasp::handJacobian(tree, Eigen::Isometry3d::Identity(), positions, problem.contacts);
    problem.torqueLimits = grasp::effortLimits(tree);
    const grasp::GraspForces forces = grasp::solveGraspForces(problem);
    return expect(forces.status == grasp::ForceStatus::Balanced &&
                      std::abs(forces.value - kWeight / problem.law.friction) < 1e-6 &&
                      forces.jointTorques.size() == 2,
                  "forces of a pinch");
}
}  // namespace

int main()
{
    const bool poses = posesAreRight();
    const bool contacts = contactsAreRight();
    const bool forces = forcesAreRight();
    return poses && contacts && forces ? 0 : 1;
}
