#include "bullet_ccd/bullet/btCcdMultiBodyMotion.h"

#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btTransformUtil.h>

#include <cmath>

using bullet_ccd::JointType;

namespace
{
bool isAsleep(const btMultiBodyLinkCollider* collider)
{
    return collider != nullptr && collider->getActivationState() == ISLAND_SLEEPING;
}

/// A vector as unit direction and length; any direction for the null vector.
struct Split
{
    Eigen::Vector3d m_direction = Eigen::Vector3d::UnitX();
    double m_length = 0.0;

    explicit Split(const Eigen::Vector3d& v) : m_length(v.norm())
    {
        if (m_length > 0.0)
        {
            m_direction = v / m_length;
        }
    }
};

Eigen::Matrix3d rotation(const Eigen::Vector3d& turn)
{
    const Split split(turn);
    return Eigen::AngleAxisd(split.m_length, split.m_direction).toRotationMatrix();
}

/// Appends links of the core and their motion.
class Reader
{
public:
    Reader(const btMultiBody& body, btScalar timeStep, double start, btCcdMultiBodyMotion& motion)
        : m_body(body),
          m_timeStep(timeStep),
          m_steppedTime(btCcdIsStepped(body) ? timeStep : btScalar(0)),
          m_start(start),
          m_to(motion)
    {
    }

    void readBase();
    void readLink(int link);
    std::size_t count() const { return m_count; }

private:
    const btMultiBody& m_body;
    btScalar m_timeStep;
    btScalar m_steppedTime;  // 0 for a body that sleeps
    double m_start;
    btCcdMultiBodyMotion& m_to;
    std::size_t m_count = 0;

    /// How long [s] the joint moves in a step of the world.
    btScalar movingTime(int link) const;
    /// Position and rate [per step] are of the joint at the present state.
    void append(std::int32_t parent,
                const Eigen::Isometry3d& X_PL0,
                JointType type,
                const Eigen::Vector3d& axis,
                double position,
                double rate);
    void readPlanar(const btMultibodyLink& from,
                    const btScalar* velocity,
                    double seconds,
                    Eigen::Isometry3d X_PL0);
};

btScalar Reader::movingTime(int link) const
{
    if (!m_body.isLinkStaticOrKinematic(link))
    {
        return m_steppedTime;
    }
    return m_body.isLinkAndAllAncestorsKinematic(link) ? m_timeStep : btScalar(0);
}

void Reader::append(std::int32_t parent,
                    const Eigen::Isometry3d& X_PL0,
                    JointType type,
                    const Eigen::Vector3d& axis,
                    double position,
                    double rate)
{
    if (m_to.m_tree.links.size() == m_count)
    {
        m_to.m_tree.links.emplace_back();
    }
    bullet_ccd::Link& link = m_to.m_tree.links[m_count];
    link.parent = parent;
    link.joint.type = type;
    link.joint.axis = axis;
    link.X_PL0 = X_PL0;
    m_to.m_motion.positions.push_back(position + m_start * rate);
    m_to.m_motion.rates.push_back(rate);
    ++m_count;
}

void Reader::readBase()
{
    const btScalar time = m_body.isBaseKinematic() ? m_timeStep : m_steppedTime;
    bullet_ccd::RigidMotion& root = m_to.m_motion.root;
    root = bullet_ccd::restAt(btCcdToEigen(m_body.getBaseWorldTransform()));
    root.v_W = btCcdToEigen(m_body.getBaseVel()) * double(time);
    root.w_W = btCcdTurn(m_body.getBaseOmega(), time);
    if (m_body.isBaseKinematic())
    {
        root.w_W = btCcdToEigen(m_body.getBaseOmega()) * double(time);
    }
    if (m_start != 0.0)
    {
        root.X_W0.translation() += m_start * root.v_W;
        root.X_W0.linear() = rotation(m_start * root.w_W) * root.X_W0.linear();
    }
    append(bullet_ccd::kNone,
           Eigen::Isometry3d::Identity(),
           JointType::Fixed,
           Eigen::Vector3d::UnitX(),
           0.0,
           0.0);
    m_to.m_coreLinks.push_back(0);
}

void Reader::readLink(int link)
{
    const btMultibodyLink& from = m_body.getLink(link);
    const btScalar time = movingTime(link);
    const double seconds = double(time);
    const btScalar* velocity = m_body.getJointVelMultiDof(link);
    const std::int32_t parent = m_to.coreLink(from.m_parent);
    Eigen::Isometry3d X_PL0 = Eigen::Isometry3d::Identity();
    X_PL0.linear() = btCcdToEigen(from.m_zeroRotParentToThis).conjugate().toRotationMatrix();
    X_PL0.translation() = m_to.bulletFrame(m_body, from.m_parent) * btCcdToEigen(from.m_eVector);
    switch (from.m_jointType)
    {
        case btMultibodyLink::eRevolute:
            append(parent,
                   X_PL0,
                   JointType::Revolute,
                   Split(btCcdToEigen(from.getAxisTop(0))).m_direction,
                   double(from.m_jointPos[0]),
                   double(velocity[0]) * seconds);
            break;
        case btMultibodyLink::ePrismatic:
        {
            // Bullet uses the axis as it is, whatever its length.
            const Split axis(btCcdToEigen(from.getAxisBottom(0)));
            append(parent,
                   X_PL0,
                   JointType::Prismatic,
                   axis.m_direction,
                   double(from.m_jointPos[0]) * axis.m_length,
                   double(velocity[0]) * axis.m_length * seconds);
            break;
        }
        case btMultibodyLink::eSpherical:
        {
            const btScalar* q = from.m_jointPos;
            X_PL0.linear() *= btCcdToEigen(btQuaternion(q[0], q[1], q[2], q[3])).toRotationMatrix();
            const Split turn(btCcdTurn(btVector3(velocity[0], velocity[1], velocity[2]), time));
            append(parent, X_PL0, JointType::Revolute, turn.m_direction, 0.0, turn.m_length);
            break;
        }
        case btMultibodyLink::ePlanar:
            readPlanar(from, velocity, seconds, X_PL0);
            break;
        default:
            append(parent, X_PL0, JointType::Fixed, Eigen::Vector3d::UnitX(), 0.0, 0.0);
    }
    m_to.m_coreLinks.push_back(std::int32_t(m_count) - 1);
}

/// With p the shift and a the angle: a step of length s gives a(s) = a + s a', p(s) = p + R(a(s)) v
/// s, where v is the velocity in the turned frame. The other way round, from the end of a step: p =
/// p(1) - R(a(1)) v.
void Reader::readPlanar(const btMultibodyLink& from,
                        const btScalar* velocity,
                        double seconds,
                        Eigen::Isometry3d X_PL0)
{
    const Eigen::Vector3d axis = Split(btCcdToEigen(from.getAxisTop(0))).m_direction;
    const Eigen::Vector3d side1 = btCcdToEigen(from.getAxisBottom(1));
    const Eigen::Vector3d side2 = btCcdToEigen(from.getAxisBottom(2));
    const Eigen::Vector3d v = (double(velocity[1]) * side1 + double(velocity[2]) * side2) * seconds;
    const double angle = double(from.m_jointPos[0]);
    const Eigen::Vector3d shift =
        double(from.m_jointPos[1]) * side1 + double(from.m_jointPos[2]) * side2;
    X_PL0.translation() +=
        X_PL0.linear() * (shift + m_start * (Eigen::AngleAxisd(angle, axis) * v));
    append(m_to.coreLink(from.m_parent),
           X_PL0,
           JointType::Revolute,
           axis,
           angle,
           double(velocity[0]) * seconds);
    const Split drift(v);
    // The slider starts the step at 0.
    append(std::int32_t(m_count) - 1,
           Eigen::Isometry3d::Identity(),
           JointType::Prismatic,
           drift.m_direction,
           -m_start * drift.m_length,
           drift.m_length);
}
}  // namespace

