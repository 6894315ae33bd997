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

/// Corners of the difference polygons of some lanes, the first N at the start, the others at the
/// end.
template <int N>
inline void loadCorners(const FeatureBatch& batch, int first, Vectors* q)
{
    Vectors x[2][4] = {};
    for (int k = 0; k < 4; ++k)
    {
        for (int i = 0; i < kWidth; ++i)
        {
            const VertexStep& v = *batch.vertex[k][first + i];
            x[0][k].x[i] = v.start[0];
            x[0][k].y[i] = v.start[1];
            x[0][k].z[i] = v.start[2];
            x[1][k].x[i] = v.end[0];
            x[1][k].y[i] = v.end[1];
            x[1][k].z[i] = v.end[2];
        }
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
    Lanes largest = {};
    for (int k = 0; k < kPoints; ++k)
    {
        largest = larger(largest, larger(q[k].x, -q[k].x));
        largest = larger(largest, larger(q[k].y, -q[k].y));
        largest = larger(largest, larger(q[k].z, -q[k].z));
    }
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
        Vectors lowest = q[0];
        for (int k = 1; k < kPoints; ++k)
        {
            const Lanes d = dot(v, q[k]);
            const Mask isLower = d < low;
            low = isLower ? d : low;
            lowest.x = isLower ? q[k].x : lowest.x;
            lowest.y = isLower ? q[k].y : lowest.y;
            lowest.z = isLower ? q[k].z : lowest.z;
        }
        done |= bitsOf((low > 0.0) & (low * low > marginSquared * dot(v, v)));
        if (done == kAll)
        {
            return done;
        }
        const Vectors back = v - lowest;
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
