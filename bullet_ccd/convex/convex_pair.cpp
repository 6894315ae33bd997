#include "bullet_ccd/convex/convex_pair.h"

#include "bullet_ccd/convex/convex_toi.h"
#include "bullet_ccd/convex/support.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace
{
/// Sum of the sizes of the entries: not less than the norm, and cheaper.
double sizeOf(const Vector3d& x)
{
    return x.lpNorm<1>();
}

/// Where the shape is in its body, seen from the body's reference point, in the shape's axes.
Vector3d armOf(const ConvexBody& body)
{
    return body.X_BG.linear().transpose() * (body.X_BG.translation() - body.motion.reference_B);
}
}  // namespace

ConvexPair::ConvexPair(const ConvexBody& bodyA, const ConvexBody& bodyB)
    : shapeA(bodyA.shape), shapeB(bodyB.shape), armA(armOf(bodyA)), armB(armOf(bodyB))
{
    const RigidMotion& a = bodyA.motion;
    const RigidMotion& b = bodyB.motion;
    D0 = (b.X_W0.translation() - a.X_W0.translation()) +
         (b.X_W0.linear() * b.reference_B - a.X_W0.linear() * a.reference_B);
    V = b.v_W - a.v_W;
    hasArms = !armA.isZero(0.0) || !armB.isZero(0.0);
    reachA = shapeA->coreRadius + (hasArms ? armA.norm() : 0.0);
    reachB = shapeB->coreRadius + (hasArms ? armB.norm() : 0.0);
    farthest = std::sqrt(std::max(D0.squaredNorm(), Vector3d(D0 + V).squaredNorm()));
}

void ConvexPair::prepareTurns(const ConvexBody& bodyA, const ConvexBody& bodyB)
{
    const RigidMotion& a = bodyA.motion;
    const RigidMotion& b = bodyB.motion;
    spinA = Spin(a.w_W);
    spinB = Spin(b.w_W);
    RA0 = a.X_W0.linear() * bodyA.X_BG.linear();
    RB0 = b.X_W0.linear() * bodyB.X_BG.linear();
    axesA = TurnedAxes(spinA.axis, RA0);
    axesB = TurnedAxes(spinB.axis, RB0);
    speed = V.norm();
    // Some dozens of roundings of what is added up, and those of the angles.
    constexpr double kUnit = std::numeric_limits<double>::epsilon();
    const double sizes = farthest + reachA + reachB + shapeA->radius + shapeB->radius +
                         std::abs(shapeB->offset) + sizeOf(a.reference_B) + sizeOf(b.reference_B);
    rounding = kUnit * (32.0 * sizes + 4.0 * (spinA.rate * reachA + spinB.rate * reachB));
}

namespace
{
Matrix3d axesAt(const Spin& spin, const TurnedAxes& axes, const Matrix3d& R0, double t)
{
    if (spin.rate == 0.0)
    {
        return R0;
    }
    const SineAndCosine of = sineAndCosine(spin.rate * t);
    return axes.along + of.cosine * axes.across + of.sine * axes.ahead;
}
}  // namespace

void ConvexPair::at(double t, ConvexPlaces& places) const
{
    places.t = t;
    places.D = D0 + t * V;
    places.RA = axesAt(spinA, axesA, RA0, t);
    places.RB = axesAt(spinB, axesB, RB0, t);
    places.X_BA.R.noalias() = places.RB.transpose() * places.RA;
    places.X_BA.p = -(places.RB.transpose() * places.D);
    if (hasArms)
    {
        places.X_BA.p += places.X_BA.R * armA - armB;
    }
}

