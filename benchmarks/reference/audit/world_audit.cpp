#include "benchmarks/reference/audit/world_audit.h"

#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

namespace bullet_ccd::reference
{
std::int32_t WorldAudit::add(btCollisionObject* object,
                             std::shared_ptr<const AuditMesh> mesh,
                             const Eigen::Isometry3d& X_OM)
{
    const auto body = static_cast<std::int32_t>(m_objects.size());
    double reach = 0.0;
    for (const Eigen::Vector3d& vertex : mesh->mesh().vertices)
    {
        reach = std::max(reach, (X_OM * vertex).norm());
    }
    m_objects.push_back(object);
    m_reaches.push_back(reach);
    m_scene.parts.push_back({mesh.get(), body, X_OM});
    m_scene.fixed.push_back(object->isStaticObject());
    m_meshes.push_back(std::move(mesh));
    return body;
}

void WorldAudit::addMultiBody(btMultiBody* body)
{
    m_multiBodies.push_back(body);
}

AuditResult WorldAudit::start()
{
    m_knots.assign(1, now(m_time));
    return auditPoses(m_scene, m_knots.front().poses, m_time);
}

AuditResult WorldAudit::step(double timeStep)
{
    m_knots.erase(m_knots.begin(), m_knots.end() - 1);
    const std::clock_t began = std::clock();
    m_world->stepSimulation(btScalar(timeStep), 0);
    m_seconds += double(std::clock() - began) / CLOCKS_PER_SEC;
    m_time += timeStep;
    m_knots.push_back(now(m_time));

    std::vector<double> motion{0.0};  // from the start to each knot
    for (std::size_t i = 1; i < m_knots.size(); ++i)
    {
        motion.push_back(motion.back() + motionBetween(m_knots[i - 1], m_knots[i]));
    }
    AuditResult result;
    for (std::size_t i = 1; i + 1 < m_knots.size(); ++i)
    {
        const Knot& knot = m_knots[i];
        result.add(auditPoses(m_scene, knot.poses, knot.time, knot.meeting));
    }
    const double wanted = std::ceil(motion.back() / m_density.longestMove);
    const int samples = int(std::clamp(wanted, 1.0, double(m_density.mostSamples)));
    std::size_t next = 1;  // knot at or after the sample
    for (int k = 1; k < samples; ++k)
    {
        const double at = motion.back() * k / samples;
        while (motion[next] < at)
        {
            ++next;
        }
        const double s = (at - motion[next - 1]) / (motion[next] - motion[next - 1]);
        const Knot knot = between(m_knots[next - 1], m_knots[next], s);
        result.add(auditPoses(m_scene, knot.poses, knot.time));
    }
    result.add(auditPoses(m_scene, m_knots.back().poses, m_time));
    setJoints(m_knots.back().joints);
    return result;
}

btCcdAfterImpact WorldAudit::onImpact(const btCcdImpact& impact)
{
    ++m_impacts[std::minmax<const btCollisionObject*>(impact.m_objectA, impact.m_objectB)];
    // Several impacts of one time are one knot.
    const double time = m_time + double(impact.m_time);
    if (time > m_knots.back().time)
    {
        m_knots.push_back(now(time));
    }
    for (const btCollisionObject* object : {impact.m_objectA, impact.m_objectB})
    {
        if (const std::int32_t body = indexOf(object); body != kNone)
        {
            m_knots.back().meeting.push_back(body);
        }
    }
    return btCcdAfterImpact::Solve;
}

std::int32_t WorldAudit::indexOf(const btCollisionObject* object) const
{
    const auto found = std::find(m_objects.begin(), m_objects.end(), object);
    return found == m_objects.end() ? kNone : std::int32_t(found - m_objects.begin());
}

WorldAudit::Busiest WorldAudit::busiestPair() const
{
    Busiest busiest;
    for (const auto& [pair, impacts] : m_impacts)
    {
        if (impacts > busiest.impacts)
        {
            busiest = {indexOf(pair.first), indexOf(pair.second), impacts};
        }
    }
    return busiest;
}

WorldAudit::Knot WorldAudit::now(double time) const
{
    Knot knot{.time = time};
    for (const btCollisionObject* object : m_objects)
    {
        knot.poses.push_back(btCcdToEigen(object->getWorldTransform()));
    }
    for (const btMultiBody* body : m_multiBodies)
    {
        for (int i = 0; i < body->getNumDofs(); ++i)
        {
            knot.joints.push_back(0.0);
        }
        double* joints = knot.joints.data() + knot.joints.size() - std::size_t(body->getNumDofs());
        for (int i = 0; i < body->getNumLinks(); ++i)
        {
            if (body->getLink(i).m_dofCount == 1)
            {
                *joints++ = double(body->getJointPos(i));
            }
        }
    }
    return knot;
}

void WorldAudit::setJoints(const std::vector<double>& joints)
{
    const double* next = joints.data();
    for (btMultiBody* body : m_multiBodies)
    {
        for (int i = 0; i < body->getNumLinks(); ++i)
        {
            if (body->getLink(i).m_dofCount == 1)
            {
                body->setJointPos(i, btScalar(*next++));
            }
        }
        btAlignedObjectArray<btQuaternion> rotations;
        btAlignedObjectArray<btVector3> origins;
        body->forwardKinematics(rotations, origins);
        body->updateCollisionObjectWorldTransforms(rotations, origins);
    }
}

double WorldAudit::motionBetween(const Knot& from, const Knot& to) const
{
    double farthest = 0.0;
    for (std::size_t i = 0; i < from.poses.size(); ++i)
    {
        const double shift = (to.poses[i].translation() - from.poses[i].translation()).norm();
        const Eigen::AngleAxisd turn(to.poses[i].linear() * from.poses[i].linear().transpose());
        farthest = std::max(farthest, shift + turn.angle() * m_reaches[i]);
    }
    return farthest;
}

WorldAudit::Knot WorldAudit::between(const Knot& from, const Knot& to, double s)
{
    Knot knot{.time = (1.0 - s) * from.time + s * to.time};
    for (std::size_t i = 0; i < from.joints.size(); ++i)
    {
        knot.joints.push_back((1.0 - s) * from.joints[i] + s * to.joints[i]);
    }
    setJoints(knot.joints);
    for (std::size_t i = 0; i < m_objects.size(); ++i)
    {
        const auto* link = btMultiBodyLinkCollider::upcast(m_objects[i]);
        knot.poses.push_back(link != nullptr ? btCcdToEigen(link->getWorldTransform())
                                             : betweenPoses(from.poses[i], to.poses[i], s));
    }
    return knot;
}
}  // namespace bullet_ccd::reference
