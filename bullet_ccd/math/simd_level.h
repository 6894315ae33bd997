/// Which instructions the kernels that are compiled several times may use.
#pragma once

namespace bullet_ccd
{
/// Each can do what those before it can.
enum class SimdLevel
{
    Baseline,  ///< what the library is compiled for
    Avx2,      ///< AVX2 and FMA, with BMI and POPCNT
    Avx512,    ///< F, BW, DQ and VL
};

/// What this processor can run.
[[nodiscard]] SimdLevel processorSimdLevel();

/// The same, or less where BULLET_CCD_SIMD in the environment says `baseline` or `avx2`. It is read
/// at every call: who asks often keeps the answer.
[[nodiscard]] SimdLevel simdLevel();
}  // namespace bullet_ccd
