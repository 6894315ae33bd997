/// A robot in a simulation whose joints follow a plan, pressed on by a squeeze.
#pragma once

#include "bullet_ccd/math/stop_condition.h"
#include "grasp/sim/trial_world.h"
#include "grasp/squeeze/squeeze.h"
#include "grasp/task/pick_place.h"

#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
inline constexpr double kSqueezeTime = 0.5;  ///< for which hands press before they lift [s]

/// Every independent joint has a position controller of limited effort. All that is referred to
/// must outlive it.
class DrivenRobot
{
public:
    /// Joints are as stiff as arms: full effort, that of the URDF or else kUsualTorque or
    /// kUsualForce, at an error of 0.02 rad or m.
    /// @param tree  of the hand that the world has
    /// @param up    unit vector against gravity, in the world's frame
    /// @param rate  steps per second
    DrivenRobot(TrialWorld& world,
                const KinematicTree& tree,
                const Eigen::Vector3d& up,
                double rate,
                StopCondition stop);

    /// The joint above the link presses as the squeeze's joint `j` does, and is as stiff.
    void pressBy(const Squeeze& squeeze, std::size_t j, std::size_t link);
    /// Is called 60 times a second.
    void onSample(std::function<void()> look) { m_look = std::move(look); }

    void follow(const TaskLeg& leg);
    void hold(const std::vector<double>& positions, double seconds);
    /// Half of the time the share of the squeeze changes, then it rests.
    void press(double from, double to, double seconds, const std::vector<double>& positions);

    [[nodiscard]] double seconds() const { return m_seconds; }  ///< since the beginning
    [[nodiscard]] bool isStopped() const { return m_isStopped; }

private:
    void step(const std::vector<double>& positions, const std::vector<double>& velocities);

    TrialWorld& m_world;
    const KinematicTree& m_tree;
    Eigen::Vector3d m_acceleration;
    double m_rate;
    StopCondition m_stop;
    std::function<void()> m_look;
    std::vector<std::int32_t> m_joints;
    std::vector<DriveSettings> m_drives;                    // one entry per link
    std::vector<std::pair<std::size_t, double>> m_pressed;  // links, and their squeeze as a way
    std::vector<double> m_offsets;                          // one entry per link
    double m_seconds = 0.0;
    double m_samples = 0.0;
    bool m_isStopped = false;
};

/// The smallest distance, at this moment, of two things that plans test: links that move, the
/// object, the bodies of the world and the pairs of links that the robot lists; or `least`, if that
/// is smaller [m].
/// @param robot      the hand that the world has
/// @param X_OR       pose of its root
/// @param obstacles  the bodies of the world, in their order
[[nodiscard]] double leastDistanceNow(const TrialWorld& world,
                                      const HandModel& robot,
                                      const Eigen::Isometry3d& X_OR,
                                      const SsvTree& object,
                                      std::span<const RigidBody> obstacles,
                                      double least);
}  // namespace bullet_ccd::grasp