GapAlong::GapAlong(const ConvexPair& pair,
                   const ConvexPlaces& places,
                   const TurningDirection& direction)
    : m_pair(pair),
      m_with(direction.with),
      m_n(direction.n),
      m_nA(places.RA.transpose() * m_n),
      m_nB(places.RB.transpose() * m_n),
      m_start(places.t)
{
    if (m_with == TurningDirection::With::Itself)
    {
        m_spin = Spin(direction.w);
    }
    const Spin& spin = m_with == TurningDirection::With::BodyA   ? pair.spinA
                       : m_with == TurningDirection::With::BodyB ? pair.spinB
                                                                 : m_spin;
    const Vector3d& w = spin.velocity;
    const Vector3d inA = supportPoint(*pair.shapeA, m_nA) + pair.armA;
    // Of a half-space, the normal is the direction, and turns with it.
    const bool isGround = pair.shapeB->core == ConvexCore::HalfSpace;
    const Vector3d inB =
        (isGround ? Vector3d(-pair.shapeB->offset * m_nB) : supportPoint(*pair.shapeB, -m_nB)) +
        pair.armB;
    m_heightA = m_nA.dot(inA);
    m_heightB = m_nB.dot(inB);
    m_gap = m_n.dot(places.D) - m_heightA + m_heightB;

    const Vector3d a = places.RA * inA;
    const Vector3d b = places.RB * inB;
    const Vector3d turning = w.cross(m_n);
    m_rate = m_n.dot(pair.V - pair.spinA.velocity.cross(a) + pair.spinB.velocity.cross(b)) +
             turning.dot(places.D - a + b);

    // Seen from the direction, a body turns with W = body - w, and W turns: a point r of it from
    // the reference accelerates by W x (W x r) - (w x W) x r. And (n . D)'' = n'' . D + 2 n' . V.
    if (m_with != TurningDirection::With::BodyA)
    {
        const Vector3d W = pair.spinA.velocity - w;
        m_bend += (W.squaredNorm() + w.cross(W).norm()) * pair.reachA;
    }
    if (m_with != TurningDirection::With::BodyB)
    {
        const Vector3d W = pair.spinB.velocity - w;
        m_bend += (W.squaredNorm() + w.cross(W).norm()) * pair.reachB;
    }
    m_bend += turning.norm() * (spin.rate * pair.farthest + 2.0 * pair.speed);
    m_bend *= 1.0 + 1e-12;
}

double GapAlong::gapAt(double t) const
{
    const ConvexPair& p = m_pair;
    const Turn turnA(p.spinA, t);
    const Turn turnB(p.spinB, t);
    const auto heightA = [&](const Vector3d& n)
    {
        const Vector3d nA = p.RA0.transpose() * turnA.back(n);
        return nA.dot(p.armA) + supportHeight(*p.shapeA, nA);
    };
    const auto heightB = [&](const Vector3d& n)
    {
        const Vector3d nB = p.RB0.transpose() * turnB.back(n);
        return nB.dot(p.armB) - supportHeight(*p.shapeB, -nB);
    };
    const Vector3d D = p.D0 + t * p.V;
    switch (m_with)
    {
        case TurningDirection::With::BodyA:
        {
            const Vector3d n = turnA(p.RA0 * m_nA);
            return n.dot(D) - m_heightA + heightB(n);
        }
        case TurningDirection::With::BodyB:
        {
            const Vector3d n = turnB(p.RB0 * m_nB);
            return n.dot(D) - heightA(n) + m_heightB;
        }
        case TurningDirection::With::Itself:
            break;
    }
    const Vector3d n = Turn(m_spin, t - m_start)(m_n);
    return n.dot(D) - heightA(n) + heightB(n);
}

double certifiedRoot(double first, double last, double length, double bend)
{
    // first + b s + bend s^2 / 2 is the chord less its sag.
    const double b = (last - first) / length - 0.5 * bend * length;
    if (b >= 0.0)
    {
        return length;
    }
    const double square = b * b - 2.0 * bend * first;
    if (square < 0.0)
    {
        return length;
    }
    const double root = 2.0 * first / (std::sqrt(square) - b);
    return root < length ? root * (1.0 - 1e-13) : length;
}
}  // namespace bullet_ccd
