/// The few vector operations that the kernels need, for the instruction set that the including file
/// is compiled for. Everything is in an unnamed namespace: copies of one function for several
/// instruction sets must never be merged by the linker.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace bullet_ccd
{
namespace
{
using Doubles4 = double __attribute__((vector_size(32)));
using Longs4 = long long __attribute__((vector_size(32)));

#if defined(__AVX2__)

constexpr int kWidth = 8;
using Floats = float __attribute__((vector_size(32)));
using Bits = int __attribute__((vector_size(32)));

inline Floats maximum(Floats a, Floats b)
{
    return _mm256_max_ps(a, b);
}
inline Floats minimum(Floats a, Floats b)
{
    return _mm256_min_ps(a, b);
}
// No approximate reciprocals: processors of different makers give different ones.
inline Floats root(Floats a)
{
    return _mm256_sqrt_ps(a);
}
inline Floats load(const float* p)
{
    return _mm256_load_ps(p);
}
inline void store(float* p, Floats a)
{
    _mm256_store_ps(p, a);
}

/// As many doubles as a Floats has lanes; wider vectors than the machine's would be taken apart.
struct Doubles
{
    Doubles4 low, high;
};
/// f applied to all lanes.
template <class Function, class... Arguments>
inline Doubles each(Function&& f, const Arguments&... x)
{
    return {f(x.low...), f(x.high...)};
}
inline Doubles loadDoubles(const double* p)
{
    return {_mm256_loadu_pd(p), _mm256_loadu_pd(p + 4)};
}
inline Floats toFloats(const Doubles& x)
{
    return _mm256_set_m128(_mm256_cvtpd_ps(x.high), _mm256_cvtpd_ps(x.low));
}

/// Transposes eight floats of each of eight nodes.
inline void loadTransposed(const float* const* rows, int offset, Floats* out)
{
    __m256 r[8];
    for (int i = 0; i < 8; ++i)
    {
        r[i] = _mm256_load_ps(rows[i] + offset);
    }
    __m256 t[8];
    for (int i = 0; i < 4; ++i)
    {
        t[2 * i] = _mm256_unpacklo_ps(r[2 * i], r[2 * i + 1]);
        t[2 * i + 1] = _mm256_unpackhi_ps(r[2 * i], r[2 * i + 1]);
    }
    __m256 s[8];
    for (int i = 0; i < 2; ++i)
    {
        s[4 * i] = _mm256_shuffle_ps(t[4 * i], t[4 * i + 2], 0x44);
        s[4 * i + 1] = _mm256_shuffle_ps(t[4 * i], t[4 * i + 2], 0xee);
        s[4 * i + 2] = _mm256_shuffle_ps(t[4 * i + 1], t[4 * i + 3], 0x44);
        s[4 * i + 3] = _mm256_shuffle_ps(t[4 * i + 1], t[4 * i + 3], 0xee);
    }
    for (int i = 0; i < 4; ++i)
    {
        out[i] = _mm256_permute2f128_ps(s[i], s[i + 4], 0x20);
        out[i + 4] = _mm256_permute2f128_ps(s[i], s[i + 4], 0x31);
    }
}

#else

constexpr int kWidth = 4;
using Floats = float __attribute__((vector_size(16)));
using Bits = int __attribute__((vector_size(16)));

inline Floats load(const float* p)
{
    return Floats{p[0], p[1], p[2], p[3]};
}
inline void store(float* p, Floats a)
{
    for (int i = 0; i < kWidth; ++i)
    {
        p[i] = a[i];
    }
}
#if defined(__SSE2__)
inline Floats maximum(Floats a, Floats b)
{
    return _mm_max_ps(a, b);
}
inline Floats minimum(Floats a, Floats b)
{
    return _mm_min_ps(a, b);
}
inline Floats root(Floats a)
{
    return _mm_sqrt_ps(a);
}
#else
inline Floats maximum(Floats a, Floats b)
{
    return a > b ? a : b;
}
inline Floats minimum(Floats a, Floats b)
{
    return a < b ? a : b;
}
inline Floats root(Floats a)
{
    Floats r;
    for (int i = 0; i < kWidth; ++i)
    {
        r[i] = __builtin_sqrtf(a[i]);
    }
    return r;
}
#endif

using Doubles = Doubles4;
template <class Function, class... Arguments>
inline Doubles each(Function&& f, const Arguments&... x)
{
    return f(x...);
}
inline Doubles loadDoubles(const double* p)
{
    return Doubles{p[0], p[1], p[2], p[3]};
}
inline Floats toFloats(const Doubles& x)
{
    return __builtin_convertvector(x, Floats);
}

/// Transposes eight floats of each of four nodes.
inline void loadTransposed(const float* const* rows, int offset, Floats* out)
{
    for (int half = 0; half < 8; half += 4)
    {
        const Floats r0 = load(rows[0] + offset + half);
        const Floats r1 = load(rows[1] + offset + half);
        const Floats r2 = load(rows[2] + offset + half);
        const Floats r3 = load(rows[3] + offset + half);
        const Floats t0 = __builtin_shuffle(r0, r1, Bits{0, 4, 1, 5});
        const Floats t1 = __builtin_shuffle(r2, r3, Bits{0, 4, 1, 5});
        const Floats t2 = __builtin_shuffle(r0, r1, Bits{2, 6, 3, 7});
        const Floats t3 = __builtin_shuffle(r2, r3, Bits{2, 6, 3, 7});
        out[half] = __builtin_shuffle(t0, t1, Bits{0, 1, 4, 5});
        out[half + 1] = __builtin_shuffle(t0, t1, Bits{2, 3, 6, 7});
        out[half + 2] = __builtin_shuffle(t2, t3, Bits{0, 1, 4, 5});
        out[half + 3] = __builtin_shuffle(t2, t3, Bits{2, 3, 6, 7});
    }
}

#endif

inline Doubles4 root(Doubles4 x)
{
#if defined(__AVX2__)
    return _mm256_sqrt_pd(x);
#else
    Doubles4 r;
    for (int i = 0; i < 4; ++i)
    {
        r[i] = __builtin_sqrt(x[i]);
    }
    return r;
#endif
}

inline Floats absolute(Floats x)
{
    return (Floats)((Bits)x & 0x7fffffff);
}

/// x with its sign turned where d is negative.
inline Floats alongSign(Floats x, Floats d)
{
    return (Floats)((Bits)x ^ ((Bits)d & (Bits{} + static_cast<int>(0x80000000U))));
}

/// Root of x >= 0 for an x that a few operations have rounded: not below the exact one, and at most
/// 1e-6 above it.
inline Floats rootAbove(Floats x)
{
    return root(x) * 1.000001F;
}
}  // namespace
}  // namespace bullet_ccd