Eigen::Isometry3d btCcdMultiBodyMotion::bulletFrame(const btMultiBody& body, int link) const
{
    Eigen::Isometry3d X_JL = Eigen::Isometry3d::Identity();
    if (link >= 0)
    {
        X_JL.translation() = btCcdToEigen(body.getLink(link).m_dVector);
    }
    return X_JL;
}

bool btCcdIsCovered(const btMultiBody& body)
{
    if (body.isUsingRK4Integration())
    {
        return false;
    }
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        if (body.getLink(i).m_jointType >= btMultibodyLink::eInvalid)
        {
            return false;
        }
    }
    return true;
}

bool btCcdIsStepped(const btMultiBody& body)
{
    bool asleep = isAsleep(body.getBaseCollider());
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        asleep = asleep || isAsleep(body.getLink(i).m_collider);
    }
    return !asleep;
}

Eigen::Vector3d btCcdTurn(const btVector3& angularVelocity, btScalar timeStep)
{
    const Eigen::Vector3d turn = btCcdToEigen(angularVelocity) * double(timeStep);
    const double angle = turn.norm();
    constexpr double kThreshold = double(ANGULAR_MOTION_THRESHOLD);
    if (!(angle > kThreshold))
    {
        return turn;
    }
    // The quaternion (sin(c / 2) turn / c, cos(c / 2)), normalised, with c the threshold.
    const double effective = 2.0 * std::atan(angle / kThreshold * std::tan(0.5 * kThreshold));
    return turn * (effective / angle);
}

void btCcdReadMotion(const btMultiBody& body,
                     btScalar timeStep,
                     btCcdMultiBodyMotion& motion,
                     double start)
{
    motion.m_motion.positions.clear();
    motion.m_motion.rates.clear();
    motion.m_coreLinks.clear();
    Reader reader(body, timeStep, start, motion);
    reader.readBase();
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        reader.readLink(i);
    }
    motion.m_tree.links.resize(reader.count());
}
