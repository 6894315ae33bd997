// Whether there is a kernel for two boxes.
#include "bullet_ccd/convex/kernels/moving_boxes.h"

#include "bullet_ccd/math/simd_level.h"

namespace bullet_ccd
{
#if defined(BULLET_CCD_AVX2)
namespace avx2
{
BoxKernel meetingOfBoxes;
}

BoxKernel* boxKernel()
{
    static BoxKernel* const chosen =
        simdLevel() >= SimdLevel::Avx2 ? avx2::meetingOfBoxes : nullptr;
    return chosen;
}
#else
BoxKernel* boxKernel()
{
    return nullptr;
}
#endif
}  // namespace bullet_ccd
