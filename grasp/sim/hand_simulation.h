/// The hand as a btMultiBody in a CCD world (double precision).
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/closing/closing.h"

#include <memory>

namespace bullet_ccd::grasp
{
/// Closes the hand in staged steps of Bullet's multibody world. The closing joints move at constant
/// speed (1 rad/s, prismatic ones 0.1 m/s, mimic joints at their multiple). The world advances to
/// the first contact of any link with the object or another link. That link stops, together with
/// the joints between it and the root, and the next stage begins. The object is fixed. If fingers
/// close one by one (ClosingOptions::order), a finger begins at the first step after the one before
/// it has stopped; the rest of that step is not counted in the times of stops.
///
/// The joints are ideal servos. Every stage is a full step of Bullet's world, but the speeds of the
/// joints are set to the prescribed ones before positions are integrated. So neither inertia nor
/// motor strength can spoil the coupling of joints, and a contact is found at its place to within
/// the tolerance, however long the steps are. A mimic joint and the joint that it follows stop
/// together, whichever of their links is stopped. So all fingers of a hand with one motor stop at
/// the first contact. Joints stop exactly at their limits.
///
/// An object of this class keeps the world of one hand and one object and can close many times.
/// Guarantee: a result depends on the arguments of close() alone, to the bit. Use one object per
/// thread; objects in different threads share nothing that is written.
class BULLET_CCD_API HandSimulation
{
public:
    /// Keeps references to both. They must outlive it, and their hierarchies must not be moved.
    HandSimulation(const HandModel& hand, const GraspObject& object);
    ~HandSimulation();
    HandSimulation(HandSimulation&&) noexcept;
    HandSimulation& operator=(HandSimulation&&) noexcept;

    /// Closes the hand. CloseHand states the contract.
    ///
    /// Status: Hit if a link was stopped; Separated if all joints reached their limits; Overlapping
    /// if a link intersects the object or a paired link at the start, and nothing moved;
    /// IterationLimit if a query gave up, with the positions reached so far. Mimic joints start
    /// where the joints that they follow put them, whatever `positions` says.
    /// Throws std::invalid_argument if `positions` does not have one finite entry per link, or if
    /// the tolerance is not positive.
    [[nodiscard]] ClosingResult close(const Eigen::Isometry3d& X_WH,
                                      const std::vector<double>& positions,
                                      const ClosingOptions& options);

private:
    struct World;
    std::unique_ptr<World> m_world;
};

/// Closing engines for the planner. Each makes a HandSimulation for the hand and object that it is
/// called with, and keeps it until it is called with others.
/// @pre hand and object stay alive and unchanged between calls with the same addresses
[[nodiscard]] BULLET_CCD_API MakeCloseHand simulatedClosing();
}  // namespace bullet_ccd::grasp
