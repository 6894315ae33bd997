#include "bullet_ccd/deformable/certain_touch.h"

#include "bullet_ccd/deformable/moving_polygon.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

constexpr double kHalfUlp = 0x1p-53;  // of 1: the bound of a relative rounding error, u below
/// How far from the given time to look.
constexpr std::array kWays{0x1p-36, 0x1p-28, 0x1p-20, 0x1p-12, 0x1p-6};
constexpr int kNewtonSteps = 4;

template <std::size_t N>
class Prover
{
public:
    explicit Prover(const ElementaryPair& pair) : m_pair(pair)
    {
        subtract(pair.start, m_start);
        Polygon<N> end;
        subtract(pair.end, end);
        for (std::size_t k = 0; k < N; ++k)
        {
            m_velocity[k] = end[k] - m_start[k];
            m_size =
                std::max({m_size, m_start[k].cwiseAbs().maxCoeff(), end[k].cwiseAbs().maxCoeff()});
        }
    }

    [[nodiscard]] bool run(double distance, double time) const
    {
        if (!(m_size > 1e-60))  // below, products of four lose digits
        {
            return false;
        }
        if (distance > 0.0)
        {
            return atSomeTime(time, [&](double t) { return isWithin(distance, t); });
        }
        for (Eigen::Index axis = 0; axis < 3; ++axis)
        {
            if (staysAcross(axis))
            {
                return atSomeTime(time, [&](double t) { return isInsideAlong(axis, t); });
            }
        }
        return crosses(time);
    }

private:
    template <class Condition>
    [[nodiscard]] static bool atSomeTime(double time, const Condition& condition)
    {
        return std::ranges::any_of(
            kWays, [&](double way) { return condition(std::min(time + way, 1.0)); });
    }

    /// Off by at most 8 u M in a coordinate, where M is m_size (see pursue.cpp).
    [[nodiscard]] Polygon<N> cornersAt(double time) const
    {
        Polygon<N> q;
        for (std::size_t k = 0; k < N; ++k)
        {
            q[k] = m_start[k] + time * m_velocity[k];
        }
        return q;
    }

    [[nodiscard]] bool isWithin(double distance, double time) const
    {
        const Polygon<N> q = cornersAt(time);
        const NearestPoint nearest = nearestPoint<N>(q);
        const std::size_t corner = nearest.isInside ? 0 : nearest.edge;
        const double u = std::clamp(nearest.u, 0.0, 1.0);
        const double v =
            nearest.isInside ? std::clamp(nearest.v, 0.0, N == 4 ? 1.0 : 1.0 - u) : 0.0;
        const Vector3d point =
            q[corner] + u * (q[(corner + 1) % N] - q[corner]) + v * (q[N - 1] - q[corner]);
        // Each coordinate is off by 8 u M, and by 12 u M at most because of this sum.
        return point.norm() + 64.0 * kHalfUlp * m_size < distance;
    }

    [[nodiscard]] bool staysAcross(Eigen::Index axis) const
    {
        return std::ranges::all_of(m_pair.start,
                                   [&](const Vector3d& x)
                                   { return x[axis] == m_pair.start[0][axis]; }) &&
               std::ranges::all_of(
                   m_pair.end, [&](const Vector3d& x) { return x[axis] == m_pair.end[0][axis]; });
    }

    /// Cross products of two corners are off by 2 (2 M 8 u M) + 6 u M^2 in a component.
    [[nodiscard]] bool isInsideAlong(Eigen::Index axis, double time) const
    {
        const Polygon<N> q = cornersAt(time);
        const double error = 64.0 * kHalfUlp * m_size * m_size;
        double least = std::numeric_limits<double>::infinity();
        double most = -least;
        for (std::size_t k = 0; k < N; ++k)
        {
            const double side = q[k].cross(q[(k + 1) % N])[axis];
            least = std::min(least, side);
            most = std::max(most, side);
        }
        return least > error || most < -error;
    }

    [[nodiscard]] bool crosses(double time) const
    {
        double root = time;
        for (int i = 0; i < kNewtonSteps; ++i)
        {
            const Polygon<N> q = cornersAt(root);
            const Vector3d product = q[1].cross(q[N - 1]);
            const double slope = m_velocity[0].dot(product) +
                                 q[0].dot(m_velocity[1].cross(q[N - 1])) +
                                 q[0].dot(q[1].cross(m_velocity[N - 1]));
            root = std::clamp(root - q[0].dot(product) / slope, 0.0, 1.0);
        }
        // Corners are off by 8 u M: cross products by 40 u M^2, determinants by less than 200 u
        // M^3.
        const double error = 512.0 * kHalfUlp * m_size * m_size * m_size;
        for (const double way : kWays)
        {
            const double from = std::max(root - way, 0.0);
            const double to = std::min(root + way, 1.0);
            const double before = determinantAt(from);
            const double after = determinantAt(to);
            if ((before < -error && after > error) || (before > error && after < -error))
            {
                return isInsideFrom(from, to);
            }
        }
        return false;  // also if a division by zero has made the root no number
    }

    [[nodiscard]] double determinantAt(double time) const
    {
        const Polygon<N> q = cornersAt(time);
        return q[0].dot(q[1].cross(q[N - 1]));
    }

    /// With corners that are off by e M at most, cross products are off by 5 e M^2, the normal by
    /// 20 e M^2, and sides by less than 260 e M^4.
    [[nodiscard]] bool isInsideFrom(double from, double to) const
    {
        const Polygon<N> q = cornersAt(0.5 * (from + to));
        const double off = 8.0 * kHalfUlp + 1.01 * (to - from);  // speeds are at most 2 M
        const Vector3d normal = (q[1] - q[0]).cross(q[N - 1] - q[0]);
        const double error = 512.0 * off * m_size * m_size * m_size * m_size;
        for (std::size_t k = 0; k < N; ++k)
        {
            if (!(q[k].cross(q[(k + 1) % N]).dot(normal) > error))
            {
                return false;
            }
        }
        return off < 0.1;
    }

    const ElementaryPair& m_pair;
    Polygon<N> m_start;
    Polygon<N> m_velocity;
    double m_size = 0.0;
};
}  // namespace

bool certainlyTouch(const ElementaryPair& pair, double distance, double time)
{
    return pair.kind == ElementaryKind::VertexFace ? Prover<3>(pair).run(distance, time)
                                                   : Prover<4>(pair).run(distance, time);
}
}  // namespace bullet_ccd
