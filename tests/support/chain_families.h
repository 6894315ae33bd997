/// The scenes behind chain_queries.h.
#pragma once

#include "tests/support/chain_queries.h"
#include "tests/support/random.h"

namespace bullet_ccd::tests
{
[[nodiscard]] ArticulatedScene chainScene(ChainFamily family, int joints, Random& random);
}  // namespace bullet_ccd::tests
