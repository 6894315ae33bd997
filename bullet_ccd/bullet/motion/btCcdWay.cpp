#include "bullet_ccd/bullet/motion/btCcdWay.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <cmath>

namespace
{
constexpr double kJump = 4.0;
/// A frame has fewer steps.
constexpr double kMostParts = 1e4;
/// A velocity may be off by this part of the way.
constexpr double kInexact = 0.1;

double lengthOf(const btVector3& v)
{
    return double(v.length());
}

/// How many steps at its velocity make the way, from `came` and `turned` [rad]; 0: none do.
double stepsOf(const btVector3& came,
               double turned,
               const btRigidBody& body,
               const btCcdWay::Step& step)
{
    const btVector3 advance = body.getLinearVelocity() * btScalar(step.m_duration);
    const double angle = step.m_duration * lengthOf(body.getAngularVelocity());
    const double length = lengthOf(advance);
    const double reach = step.m_reach;
    double steps = 1.0;
    if (lengthOf(came) > 1.5 * length + step.m_rounding ||
        turned * reach > 1.5 * angle * reach + step.m_rounding)
    {
        steps = std::round(length > angle * reach ? lengthOf(came) / length : turned / angle);
    }
    const bool isExplained =
        steps >= 1.0 && steps < kMostParts &&
        std::abs(turned - steps * angle) * reach <=
            kInexact * steps * angle * reach + step.m_rounding &&
        lengthOf(came - advance * btScalar(steps)) <= kInexact * lengthOf(came) + step.m_rounding;
    return isExplained ? steps : 0.0;
}
}  // namespace

void btCcdWay::go(const btRigidBody& body, const Step& step)
{
    if (m_step == step.m_number)
    {
        return;
    }
    const bool isSameFrame = !step.m_isTold && m_step == step.m_number - 1 &&
                             m_part + 1 < m_parts && m_bullets == body.getLinearVelocity() &&
                             m_to == body.getWorldTransform();
    if (isSameFrame)
    {
        ++m_part;
    }
    else
    {
        beginFrame(body, step);
    }
    takePart(step);
    m_step = step.m_number;
}

void btCcdWay::rest(const btRigidBody& body, int step)
{
    m_from = m_to = m_start = m_end = body.getWorldTransform();
    m_velocity = m_spin = m_bullets = btVector3(0, 0, 0);
    m_jumped = false;
    m_ahead = 0.0;
    m_length = 0.0;
    m_part = 0;
    m_parts = 1;
    m_step = step;
}

void btCcdWay::beginFrame(const btRigidBody& body, const Step& step)
{
    const bool isKnown = m_step == step.m_number - 1;
    const btTransform before = m_to;
    const double lengthBefore = m_length;
    rest(body, step.m_number);
    m_bullets = body.getLinearVelocity();
    if (isKnown && before == m_to)
    {
        return;
    }
    const bool isMoving =
        m_bullets != btVector3(0, 0, 0) || body.getAngularVelocity() != btVector3(0, 0, 0);
    double steps = 1.0;
    if (isKnown && isMoving)
    {
        const double turned =
            bullet_ccd::motionBetween(btCcdToEigen(before), btCcdToEigen(m_to)).w_W.norm();
        steps = stepsOf(m_to.getOrigin() - before.getOrigin(), turned, body, step);
    }
    if (isKnown && steps > 0.0)
    {
        m_from = before;
        m_parts = int(steps);
    }
    else
    {
        bullet_ccd::RigidMotion back = bullet_ccd::restAt(btCcdToEigen(m_to));
        back.v_W = -step.m_duration * btCcdToEigen(m_bullets);
        back.w_W = -step.m_duration * btCcdToEigen(body.getAngularVelocity());
        m_from = btCcdToBullet(back.at(1.0).X_W);
    }
    m_length = lengthOf(m_to.getOrigin() - m_from.getOrigin()) / m_parts;
    m_jumped = step.m_isTold || (m_length > kJump * step.m_reach && m_length > 2.0 * lengthBefore);
    if (m_jumped)
    {
        m_from = m_to;
        m_parts = 1;
    }
}

void btCcdWay::takePart(const Step& step)
{
    const auto frame = bullet_ccd::motionBetween(btCcdToEigen(m_from), btCcdToEigen(m_to));
    const double begin = double(m_part) / m_parts;
    const double end = double(m_part + 1) / m_parts;
    m_start = m_part == 0 ? m_from : m_end;
    m_end = end < 1.0 ? btCcdToBullet(frame.at(end).X_W) : m_to;
    m_velocity = btCcdToBullet(Eigen::Vector3d(frame.v_W / (m_parts * step.m_duration)));
    m_spin = btCcdToBullet(Eigen::Vector3d(frame.w_W / (m_parts * step.m_duration)));
    m_ahead = (1.0 - begin) * (frame.v_W.norm() + frame.w_W.norm() * step.m_reach);
}
