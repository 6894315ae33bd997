/// What is measured of one hand and one object: rows of the log.
#pragma once

#include "grasp/planner/grasp_planner.h"
#include "tools/grasp_cli/inputs/catalogue.h"

#include <nlohmann/json_fwd.hpp>

namespace bullet_ccd::benchmarks
{
enum class ClosingReference : std::uint8_t
{
    Sweep,      ///< the discrete baseline in steps of 0.001 rad
    Simulated,  ///< the engine on Bullet's multibody world
};
[[nodiscard]] const char* toString(ClosingReference reference);

/// Samples candidates, closes each where its approach meets the object by the kinematic engine and
/// by the reference, and looks at both: what is inside something, how wide stops gape, and which is
/// right where they differ. Joints may differ by 0.02 rad from the sweep; by 0.01 rad, and not in
/// the links that are stopped, from the simulation.
/// @return a row of the log
[[nodiscard]] nlohmann::json judgeClosings(const tools::LoadedHand& hand,
                                           const tools::LoadedObject& object,
                                           ClosingReference reference,
                                           const grasp::PlannerOptions& options);

/// Plans grasps: how many of the candidates are force closures, the best epsilon, the time, and the
/// reasons of the rejected ones.
/// @return a row of the log
[[nodiscard]] nlohmann::json judgePlans(const tools::LoadedHand& hand,
                                        const tools::LoadedObject& object,
                                        const grasp::PlannerOptions& options);
}  // namespace bullet_ccd::benchmarks
