// Pushes a trajectory of an arm out of an obstacle along the gradients that a contact manager
// gives, as planners do that optimise trajectories. The cost is half the sum of max(0, wanted -
// d)^2 over all contacts, and a share of the squared second differences of the waypoints. The ends
// stay.
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/trajectory/contact_manager.h"
#include "bullet_ccd/trajectory/trajectory.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cstdio>
#include <future>

using namespace bullet_ccd;
using Eigen::Index;

namespace
{
constexpr Index kWaypoints = 11;
constexpr double kMargin = 0.02;   // what the trajectory has to keep in the end [m]
constexpr double kWanted = 0.025;  // what contacts push for: smoothness takes a part of it [m]
constexpr double kSmooth = 1e-3;   // share of the second differences [m^2/rad^2]

using Path = Eigen::MatrixXd;  // a row for each link's joint, a column for each waypoint

Trajectory trajectoryOf(const KinematicTree& arm, const Path& path)
{
    std::vector<Waypoint> waypoints;
    for (Index k = 0; k < path.cols(); ++k)
    {
        waypoints.push_back({double(k), {path.col(k).data(), path.col(k).data() + path.rows()}});
    }
    return trajectoryThrough(arm, Eigen::Isometry3d::Identity(), waypoints);
}

// Contacts of one segment: its links go straight from pose to pose, nearly as the joints move them.
std::vector<ManagedContact> contactsOf(ContactManager manager,  // a copy, for this thread alone
                                       const KinematicTree& arm,
                                       const JointMotion& segment)
{
    for (std::size_t i = 0; i < arm.size(); ++i)
    {
        if (const std::string& name = arm.links[i].name; manager.hasObject(name))
        {
            const auto poseAt = [&](double t)
            { return linkStateAt(arm, segment, kNone, std::int32_t(i), t).X_W; };
            manager.setPoses(name, poseAt(0.0), poseAt(1.0));
        }
    }
    return manager.contacts();
}

// How the distance of a contact grows with each joint (entries of fixed joints mean nothing).
Eigen::VectorXd gradientOf(const ManagedContact& contact,
                           const KinematicTree& arm,
                           const JointMotion& segment)
{
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(Index(arm.size()));
    for (std::int32_t i = arm.findLink(contact.nameA); i != kNone;)
    {
        const Link& link = arm.links[std::size_t(i)];
        const Eigen::Isometry3d X_WL = linkStateAt(arm, segment, kNone, i, contact.time).X_W;
        const Eigen::Vector3d axis = X_WL.linear() * link.joint.axis;
        gradient(i) = -contact.normal.dot(axis.cross(contact.pointA - X_WL.translation()));
        i = link.parent;
    }
    return gradient;
}

// One step down the cost; returns how many contacts pushed.
std::size_t descend(const ContactManager& manager, const KinematicTree& arm, Path& path)
{
    const Trajectory trajectory = trajectoryOf(arm, path);
    std::vector<std::future<std::vector<ManagedContact>>> answers;
    for (const JointMotion& segment : trajectory.segments)
    {
        answers.push_back(std::async(contactsOf, manager, std::cref(arm), std::cref(segment)));
    }
    std::size_t count = 0;
    Path push = Path::Zero(path.rows(), path.cols());
    for (std::size_t k = 0; k < answers.size(); ++k)
    {
        for (const ManagedContact& contact : answers[k].get())
        {
            const Eigen::VectorXd step =
                (kWanted - contact.distance) * gradientOf(contact, arm, trajectory.segments[k]);
            push.col(Index(k)) += (1.0 - contact.time) * step;
            push.col(Index(k) + 1) += contact.time * step;
            ++count;
        }
    }
    Eigen::MatrixXd bends = Eigen::MatrixXd::Zero(kWaypoints - 2, kWaypoints);
    bends.diagonal().setOnes();
    bends.diagonal(1).setConstant(-2.0);
    bends.diagonal(2).setOnes();
    const Eigen::MatrixXd smooth = kSmooth * bends.transpose() * bends;
    push -= path * smooth;
    // The second derivatives of the cost, those of distances taken as 1 m^2/rad^2 a waypoint.
    const Index inner = kWaypoints - 2;
    const Eigen::MatrixXd hessian = smooth + Eigen::MatrixXd::Identity(kWaypoints, kWaypoints);
    path.middleCols(1, inner) += hessian.block(1, 1, inner, inner)
                                     .ldlt()
                                     .solve(push.middleCols(1, inner).transpose())
                                     .transpose();
    return count;
}
}  // namespace

