#include "bullet_ccd/toi/search/rigid_pair.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d crossMatrix(const Vector3d& u)
{
    Matrix3d m;
    m << 0.0, -u.z(), u.y(), u.z(), 0.0, -u.x(), -u.y(), u.x(), 0.0;
    return m;
}

/// left exp(sense angle [u]) right = parts[0] + cos(angle) parts[1] + sin(angle) parts[2].
std::array<Matrix3d, 3> turnParts(const Matrix3d& left,
                                  const Vector3d& unitAxis,
                                  double sense,
                                  const Matrix3d& right)
{
    const Matrix3d along = unitAxis * unitAxis.transpose();
    return {left * along * right,
            left * (Matrix3d::Identity() - along) * right,
            sense * (left * crossMatrix(unitAxis) * right)};
}

Matrix3d turned(const std::array<Matrix3d, 3>& parts, double angle)
{
    return parts[0] + std::cos(angle) * parts[1] + std::sin(angle) * parts[2];
}

template <class Vector, class Number, std::size_t N>
void copy(const Vector& from, Number (&to)[N])
{
    for (std::size_t k = 0; k < N; ++k)
    {
        to[k] = static_cast<Number>(from[static_cast<Eigen::Index>(k)]);
    }
}

/// One body, seen from its reference point.
struct Turning
{
    Matrix3d R0;  // tree frame in W at t = 0
    Vector3d point_W0;
    Vector3d v_W;
    Vector3d w_W;
    Vector3d arm;
    double rate;
    Vector3d axis;
    double radius;  // farthest point of the tree from the reference
    double offset;  // size of the world coordinates that the reference was rounded to
};

Turning turningOf(const MovingBody& body)
{
    const auto& m = std::get<RigidMotion>(body.motion);
    Turning t;
    t.R0 = m.X_W0.linear() * body.X_BG.linear();
    t.point_W0 = m.X_W0 * m.reference_B;
    t.v_W = m.v_W;
    t.w_W = m.w_W;
    t.arm = body.X_BG.linear().transpose() * (body.X_BG * body.tree->origin() - m.reference_B);
    t.rate = m.w_W.norm();
    t.axis = t.rate > 0.0 ? Vector3d(m.w_W / t.rate) : Vector3d(Vector3d::UnitZ());
    t.radius = t.arm.norm() + body.tree->radius();
    t.offset = m.reference_B.isZero(0.0) ? 0.0 : m.X_W0.translation().norm() + m.reference_B.norm();
    return t;
}

/// A seen from the turning frame of B, if that is asked for. With
/// W = wA - wB, d the vector from B's reference to A's and r a point of A from its reference, the
/// acceleration is (bullet_ccd/toi/README.md, "Relative motion")
///   W x (W x r) + (W x wB) x r + wB x (wB x d) - 2 wB x v
void tryFrameOfB(const Turning& a, const Turning& b, RigidFrame frame, RigidPair& pair)
{
    const Vector3d W = a.w_W - b.w_W;
    const double twist = W.cross(b.w_W).norm();
    const double farthest =
        std::max(b.w_W.cross(pair.d0).norm(), b.w_W.cross(Vector3d(pair.d0 + pair.v)).norm());
    const double constant = b.rate * farthest + 2.0 * b.w_W.cross(pair.v).norm();
    const double inFrame = constant + (W.squaredNorm() + twist) * a.radius;
    const double inWorld = a.rate * a.rate * a.radius + b.rate * b.rate * b.radius;
    if (frame == RigidFrame::Slower && inFrame >= inWorld)
    {
        return;
    }
    pair.inFrameOfB = true;
    pair.wA = W;
    pair.spinA = W.norm();
    pair.constant = constant * (1.0 + 1e-12);
    // (W x wB) x r, and what |W x n| |W x r| varies by because W turns in B's frame, with -wB.
    const double rate = W.norm();
    pair.perRadiusA = twist * (1.0 + 2.0 * rate + twist) * (1.0 + 1e-12);
    if (twist > 1e-9 * rate * rate)
    {
        // No use of the direction of W at all.
        pair.axisA = 0.0;
        pair.perRadiusA = (twist + rate * rate) * (1.0 + 1e-12);
    }
    pair.speed += b.rate * std::max(pair.d0.norm(), Vector3d(pair.d0 + pair.v).norm());
}
}  // namespace

