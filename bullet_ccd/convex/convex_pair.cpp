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

bool isPlain(const ConvexBody& body)
{
    return body.X_BG.matrix() == Eigen::Matrix4d::Identity();
}

ConvexCourse::ConvexCourse(const ConvexBody& bodyA, const ConvexBody& bodyB)
    : shapeA(bodyA.shape), shapeB(bodyB.shape), isPlainA(isPlain(bodyA)), isPlainB(isPlain(bodyB))
{
    const RigidMotion& a = bodyA.motion;
    const RigidMotion& b = bodyB.motion;
    D0 = b.X_W0.translation() - a.X_W0.translation();
    V = b.v_W - a.v_W;
    hasArms = !isPlainA || !isPlainB || !a.reference_B.isZero(0.0) || !b.reference_B.isZero(0.0);
    if (hasArms)
    {
        armA = armOf(bodyA);
        armB = armOf(bodyB);
        D0 += b.X_W0.linear() * b.reference_B - a.X_W0.linear() * a.reference_B;
    }
    reachA = shapeA->coreRadius + (hasArms ? armA.norm() : 0.0);
    reachB = shapeB->coreRadius + (hasArms ? armB.norm() : 0.0);
    farthest = std::sqrt(std::max(D0.squaredNorm(), Vector3d(D0 + V).squaredNorm()));
    sizes = farthest + reachA + reachB + shapeA->radius + shapeB->radius +
            std::abs(shapeB->offset) + sizeOf(a.reference_B) + sizeOf(b.reference_B);
}

namespace
{
TurnedAxes axesOf(const Spin& spin, const ConvexBody& body, bool isPlain)
{
    const auto R0 = body.motion.X_W0.linear();
    return isPlain ? TurnedAxes(spin.axis, R0) : TurnedAxes(spin.axis, R0 * body.X_BG.linear());
}
}  // namespace

ConvexPair::ConvexPair(const ConvexCourse& course, const ConvexBody& bodyA, const ConvexBody& bodyB)
    : ConvexCourse(course),
      spinA(bodyA.motion.w_W),
      spinB(bodyB.motion.w_W),
      axesA(axesOf(spinA, bodyA, isPlainA)),
      axesB(axesOf(spinB, bodyB, isPlainB)),
      spread((spinA.velocity - spinB.velocity).squaredNorm() +
             spinA.velocity.cross(spinB.velocity).norm()),
      speed(V.norm())
{
    // Some dozens of roundings of what is added up, and those of the angles.
    constexpr double kUnit = std::numeric_limits<double>::epsilon();
    rounding = kUnit * (32.0 * sizes + 4.0 * (spinA.rate * reachA + spinB.rate * reachB));
}

void ConvexPair::at(double t, ConvexPlaces& places) const
{
    places.t = t;
    places.D = D0 + t * V;
    const auto [ofA, ofB] = sinesAndCosines(spinA.rate * t, spinB.rate * t);
    places.axesA = axesA.at(ofA);
    places.axesB = axesB.at(ofB);
    places.X_BA.R.noalias() = places.RB().transpose() * places.RA();
    places.X_BA.p.noalias() = -places.RB().transpose() * places.D;
    if (hasArms)
    {
        places.X_BA.p += places.X_BA.R * armA - armB;
    }
}

GapAlong::GapAlong(const ConvexPair& pair,
                   const ConvexPlaces& places,
                   const TurningDirection& direction)
    : m_pair(pair), m_places(places), m_with(direction.with), m_n(direction.n)
{
    const Vector3d& nB = direction.n_B;
    const Vector3d nA = places.X_BA.R.transpose() * nB;
    Vector3d inA = supportPoint(*pair.shapeA, nA);
    // Of a half-space, the normal is the direction, and turns with it.
    const bool isGround = pair.shapeB->core == ConvexCore::HalfSpace;
    Vector3d inB = isGround ? Vector3d(-pair.shapeB->offset * nB) : supportPoint(*pair.shapeB, -nB);
    if (pair.hasArms)
    {
        inA += pair.armA;
        inB += pair.armB;
    }
    const double heightA = nA.dot(inA);
    const double heightB = nB.dot(inB);
    m_gap = m_n.dot(places.D) - heightA + heightB;

    // Seen from the direction, a body turns with W = body - w, and W turns: a point r of it from
    // the reference accelerates by W x (W x r) - (w x W) x r. And (n . D)'' = n'' . D + 2 n' . V.
    const Vector3d& wA = pair.spinA.velocity;
    const Vector3d& wB = pair.spinB.velocity;
    const auto follow = [&](const Spin& spin)
    {
        const Vector3d turning = spin.velocity.cross(m_n);
        m_rate = m_n.dot(pair.V) + turning.dot(places.D);
        m_bend = turning.norm() * (spin.rate * pair.farthest + 2.0 * pair.speed);
    };
    switch (m_with)
    {
        case TurningDirection::With::BodyA:
            follow(pair.spinA);
            m_rate += (places.RB() * inB).dot(m_n.cross(wB - wA));
            m_bend += pair.spread * pair.reachB;
            m_height = heightA;
            break;
        case TurningDirection::With::BodyB:
            follow(pair.spinB);
            m_rate -= (places.RA() * inA).dot(m_n.cross(wA - wB));
            m_bend += pair.spread * pair.reachA;
            m_height = heightB;
            break;
        case TurningDirection::With::Itself:
        {
            m_spin = Spin(direction.w);
            const Vector3d& w = m_spin.velocity;
            const Vector3d A = wA - w;
            const Vector3d B = wB - w;
            follow(m_spin);
            m_rate += (places.RB() * inB).dot(m_n.cross(B)) - (places.RA() * inA).dot(m_n.cross(A));
            m_bend += (A.squaredNorm() + w.cross(A).norm()) * pair.reachA +
                      (B.squaredNorm() + w.cross(B).norm()) * pair.reachB;
            break;
        }
    }
    m_bend *= 1.0 + 1e-12;
}

double GapAlong::gapAt(double t) const
{
    const ConvexPair& p = m_pair;
    const double later = t - m_places.t;
    const Vector3d D = p.D0 + t * p.V;
    const auto [ofA, ofB] = sinesAndCosines(p.spinA.rate * later, p.spinB.rate * later);
    const Turn turnA{p.spinA.axis, ofA};
    const Turn turnB{p.spinB.axis, ofB};
    const auto heightA = [&](const Vector3d& n)
    {
        const Vector3d nA = m_places.RA().transpose() * turnA.back(n);
        return supportHeight(*p.shapeA, nA) + (p.hasArms ? nA.dot(p.armA) : 0.0);
    };
    const auto heightB = [&](const Vector3d& n)
    {
        const Vector3d nB = m_places.RB().transpose() * turnB.back(n);
        return (p.hasArms ? nB.dot(p.armB) : 0.0) - supportHeight(*p.shapeB, -nB);
    };
    switch (m_with)
    {
        case TurningDirection::With::BodyA:
        {
            const Vector3d n = turnA(m_n);
            return n.dot(D) - m_height + heightB(n);
        }
        case TurningDirection::With::BodyB:
        {
            const Vector3d n = turnB(m_n);
            return n.dot(D) - heightA(n) + m_height;
        }
        case TurningDirection::With::Itself:
            break;
    }
    const Vector3d n = Turn{m_spin.axis, sinesAndCosines(m_spin.rate * later, 0.0)[0]}(m_n);
    return n.dot(D) - heightA(n) + heightB(n);
}
}  // namespace bullet_ccd
