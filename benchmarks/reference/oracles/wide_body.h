/// A rigid body on its way, evaluated in long double from the definition of the motion.
#pragma once

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace bullet_ccd::reference
{
using Real = long double;
using Wide = Eigen::Matrix<Real, 3, 1>;
using WideMatrix = Eigen::Matrix<Real, 3, 3>;

/// A point that turns with its body: where it is at t = 0, and its arm from the reference then.
struct Rider
{
    Wide start;
    Wide arm;
    double reach = 0.0;  ///< distance from the axis of rotation through the reference
};

struct Ball
{
    Rider center;
    double radius = 0.0;
};

struct Piece
{
    std::array<Rider, 3> corners;
    Ball ball;
};

/// A body and where it is at the instant last asked for. Positions are relative to `origin`.
class Body
{
public:
    Body(const TriangleMesh& mesh, const RigidMotion& motion)
        : m_v(motion.v_W.cast<Real>()), m_w(motion.w_W.cast<Real>()), m_spin(m_w.norm())
    {
        const WideMatrix R0 = motion.X_W0.linear().cast<Real>();
        const Wide x0 = motion.X_W0.translation().cast<Real>();
        const Wide reference = motion.reference_B.cast<Real>();
        const auto rider = [&](const Wide& p)
        { return riderAt(x0 + R0 * p, R0 * (p - reference)); };
        Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
        Eigen::Vector3d high = -low;
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        {
            const Corners corners = cornersOf(mesh, i);
            Piece piece;
            for (std::size_t k = 0; k < 3; ++k)
            {
                piece.corners[k] = rider(corners[k].cast<Real>());
                low = low.cwiseMin(corners[k]);
                high = high.cwiseMax(corners[k]);
            }
            const Wide middle =
                (corners[0].cast<Real>() + corners[1].cast<Real>() + corners[2].cast<Real>()) / 3;
            piece.ball = ballAbout(rider(middle), {&piece, 1});
            m_pieces.push_back(piece);
        }
        m_ball = ballAbout(rider((0.5 * (low + high)).cast<Real>()), m_pieces);
        m_centers.resize(m_pieces.size());
        m_centerRates.resize(m_pieces.size());
        m_stamps.assign(m_pieces.size(), 0);
    }

    [[nodiscard]] std::size_t size() const { return m_pieces.size(); }
    [[nodiscard]] double spin() const { return static_cast<double>(m_spin); }
    [[nodiscard]] const Piece& piece(std::size_t i) const { return m_pieces[i]; }
    [[nodiscard]] const Ball& ball() const { return m_ball; }

    void moveTo(Real t)
    {
        ++m_stamp;
        m_shift = t * m_v;
        m_turnLess1.setZero();
        if (m_spin > 0)
        {
            const Wide u = m_w / m_spin;
            const Real angle = t * m_spin;
            const Real half = std::sin(angle / 2);
            WideMatrix K;
            K << 0, -u.z(), u.y(), u.z(), 0, -u.x(), -u.y(), u.x(), 0;
            m_turnLess1 = std::sin(angle) * K + 2 * half * half * (K * K);
        }
    }

    [[nodiscard]] Wide at(const Rider& rider) const
    {
        return rider.start + (m_shift + m_turnLess1 * rider.arm);
    }
    [[nodiscard]] Wide rate(const Rider& rider) const
    {
        return m_v + m_w.cross(rider.arm + m_turnLess1 * rider.arm);
    }
    void setOrigin(const Wide& origin) { m_origin = origin; }

    /// Centre of the ball about a triangle, its velocity, and the corners: at the instant of the
    /// last moveTo(), relative to the origin.
    [[nodiscard]] const Eigen::Vector3d& center(std::size_t i) { return touch(i), m_centers[i]; }
    [[nodiscard]] const Eigen::Vector3d& centerRate(std::size_t i)
    {
        return touch(i), m_centerRates[i];
    }
    [[nodiscard]] WideCorners corners(std::size_t i) const
    {
        const Piece& p = m_pieces[i];
        return {
            at(p.corners[0]) - m_origin, at(p.corners[1]) - m_origin, at(p.corners[2]) - m_origin};
    }

private:
    [[nodiscard]] Rider riderAt(const Wide& start, const Wide& arm) const
    {
        const Real across = m_spin > 0 ? m_w.cross(arm).norm() / m_spin : Real(0);
        return {.start = start, .arm = arm, .reach = static_cast<double>(across * (1 + 1e-15L))};
    }

    static Ball ballAbout(const Rider& center, std::span<const Piece> pieces)
    {
        Real radius = 0;
        for (const Piece& piece : pieces)
        {
            for (const Rider& corner : piece.corners)
            {
                radius = std::max(radius, (corner.arm - center.arm).norm());
            }
        }
        return {.center = center, .radius = static_cast<double>(radius * (1 + 1e-15L))};
    }

    void touch(std::size_t i)
    {
        if (m_stamps[i] != m_stamp)
        {
            m_stamps[i] = m_stamp;
            m_centers[i] = (at(m_pieces[i].ball.center) - m_origin).cast<double>();
            m_centerRates[i] = rate(m_pieces[i].ball.center).cast<double>();
        }
    }

    Wide m_v;
    Wide m_w;
    Real m_spin;
    std::vector<Piece> m_pieces;
    Ball m_ball;
    Wide m_shift = Wide::Zero();
    WideMatrix m_turnLess1 = WideMatrix::Zero();
    Wide m_origin = Wide::Zero();
    std::uint64_t m_stamp = 0;
    std::vector<std::uint64_t> m_stamps;
    std::vector<Eigen::Vector3d> m_centers;
    std::vector<Eigen::Vector3d> m_centerRates;
};

}  // namespace bullet_ccd::reference
