#include "bullet_ccd/bullet/motion/btCcdObjectMotion.h"

#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <cmath>

using bullet_ccd::LinkMotion;
using bullet_ccd::RigidMotion;

bullet_ccd::MovingBody btCcdObjectMotion::body(const bullet_ccd::SsvTree& tree,
                                               const Eigen::Isometry3d& X_SG) const
{
    bullet_ccd::MovingBody result;
    result.tree = &tree;
    std::visit([&](const auto& motion) { result.motion = motion; }, m_motion);
    result.X_BG = X_BS * X_SG;
    return result;
}

bool btCcdObjectMotion::isFinite() const
{
    const auto finite = [](double value) { return std::isfinite(value); };
    const auto rigid = [](const RigidMotion& motion) {
        return motion.X_W0.matrix().allFinite() && motion.v_W.allFinite() && motion.w_W.allFinite();
    };
    if (const auto* motion = std::get_if<RigidMotion>(&m_motion))
    {
        return rigid(*motion);
    }
    const bullet_ccd::JointMotion& joints = *std::get<LinkMotion>(m_motion).motion;
    return rigid(joints.root) &&
           std::all_of(joints.positions.begin(), joints.positions.end(), finite) &&
           std::all_of(joints.rates.begin(), joints.rates.end(), finite);
}

Eigen::AlignedBox3d btCcdObjectMotion::boxOf(const Eigen::Vector3d& center_S, double radius) const
{
    const Eigen::Vector3d from = btCcdShapePoseAt(*this, 0.0) * center_S;
    Eigen::AlignedBox3d box(from);
    double around = radius;
    if (const auto* rigid = std::get_if<RigidMotion>(&m_motion))
    {
        box.extend(from + rigid->v_W);
        around += std::min(rigid->w_W.norm(), 2.0) * (X_BS * center_S).norm();
    }
    else
    {
        around += m_way;
    }
    const Eigen::Vector3d room = Eigen::Vector3d::Constant(around);
    return {box.min() - room, box.max() + room};
}

double btCcdObjectMotion::wayAt(double distance) const
{
    const auto* rigid = std::get_if<RigidMotion>(&m_motion);
    if (rigid == nullptr)
    {
        return m_way > 0.0 ? std::numeric_limits<double>::infinity() : 0.0;
    }
    const double way = rigid->v_W.norm();
    return way + rigid->w_W.norm() * (distance + way + X_BS.translation().norm());
}

Eigen::Isometry3d btCcdShapePoseAt(const btCcdObjectMotion& motion, double t)
{
    if (const auto* rigid = std::get_if<RigidMotion>(&motion.m_motion))
    {
        return rigid->at(t).X_W * motion.X_BS;
    }
    const auto& link = std::get<LinkMotion>(motion.m_motion);
    return bullet_ccd::linkStateAt(*link.tree, *link.motion, bullet_ccd::kNone, link.link, t).X_W *
           motion.X_BS;
}

RigidMotion btCcdRigidMotion(const btCollisionObject& object,
                             double timeStep,
                             double part,
                             double start)
{
    RigidMotion motion = bullet_ccd::restAt(btCcdToEigen(object.getWorldTransform()));
    const btRigidBody* body = btRigidBody::upcast(&object);
    if (body == nullptr || !body->isActive() || body->isStaticOrKinematicObject())
    {
        return motion;
    }
    motion.v_W = btCcdToEigen(body->getLinearVelocity()) * timeStep;
    motion.w_W = btCcdToEigen(body->getAngularVelocity()) * timeStep;
    if (start != 0.0)
    {
        motion.w_W = btCcdTurn(body->getAngularVelocity(), btScalar(timeStep));
    }
    motion.v_W *= part;
    motion.w_W *= part;
    if (start != 0.0)
    {
        motion.X_W0 = motion.at(start).X_W;
    }
    return motion;
}

btCcdObjectMotion btCcdLinkMotion(const btMultiBodyLinkCollider& collider,
                                  const btCcdMultiBodyMotion& links)
{
    const std::int32_t link = links.coreLink(collider.m_link);
    return {LinkMotion{&links.m_tree, &links.m_motion, link},
            links.bulletFrame(*collider.m_multiBody, collider.m_link)};
}

void btCcdReadSpeeds(const btMultiBody& body, double timeStep, std::vector<double>& speeds)
{
    speeds.resize(2 * std::size_t(body.getNumLinks() + 1));
    if (!btCcdIsStepped(body))
    {
        std::fill(speeds.begin(), speeds.end(), 0.0);
        return;
    }
    const btScalar* rates = body.getVelocityVector() + 6;
    speeds[0] = double(body.getBaseVel().length());
    speeds[1] = double(body.getBaseOmega().length());
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        const btMultibodyLink& link = body.getLink(i);
        const btScalar* rate = rates + link.m_dofOffset;
        const auto size = [&](int from, int to)
        {
            double sum = 0.0;
            for (int dof = from; dof < to; ++dof)
            {
                sum += double(rate[dof]) * double(rate[dof]);
            }
            return std::sqrt(sum);
        };
        double turning = 0.0;
        double sliding = 0.0;
        double offset = 0.0;  // of this joint from its zero, over the step
        switch (link.m_jointType)
        {
            case btMultibodyLink::eRevolute:
                turning = std::abs(double(rate[0]));
                break;
            case btMultibodyLink::eSpherical:
                turning = size(0, 3);
                break;
            case btMultibodyLink::ePrismatic:
                sliding = std::abs(double(rate[0])) * double(link.getAxisBottom(0).length());
                offset =
                    std::abs(double(link.m_jointPos[0])) * double(link.getAxisBottom(0).length());
                break;
            case btMultibodyLink::ePlanar:
                turning = std::abs(double(rate[0]));
                sliding = size(1, 3);
                offset = std::hypot(double(link.m_jointPos[1]), double(link.m_jointPos[2]));
                break;
            default:
                break;
        }
        const double toCenter = double(link.m_dVector.length());
        const double lever =
            double(link.m_eVector.length()) + toCenter + offset + sliding * timeStep;
        const std::size_t parent = 2 * std::size_t(link.m_parent + 1);
        const std::size_t own = 2 * std::size_t(i + 1);
        speeds[own] = speeds[parent] + speeds[parent + 1] * lever + turning * toCenter + sliding;
        speeds[own + 1] = speeds[parent + 1] + turning;
    }
}

RigidMotion btCcdInterpolatedMotion(const btCollisionObject& object)
{
    return bullet_ccd::motionBetween(btCcdToEigen(object.getWorldTransform()),
                                     btCcdToEigen(object.getInterpolationWorldTransform()));
}