int main(int argc, char** argv)
{
    const RobotModel robot = loadRobot(argc == 2 ? argv[1] : "robots/arms/seven_joint_arm.urdf");
    const KinematicTree& arm = robot.tree;
    const auto ball = std::make_shared<const SsvTree>(buildSsvTree(makeSphere(0.15, 4)));
    RigidBody obstacle{.tree = ball.get()};
    obstacle.motion.X_W0.translation() = Eigen::Vector3d(0.6, 0.0, 0.45);

    ContactManager manager;
    std::vector<std::string> moving;
    std::vector<std::shared_ptr<const SsvTree>> links(arm.size());
    for (std::size_t i = 1; i < arm.size(); ++i)
    {
        if (!robot.linkMeshes[i].triangles.empty())
        {
            links[i] = std::make_shared<const SsvTree>(buildSsvTree(robot.linkMeshes[i]));
            moving.push_back(arm.links[i].name);
            manager.addObject(moving.back(), links[i]);
        }
    }
    manager.addObject("ball", ball);
    manager.setMotion("ball", obstacle.motion);
    manager.setActiveObjects(moving);
    manager.setMargin(kWanted);
    manager.setAllowed([](const auto& a, const auto& b) { return a != "ball" && b != "ball"; });

    Path path =
        Path::Zero(Index(arm.size()), kWaypoints);  // reaching forward, it turns to the left
    path.row(arm.findJoint("shoulder_turn_joint")).setLinSpaced(-0.9, 0.9);
    path.row(arm.findJoint("shoulder_bend_joint")).setConstant(1.0);
    path.row(arm.findJoint("elbow_joint")).setConstant(-0.6);
    const auto certified = [&](double enough)  // of the motion of the joints, as a whole
    {
        std::vector<const SsvTree*> trees;
        std::transform(links.begin(),
                       links.end(),
                       std::back_inserter(trees),
                       [](const auto& link) { return link.get(); });
        std::vector<ToiWorkspace> work(1);
        return leastDistance({.tree = &arm, .linkTrees = trees, .selfPairs = {}},
                             std::span(&obstacle, 1),
                             trajectoryOf(arm, path),
                             {.tolerance = 1e-5, .enough = enough},
                             work);
    };
    const TrajectoryLeastDistance before = certified(1.0);
    std::printf("before: least distance %.4f m at t = %.3f\n", before.distance, before.seconds);
    int steps = 0;
    for (; steps < 200 && certified(kMargin + 1e-5).distance < kMargin; ++steps)
    {
        std::printf("step %d: %zu contacts\n", steps + 1, descend(manager, arm, path));
    }
    const TrajectoryLeastDistance after = certified(1.0);
    std::printf("after %d steps: %.4f m at t = %.3f\n", steps, after.distance, after.seconds);

    double sampled = kAnyDistance;  // by distances at fixed poses, which know nothing of motions
    const Trajectory trajectory = trajectoryOf(arm, path);
    for (int i = 0; i <= 1000 * (kWaypoints - 1); ++i)
    {
        const std::vector<Eigen::Isometry3d> X_WL =
            linkPoses(arm, Eigen::Isometry3d::Identity(), positionsAt(trajectory, 0.001 * i));
        for (std::size_t k = 0; k < arm.size(); ++k)
        {
            const Eigen::Isometry3d X_BL = obstacle.motion.X_W0.inverse() * X_WL[k];
            sampled = links[k] == nullptr ? sampled
                                          : treeDistance(*links[k], *ball, X_BL, sampled).distance;
        }
    }
    std::printf("least distance at 10,001 samples: %.4f m\n", sampled);
    return before.distance == 0.0 && after.distance >= kMargin && sampled >= after.distance ? 0 : 1;
}
