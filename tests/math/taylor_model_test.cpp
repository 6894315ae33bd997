/// Containment of Taylor models by sampling in extended precision, and the proof that the sampling
/// would notice: remainders that are known to be wrong are caught.
#include "bullet_ccd/math/taylor_model.h"

#include "benchmarks/reference/scenes/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Real = long double;

/// A model and the function that it stands for.
struct Pair
{
    TaylorModel model;
    std::function<Real(Real)> exact;
};

Pair linear(Random& random)
{
    const double middle = random.uniform(-2.0, 2.0);
    const double slope = random.chance(0.2) ? 0.0 : random.uniform(-1.5, 1.5);
    return {linearModel(middle, slope), [=](Real s) { return Real{middle} + Real{slope} * s; }};
}

Pair wave(Random& random)
{
    const double middle = random.uniform(-10.0, 10.0);
    const double slope = random.uniform(-1.0, 1.0) * random.logUniform(1e-6, 3.5);
    const SineCosine both = sineCosine(middle, slope);
    if (random.chance(0.5))
    {
        return {both.sine, [=](Real s) { return std::sin(Real{middle} + Real{slope} * s); }};
    }
    return {both.cosine, [=](Real s) { return std::cos(Real{middle} + Real{slope} * s); }};
}

/// An expression of that depth of random operations.
Pair expression(Random& random, int depth)
{
    if (depth == 0)
    {
        return random.chance(0.5) ? wave(random) : linear(random);
    }
    const Pair p = expression(random, depth - 1);
    const Pair q = expression(random, depth - 1);
    switch (random.integer(0, 4))
    {
        case 0:
            return {p.model + q.model, [=](Real s) { return p.exact(s) + q.exact(s); }};
        case 1:
            return {p.model - q.model, [=](Real s) { return p.exact(s) - q.exact(s); }};
        case 2:
        {
            const double f = random.uniform(-3.0, 3.0);
            return {scaled(f, p.model), [=](Real s) { return Real{f} * p.exact(s); }};
        }
        case 3:
        {
            const double f[3] = {
                random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)};
            const Real g[3] = {f[0], f[1], f[2]};
            return {combined(f, p.model, q.model, p.model),
                    [=, a = g[0], b = g[1], c = g[2]](Real s)
                    { return a * p.exact(s) + b * q.exact(s) + c * p.exact(s); }};
        }
        default:
            return {p.model * q.model, [=](Real s) { return p.exact(s) * q.exact(s); }};
    }
}

Real cubicAt(const TaylorModel& p, Real s)
{
    return Real{p.c[0]} + s * (Real{p.c[1]} + s * (Real{p.c[2]} + s * Real{p.c[3]}));
}

/// Samples of [-1, 1] with both ends.
Real sampleAt(Random& random, int i)
{
    return i == 0 ? Real{-1} : i == 1 ? Real{1} : Real{random.uniform(-1.0, 1.0)};
}

/// How many of the samples lie outside the model, and outside its range.
int countEscapes(Random& random, const Pair& pair, int samples)
{
    const Interval values = range(pair.model);
    int escapes = 0;
    for (int i = 0; i < samples; ++i)
    {
        const Real s = sampleAt(random, i);
        const Real f = pair.exact(s);
        const bool inModel = std::abs(f - cubicAt(pair.model, s)) <= Real{pair.model.error};
        const bool inRange = f >= Real{values.low} && f <= Real{values.high};
        escapes += inModel && inRange ? 0 : 1;
    }
    return escapes;
}

TEST(TaylorModel, ContainsMillionsOfSamplesOfRandomExpressions)
{
    Random random(2201);
    int escapes = 0;
    for (int i = 0; i < 40000; ++i)
    {
        const Pair pair = expression(random, random.integer(0, 4));
        escapes += countEscapes(random, pair, 50);
    }
    EXPECT_EQ(escapes, 0);
}

TEST(TaylorModel, SinesContainMillionsOfSamplesWithinRounding)
{
    // Arcs so short that the remainder is all rounding, and angles of many turns.
    Random random(2202);
    int escapes = 0;
    for (int i = 0; i < 40000; ++i)
    {
        const double middle = random.uniform(-1.0, 1.0) * random.logUniform(1e-3, 1e4);
        const double slope = random.uniform(-1.0, 1.0) * random.logUniform(1e-12, 4.0);
        const SineCosine both = sineCosine(middle, slope);
        const auto angle = [=](Real s) { return Real{middle} + Real{slope} * s; };
        escapes +=
            countEscapes(random, {both.sine, [=](Real s) { return std::sin(angle(s)); }}, 15);
        escapes +=
            countEscapes(random, {both.cosine, [=](Real s) { return std::cos(angle(s)); }}, 15);
    }
    EXPECT_EQ(escapes, 0);
}

TEST(TaylorModel, ErrorsOfSinesAreOfFourthOrder)
{
    // Products of four sines: halving the interval divides the error by about 16.
    Random random(2203);
    for (int i = 0; i < 100; ++i)
    {
        const double middle = random.uniform(-4.0, 4.0);
        double previous = 0.0;
        for (const double slope : {0.4, 0.2, 0.1, 0.05})
        {
            const SineCosine a = sineCosine(middle, slope);
            const SineCosine b = sineCosine(2.0 * middle, 0.7 * slope);
            const double error = (a.sine * b.cosine * (a.cosine * b.sine)).error;
            if (previous > 0.0)
            {
                EXPECT_LT(error, previous / 10.0);
            }
            previous = error;
        }
        EXPECT_LT(previous, 1e-5);
    }
}

