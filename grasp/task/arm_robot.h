/// An arm with a hand at its end, as one robot.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "grasp/hand/hand_model.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
/// The links of the arm come first; link i of the hand is link `handRoot` + i. It can be moved but
/// not copied, and refers to the hand, which must outlive it.
struct ArmRobot
{
    ArmRobot() = default;
    ArmRobot(ArmRobot&&) = default;
    ArmRobot& operator=(ArmRobot&&) = default;

    std::string name;
    KinematicTree tree;
    std::vector<std::unique_ptr<const SsvTree>> armTrees;
    std::vector<const SsvTree*> linkTrees;  ///< one entry per link; null without geometry
    std::int32_t handRoot = kNone;
    /// The links below the joints of the arm that move the hand, from the root to the hand.
    std::vector<std::int32_t> joints;
    /// Pairs of links that are tested: those of the hand, and all other pairs that neither are
    /// joined nor overlap at rest or in nearly all of a few hundred sampled postures.
    std::vector<std::pair<std::int32_t, std::int32_t>> selfPairs;

    [[nodiscard]] std::int32_t ofHand(std::int32_t link) const { return handRoot + link; }
};

/// Mounts the hand on a link of the arm.
///
/// Links and joints of the hand whose names the arm has, too, get "hand_" before them.
/// @param flange the link; empty: the last link of the only chain of the arm
/// @param X_FH   pose of the hand's root link in it
/// Throws std::invalid_argument for a link that the arm does not have, an arm whose chain to the
/// hand has no joint or one that follows another, and no name where there are several chains.
[[nodiscard]] BULLET_CCD_API ArmRobot mountHand(const RobotModel& arm,
                                                const HandModel& hand,
                                                const std::string& flange,
                                                const Eigen::Isometry3d& X_FH);

/// Arm and hand as one hand, with the fingers of `hand`, for what simulates and draws hands. It
/// refers to shapes of the robot.
[[nodiscard]] BULLET_CCD_API HandModel wholeRobot(const ArmRobot& robot, const HandModel& hand);

/// Positions of robot.joints: those that are named, else 0, or the limit next to it.
/// Throws std::invalid_argument for a name that no joint of the arm has, and a position that is not
/// within the limits of its joint.
[[nodiscard]] BULLET_CCD_API std::vector<double> startPositions(
    const ArmRobot& robot, std::span<const std::pair<std::string, double>> named);
}  // namespace bullet_ccd::grasp
