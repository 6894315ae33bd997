#include "bullet_ccd/bullet/btCcdMultiBodyMotion.h"

#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

using bullet_ccd::JointType;

namespace
{
bool isAsleep(const btMultiBodyLinkCollider* collider)
{
    return collider != nullptr && collider->getActivationState() == ISLAND_SLEEPING;
}

/// Unit axis in the link's frame, and by how much Bullet's coordinate has to be stretched: Bullet
/// uses a prismatic axis as it is, whatever its length.
struct Axis
{
    Eigen::Vector3d m_axis = Eigen::Vector3d::UnitX();
    double m_stretch = 1.0;
};

Axis jointAxis(const btMultibodyLink& link)
{
    const bool prismatic = link.m_jointType == btMultibodyLink::ePrismatic;
    const Eigen::Vector3d axis =
        btCcdToEigen(prismatic ? link.getAxisBottom(0) : link.getAxisTop(0));
    const double length = axis.norm();
    if (!(length > 0.0))
    {
        return {};
    }
    return {axis / length, prismatic ? length : 1.0};
}

JointType jointType(const btMultibodyLink& link)
{
    switch (link.m_jointType)
    {
        case btMultibodyLink::eRevolute:
            return JointType::Revolute;
        case btMultibodyLink::ePrismatic:
            return JointType::Prismatic;
        default:
            return JointType::Fixed;
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
        const auto type = body.getLink(i).m_jointType;
        if (type != btMultibodyLink::eRevolute && type != btMultibodyLink::ePrismatic &&
            type != btMultibodyLink::eFixed)
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

void btCcdReadMotion(const btMultiBody& body, btScalar timeStep, btCcdMultiBodyMotion& motion)
{
    const auto count = std::size_t(body.getNumLinks()) + 1;
    const double dt = btCcdIsStepped(body) ? double(timeStep) : 0.0;
    motion.m_tree.links.resize(count);
    motion.m_motion.positions.assign(count, 0.0);
    motion.m_motion.rates.assign(count, 0.0);

    bullet_ccd::RigidMotion& root = motion.m_motion.root;
    root = bullet_ccd::restAt(btCcdToEigen(body.getBaseWorldTransform()));
    if (!body.isBaseKinematic())
    {
        root.v_W = btCcdToEigen(body.getBaseVel()) * dt;
        root.w_W = btCcdToEigen(body.getBaseOmega()) * dt;
    }
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        const btMultibodyLink& from = body.getLink(i);
        const std::size_t index = std::size_t(i) + 1;
        const Axis axis = jointAxis(from);
        bullet_ccd::Link& link = motion.m_tree.links[index];
        link.parent = from.m_parent + 1;
        link.joint.type = jointType(from);
        link.joint.axis = axis.m_axis;
        link.X_PL0.linear() =
            btCcdToEigen(from.m_zeroRotParentToThis).conjugate().toRotationMatrix();
        link.X_PL0.translation() =
            motion.bulletFrame(body, from.m_parent) * btCcdToEigen(from.m_eVector);
        if (!link.joint.isMovable())
        {
            continue;
        }
        motion.m_motion.positions[index] = double(from.m_jointPos[0]) * axis.m_stretch;
        if (!body.isLinkStaticOrKinematic(i))
        {
            motion.m_motion.rates[index] = double(body.getJointVel(i)) * axis.m_stretch * dt;
        }
    }
}