RigidPair makeRigidPair(const MovingBody& bodyA, const MovingBody& bodyB, RigidFrame frame)
{
    const Turning a = turningOf(bodyA);
    const Turning b = turningOf(bodyB);
    RigidPair pair;
    pair.d0 = a.point_W0 - b.point_W0;
    pair.v = a.v_W - b.v_W;
    pair.wA = a.w_W;
    pair.armA = a.arm;
    pair.armB = b.arm;
    pair.reach = a.radius + b.radius;
    pair.offset = a.offset + b.offset;
    pair.speed = pair.v.norm() + a.rate * a.radius + b.rate * b.radius;
    pair.rateA = a.rate;
    pair.rateB = b.rate;
    pair.spinA = a.rate;
    pair.turnsB = b.rate > 0.0;
    const Matrix3d toB = b.R0.transpose();
    constexpr double kParallel = 1e-14;
    if (pair.turnsB && (a.rate == 0.0 || a.axis.cross(b.axis).norm() <= kParallel))
    {
        constexpr double kDeviation = 1e-12;
        pair.plane = toB * b.axis;
        pair.acrossPlane =
            kDeviation * (a.rate * a.rate * a.radius +
                          b.rate * (b.rate * (b.radius + pair.d0.norm()) + 3.0 * pair.v.norm()));
    }
    if (pair.turnsB)
    {
        pair.turnA = turnParts(Matrix3d::Identity(), a.axis, 1.0, a.R0);
        pair.turnB = turnParts(toB, b.axis, -1.0, Matrix3d::Identity());
        pair.wB = toB * b.w_W;
        pair.wBw = b.w_W;
        tryFrameOfB(a, b, frame, pair);
    }
    else
    {
        pair.turnA = turnParts(toB, a.axis, 1.0, a.R0);
        pair.turnB.fill(Matrix3d::Zero());
        pair.wB = pair.wBw = Vector3d::Zero();
        pair.d0 = toB * pair.d0 - b.arm;
        pair.v = toB * pair.v;
        pair.wA = toB * pair.wA;
    }
    return pair;
}

RigidPoses toRigidPoses(const RigidPair& pair)
{
    RigidPoses poses;
    copy(pair.d0, poses.d0);
    copy(pair.v, poses.v);
    copy(pair.wA, poses.wA);
    copy(pair.wB, poses.wB);
    copy(pair.wBw, poses.wBw);
    copy(pair.armB, poses.armB);
    for (std::size_t part = 0; part < 3; ++part)
    {
        for (int i = 0; i < 9; ++i)
        {
            poses.turnA[part][i] = static_cast<float>(pair.turnA[part](i / 3, i % 3));
            poses.turnB[part][i] = static_cast<float>(pair.turnB[part](i / 3, i % 3));
        }
    }
    poses.rateA = pair.rateA;
    poses.rateB = pair.rateB;
    poses.turnsB = pair.turnsB;
    poses.inFrameOfB = pair.inFrameOfB;
    return poses;
}

RelativeMotion RigidPair::at(double t) const
{
    Matrix3d R = turned(turnA, rateA * t);
    Vector3d p = d0 + t * v;
    Vector3d velocity = v;
    Vector3d w = wA;
    if (turnsB)
    {
        const Matrix3d Q = turned(turnB, rateB * t);
        R = Q * R;
        if (inFrameOfB)
        {
            velocity -= wBw.cross(p);
        }
        p = Q * p - armB;
        velocity = Q * velocity;
        w = Q * w;
    }
    RelativeMotion m;
    for (int i = 0; i < 9; ++i)
    {
        m.R[i] = R(i / 3, i % 3);
    }
    const bool restsB = !turnsB || inFrameOfB;
    copy(p, m.p);
    copy(armA, m.armA);
    copy(velocity, m.velocity);
    copy(w, m.wA);
    copy(armA, m.radiusArmA);
    copy(restsB ? Vector3d(Vector3d::Zero()) : wB, m.wB);
    copy(armB, m.armB);
    m.spinA = spinA;
    m.constant = constant;
    m.perRadiusA = perRadiusA;
    m.axisA = axisA;
    m.spinB = restsB ? 0.0 : rateB;
    m.perRadiusB = 0.0;
    m.axisB = 1.0;
    copy(plane, m.plane);
    m.acrossPlane = acrossPlane;
    return m;
}
}  // namespace bullet_ccd
