/// Taylor models: functions of time over an interval, enclosed by a cubic and a bound of what the
/// cubic leaves out. Sums and products of models are models again, so that the range of a chain of
/// rotations follows with an error of fourth order in the length of the interval, where interval
/// arithmetic would be wrong to first order.
///
/// The variable is s in [-1, 1], from the first to the last time of the interval. All models of an
/// expression belong to the same interval.
///
/// Rounding: no rounding mode is touched. Every operation adds a bound of its own rounding errors
/// (units in the last place of the sizes involved) to the bound of the model, so that results
/// enclose what exact arithmetic would give. Higher powers of s are not simply dropped into the
/// bound: each is replaced by the cubic nearest to it on [-1, 1] (Chebyshev), which leaves an
/// eighth of s^4 and a sixteenth of s^5.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace bullet_ccd
{
struct Interval
{
    double low = 0.0;
    double high = 0.0;

    [[nodiscard]] double width() const { return high - low; }
    [[nodiscard]] double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
};

/// Twice the unit roundoff of double precision, and a factor that rounds a few operations up.
inline constexpr double kTaylorUnit = 2.3e-16;
inline constexpr double kTaylorUp = 1.0 + 4e-15;

/// |f - (c0 + c1 s + c2 s^2 + c3 s^3)| <= error for all s in [-1, 1].
struct TaylorModel
{
    std::array<double, 4> c{};
    double error = 0.0;

    /// Bound of |f - error| from its coefficients.
    [[nodiscard]] double norm() const
    {
        return std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]) + std::abs(c[3]);
    }
};

/// A number, known to within `error`.
[[nodiscard]] inline TaylorModel constantModel(double value, double error = 0.0)
{
    return {.c = {value, 0.0, 0.0, 0.0}, .error = error};
}

/// middle + slope s, each rounded once.
[[nodiscard]] inline TaylorModel linearModel(double middle, double slope)
{
    return {.c = {middle, slope, 0.0, 0.0},
            .error = kTaylorUnit * (std::abs(middle) + std::abs(slope))};
}

/// factor p, where the factor is known to one rounding.
[[nodiscard]] inline TaylorModel scaled(double factor, const TaylorModel& p)
{
    TaylorModel r;
    for (std::size_t k = 0; k < 4; ++k)
    {
        r.c[k] = factor * p.c[k];
    }
    r.error = (std::abs(factor) * p.error + kTaylorUnit * r.norm()) * kTaylorUp + 1e-300;
    return r;
}

[[nodiscard]] inline TaylorModel operator+(const TaylorModel& p, const TaylorModel& q)
{
    TaylorModel r;
    for (std::size_t k = 0; k < 4; ++k)
    {
        r.c[k] = p.c[k] + q.c[k];
    }
    r.error = (p.error + q.error + kTaylorUnit * r.norm()) * kTaylorUp;
    return r;
}

[[nodiscard]] inline TaylorModel operator-(const TaylorModel& p, const TaylorModel& q)
{
    TaylorModel r;
    for (std::size_t k = 0; k < 4; ++k)
    {
        r.c[k] = p.c[k] - q.c[k];
    }
    r.error = (p.error + q.error + kTaylorUnit * r.norm()) * kTaylorUp;
    return r;
}

/// factors . p, where the factors are known to one rounding each: one row of a constant matrix.
[[nodiscard]] inline TaylorModel combined(const double (&factors)[3],
                                          const TaylorModel& p0,
                                          const TaylorModel& p1,
                                          const TaylorModel& p2)
{
    TaylorModel r;
    double size = 0.0;
    for (std::size_t k = 0; k < 4; ++k)
    {
        const double a = factors[0] * p0.c[k];
        const double b = factors[1] * p1.c[k];
        const double d = factors[2] * p2.c[k];
        r.c[k] = a + b + d;
        size += std::abs(a) + std::abs(b) + std::abs(d);
    }
    const double inherited = std::abs(factors[0]) * p0.error + std::abs(factors[1]) * p1.error +
                             std::abs(factors[2]) * p2.error;
    r.error = (inherited + 2.0 * kTaylorUnit * size) * kTaylorUp + 1e-300;
    return r;
}

[[nodiscard]] inline TaylorModel operator*(const TaylorModel& p, const TaylorModel& q)
{
    const auto& a = p.c;
    const auto& b = q.c;
    const double d4 = a[1] * b[3] + a[2] * b[2] + a[3] * b[1];
    const double d5 = a[2] * b[3] + a[3] * b[2];
    const double d6 = a[3] * b[3];
    TaylorModel r;
    // s^4 = s^2 - 1/8 +- 1/8, s^5 = (5 s^3 - 5/4 s) / 4 +- 1/16, and
    // s^6 = 15/16 s^2 - 5/32 +- 7/32 (from T6, and s^4 as above).
    r.c[0] = a[0] * b[0] - 0.125 * d4 - 0.15625 * d6;
    r.c[1] = a[0] * b[1] + a[1] * b[0] - 0.3125 * d5;
    r.c[2] = a[0] * b[2] + a[1] * b[1] + a[2] * b[0] + d4 + 0.9375 * d6;
    r.c[3] = a[0] * b[3] + a[1] * b[2] + a[2] * b[1] + a[3] * b[0] + 1.25 * d5;
    const double normP = p.norm();
    const double normQ = q.norm();
    // Every product of two coefficients passes through at most a dozen roundings.
    const double rounding = 16.0 * kTaylorUnit * normP * normQ;
    r.error = (0.125 * std::abs(d4) + 0.0625 * std::abs(d5) + 0.21875 * std::abs(d6) +
               normP * q.error + normQ * p.error + p.error * q.error + rounding) *
                  kTaylorUp +
              1e-300;
    return r;
}

/// Encloses all values: exact extrema of the cubic, plus the error, rounded outwards.
[[nodiscard]] Interval range(const TaylorModel& p);

/// Bound of |f|, cheaper than range() and wider.
[[nodiscard]] inline double magnitude(const TaylorModel& p)
{
    return (p.norm() + p.error) * kTaylorUp;
}

struct SineCosine
{
    TaylorModel sine;
    TaylorModel cosine;
};

/// Sine and cosine of the angle middle + slope s, for any number of turns.
/// @param error by which the angle may be off [rad]
[[nodiscard]] SineCosine sineCosine(double middle, double slope, double error = 0.0);

/// Sine and cosine of an angle [rad].
[[nodiscard]] SineCosine sineCosine(const TaylorModel& angle);
}  // namespace bullet_ccd
