#include "bullet_ccd/toi/articulated/near_times.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// A slice is so short that its curve widens a ball by this part of its radius, if that takes no
/// more than so many of them.
constexpr double kWidening = 0.5;
constexpr double kMostSlices = 32.0;

/// Of coordinates and sizes: hundreds of roundings.
constexpr double kRounding = 1e-12;

/// Of directions, which are unit to single precision.
constexpr double kUnit = 1e-6;
}  // namespace

void NearTimes::reset(MovingFrames& frames, std::int32_t base, std::span<const FrameBall> balls)
{
    m_accelerations.clear();
    double slices = 1.0;
    for (const FrameBall& ball : balls)
    {
        const AccelerationBound bound = frames.accelerationBound(base, ball.frame);
        m_accelerations.push_back(bound.constant + bound.perRadius * ball.center.norm());
        slices =
            std::max(slices, std::sqrt(0.125 * m_accelerations.back() / (kWidening * ball.radius)));
    }
    m_slices = static_cast<std::size_t>(std::ceil(std::min(slices, kMostSlices)));
    m_moved.resize(balls.size() * m_slices);
    const double half = 0.5 / static_cast<double>(m_slices);
    for (std::size_t slice = 0; slice < m_slices; ++slice)
    {
        const double middle = static_cast<double>(2 * slice + 1) * half;
        for (std::size_t i = 0; i < balls.size(); ++i)
        {
            const FrameBall& ball = balls[i];
            const MotionState& state = frames.stateAt(base, ball.frame, middle);
            const Vector3d arm = state.X_W.linear() * ball.center;
            Moved& moved = m_moved[i * m_slices + slice];
            moved.center = state.X_W.translation() + arm;
            moved.half = half * (state.v_W + state.w_W.cross(arm));
            moved.length = moved.half.norm();
            moved.radius = ball.radius + 0.5 * m_accelerations[i] * half * half +
                           kRounding * (moved.center.norm() + moved.length + ball.radius);
        }
    }
}

AlignedBox3d NearTimes::boxOf(std::size_t ball) const
{
    AlignedBox3d box;
    for (const Moved& moved : slicesOf(ball))
    {
        const Vector3d half = moved.half.cwiseAbs() + Vector3d::Constant(moved.radius);
        box.extend(AlignedBox3d(moved.center - half, moved.center + half));
    }
    return box;
}

template <typename MayMeet>
std::optional<std::pair<double, double>> NearTimes::nearWhere(const MayMeet& mayMeet) const
{
    std::size_t first = 0;
    while (first < m_slices && !mayMeet(first))
    {
        ++first;
    }
    if (first == m_slices)
    {
        return std::nullopt;
    }
    std::size_t last = m_slices;
    while (last > first + 1 && !mayMeet(last - 1))
    {
        --last;
    }
    const auto all = static_cast<double>(m_slices);
    return std::pair{static_cast<double>(first) / all, static_cast<double>(last) / all};
}

std::optional<std::pair<double, double>> NearTimes::near(std::size_t ball,
                                                         const OrientedBox& box,
                                                         double reach) const
{
    const double size = box.half.norm() * (1.0 + kUnit);
    const double beside = box.radius + reach + kRounding * (box.center.norm() + size);
    return nearWhere(
        [&, moved = slicesOf(ball)](std::size_t slice)
        {
            const Moved& piece = moved[slice];
            const Vector3d apart = piece.center - box.center;
            const double room = piece.radius + beside;
            const double far = room + piece.length + size;
            if (apart.squaredNorm() > far * far)
            {
                return false;
            }
            const Vector3d beyond = ((box.axes.transpose() * apart).cwiseAbs() -
                                     (box.axes.transpose() * piece.half).cwiseAbs() - box.half)
                                        .cwiseMax(0.0);
            return !(beyond.squaredNorm() * (1.0 - kUnit) > room * room);  // nor if it overflows
        });
}

std::optional<std::pair<double, double>> NearTimes::near(std::size_t ball,
                                                         std::size_t other,
                                                         double reach) const
{
    return nearWhere(
        [&, a = slicesOf(ball), b = slicesOf(other)](std::size_t slice)
        {
            const Vector3d apart = a[slice].center - b[slice].center;
            const Vector3d half = a[slice].half - b[slice].half;
            const double square = half.squaredNorm();
            const double at = square > 0.0 ? std::clamp(-apart.dot(half) / square, -1.0, 1.0) : 0.0;
            const double room = a[slice].radius + b[slice].radius + reach;
            return !((apart + at * half).squaredNorm() * (1.0 - kRounding) > room * room);
        });
}
}  // namespace bullet_ccd
