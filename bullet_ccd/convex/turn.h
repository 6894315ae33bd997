/// Turning at constant speed about an axis at rest.
#pragma once

#include "bullet_ccd/convex/sine_series.h"

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
    if (first == 0.0 && second == 0.0)
    {
        return {};  // neither body turns
    }
    const auto isLarge = [](double angle) { return !(std::abs(angle) < kLargestAngle); };
    if (isLarge(first) || isLarge(second))
    {
        const auto alone = [&](double angle)
        {
            return isLarge(angle) ? SineAndCosine{std::sin(angle), std::cos(angle)}
                                  : sinesAndCosines(angle, 0.0)[0];
        };
        return {alone(first), alone(second)};
    }
    const auto [sines, cosines] = sinesAndCosinesOf(TwoNumbers{first, second});
    return {SineAndCosine{sines[0], cosines[0]}, SineAndCosine{sines[1], cosines[1]}};
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
