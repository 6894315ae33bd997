// Whether there is a kernel for two boxes.
#include "bullet_ccd/convex/kernels/moving_boxes.h"

#include <cstdlib>
#include <cstring>

namespace bullet_ccd
{
#if defined(BULLET_CCD_AVX2)
namespace avx2
{
BoxKernel meetingOfBoxes;
}

BoxKernel* boxKernel()
{
    static BoxKernel* const chosen = []() -> BoxKernel*
    {
        const char* wish = std::getenv("BULLET_CCD_SIMD");
        const bool isBaselineWanted = wish != nullptr && std::strcmp(wish, "baseline") == 0;
        __builtin_cpu_init();  // this may run before the constructor that the compiler has for it
        const bool isAble = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
        return isAble && !isBaselineWanted ? avx2::meetingOfBoxes : nullptr;
    }();
    return chosen;
}
#else
BoxKernel* boxKernel()
{
    return nullptr;
}
#endif
}  // namespace bullet_ccd