TEST(TaylorModel, RangeOfACubicIsAttainedAndHolds)
{
    Random random(2204);
    int inside = 0;
    for (int i = 0; i < 20000; ++i)
    {
        TaylorModel p;
        for (double& c : p.c)
        {
            c = random.chance(0.2) ? 0.0 : random.uniform(-1.0, 1.0) * random.logUniform(1e-8, 1.0);
        }
        const Interval values = range(p);
        Real low = std::numeric_limits<Real>::infinity();
        Real high = -low;
        for (int k = 0; k <= 200; ++k)
        {
            const Real value = cubicAt(p, Real{-1} + static_cast<Real>(k) / Real{100});
            low = std::min(low, value);
            high = std::max(high, value);
        }
        ASSERT_LE(values.low, static_cast<double>(low)) << i;
        ASSERT_GE(values.high, static_cast<double>(high)) << i;
        // A grid of spacing h misses an extremum by h^2 / 8 of the second derivative at most.
        const double missed = 1.25e-5 * (2.0 * std::abs(p.c[2]) + 6.0 * std::abs(p.c[3])) + 1e-14;
        ASSERT_LE(static_cast<double>(low) - values.low, missed) << i;
        ASSERT_LE(values.high - static_cast<double>(high), missed) << i;
        const Real atEnds = std::min(cubicAt(p, -1), cubicAt(p, 1));
        inside += low < atEnds - Real{1e-6} ? 1 : 0;
    }
    EXPECT_GT(inside, 2000);  // extrema between the ends
}

TEST(TaylorModel, RangeOfDegenerateCubicsHolds)
{
    for (const TaylorModel& p : {TaylorModel{.c = {0, 0, 0, 0}},
                                 TaylorModel{.c = {1, 0, 0, 0}},
                                 TaylorModel{.c = {0, 1, 0, 0}},
                                 TaylorModel{.c = {0, 0, -1, 0}},
                                 TaylorModel{.c = {0, 0, 0, 1}},
                                 TaylorModel{.c = {0, 3e-200, 0, 1e-200}},
                                 TaylorModel{.c = {0, -0.75, 0, 1}},  // both extrema are +-1/4
                                 TaylorModel{.c = {0, 3, 3, 1}}})     // a double root at -1
    {
        const Interval values = range(p);
        for (int k = -100; k <= 100; ++k)
        {
            const Real value = cubicAt(p, static_cast<Real>(k) / Real{100});
            EXPECT_LE(Real{values.low}, value);
            EXPECT_GE(Real{values.high}, value);
        }
    }
    const Interval swing = range({.c = {0, -0.75, 0, 1}});
    EXPECT_NEAR(swing.low, -0.25, 1e-13);
    EXPECT_NEAR(swing.high, 0.25, 1e-13);
}

/// Third-order Taylor polynomial of cos about the middle, with the range of its fourth derivative
/// over the arc, as of a known code: where that range contains 0, the upper end of the remainder is
/// taken to be 0, because the fourth derivative "may vanish".
Pair cosineWithoutHull(double middle, double slope, bool sound)
{
    const double c = std::cos(middle);
    const double s = std::sin(middle);
    TaylorModel model{.c = {c, -slope * s, -0.5 * slope * slope * c, std::pow(slope, 3) * s / 6.0}};
    const double fourth = std::pow(slope, 4) / 24.0;
    double low = 1.0;
    double high = -1.0;
    for (int k = 0; k <= 1000; ++k)
    {
        const double value = std::cos(middle + slope * (0.002 * k - 1.0));
        low = std::min(low, value);
        high = std::max(high, value);
    }
    // The remainder is fourth [low, high] s^4 with s^4 in [0, 1].
    const bool straddles = low < 0.0 && high > 0.0;
    const double lowest = fourth * std::min(low, 0.0);
    const double highest = !sound && straddles ? 0.0 : fourth * std::max(high, 0.0);
    model.c[0] += 0.5 * (lowest + highest);
    model.error = 0.5 * (highest - lowest) + 1e-5 * fourth + 1e-15;
    return {model, [=](Real t) { return std::cos(Real{middle} + Real{slope} * t); }};
}

TEST(TaylorModel, SamplingCatchesTheUnsoundRemainderOfAKnownCode)
{
    Random random(2205);
    int unsound = 0;
    int sound = 0;
    for (int i = 0; i < 2000; ++i)
    {
        const double middle = random.uniform(-4.0, 4.0);
        const double slope = random.uniform(-2.0, 2.0);
        unsound += countEscapes(random, cosineWithoutHull(middle, slope, false), 50);
        sound += countEscapes(random, cosineWithoutHull(middle, slope, true), 50);
    }
    EXPECT_GT(unsound, 1000);
    EXPECT_EQ(sound, 0);
}

TEST(TaylorModel, SamplingCatchesARemainderThatIsATenthTooSmall)
{
    Random random(2206);
    int caught = 0;
    for (int i = 0; i < 2000; ++i)
    {
        const double middle = random.uniform(-4.0, 4.0);
        const double slope = random.uniform(0.05, 2.0);
        Pair pair{sineCosine(middle, slope).cosine,
                  [=](Real t) { return std::cos(Real{middle} + Real{slope} * t); }};
        pair.model.error *= 0.9;
        caught += countEscapes(random, pair, 100) > 0 ? 1 : 0;
    }
    EXPECT_GT(caught, 100);
}

TEST(TaylorModel, AnglesOfMoreThanHalfATurnKnowTheRangeOfASine)
{
    const SineCosine wide = sineCosine(1.0, 50.0);
    EXPECT_LE(range(wide.sine).high, 1.0 + 1e-14);
    EXPECT_GE(range(wide.sine).high, 1.0);
    const SineCosine bad = sineCosine(1.0, std::numeric_limits<double>::quiet_NaN());
    EXPECT_GE(range(bad.cosine).high, 1.0);
}
}  // namespace
}  // namespace bullet_ccd::tests
