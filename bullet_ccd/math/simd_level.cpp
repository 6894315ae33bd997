#include "bullet_ccd/math/simd_level.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace bullet_ccd
{
SimdLevel processorSimdLevel()
{
#if defined(__x86_64__)
    __builtin_cpu_init();  // this may run before the constructor that the compiler has for it
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
        __builtin_cpu_supports("bmi") && __builtin_cpu_supports("popcnt"))
    {
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                       __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")
                   ? SimdLevel::Avx512
                   : SimdLevel::Avx2;
    }
#endif
    return SimdLevel::Baseline;
}

SimdLevel simdLevel()
{
    const char* text = std::getenv("BULLET_CCD_SIMD");
    const std::string_view wish = text != nullptr ? text : "";
    const SimdLevel most = wish == "baseline" ? SimdLevel::Baseline
                           : wish == "avx2"   ? SimdLevel::Avx2
                                              : SimdLevel::Avx512;
    return std::min(most, processorSimdLevel());
}
}  // namespace bullet_ccd
