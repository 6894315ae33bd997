/// Where a function that is certified by two of its values meets zero. In an unnamed namespace:
/// copies for several instruction sets must never be merged by the linker.
#pragma once

namespace bullet_ccd
{
namespace
{
/// The first s in (0, length] at which the lower bound of a semi-concave function meets zero, given
/// its values at 0 (positive) and at `length`; `length` if it does not.
[[nodiscard, maybe_unused]] inline double certifiedRoot(double first,
                                                        double last,
                                                        double length,
                                                        double bend)
{
    // first + b s + bend s^2 / 2 is the chord less its sag. All is taken times the length, which
    // spares a division.
    const double b = (last - first) - 0.5 * bend * length * length;
    if (b >= 0.0)
    {
        return length;
    }
    const double square = b * b - 2.0 * bend * first * (length * length);
    if (square < 0.0)
    {
        return length;
    }
    const double root = 2.0 * first * length / (__builtin_sqrt(square) - b);
    return root < length ? root * (1.0 - 1e-13) : length;
}
}  // namespace
}  // namespace bullet_ccd
