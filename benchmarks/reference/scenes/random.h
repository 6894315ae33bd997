/// Seeded random numbers and poses for tests: the same on every platform.
#pragma once

#include <Eigen/Geometry>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace bullet_ccd::reference
{
/// What is drawn, from any engine of 64 random bits.
template <typename Engine>
class RandomFrom
{
public:
    explicit RandomFrom(std::uint64_t begin) : m_engine(begin) {}

    /// Uniform in [low, high).
    double uniform(double low, double high)
    {
        constexpr double kScale = 1.0 / 9007199254740992.0;  // 2^-53
        return low + (high - low) * static_cast<double>(m_engine() >> 11U) * kScale;
    }
    /// Uniform in low..high, both included.
    int integer(int low, int high)
    {
        const auto count = static_cast<std::uint64_t>(high - low + 1);
        return low + static_cast<int>(m_engine() % count);
    }
    /// The logarithm is uniform.
    double logUniform(double low, double high)
    {
        return std::exp(uniform(std::log(low), std::log(high)));
    }
    bool chance(double probability) { return uniform(0.0, 1.0) < probability; }

    Eigen::Vector3d inBox(double half)
    {
        const double x = uniform(-half, half);
        const double y = uniform(-half, half);
        const double z = uniform(-half, half);
        return {x, y, z};
    }
    Eigen::Vector3d direction()
    {
        const double z = uniform(-1.0, 1.0);
        const double angle = uniform(0.0, 2.0 * std::numbers::pi);
        const double r = std::sqrt(1.0 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
    }
    Eigen::Matrix3d rotation()
    {
        const Eigen::Vector3d axis = direction();
        return Eigen::AngleAxisd(uniform(-std::numbers::pi, std::numbers::pi), axis)
            .toRotationMatrix();
    }
    /// A rotated frame with its origin within the cube of that half edge.
    Eigen::Isometry3d pose(double half)
    {
        Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
        X.linear() = rotation();
        X.translation() = inBox(half);
        return X;
    }

private:
    Engine m_engine;
};

using Random = RandomFrom<std::mt19937_64>;
}  // namespace bullet_ccd::reference
