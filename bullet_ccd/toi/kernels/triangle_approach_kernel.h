/// The SIMD kernel behind approachTriangles(); included once for each instruction set, like
/// node_batch_kernel.h. Lanes are corners or edges of one triangle, the fourth repeats the third.
#pragma once

#include "bullet_ccd/toi/kernels/simd.h"
#include "bullet_ccd/toi/kernels/triangle_approach.h"

namespace bullet_ccd::BULLET_CCD_ISA
{
namespace
{
struct Vector4
{
    Doubles4 x, y, z;
};
inline Vector4 operator+(const Vector4& a, const Vector4& b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vector4 operator-(const Vector4& a, const Vector4& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vector4 operator*(Doubles4 s, const Vector4& a)
{
    return {s * a.x, s * a.y, s * a.z};
}
inline Doubles4 dot(const Vector4& a, const Vector4& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vector4 cross(const Vector4& a, const Vector4& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vector4 splat(const double* v)
{
    return {Doubles4{} + v[0], Doubles4{} + v[1], Doubles4{} + v[2]};
}
inline Vector4 lane(const Vector4& a, int i)
{
    return {Doubles4{} + a.x[i], Doubles4{} + a.y[i], Doubles4{} + a.z[i]};
}
inline Vector4 select(Longs4 take, const Vector4& a, const Vector4& b)
{
    return {take ? a.x : b.x, take ? a.y : b.y, take ? a.z : b.z};
}
inline Doubles4 clamp01(Doubles4 x)
{
    const Doubles4 zero{};
    const Doubles4 atLeast = x > zero ? x : zero;  // NaN becomes 0
    return atLeast < 1.0 ? atLeast : zero + 1.0;
}
inline Doubles4 orOne(Doubles4 x)
{
    return x > 0.0 ? x : Doubles4{} + 1.0;
}
inline double smallest(Doubles4 x)
{
    const double a = x[0] < x[1] ? x[0] : x[1];
    const double b = x[2] < x[3] ? x[2] : x[3];
    return a < b ? a : b;
}

inline Vector4 loadCorners(const double* c)
{
    return {Doubles4{c[0], c[3], c[6], c[6]},
            Doubles4{c[1], c[4], c[7], c[7]},
            Doubles4{c[2], c[5], c[8], c[8]}};
}
/// The next corner in each lane.
inline Vector4 next(const Vector4& c)
{
    constexpr Longs4 kNext{1, 2, 0, 0};
    return {__builtin_shuffle(c.x, kNext),
            __builtin_shuffle(c.y, kNext),
            __builtin_shuffle(c.z, kNext)};
}

/// The corners with their motion.
struct MovingCorners
{
    Vector4 place;
    Vector4 velocity;
    Doubles4 constant;  ///< acceleration in any direction
    Doubles4 bend;      ///< acceleration, times |u x n|
};

inline MovingCorners moveA(const RelativeMotion& m, const double* corners)
{
    const Vector4 x = loadCorners(corners);
    const Vector4 c = x + splat(m.armA);
    const double* R = m.R;
    const Vector4 arm{R[0] * c.x + R[1] * c.y + R[2] * c.z,
                      R[3] * c.x + R[4] * c.y + R[5] * c.z,
                      R[6] * c.x + R[7] * c.y + R[8] * c.z};
    const Vector4 orbit = cross(splat(m.wA), arm);
    MovingCorners out;
    out.place = arm + splat(m.p);
    out.velocity = splat(m.velocity) + orbit;
    const Vector4 r = x + splat(m.radiusArmA);
    out.constant = m.constant + m.perRadiusA * root(dot(r, r));
    out.bend = m.axisA * m.spinA * root(dot(orbit, orbit));
    return out;
}

inline MovingCorners moveB(const RelativeMotion& m, const double* corners)
{
    const Vector4 x = loadCorners(corners);
    const Vector4 r = x + splat(m.armB);
    const Vector4 orbit = cross(splat(m.wB), r);
    return {.place = x,
            .velocity = orbit,
            .constant = m.perRadiusB * root(dot(r, r)),
            .bend = m.axisB * m.spinB * root(dot(orbit, orbit))};
}

/// |u x n| for w = spin u, never too small.
inline double across(const double* w, double spin, const double* n)
{
    if (!(spin > 0.0))
    {
        return 0.0;
    }
    const double x = w[1] * n[2] - w[2] * n[1];
    const double y = w[2] * n[0] - w[0] * n[2];
    const double z = w[0] * n[1] - w[1] * n[0];
    return __builtin_sqrt(x * x + y * y + z * z) / spin * (1.0 + 1e-14) + 1e-15;
}

/// How much of an acceleration in the plane is along n: |n x u|, never too small.
inline double inPlane(const double* u, const double* n)
{
    if (u[0] == 0.0 && u[1] == 0.0 && u[2] == 0.0)
    {
        return 1.0;
    }
    return across(u, 1.0, n);
}

/// Every pair of corners has its own gap and speed along n.
inline void stepAlong(const RelativeMotion& m,
                      const MovingCorners& a,
                      const MovingCorners& b,
                      const double* direction,
                      double margin,
                      TriangleApproach& out)
{
    const Vector4 n = splat(direction);
    const double part = inPlane(m.plane, direction);
    const Doubles4 bendA =
        part * a.constant + across(m.wA, m.spinA, direction) * a.bend + m.acrossPlane;
    const Doubles4 bendB = part * b.constant + across(m.wB, m.spinB, direction) * b.bend;
    const Doubles4 heightA = dot(n, a.place);
    const Doubles4 speedA = dot(n, a.velocity);
    const Doubles4 heightB = dot(n, b.place);
    const Doubles4 speedB = dot(n, b.velocity);
    const bool turnsB = m.spinB > 0.0 || m.perRadiusB > 0.0;
    const double lowestB = smallest(heightB);
    const Doubles4 zero{};
    double gap = 1e300;
    double time = 1e300;
    for (int j = 0; j < (turnsB ? 3 : 1); ++j)
    {
        const Doubles4 gaps = (turnsB ? heightB[j] : lowestB) - heightA;
        const Doubles4 room = gaps - margin;
        const Doubles4 speed = turnsB ? speedA - speedB[j] : speedA;
        const Doubles4 bend = turnsB ? bendA + bendB[j] : bendA;
        // The root of speed s + bend s^2 / 2 = room, without cancellation on either side.
        const Doubles4 r = root(speed * speed + 2.0 * bend * (room > zero ? room : zero));
        const Doubles4 closing = 2.0 * room / (speed + r > 1e-290 ? speed + r : zero + 1e-290);
        const Doubles4 opening = bend > 1e-290 ? (r - speed) / bend : zero + 1e300;
        const Doubles4 times = room > zero ? (speed >= zero ? closing : opening) : zero;
        const double earliest = smallest(times);
        const double lowest = smallest(gaps);
        time = earliest < time ? earliest : time;
        gap = lowest < gap ? lowest : gap;
    }
    out.gap = gap;
    out.time = time;
}

/// Closest points found so far, in each lane.
struct Closest
{
    Doubles4 square;
    Vector4 onA, onB;

    void take(Doubles4 candidate, const Vector4& a, const Vector4& b)
    {
        const Longs4 nearer = candidate < square;
        square = nearer ? candidate : square;
        onA = select(nearer, a, onA);
        onB = select(nearer, b, onB);
    }
};

inline void takeEdges(const Vector4& a, const Vector4& b, Closest& best)
{
    const Vector4 alongA = next(a) - a;
    const Vector4 alongB = next(b) - b;
    const Doubles4 E = dot(alongB, alongB);
    const Doubles4 zero{};
    for (int i = 0; i < 3; ++i)
    {
        const Vector4 p = lane(a, i);
        const Vector4 u = lane(alongA, i);
        const Vector4 r = p - b;
        const Doubles4 A = dot(u, u);
        const Doubles4 B = dot(u, alongB);
        const Doubles4 C = dot(u, r);
        const Doubles4 F = dot(alongB, r);
        const Doubles4 determinant = A * E - B * B;
        Doubles4 s =
            clamp01((B * F - C * E) / (determinant > 1e-14 * A * E ? determinant : zero + 1e300));
        const Doubles4 t = clamp01((B * s + F) / orOne(E));
        s = clamp01((B * t - C) / orOne(A));
        const Vector4 onA = p + s * u;
        const Vector4 onB = b + t * alongB;
        const Vector4 d = onB - onA;
        best.take(dot(d, d), onA, onB);
    }
}

/// Corners of one triangle above the inside of the other. Their feet are convex combinations of its
/// corners, so they are points of it however small and wrong the normal of a sliver is: the
/// distance stays an upper bound.
template <bool kCornersOfA>
inline void takeFace(const Vector4& face, const Vector4& corners, Closest& best)
{
    const Vector4 origin = lane(face, 0);
    const Vector4 e0 = lane(face, 1) - origin;
    const Vector4 e1 = lane(face, 2) - origin;
    const Vector4 n = cross(e0, e1);
    const Doubles4 square = dot(n, n);
    const Vector4 d = corners - origin;
    const Doubles4 first = dot(cross(d, e1), n);
    const Doubles4 second = dot(cross(e0, d), n);
    const Doubles4 zero{};
    const Longs4 inside =
        (first >= zero) & (second >= zero) & (first + second <= square) & (square > 1e-280);
    const Doubles4 scale = 1.0 / (square > 1e-280 ? square : zero + 1.0);
    const Vector4 foot = origin + (first * scale) * e0 + (second * scale) * e1;
    const Vector4 away = corners - foot;
    const Doubles4 candidate = inside ? dot(away, away) : zero + 1e300;
    if constexpr (kCornersOfA)
    {
        best.take(candidate, corners, foot);
    }
    else
    {
        best.take(candidate, foot, corners);
    }
}

/// The direction perpendicular to two edges, or to a face, that is nearest to n. The vector between
/// closest points loses digits as they come together, and an error of the direction times the size
/// of the triangles is an error of the gap; edges and faces keep theirs.
inline void alignWithFeatures(const Vector4& a, const Vector4& b, double (&n)[3])
{
    const Vector4 alongA = next(a) - a;
    const Vector4 alongB = next(b) - b;
    const Vector4 target = splat(n);
    double bestScore = 0.0;
    double best[3] = {n[0], n[1], n[2]};
    for (int i = 0; i < 4; ++i)
    {
        // Three times an edge of A and those of B, then both faces.
        Vector4 c = cross(lane(alongA, i), alongB);
        if (i == 3)
        {
            const Vector4 faceA = cross(lane(alongA, 0), lane(alongA, 1));
            const Vector4 faceB = cross(lane(alongB, 0), lane(alongB, 1));
            c = select(Longs4{-1, -1, 0, 0}, faceA, faceB);
        }
        const Doubles4 square = dot(c, c);
        const Doubles4 along = dot(c, target);
        const Doubles4 score = square > 1e-280 ? along * along / orOne(square) : Doubles4{};
        for (int j = 0; j < 4; ++j)
        {
            if (score[j] > bestScore)
            {
                bestScore = score[j];
                const double scale = (along[j] < 0.0 ? -1.0 : 1.0) / __builtin_sqrt(square[j]);
                best[0] = scale * c.x[j];
                best[1] = scale * c.y[j];
                best[2] = scale * c.z[j];
            }
        }
    }
    n[0] = best[0];
    n[1] = best[1];
    n[2] = best[2];
}
}  // namespace

void approachTriangles(const RelativeMotion& motion,
                       const double* cornersA,
                       const double* cornersB,
                       double margin,
                       TriangleApproach& approach)
{
    const MovingCorners a = moveA(motion, cornersA);
    const MovingCorners b = moveB(motion, cornersB);
    Closest best{.square = Doubles4{} + 1e300, .onA = a.place, .onB = b.place};
    takeEdges(a.place, b.place, best);
    takeFace<true>(b.place, a.place, best);
    takeFace<false>(a.place, b.place, best);
    int at = 0;
    for (int i = 1; i < 4; ++i)
    {
        at = best.square[i] < best.square[at] ? i : at;
    }
    const Vector4& pA = best.onA;
    const Vector4& pB = best.onB;
    double n[3] = {pB.x[at] - pA.x[at], pB.y[at] - pA.y[at], pB.z[at] - pA.z[at]};
    const double distance = __builtin_sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    approach.pointA[0] = pA.x[at];
    approach.pointA[1] = pA.y[at];
    approach.pointA[2] = pA.z[at];
    approach.pointB[0] = pB.x[at];
    approach.pointB[1] = pB.y[at];
    approach.pointB[2] = pB.z[at];
    approach.distance = distance;
    if (!(distance > 1e-150))
    {
        approach.gap = 0.0;
        approach.time = 0.0;
        return;
    }
    for (double& x : n)
    {
        x /= distance;
    }
    stepAlong(motion, a, b, n, margin, approach);
    // Above a minimum separation that is large beside what is left, less of the distance counts.
    if (approach.gap < 0.999 * distance || approach.gap - margin < 0.5 * (distance - margin))
    {
        TriangleApproach aligned = approach;
        alignWithFeatures(a.place, b.place, n);
        stepAlong(motion, a, b, n, margin, aligned);
        if (aligned.gap > approach.gap)
        {
            approach = aligned;
        }
    }
}

void approachAlong(const RelativeMotion& motion,
                   const double* cornersA,
                   const double* cornersB,
                   const double* n,
                   double margin,
                   TriangleApproach& approach)
{
    stepAlong(motion, moveA(motion, cornersA), moveB(motion, cornersB), n, margin, approach);
}
}  // namespace bullet_ccd::BULLET_CCD_ISA
