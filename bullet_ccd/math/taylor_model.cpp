#include "bullet_ccd/math/taylor_model.h"

namespace bullet_ccd
{
namespace
{
double valueAt(const TaylorModel& p, double s)
{
    return p.c[0] + s * (p.c[1] + s * (p.c[2] + s * p.c[3]));
}

/// sin(x s) and cos(x s) for s in [-1, 1].
struct Series
{
    TaylorModel sine;
    TaylorModel cosine;
};

/// The partial sums of both series lie on alternate sides of the function, for any argument: this
/// follows from 1 - cos >= 0 by integrating again and again from 0. So what is left out has one
/// sign and is at most the first term that is left out; it is halved by centring.
Series seriesOf(double x)
{
    const double x2 = x * x;
    const double x4 = x2 * x2;
    const double size = std::abs(x);
    const double fourth = x4 / 24.0;       // of s^4, in the cosine
    const double sixth = x4 * x2 / 720.0;  // left out, of s^6, negative
    const double fifth = x4 * x / 120.0;   // of s^5, in the sine
    const double seventh = x4 * x2 * size / 5040.0;
    Series r;
    r.cosine.c = {1.0 - 0.125 * fourth - 0.5 * sixth, 0.0, -0.5 * x2 + fourth, 0.0};
    r.cosine.error =
        (0.125 * fourth + 0.5 * sixth + 8.0 * kTaylorUnit * (1.0 + x2 + fourth + sixth)) *
        kTaylorUp;
    r.sine.c = {0.0, x - 0.3125 * fifth, 0.0, -x2 * x / 6.0 + 1.25 * fifth};
    r.sine.error =
        (0.0625 * std::abs(fifth) + seventh + 8.0 * kTaylorUnit * size * (1.0 + x2 + x4)) *
            kTaylorUp +
        1e-300;
    return r;
}

/// Beyond this the series is worse than nothing: the range of a sine is known.
constexpr double kLongestArc = 3.0;
}  // namespace

Interval range(const TaylorModel& p)
{
    const double first = valueAt(p, -1.0);
    const double last = valueAt(p, 1.0);
    double low = std::min(first, last);
    double high = std::max(first, last);
    const auto consider = [&](double s)
    {
        if (s > -1.0 && s < 1.0)
        {
            const double value = valueAt(p, s);
            low = std::min(low, value);
            high = std::max(high, value);
        }
    };
    // Roots of 3 c3 s^2 + 2 c2 s + c1, without cancellation and without dividing by zero (0 / 0 is
    // no root and compares false above).
    const double discriminant = p.c[2] * p.c[2] - 3.0 * p.c[3] * p.c[1];
    if (discriminant >= 0.0)
    {
        const double q = -(p.c[2] + std::copysign(std::sqrt(discriminant), p.c[2]));
        consider(q / (3.0 * p.c[3]));
        consider(p.c[1] / q);
    }
    // The roots are those of a cubic whose coefficients differ by a few roundings.
    const double slack = (p.error + 32.0 * kTaylorUnit * p.norm()) * kTaylorUp;
    return {.low = low - slack, .high = high + slack};
}

SineCosine sineCosine(double middle, double slope, double error)
{
    const double offset = error + 2.0 * kTaylorUnit * (std::abs(middle) + std::abs(slope));
    if (!(std::abs(slope) <= kLongestArc))
    {
        return {.sine = constantModel(0.0, 1.0), .cosine = constantModel(0.0, 1.0)};
    }
    const double s = std::sin(middle);
    const double c = std::cos(middle);
    const Series arc = seriesOf(slope);
    SineCosine r{.sine = scaled(s, arc.cosine) + scaled(c, arc.sine),
                 .cosine = scaled(c, arc.cosine) - scaled(s, arc.sine)};
    // The library's sine and cosine are right to a unit or two in the last place of 1.
    const double rounding = (offset + 4.0 * kTaylorUnit * (1.0 + std::abs(slope))) * kTaylorUp;
    r.sine.error += rounding;
    r.cosine.error += rounding;
    return r;
}

SineCosine sineCosine(const TaylorModel& angle)
{
    // As above, with a cubic without constant term in place of x s. What the angle may be off moves
    // sine and cosine by no more.
    TaylorModel arc{.c = {0.0, angle.c[1], angle.c[2], angle.c[3]}};
    const double x = arc.norm() * kTaylorUp;
    if (!(x <= kLongestArc))
    {
        return {.sine = constantModel(0.0, 1.0), .cosine = constantModel(0.0, 1.0)};
    }
    const TaylorModel square = arc * arc;
    const TaylorModel fourth = square * square;
    const double x3 = x * x * x;
    const double sixth = x3 * x3 / 720.0;
    const double seventh = x3 * x3 * x / 5040.0;
    TaylorModel cosine = constantModel(1.0 - 0.5 * sixth, 2.0 * kTaylorUnit) - scaled(0.5, square) +
                         scaled(1.0 / 24.0, fourth);
    cosine.error = (cosine.error + 0.5 * sixth) * kTaylorUp;
    TaylorModel sine = arc - scaled(1.0 / 6.0, arc * square) + scaled(1.0 / 120.0, arc * fourth);
    sine.error = (sine.error + seventh) * kTaylorUp;
    const double s = std::sin(angle.c[0]);
    const double c = std::cos(angle.c[0]);
    SineCosine r{.sine = scaled(s, cosine) + scaled(c, sine),
                 .cosine = scaled(c, cosine) - scaled(s, sine)};
    const double rounding =
        (angle.error + 4.0 * kTaylorUnit * (1.0 + std::abs(angle.c[0]) + x)) * kTaylorUp;
    r.sine.error += rounding;
    r.cosine.error += rounding;
    return r;
}
}  // namespace bullet_ccd
