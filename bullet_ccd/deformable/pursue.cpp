#include "bullet_ccd/deformable/pursue.h"

#include "bullet_ccd/deformable/moving_polygon.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
constexpr double kUnitRoundoff = 1.1102230246251565e-16;  // 2^-53
/// Evaluations that ElementaryDepth::Decide spends on a pair below the tolerance.
constexpr std::int64_t kDecideIterations = 64;
/// The part of the gap that a step aims to close, where the nearest points approach each other.
constexpr double kClose = 0.95;

/// Bound of all rounding: a difference is rounded once, a corner at time t by three operations more
/// (8 u M in a coordinate), a product with a unit direction by five (5.2 u M), the direction's
/// length by 4 u. That is below 20 u M in all; 64 leaves room.
template <std::size_t N>
double roundingError(const Polygon<N>& a, const Polygon<N>& b)
{
    double largest = 0.0;
    for (std::size_t k = 0; k < N; ++k)
    {
        largest = std::max({largest, a[k].cwiseAbs().maxCoeff(), b[k].cwiseAbs().maxCoeff()});
    }
    return 64.0 * kUnitRoundoff * largest + 1e-300;
}

template <std::size_t N>
class Pursuer
{
public:
    Pursuer(const ElementaryPair& pair, const ElementaryOptions& options) : m_options(options)
    {
        subtract(pair.start, m_start);
        Polygon<N> end;
        subtract(pair.end, end);
        for (std::size_t k = 0; k < N; ++k)
        {
            m_velocity[k] = end[k] - m_start[k];
        }
        const double error = roundingError<N>(m_start, end);
        m_margin = options.minimumSeparation + error;
        m_touching = m_margin + error;
        m_now = m_start;
        m_nearest = nearestPoint<N>(m_now);
    }

    Pursuit run()
    {
        const double separation = m_options.minimumSeparation;
        const double startGap = m_nearest.distance;
        m_startsNear = startGap <= separation + m_options.tolerance;
        if (!(startGap > m_touching))  // touching, too close, or not a number
        {
            return contact(ToiStatus::Overlapping);
        }
        m_stop = separation + std::min(m_options.tolerance, 0.5 * (startGap - separation));
        std::int64_t budget = m_options.maxIterations;
        bool isNear = false;
        double step = 1.0;
        while (m_iterations < budget)
        {
            const double rest = 1.0 - m_time;
            const double support =
                supportStep<N>(m_now, m_velocity, m_nearest.direction, m_margin, rest);
            if (support >= rest)
            {
                return separated();
            }
            step = aimed(std::min(step, rest));
            if (!(m_time + std::max(step, support) > m_time))
            {
                return stuck();
            }
            if (!advance(step, support))
            {
                continue;
            }
            if (m_time >= 1.0)
            {
                return separated();
            }
            if (!(m_nearest.distance > m_touching))
            {
                return contact(hit());
            }
            if (m_nearest.distance <= m_stop && !isNear)
            {
                isNear = true;
                m_near = contact(hit());
                if (m_options.depth == ElementaryDepth::Tolerance)
                {
                    return m_near;
                }
                budget = std::min(budget, m_iterations + kDecideIterations);
            }
        }
        if (isNear)
        {
            m_near.result.iterations = m_iterations;
            return m_near;
        }
        return contact(ToiStatus::IterationLimit);
    }

private:
    /// Not much further than where the nearest points would have closed nearly all of their gap.
    [[nodiscard]] double aimed(double step) const
    {
        const double rate = m_nearest.rate<N>(m_velocity);
        if (rate < 0.0)
        {
            const double newton =
                kClose * (m_nearest.distance - m_options.minimumSeparation) / -rate;
            if (newton < step)
            {
                return std::max(newton, step / 1024.0);
            }
        }
        return step;
    }

    /// Moves time forward by `step` if that is certified, else by the support step if that is
    /// longer than the next smaller try. Returns false if time did not move. `step` becomes the
    /// next one to try.
    bool advance(double& step, double support)
    {
        if (step > support)
        {
            const double time = m_time + step;
            const Polygon<N> then = cornersAt(time);
            const NearestPoint nearest = nearestPoint<N>(then);
            ++m_iterations;
            if (certify<N>(m_now, then, m_nearest.direction, nearest.direction, m_margin))
            {
                m_time = time;
                m_now = then;
                m_nearest = nearest;
                step *= 4.0;
                return true;
            }
            step *= 0.25;
            if (step > support || !(m_time + support > m_time))
            {
                return false;
            }
        }
        m_time += support;
        m_now = cornersAt(m_time);
        m_nearest = nearestPoint<N>(m_now);
        ++m_iterations;
        step = 4.0 * support;
        return true;
    }

    [[nodiscard]] Polygon<N> cornersAt(double time) const
    {
        Polygon<N> q;
        for (std::size_t k = 0; k < N; ++k)
        {
            q[k] = m_start[k] + time * m_velocity[k];
        }
        return q;
    }

    [[nodiscard]] ToiStatus hit() const
    {
        return m_startsNear ? ToiStatus::TouchingPressing : ToiStatus::Hit;
    }
    [[nodiscard]] Pursuit contact(ToiStatus status) const
    {
        return {.result = {.status = status,
                           .time = m_time,
                           .gap = m_nearest.distance,
                           .normal = m_nearest.direction,
                           .weights = vertexWeights(m_nearest.cornerWeights<N>()),
                           .iterations = m_iterations},
                .startsNear = m_startsNear};
    }
    [[nodiscard]] Pursuit separated() const
    {
        return {
            .result = {.status = m_startsNear ? ToiStatus::TouchingLeaving : ToiStatus::Separated,
                       .gap = m_options.minimumSeparation,
                       .iterations = m_iterations},
            .startsNear = m_startsNear};
    }
    /// No step that time can represent is certain.
    [[nodiscard]] Pursuit stuck() const
    {
        const bool isNear = m_nearest.distance <= m_touching + m_options.tolerance;
        return contact(isNear ? hit() : ToiStatus::IterationLimit);
    }

    const ElementaryOptions& m_options;
    Polygon<N> m_start;
    Polygon<N> m_velocity;
    Polygon<N> m_now;  ///< corners at m_time
    NearestPoint m_nearest;
    double m_margin = 0.0;    ///< what certificates keep: separation and rounding
    double m_touching = 0.0;  ///< at this distance no certificate can begin
    double m_stop = 0.0;
    double m_time = 0.0;
    std::int64_t m_iterations = 1;
    bool m_startsNear = false;
    Pursuit m_near;  ///< when the tolerance was first reached
};
}  // namespace

template <std::size_t N>
Pursuit pursue(const ElementaryPair& pair, const ElementaryOptions& options)
{
    return Pursuer<N>(pair, options).run();
}
template Pursuit pursue<3>(const ElementaryPair&, const ElementaryOptions&);
template Pursuit pursue<4>(const ElementaryPair&, const ElementaryOptions&);
}  // namespace bullet_ccd
