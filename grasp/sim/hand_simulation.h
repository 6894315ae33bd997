/// The hand as a btMultiBody in a CCD world (double precision).
#pragma once

#include "grasp/closing/closing.h"

#include <memory>

namespace bullet_ccd::grasp
{
/// Closes the hand as staged simulation steps in Bullet's multibody world: the closing joints are
/// driven at constant speed by velocity motors, the world advances to the first contact of any link
/// with the object or another link, that link and the joints between it and the palm are frozen,
/// and the next stage begins. The object is fixed. An object of this class keeps the world of one
/// hand and object and can close many times; one per thread.
class HandSimulation
{
public:
    HandSimulation(const HandModel& hand, const GraspObject& object);
    ~HandSimulation();
    HandSimulation(HandSimulation&&) noexcept;
    HandSimulation& operator=(HandSimulation&&) noexcept;

    /// See CloseHand for the contract.
    [[nodiscard]] ClosingResult close(const Eigen::Isometry3d& X_WH,
                                      const std::vector<double>& positions,
                                      const ClosingOptions& options);

private:
    struct World;
    std::unique_ptr<World> m_world;
};
}  // namespace bullet_ccd::grasp
