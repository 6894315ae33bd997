/// The scenes behind soak_queries.h.
#pragma once

#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/reference/scenes/random.h"

namespace bullet_ccd::reference
{
/// A scene in units of about the size of its bodies; whoever asks for it scales and moves it.
struct SoakScene
{
    RigidScene scene = {};
    double scale = 1.0;
    double tolerance = 0.0;   ///< in the scene's units; 0: free to choose
    double separation = 0.0;  ///< minimum separation, in the scene's units
    double clearance = 1.0;   ///< tolerances around this one are the interesting ones
};

[[nodiscard]] SoakScene soakScene(SoakFamily family, Random& random);
}  // namespace bullet_ccd::reference
