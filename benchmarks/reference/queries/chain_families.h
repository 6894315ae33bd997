/// The scenes behind chain_queries.h.
#pragma once

#include "benchmarks/reference/queries/chain_queries.h"
#include "benchmarks/reference/scenes/random.h"

namespace bullet_ccd::reference
{
[[nodiscard]] ArticulatedScene chainScene(ChainFamily family, int joints, Random& random);
}  // namespace bullet_ccd::reference
