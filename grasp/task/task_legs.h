/// Motions of a robot in time, and their certificates.
#pragma once

#include "grasp/task/joint_path.h"
#include "grasp/task/pick_place.h"

#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// Obstacles by name, and the environment made of them.
struct NamedSurroundings
{
    std::vector<RigidBody> bodies;
    std::vector<std::string> names;
    Environment environment;

    void add(const SsvTree& tree, const Eigen::Isometry3d& X_W, const std::string& name);
    void finish() { environment.reset(bodies); }
};

/// The robot, with or without the object in its hand, as a body of queries.
struct RobotBody
{
    KinematicTree tree;
    std::vector<const SsvTree*> linkTrees;
    std::vector<std::pair<std::int32_t, std::int32_t>> selfPairs;

    explicit RobotBody(const ArmRobot& robot);
    /// Fixes the object to the hand, as one more link, which is tested against the arm.
    void carry(const ArmRobot& robot, const GraspObject& object, const Eigen::Isometry3d& X_HO);
    [[nodiscard]] ArticulatedBody body() const
    {
        return {.tree = &tree, .linkTrees = linkTrees, .motion = nullptr, .selfPairs = selfPairs};
    }
};

/// Waypoints at rest through the positions (one entry per link each), as fast as the limits allow;
/// positions that repeat are left out. The first is at `begin` [s].
[[nodiscard]] std::vector<Waypoint> timedWaypoints(
    const KinematicTree& tree,
    const std::vector<std::vector<double>>& positions,
    double begin,
    const PickPlaceOptions& options);

/// Nearer than this nothing comes on a certified leg [m].
inline constexpr double kLegTolerance = 1e-6;

/// Certifies the leg and fills in its clearance. Returns what is touched, or nothing.
/// @param X_WR   pose of the root
/// @param margin so near nothing comes, beside the tolerance; what is nearer at the start may stay
[[nodiscard]] std::string certifyLeg(const RobotBody& body,
                                     const Eigen::Isometry3d& X_WR,
                                     const NamedSurroundings& around,
                                     TaskLeg& leg,
                                     double margin,
                                     ToiWorkspace& work);
}  // namespace bullet_ccd::grasp
