/// The SIMD kernel behind nodeSteps() and rigidPoses(); included once for each instruction set, by
/// a file that defines BULLET_CCD_ISA as the namespace of its copy.
///
/// Reference: nodeStep() in pair_step.h does the same for one pair in double precision; a test
/// holds the two against each other. Rounding: every gap gives up `slack` before it is normalised
/// and every speed `speedSlack` (pair_scene.cpp says how much), so that what single precision
/// loses in between cannot make a step too long.
#pragma once

#include "bullet_ccd/toi/kernels/node_batch.h"
#include "bullet_ccd/toi/kernels/simd.h"

namespace bullet_ccd::BULLET_CCD_ISA
{
namespace
{
struct Vector
{
    Floats x, y, z;
};
inline Vector operator+(const Vector& a, const Vector& b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vector operator-(const Vector& a, const Vector& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Floats dot(const Vector& a, const Vector& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vector cross(const Vector& a, const Vector& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Number>
inline Vector all(const Number (&v)[3])
{
    return {Floats{} + static_cast<float>(v[0]),
            Floats{} + static_cast<float>(v[1]),
            Floats{} + static_cast<float>(v[2])};
}
inline Floats lengthAbove(const Vector& a)
{
    return rootAbove(dot(a, a));
}
inline Vector loadVector(const float (&v)[3][NodeBatch::kLanes], int lane)
{
    return {load(v[0] + lane), load(v[1] + lane), load(v[2] + lane)};
}

struct Rotation
{
    Floats m[9];
    Vector operator*(const Vector& v) const
    {
        return {m[0] * v.x + m[1] * v.y + m[2] * v.z,
                m[3] * v.x + m[4] * v.y + m[5] * v.z,
                m[6] * v.x + m[7] * v.y + m[8] * v.z};
    }
};

struct Volume
{
    Vector center;
    Vector axis[3];
    Floats half[3];
    Floats radius;
    Floats coreRadius;
};

inline Volume loadVolume(const SsvNode* const* nodes)
{
    const float* rows[kWidth];
    for (int i = 0; i < kWidth; ++i)
    {
        rows[i] = nodes[i]->center;
    }
    Floats f[16];
    loadTransposed(rows, 0, f);
    loadTransposed(rows, 8, f + 8);
    Volume v;
    v.center = {f[0], f[1], f[2]};
    v.axis[0] = {f[3], f[4], f[5]};
    v.axis[1] = {f[6], f[7], f[8]};
    v.axis[2] = cross(v.axis[0], v.axis[1]);
    v.half[0] = f[9];
    v.half[1] = f[10];
    v.half[2] = f[11];
    v.radius = f[12];
    v.coreRadius = f[13];
    return v;
}

/// What a pair does, apart from direction.
template <bool kTurnsB>
struct Motion
{
    Vector closing;       ///< velocity of A's center relative to B's
    Vector spinA, spinB;  ///< unit axes of rotation
    Floats turnA, turnB;  ///< speed of the core about its center, times |spin x n|
    Floats bendA, bendB;  ///< acceleration, times |spin x n|
    Floats constant;
    Floats margin, slack, speedSlack;
};

/// |u x n| = root(1 - (u.n)^2), never too small nor more than 1: single precision leaves an error
/// of 4e-6 in the square, which counts where u and n are almost parallel.
inline Floats across(Floats along)
{
    const Floats one = Floats{} + 1.0F;
    return minimum(rootAbove(maximum(one - along * along, Floats{}) + 4e-6F), one);
}

/// The longest step and the widest gap so far.
struct Best
{
    Floats step{};
    Floats gap{};
};

/// Everything that a direction contributes. `scale` normalises it: |n| scale <= 1, up to rounding.
template <bool kTurnsB>
inline void takeAxis(const Motion<kTurnsB>& m,
                     Best& best,
                     Floats distance,
                     Floats extent,
                     Floats speed,
                     Floats alongA,
                     Floats alongB,
                     Floats scale)
{
    const Floats zero{};
    const Floats gap = maximum((absolute(distance) - extent - m.slack) * scale - m.margin, zero);
    const Floats acrossA = across(alongA * scale);
    Floats closing = alongSign(speed * scale, distance) + m.speedSlack + m.turnA * acrossA;
    Floats bend = m.constant + m.bendA * acrossA;
    if constexpr (kTurnsB)
    {
        const Floats acrossB = across(alongB * scale);
        closing += m.turnB * acrossB;
        bend += m.bendB * acrossB;
    }
    // The root of closing s + bend s^2 / 2 = gap.
    const Floats root = rootAbove(closing * closing + 2.0F * bend * gap);
    const Floats step = 1.99999F * gap / maximum(closing + root, zero + 1e-30F);
    // In this order NaN, from motions that overflow, leaves what there was.
    best.step = maximum(step, best.step);
    best.gap = maximum(gap, best.gap);
}

template <bool kTurnsB>
inline void stepLanes(NodeBatch& batch, int lane)
{
    const Volume a = loadVolume(batch.a + lane);
    const Volume b = loadVolume(batch.b + lane);
    Rotation R;
    for (int i = 0; i < 9; ++i)
    {
        R.m[i] = load(batch.R[i] + lane);
    }
    const Vector arm = R * (a.center + loadVector(batch.armA, lane));
    const Vector D = b.center - arm - loadVector(batch.p, lane);
    const Vector wA = loadVector(batch.wA, lane);
    const Vector orbit = cross(wA, arm);
    const Floats rateA = load(batch.spinA + lane);
    const Floats inverseA = 1.0F / maximum(rateA, Floats{} + 1e-30F);

    Motion<kTurnsB> m;
    m.closing = loadVector(batch.velocity, lane) + orbit;
    m.spinA = {wA.x * inverseA, wA.y * inverseA, wA.z * inverseA};
    m.turnA = rateA * a.coreRadius;
    m.bendA = load(batch.axisA + lane) * rateA * (lengthAbove(orbit) + m.turnA) * 1.00001F;
    m.constant = load(batch.constant + lane);
    m.margin = load(batch.margin + lane) + a.radius + b.radius;
    m.slack = load(batch.slack + lane);
    m.speedSlack = load(batch.speedSlack + lane);
    if (batch.hasRadius)
    {
        const Vector fromAxis = a.center + loadVector(batch.radiusArmA, lane);
        m.constant += load(batch.perRadiusA + lane) * (lengthAbove(fromAxis) + a.coreRadius);
    }
    if constexpr (kTurnsB)
    {
        const Vector wB = loadVector(batch.wB, lane);
        const Vector armB = b.center + loadVector(batch.armB, lane);
        const Vector orbitB = cross(wB, armB);
        const Floats rateB = load(batch.spinB + lane);
        const Floats inverseB = 1.0F / maximum(rateB, Floats{} + 1e-30F);
        m.closing = m.closing - orbitB;
        m.spinB = {wB.x * inverseB, wB.y * inverseB, wB.z * inverseB};
        m.turnB = rateB * b.coreRadius;
        m.bendB = load(batch.axisB + lane) * rateB * (lengthAbove(orbitB) + m.turnB) * 1.00001F;
        if (batch.hasRadius)
        {
            m.constant += load(batch.perRadiusB + lane) * (lengthAbove(armB) + b.coreRadius);
        }
    }

    // Coordinates along the axes of both: of the distance, the velocity and the axes of rotation.
    Floats C[3][3], absC[3][3], DA[3], DB[3], UA[3], UB[3], SA[3], SB[3], TA[3], TB[3];
    for (int i = 0; i < 3; ++i)
    {
        const Vector axis = R * a.axis[i];
        for (int j = 0; j < 3; ++j)
        {
            C[i][j] = dot(axis, b.axis[j]);
            absC[i][j] = absolute(C[i][j]);
        }
        DA[i] = dot(D, axis);
        DB[i] = dot(D, b.axis[i]);
        UA[i] = dot(m.closing, axis);
        UB[i] = dot(m.closing, b.axis[i]);
        SA[i] = dot(m.spinA, axis);
        SB[i] = dot(m.spinA, b.axis[i]);
        if constexpr (kTurnsB)
        {
            TA[i] = dot(m.spinB, axis);
            TB[i] = dot(m.spinB, b.axis[i]);
        }
        else
        {
            TA[i] = TB[i] = Floats{};
        }
    }
    const Floats one = Floats{} + 1.0F;
    Best best;
    for (int i = 0; i < 3; ++i)
    {
        const Floats extentA =
            a.half[i] + b.half[0] * absC[i][0] + b.half[1] * absC[i][1] + b.half[2] * absC[i][2];
        takeAxis(m, best, DA[i], extentA, UA[i], SA[i], TA[i], one);
        const Floats extentB =
            b.half[i] + a.half[0] * absC[0][i] + a.half[1] * absC[1][i] + a.half[2] * absC[2][i];
        takeAxis(m, best, DB[i], extentB, UB[i], SB[i], TB[i], one);
    }
    for (int i = 0; i < 3; ++i)
    {
        const int i1 = (i + 1) % 3;
        const int i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j)
        {
            // n = a_i x b_j, |n|^2 = 1 - C_ij^2. Almost parallel edges count as longer than they
            // are, which shrinks gap and speed alike.
            const int j1 = (j + 1) % 3;
            const int j2 = (j + 2) % 3;
            const Floats square = maximum(one - C[i][j] * C[i][j], Floats{} + 1e-2F);
            const Floats scale = 0.99997F / root(square);
            const auto along = [&](const Floats* x) { return x[i2] * C[i1][j] - x[i1] * C[i2][j]; };
            const Floats extent = a.half[i1] * absC[i2][j] + a.half[i2] * absC[i1][j] +
                                  b.half[j1] * absC[i][j2] + b.half[j2] * absC[i][j1];
            takeAxis(m, best, along(DA), extent, along(UA), along(SA), along(TA), scale);
        }
    }
    store(batch.step + lane, best.step);
    store(batch.gap + lane, best.gap);
}

// ---------------------------------------------------------------------------------------- poses

struct Turn
{
    Floats sine, cosine;
};

/// Half of the angle rate t, reduced to at most a quarter turn.
inline Doubles4 halfAngle(double rate, Doubles4 t)
{
    constexpr double kTwoPi = 6.283185307179586;
    constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to integers
    const Doubles4 angle = rate * t;
    const Doubles4 turns = (angle * (1.0 / kTwoPi) + kRound) - kRound;
    return 0.5 * (angle - turns * kTwoPi);
}

// Taylor series, error below 1e-8 up to a quarter turn.
inline Doubles4 sineSeries(Doubles4 x)
{
    const Doubles4 y = x * x;
    return x * (1.0 +
                y * (-1.66666666666666667e-1 +
                     y * (8.33333333333333333e-3 +
                          y * (-1.98412698412698413e-4 +
                               y * (2.75573192239858907e-6 + y * (-2.50521083854417188e-8 +
                                                                  y * 1.60590438368216146e-10))))));
}
inline Doubles4 cosineSeries(Doubles4 x)
{
    const Doubles4 y = x * x;
    return 1.0 +
           y * (-0.5 + y * (4.16666666666666667e-2 +
                            y * (-1.38888888888888889e-3 +
                                 y * (2.48015873015873016e-5 + y * (-2.75573192239858907e-7 +
                                                                    y * 2.08767569878680990e-9)))));
}

/// Sine and cosine, error below 1e-7, for angles up to 1e8.
inline Turn sineCosine(double rate, const Doubles& times)
{
    const Doubles x = each([&](Doubles4 t) { return halfAngle(rate, t); }, times);
    const Doubles s = each(sineSeries, x);
    const Doubles c = each(cosineSeries, x);
    return {.sine = toFloats(each([](Doubles4 u, Doubles4 v) { return 2.0 * u * v; }, s, c)),
            .cosine = toFloats(each([](Doubles4 u) { return 1.0 - 2.0 * u * u; }, s))};
}

inline Rotation turned(const float (&parts)[3][9], const Turn& turn)
{
    Rotation R;
    for (int i = 0; i < 9; ++i)
    {
        R.m[i] = parts[0][i] + turn.cosine * parts[1][i] + turn.sine * parts[2][i];
    }
    return R;
}

inline void storeVector(float (&out)[3][NodeBatch::kLanes], int lane, const Vector& v)
{
    store(out[0] + lane, v.x);
    store(out[1] + lane, v.y);
    store(out[2] + lane, v.z);
}

inline void poseLanes(const RigidPoses& poses,
                      const double* times,
                      float slackPerMeter,
                      float slackFloor,
                      NodeBatch& batch,
                      int lane)
{
    const Doubles t = loadDoubles(times + lane);
    Rotation R = turned(poses.turnA, sineCosine(poses.rateA, t));
    Doubles d[3];
    for (int k = 0; k < 3; ++k)
    {
        d[k] = each([&](Doubles4 s) { return poses.d0[k] + poses.v[k] * s; }, t);
    }
    Vector p{toFloats(d[0]), toFloats(d[1]), toFloats(d[2])};
    const Floats reach = absolute(p.x) + absolute(p.y) + absolute(p.z);
    if (poses.turnsB)
    {
        const Rotation Q = turned(poses.turnB, sineCosine(poses.rateB, t));
        const Rotation RA = R;
        for (int i = 0; i < 3; ++i)
        {
            const Vector column = Q * Vector{RA.m[i], RA.m[3 + i], RA.m[6 + i]};
            R.m[i] = column.x;
            R.m[3 + i] = column.y;
            R.m[6 + i] = column.z;
        }
        Vector v = all(poses.v);
        if (poses.inFrameOfB)
        {
            v = v - cross(all(poses.wBw), p);
        }
        p = Q * p - all(poses.armB);
        storeVector(batch.velocity, lane, Q * v);
        storeVector(batch.wA, lane, Q * all(poses.wA));
    }
    for (int i = 0; i < 9; ++i)
    {
        store(batch.R[i] + lane, R.m[i]);
    }
    storeVector(batch.p, lane, p);
    store(batch.slack + lane, slackFloor + slackPerMeter * reach);
}
}  // namespace

void nodeSteps(NodeBatch& batch)
{
    for (int lane = 0; lane < NodeBatch::kLanes; lane += kWidth)
    {
        if (batch.turnsB)
        {
            stepLanes<true>(batch, lane);
        }
        else
        {
            stepLanes<false>(batch, lane);
        }
    }
}

void rigidPoses(const RigidPoses& poses,
                const double (&times)[NodeBatch::kLanes],
                float slackPerMeter,
                float slackFloor,
                NodeBatch& batch)
{
    for (int lane = 0; lane < NodeBatch::kLanes; lane += kWidth)
    {
        poseLanes(poses, times, slackPerMeter, slackFloor, batch, lane);
    }
}
}  // namespace bullet_ccd::BULLET_CCD_ISA
