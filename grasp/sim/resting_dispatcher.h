/// A dispatcher that looks for contacts only where something has moved.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <unordered_map>

namespace bullet_ccd::grasp
{
/// What a hand holds hardly moves in it. A pair whose bodies have moved relative to each other by
/// no more than a given way since its contacts were last looked for keeps these contacts, whose
/// distances follow the motion (btPersistentManifold::refreshContactPoints()). The way of all
/// points of the second body counts.
class RestingDispatcher : public btCollisionDispatcher
{
public:
    explicit RestingDispatcher(btCollisionConfiguration* configuration)
        : btCollisionDispatcher(configuration)
    {
        setNearCallback(look);
    }

    /// 0: contacts are looked for in every step [m].
    void setRestingWay(double way) { m_way = way; }

private:
    static btTransform relativePose(const btBroadphasePair& pair)
    {
        const auto* a = static_cast<btCollisionObject*>(pair.m_pProxy0->m_clientObject);
        const auto* b = static_cast<btCollisionObject*>(pair.m_pProxy1->m_clientObject);
        return a->getWorldTransform().inverseTimes(b->getWorldTransform());
    }

    [[nodiscard]] bool rests(const btBroadphasePair& pair) const
    {
        const auto known = m_poses.find(pair.m_algorithm);
        if (pair.m_algorithm == nullptr || known == m_poses.end())
        {
            return false;
        }
        const auto* b = static_cast<btCollisionObject*>(pair.m_pProxy1->m_clientObject);
        const btTransform now = relativePose(pair);
        const btMatrix3x3& was = known->second.getBasis();
        double turned = 0.0;  // of the unit vectors, squared and summed: at least the angle squared
        for (int k = 0; k < 3; ++k)
        {
            turned += (now.getBasis()[k] - was[k]).length2();
        }
        const double way = (now.getOrigin() - known->second.getOrigin()).length() +
                           btSqrt(turned) * b->getCollisionShape()->getAngularMotionDisc();
        return way <= m_way;
    }

    static void look(btBroadphasePair& pair,
                     btCollisionDispatcher& dispatcher,
                     const btDispatcherInfo& info)
    {
        auto& self = static_cast<RestingDispatcher&>(dispatcher);
        if (!self.rests(pair))
        {
            defaultNearCallback(pair, dispatcher, info);
            self.m_poses[pair.m_algorithm] = relativePose(pair);
            return;
        }
        self.m_manifolds.resize(0);
        pair.m_algorithm->getAllContactManifolds(self.m_manifolds);
        for (int i = 0; i < self.m_manifolds.size(); ++i)
        {
            btPersistentManifold& manifold = *self.m_manifolds[i];
            manifold.refreshContactPoints(manifold.getBody0()->getWorldTransform(),
                                          manifold.getBody1()->getWorldTransform());
        }
    }

    double m_way = 0.0;
    std::unordered_map<const btCollisionAlgorithm*, btTransform> m_poses;
    btManifoldArray m_manifolds;
};
}  // namespace bullet_ccd::grasp
