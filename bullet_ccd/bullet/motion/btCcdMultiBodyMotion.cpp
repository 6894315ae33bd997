#include "bullet_ccd/bullet/motion/btCcdMultiBodyMotion.h"

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
    Reader(const btMultiBody& body,
           btScalar timeStep,
           const btCcdPartOfStep& which,
           btCcdMultiBodyMotion& motion)
        : m_body(body),
          m_timeStep(timeStep),
          m_which(which),
          m_isStepped(btCcdIsStepped(body)),
          m_start(which.m_done ? -1.0 : 0.0),
          m_to(motion)
    {
    }

    void readBase();
    void readLink(int link);
    std::size_t count() const { return m_count; }

private:
    const btMultiBody& m_body;
    btScalar m_timeStep;
    const btCcdPartOfStep& m_which;
    bool m_isStepped;  // does not sleep
    double m_start;    // [parts of the step]
    btCcdMultiBodyMotion& m_to;
    std::size_t m_count = 0;

    /// How long [s] the part of the step is for something that moves then.
    double seconds(bool moves) const { return moves ? m_which.m_part * double(m_timeStep) : 0.0; }
    /// True if the joint moves in a step of the world.
    bool moves(int link) const;
    /// Rotation vector of the part of the step.
    Eigen::Vector3d turn(const btVector3& angularVelocity) const;
    /// Position and rate [per step] are of the joint at the present state.
    void append(std::int32_t parent,
                const Eigen::Isometry3d& X_PL0,
                JointType type,
                const Eigen::Vector3d& axis,
                double position,
                double rate);
    void readPlanar(const btMultibodyLink& from,
                    const btScalar* velocity,
                    bool moves,
                    Eigen::Isometry3d X_PL0);
};

bool Reader::moves(int link) const
{
    return m_body.isLinkStaticOrKinematic(link) ? m_body.isLinkAndAllAncestorsKinematic(link)
                                                : m_isStepped;
}

Eigen::Vector3d Reader::turn(const btVector3& angularVelocity) const
{
    if (m_which.m_inPieces)
    {
        return btCcdToEigen(angularVelocity) * seconds(true);
    }
    return btCcdTurn(angularVelocity, m_timeStep) * m_which.m_part;
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
    const bool kinematic = m_body.isBaseKinematic();
    const double time = seconds(kinematic || m_isStepped);
    bullet_ccd::RigidMotion& root = m_to.m_motion.root;
    root = bullet_ccd::restAt(btCcdToEigen(m_body.getBaseWorldTransform()));
    root.v_W = btCcdToEigen(m_body.getBaseVel()) * time;
    if (kinematic)
    {
        root.w_W = btCcdToEigen(m_body.getBaseOmega()) * time;
    }
    else if (m_isStepped)
    {
        root.w_W = turn(m_body.getBaseOmega());
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
    const double time = seconds(moves(link));
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
                   double(velocity[0]) * time);
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
                   double(velocity[0]) * axis.m_length * time);
            break;
        }
        case btMultibodyLink::eSpherical:
        {
            const btScalar* q = from.m_jointPos;
            X_PL0.linear() *= btCcdToEigen(btQuaternion(q[0], q[1], q[2], q[3])).toRotationMatrix();
            const btVector3 spin(velocity[0], velocity[1], velocity[2]);
            const Split turned(moves(link) ? turn(spin) : Eigen::Vector3d::Zero());
            append(parent, X_PL0, JointType::Revolute, turned.m_direction, 0.0, turned.m_length);
            break;
        }
        case btMultibodyLink::ePlanar:
            readPlanar(from, velocity, moves(link), X_PL0);
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
                        bool moves,
                        Eigen::Isometry3d X_PL0)
{
    const Eigen::Vector3d axis = Split(btCcdToEigen(from.getAxisTop(0))).m_direction;
    const Eigen::Vector3d side1 = btCcdToEigen(from.getAxisBottom(1));
    const Eigen::Vector3d side2 = btCcdToEigen(from.getAxisBottom(2));
    const double wholeStep = moves ? double(m_timeStep) : 0.0;
    const Eigen::Vector3d v =
        (double(velocity[1]) * side1 + double(velocity[2]) * side2) * wholeStep;
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
           double(velocity[0]) * seconds(moves));
    const Split drift(v);
    // The slider starts the step at 0.
    append(std::int32_t(m_count) - 1,
           Eigen::Isometry3d::Identity(),
           JointType::Prismatic,
           drift.m_direction,
           -m_start * drift.m_length,
           m_which.m_part * drift.m_length);
}

/// The reverse of Reader::readLink().
void placeJoint(btMultiBody& body, int link, const btCcdMultiBodyMotion& motion)
{
    const btMultibodyLink& to = body.getLink(link);
    const auto last = std::size_t(motion.coreLink(link));
    const double position = motion.m_motion.positions[last];
    const bullet_ccd::Link& from = motion.m_tree.links[last];
    switch (to.m_jointType)
    {
        case btMultibodyLink::eRevolute:
            body.setJointPos(link, btScalar(position));
            break;
        case btMultibodyLink::ePrismatic:
        {
            const double length = double(to.getAxisBottom(0).length());
            body.setJointPos(link, btScalar(length > 0.0 ? position / length : 0.0));
            break;
        }
        case btMultibodyLink::eSpherical:
        {
            const Eigen::Quaterniond atZero = btCcdToEigen(to.m_zeroRotParentToThis).conjugate();
            const Eigen::Quaterniond turned(from.X_PL0.linear() *
                                            rotation(position * from.joint.axis));
            const Eigen::Quaterniond q = atZero.conjugate() * turned;
            const btScalar values[] = {
                btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())};
            body.setJointPosMultiDof(link, values);
            break;
        }
        case btMultibodyLink::ePlanar:
        {
            const bullet_ccd::Link& turning = motion.m_tree.links[last - 1];
            const double angle = motion.m_motion.positions[last - 1];
            const Eigen::Vector3d origin =
                motion.bulletFrame(body, to.m_parent) * btCcdToEigen(to.m_eVector);
            const Eigen::Vector3d shift =
                turning.X_PL0.linear().transpose() * (turning.X_PL0.translation() - origin) +
                rotation(angle * turning.joint.axis) * (position * from.joint.axis);
            const btScalar values[] = {btScalar(angle),
                                       btScalar(shift.dot(btCcdToEigen(to.getAxisBottom(1)))),
                                       btScalar(shift.dot(btCcdToEigen(to.getAxisBottom(2))))};
            body.setJointPosMultiDof(link, values);
            break;
        }
        default:
            break;
    }
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
                     const btCcdPartOfStep& which)
{
    motion.m_motion.positions.clear();
    motion.m_motion.rates.clear();
    motion.m_coreLinks.clear();
    Reader reader(body, timeStep, which, motion);
    reader.readBase();
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        reader.readLink(i);
    }
    motion.m_tree.links.resize(reader.count());
}

void btCcdPlaceAtStart(btMultiBody& body, const btCcdMultiBodyMotion& motion)
{
    if (!body.isBaseKinematic())
    {
        body.setBaseWorldTransform(btCcdToBullet(motion.m_motion.root.X_W0));
    }
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        if (!body.isLinkKinematic(i))
        {
            placeJoint(body, i, motion);
        }
    }
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body.forwardKinematics(rotations, origins);
    body.updateCollisionObjectWorldTransforms(rotations, origins);
}
