/// Motions of a robot in time, and their certificates.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/hand/hand_model.h"
#include "grasp/report/closing_spans.h"
#include "grasp/task/arm_kinematics.h"
#include "grasp/task/joint_path.h"
#include "grasp/task/pick_place.h"

#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// Obstacles by name, and the environment made of them.
struct BULLET_CCD_API NamedSurroundings
{
    std::vector<RigidBody> bodies;
    std::vector<std::string> names;
    Environment environment;

    void add(const SsvTree& tree, const Eigen::Isometry3d& X_W, const std::string& name);
    void finish() { environment.reset(bodies); }
};

/// The robot, with or without the object in its hand, as a body of queries.
struct BULLET_CCD_API RobotBody
{
    KinematicTree tree;
    std::vector<const SsvTree*> linkTrees;
    std::vector<std::pair<std::int32_t, std::int32_t>> selfPairs;

    explicit RobotBody(const ArmRobot& robot);
    /// Of a robot that is a hand as a whole (TwoArms).
    explicit RobotBody(const HandModel& robot);
    /// Fixes the object to the hand, as one more link, which is tested against the arm.
    void carry(const ArmRobot& robot, const GraspObject& object, const Eigen::Isometry3d& X_HO);
    /// Fixes the object to the link and tests it against the others named.
    void carry(std::int32_t link,
               const std::vector<std::int32_t>& tested,
               const GraspObject& object,
               const Eigen::Isometry3d& X_LO);
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

/// The arm from `start` along a straight line of the hand [W, m], in steps of 2 cm at most, as many
/// as the length of the line asks for, in each of which no joint jumps; empty if it cannot follow.
[[nodiscard]] std::vector<JointPositions> straightPath(const ArmKinematics& arm,
                                                       const JointPositions& start,
                                                       const Eigen::Vector3d& shift);

/// When a joint begins or ends, ascending, from 0 on [s].
[[nodiscard]] std::vector<double> closingTimes(const ClosingSpans& spans);
/// Positions of the hand at a time of its closing, at the end of which they are `closed`.
[[nodiscard]] std::vector<double> closingAt(const ClosingSpans& spans,
                                            const std::vector<double>& closed,
                                            double time);

/// Nearer than this nothing comes on a certified leg [m].
inline constexpr double kLegTolerance = 1e-6;

/// Certifies the leg. Returns what is touched, or nothing.
/// @param X_WR   pose of the root
/// @param margin so near nothing comes, beside the tolerance; what is nearer at the start may stay
[[nodiscard]] std::string touchedOnLeg(const RobotBody& body,
                                       const Eigen::Isometry3d& X_WR,
                                       const NamedSurroundings& around,
                                       const TaskLeg& leg,
                                       double margin,
                                       ToiWorkspace& work);

/// What an object that is lifted touches when the leg begins.
struct Parting
{
    std::vector<std::string> from;  ///< names of what it stands on, as far as that is near
    std::string objection;          ///< what is touched, or does not part; empty: certified
};

/// Certifies the first motion of a leg on which the object, the last link of `body`, begins in
/// contact with what it stands on. Of what is within `reach` [m] of the object then, the triangles
/// of both that are within `overlap` [m] of each other are not tested against each other until the
/// first waypoint; all else is. If nothing is that near, nothing is certified, and `from` is empty.
///
/// Guarantee, unless there is an objection: nothing else is touched, and each of these triangles of
/// the object rises at all times. When the motion begins, those of the other body reach no higher
/// than `overlap` above the lowest of them: they part across a level plane.
/// @pre overlap >= reach
[[nodiscard]] BULLET_CCD_API Parting certifyParting(const RobotBody& body,
                                                    const Eigen::Isometry3d& X_WR,
                                                    const NamedSurroundings& around,
                                                    const TaskLeg& leg,
                                                    double reach,
                                                    double overlap,
                                                    ToiWorkspace& work);

/// TaskLeg::clearance of a leg on which nothing is touched, which takes longer.
[[nodiscard]] double clearanceOf(const RobotBody& body,
                                 const Eigen::Isometry3d& X_WR,
                                 const NamedSurroundings& around,
                                 const TaskLeg& leg,
                                 ToiWorkspace& work);

/// Both: fills in the clearance of a leg on which nothing is touched.
[[nodiscard]] std::string certifyLeg(const RobotBody& body,
                                     const Eigen::Isometry3d& X_WR,
                                     const NamedSurroundings& around,
                                     TaskLeg& leg,
                                     double margin,
                                     ToiWorkspace& work);

/// Every leg begins when the one before it ends.
void followOn(std::vector<TaskLeg>& legs);
}  // namespace bullet_ccd::grasp
