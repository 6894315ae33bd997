/// Two arms with a hand each, as one robot.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/hand/hand_model.h"
#include "grasp/task/arm_robot.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// An arm with its hand, where it stands. What is referred to must outlive the two arms.
struct PlacedArm
{
    const HandModel* hand = nullptr;
    const ArmRobot* robot = nullptr;
    Eigen::Isometry3d X_WR = Eigen::Isometry3d::Identity();  ///< its root
};

/// The two as one hand whose root rests in W and whose fingers are those of both: so all that asks
/// or moves a hand, such as squeezeOf() and the simulation, takes both with their arms.
struct TwoArms
{
    std::array<PlacedArm, 2> arms;      ///< left, right
    std::array<std::int32_t, 2> first;  ///< link i of arm k is link first[k] + i of `whole`
    HandModel whole;
    /// One entry per independent joint of `whole` [N m or N]: of the hands jointEfforts(), of the
    /// arms what the URDF states, or kUsualTorque or kUsualForce.
    std::vector<double> efforts;

    [[nodiscard]] std::int32_t linkOf(std::size_t arm, std::int32_t link) const
    {
        return first[arm] + link;
    }
    [[nodiscard]] std::int32_t handRoot(std::size_t arm) const
    {
        return linkOf(arm, arms[arm].robot->handRoot);
    }
    /// The links below the joints of both arms.
    [[nodiscard]] std::vector<std::int32_t> joints() const;
    /// Positions of all links from those of the arms' joints and of the hands' links.
    [[nodiscard]] std::vector<double> positions(
        const std::array<std::vector<double>, 2>& joints,
        const std::array<std::vector<double>, 2>& hands) const;
};

/// Joins them. Names of links and joints get the prefixes before them; those of the roots get
/// "left_" and "right_" whatever these are. Every link of one arm is tested against every link of
/// the other.
[[nodiscard]] BULLET_CCD_API TwoArms joinArms(const std::array<PlacedArm, 2>& arms,
                                              const std::array<std::string, 2>& prefixes = {
                                                  "left_", "right_"});
}  // namespace bullet_ccd::grasp
