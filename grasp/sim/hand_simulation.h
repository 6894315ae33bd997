/// The hand as a btMultiBody in a CCD world (double precision).
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/closing/closing.h"

#include <memory>

namespace bullet_ccd::grasp
{
/// Closes the hand as staged simulation steps in Bullet's multibody world: the closing joints move
/// at constant speed (1 rad/s, prismatic ones 0.1 m/s; mimic joints at their multiple), the world
/// advances to the first contact of any link with the object or another link, that link and the
/// joints between it and the root stop, and the next stage begins. The object is fixed. One by one
/// (ClosingOptions::order), a finger begins at the first step after the one before it has stopped;
/// the rest of that step is not counted in the times of stops.
///
/// The joints are ideal servos: every stage is a full step of Bullet's world, but before positions
/// are integrated the joints' speeds are set to what is prescribed, so that neither inertia nor
/// motor strength can spoil the coupling of joints, and a
/// contact is found at its place to within the tolerance, however long the steps are. A joint that
/// mimics another and the joint that it mimics stop together, whichever of their links is stopped;
/// of a hand with one motor, all fingers stop at the first contact. At their limits joints stop
/// exactly.
///
/// An object of this class keeps the world of one hand and object and can close many times: a
/// result depends on the arguments of close() alone, to the bit. One per thread; objects in
/// different threads share nothing that is written.
class BULLET_CCD_API HandSimulation
{
public:
    /// Keeps references: both must outlive it, and their hierarchies must not move.
    HandSimulation(const HandModel& hand, const GraspObject& object);
    ~HandSimulation();
    HandSimulation(HandSimulation&&) noexcept;
    HandSimulation& operator=(HandSimulation&&) noexcept;

    /// See CloseHand for the contract. Status: Hit if a link was stopped, Separated if all joints
    /// reached their limits; Overlapping (nothing moved) if a link intersects the object or a link
    /// that it is paired with at the start; IterationLimit if a query gave up (positions: so far).
    /// Mimic joints start where the joints they follow want them, whatever `positions` says of
    /// them. Throws std::invalid_argument if `positions` has not one finite entry a link or the
    /// tolerance is not positive.
    [[nodiscard]] ClosingResult close(const Eigen::Isometry3d& X_WH,
                                      const std::vector<double>& positions,
                                      const ClosingOptions& options);

private:
    struct World;
    std::unique_ptr<World> m_world;
};

/// Closing engines for the planner: each makes a HandSimulation for the hand and object that it is
/// called with and keeps it until it is called with others. Hand and object must stay alive and
/// unchanged between calls with the same addresses.
[[nodiscard]] BULLET_CCD_API MakeCloseHand simulatedClosing();
}  // namespace bullet_ccd::grasp
