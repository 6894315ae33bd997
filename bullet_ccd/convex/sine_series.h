/// Sines and cosines of several angles at once, without a call and with the same bits with every C
/// library. In an unnamed namespace: copies for several instruction sets must never be merged by
/// the linker.
#pragma once

namespace bullet_ccd
{
namespace
{
/// Beyond, the reduction would lose digits.
constexpr double kLargestAngle = 1e5;

template <class Numbers>
struct SinesAndCosines
{
    Numbers sines;
    Numbers cosines;
};

/// Within 3e-16 of the truth for the angles as given, a vector of the compiler.
/// @pre |angle| < kLargestAngle
template <class Numbers>
[[nodiscard, maybe_unused]] inline SinesAndCosines<Numbers> sinesAndCosinesOf(Numbers angle)
{
    // angle = quarters pi/2 + x with |x| <= pi/4; pi/2 in three parts, the products with the first
    // two being exact.
    constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to whole numbers
    const Numbers rounded = angle * 0.63661977236758134308 + kRound;
    const Numbers quarters = rounded - kRound;
    Numbers x = angle - quarters * 1.57079632673412561417;
    x -= quarters * 6.07710050630396597660e-11;
    x -= quarters * 2.02226624879595063154e-21;
    const Numbers y = x * x;
    // Taylor's series; what is left out is below 5e-17.
    Numbers s = y * (-1.0 / 1307674368000.0) + 1.0 / 6227020800.0;
    s = s * y - 1.0 / 39916800.0;
    s = s * y + 1.0 / 362880.0;
    s = s * y - 1.0 / 5040.0;
    s = s * y + 1.0 / 120.0;
    s = s * y - 1.0 / 6.0;
    s = x + x * y * s;
    Numbers c = y * (1.0 / 20922789888000.0) - 1.0 / 87178291200.0;
    c = c * y + 1.0 / 479001600.0;
    c = c * y - 1.0 / 3628800.0;
    c = c * y + 1.0 / 40320.0;
    c = c * y - 1.0 / 720.0;
    c = c * y + 1.0 / 24.0;
    c = 1.0 - 0.5 * y + y * y * c;
    // The last bits of the rounded number are those of the quarter.
    using Bits = decltype(angle < angle);
    Bits bits;
    static_assert(sizeof(bits) == sizeof(rounded));
    __builtin_memcpy(&bits, &rounded, sizeof(bits));
    const Bits isOdd = (bits & 1) != 0;
    const Numbers across = isOdd ? c : s;
    const Numbers along = isOdd ? s : c;
    return {(bits & 2) != 0 ? -across : across, ((bits + 1) & 2) != 0 ? -along : along};
}
}  // namespace
}  // namespace bullet_ccd
