/// Eight pairs of features at once: does one fixed direction keep them apart for the whole step?
/// The doubles of a register are the lanes. Included once per instruction set.
#pragma once

#include "bullet_ccd/deformable/kernels/surface_kernels.h"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace bullet_ccd
{
namespace
{
#if defined(__AVX512DQ__)
constexpr int kWidth = 8;
#elif defined(__AVX2__)
constexpr int kWidth = 4;
#else
constexpr int kWidth = 2;
#endif
using Lanes = double __attribute__((vector_size(8 * kWidth)));
using Mask = long long __attribute__((vector_size(8 * kWidth)));

struct Vectors
{
    Lanes x, y, z;
};

inline Lanes dot(const Vectors& a, const Vectors& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vectors operator-(const Vectors& a, const Vectors& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vectors operator*(const Lanes& s, const Vectors& a)
{
    return {s * a.x, s * a.y, s * a.z};
}
inline Vectors cross(const Vectors& a, const Vectors& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Lanes larger(const Lanes& a, const Lanes& b)
{
    return a > b ? a : b;
}
inline Lanes smaller(const Lanes& a, const Lanes& b)
{
    return a < b ? a : b;
}
inline unsigned bitsOf(const Mask& m)
{
#if defined(__AVX512DQ__)
    return _mm512_movepi64_mask((__m512i)m);
#elif defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_pd((__m256d)m));
#else
    unsigned bits = 0;
    for (int i = 0; i < kWidth; ++i)
    {
        bits |= m[i] != 0 ? 1U << i : 0U;
    }
    return bits;
#endif
}

/// Places of one vertex of some lanes, at the start and at the end: a vertex fills a few registers,
/// which are transposed.
inline void loadVertices(const VertexStep* const* vertex, Vectors& start, Vectors& end)
{
#if defined(__AVX512DQ__)
    constexpr __mmask8 kAll = 0xFF;  // GCC 12 takes the forms without a mask for uninitialised
    __m512d low[4];                  // x and z of two vertices, at both ends
    __m512d high[4];                 // y
    for (int i = 0; i < 4; ++i)
    {
        const __m512d a = _mm512_load_pd(vertex[2 * i]->start);
        const __m512d b = _mm512_load_pd(vertex[2 * i + 1]->start);
        low[i] = _mm512_maskz_unpacklo_pd(kAll, a, b);
        high[i] = _mm512_maskz_unpackhi_pd(kAll, a, b);
    }
    constexpr int kEven = 0x88;
    constexpr int kOdd = 0xDD;
    const __m512d x0 = _mm512_maskz_shuffle_f64x2(kAll, low[0], low[1], kEven);
    const __m512d x1 = _mm512_maskz_shuffle_f64x2(kAll, low[2], low[3], kEven);
    const __m512d y0 = _mm512_maskz_shuffle_f64x2(kAll, high[0], high[1], kEven);
    const __m512d y1 = _mm512_maskz_shuffle_f64x2(kAll, high[2], high[3], kEven);
    const __m512d z0 = _mm512_maskz_shuffle_f64x2(kAll, low[0], low[1], kOdd);
    const __m512d z1 = _mm512_maskz_shuffle_f64x2(kAll, low[2], low[3], kOdd);
    start = {(Lanes)_mm512_maskz_shuffle_f64x2(kAll, x0, x1, kEven),
             (Lanes)_mm512_maskz_shuffle_f64x2(kAll, y0, y1, kEven),
             (Lanes)_mm512_maskz_shuffle_f64x2(kAll, z0, z1, kEven)};
    end = {(Lanes)_mm512_maskz_shuffle_f64x2(kAll, x0, x1, kOdd),
           (Lanes)_mm512_maskz_shuffle_f64x2(kAll, y0, y1, kOdd),
           (Lanes)_mm512_maskz_shuffle_f64x2(kAll, z0, z1, kOdd)};
#elif defined(__AVX2__)
    for (int e = 0; e < 2; ++e)
    {
        __m256d row[4];
        for (int i = 0; i < 4; ++i)
        {
            row[i] = _mm256_load_pd(e == 0 ? vertex[i]->start : vertex[i]->end);
        }
        const __m256d xz0 = _mm256_unpacklo_pd(row[0], row[1]);
        const __m256d xz1 = _mm256_unpacklo_pd(row[2], row[3]);
        const __m256d y0 = _mm256_unpackhi_pd(row[0], row[1]);
        const __m256d y1 = _mm256_unpackhi_pd(row[2], row[3]);
        (e == 0 ? start : end) = {(Lanes)_mm256_permute2f128_pd(xz0, xz1, 0x20),
                                  (Lanes)_mm256_permute2f128_pd(y0, y1, 0x20),
                                  (Lanes)_mm256_permute2f128_pd(xz0, xz1, 0x31)};
    }
#else
    for (int i = 0; i < kWidth; ++i)
    {
        const VertexStep& v = *vertex[i];
        start.x[i] = v.start[0];
        start.y[i] = v.start[1];
        start.z[i] = v.start[2];
        end.x[i] = v.end[0];
        end.y[i] = v.end[1];
        end.z[i] = v.end[2];
    }
#endif
}

/// Corners of the difference polygons of some lanes, the first N at the start, the others at the
/// end.
template <int N>
inline void loadCorners(const FeatureBatch& batch, int first, Vectors* q)
{
    Vectors x[2][4] = {};
    for (int k = 0; k < 4; ++k)
    {
        loadVertices(batch.vertex[k] + first, x[0][k], x[1][k]);
    }
    for (int end = 0; end < 2; ++end)
    {
        const Vectors* v = x[end];
        Vectors* p = q + end * N;
        if constexpr (N == 3)
        {
            p[0] = v[1] - v[0];
            p[1] = v[2] - v[0];
            p[2] = v[3] - v[0];
        }
        else
        {
            p[0] = v[2] - v[0];
            p[1] = v[3] - v[0];
            p[2] = v[3] - v[1];
            p[3] = v[2] - v[1];
        }
    }
    if (batch.until < 1.0)
    {
        const Lanes until = Lanes{} + batch.until;
        for (int k = 0; k < N; ++k)
        {
            const Vectors move = until * (q[N + k] - q[k]);
            q[N + k] = {q[k].x + move.x, q[k].y + move.y, q[k].z + move.z};
        }
    }
}

/// Lanes whose 2 N points are on one side of the origin, farther than the margin and the rounding
/// error, of which 64 u M is enough for one side (see the README of the room), along a direction
/// that is tried: three rounds of Gilbert's walk to the nearest point of their hull, from their
/// mean; then the planes of the polygon at both ends.
template <int N>
inline unsigned separatedLanes(const Vectors* q, double distance)
{
    constexpr int kPoints = 2 * N;
    constexpr unsigned kAll = (1U << kWidth) - 1;
    constexpr double kRounding = 192.0 * 1.1102230246251565e-16;
    Lanes lowest = {};
    Lanes highest = {};
    for (int k = 0; k < kPoints; ++k)
    {
        lowest = smaller(lowest, smaller(q[k].x, smaller(q[k].y, q[k].z)));
        highest = larger(highest, larger(q[k].x, larger(q[k].y, q[k].z)));
    }
    const Lanes largest = larger(highest, -lowest);
    const Lanes margin = largest * kRounding + (distance + 1e-300);
    const Lanes marginSquared = margin * margin * 1.000001;
    unsigned done = 0;
    Vectors v = q[0];
    for (int k = 1; k < kPoints; ++k)
    {
        v = {v.x + q[k].x, v.y + q[k].y, v.z + q[k].z};
    }
    v = (Lanes{} + 1.0 / kPoints) * v;
    for (int round = 0; round < 3; ++round)
    {
        Lanes low = dot(v, q[0]);
        Vectors point = q[0];
        for (int k = 1; k < kPoints; ++k)
        {
            const Lanes d = dot(v, q[k]);
            const Mask isLower = d < low;
            low = isLower ? d : low;
            point.x = isLower ? q[k].x : point.x;
            point.y = isLower ? q[k].y : point.y;
            point.z = isLower ? q[k].z : point.z;
        }
        done |= bitsOf((low > 0.0) & (low * low > marginSquared * dot(v, v)));
        if (done == kAll)
        {
            return done;
        }
        const Vectors back = v - point;
        const Lanes step = smaller(dot(v, back) / (dot(back, back) + 1e-300), Lanes{} + 1.0);
        v = v - step * back;
    }
    for (int end = 0; end < 2; ++end)
    {
        const Vectors* p = q + end * N;
        const Vectors n = cross(p[1] - p[0], p[N - 1] - p[0]);
        Lanes low = dot(n, q[0]);
        Lanes high = low;
        for (int k = 1; k < kPoints; ++k)
        {
            const Lanes d = dot(n, q[k]);
            low = smaller(low, d);
            high = larger(high, d);
        }
        const Lanes height = larger(low, -high);
        done |= bitsOf((height > 0.0) & (height * height > marginSquared * dot(n, n)));
        if (done == kAll)
        {
            return done;
        }
    }
    return done;
}

template <int N>
inline unsigned separated(const FeatureBatch& batch)
{
    unsigned done = 0;
    for (int first = 0; first < FeatureBatch::kLanes; first += kWidth)
    {
        Vectors q[2 * N];
        loadCorners<N>(batch, first, q);
        done |= separatedLanes<N>(q, batch.margin) << first;
    }
    return done;
}
}  // namespace

namespace BULLET_CCD_ISA
{
unsigned separatedVertexFaces(const FeatureBatch& batch)
{
    return separated<3>(batch);
}
unsigned separatedEdges(const FeatureBatch& batch)
{
    return separated<4>(batch);
}
}  // namespace BULLET_CCD_ISA
}  // namespace bullet_ccd
