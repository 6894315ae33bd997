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
/// points and distances follow the motion (btPersistentManifold::refreshContactPoints()), as do
/// their normals, which turn with both bodies. The way of all points of the second body counts.
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
    struct Known
    {
        btTransform relative;   ///< pose of the second body in the first, at the last search
        btMatrix3x3 direction;  ///< of the second body in the world, in the last step
    };

    static const btTransform& poseOf(const btBroadphaseProxy& proxy)
    {
        return static_cast<const btCollisionObject*>(proxy.m_clientObject)->getWorldTransform();
    }
    static btTransform relativePose(const btBroadphasePair& pair)
    {
        return poseOf(*pair.m_pProxy0).inverseTimes(poseOf(*pair.m_pProxy1));
    }

    [[nodiscard]] bool rests(const btBroadphasePair& pair, const Known& known) const
    {
        const auto* b = static_cast<btCollisionObject*>(pair.m_pProxy1->m_clientObject);
        const btTransform now = relativePose(pair);
        const btMatrix3x3& was = known.relative.getBasis();
        double turned = 0.0;  // of the unit vectors, squared and summed: at least the angle squared
        for (int k = 0; k < 3; ++k)
        {
            turned += (now.getBasis()[k] - was[k]).length2();
        }
        const double way = (now.getOrigin() - known.relative.getOrigin()).length() +
                           btSqrt(turned) * b->getCollisionShape()->getAngularMotionDisc();
        return way <= m_way;
    }

    static void look(btBroadphasePair& pair,
                     btCollisionDispatcher& dispatcher,
                     const btDispatcherInfo& info)
    {
        auto& self = static_cast<RestingDispatcher&>(dispatcher);
        const btMatrix3x3& direction = poseOf(*pair.m_pProxy1).getBasis();
        const auto known = self.m_known.find(pair.m_algorithm);
        if (pair.m_algorithm == nullptr || known == self.m_known.end() ||
            !self.rests(pair, known->second))
        {
            defaultNearCallback(pair, dispatcher, info);
            self.m_known[pair.m_algorithm] = {relativePose(pair), direction};
            return;
        }
        const btMatrix3x3 turn = direction * known->second.direction.transpose();
        known->second.direction = direction;
        // Bullet's algorithm for two compounds does not say which ones it has.
        const void* a = pair.m_pProxy0->m_clientObject;
        const void* b = pair.m_pProxy1->m_clientObject;
        for (int i = 0; i < self.getNumManifolds(); ++i)
        {
            btPersistentManifold& manifold = *self.getManifoldByIndexInternal(i);
            const void* first = manifold.getBody0();
            const void* second = manifold.getBody1();
            if (!(first == a && second == b) && !(first == b && second == a))
            {
                continue;
            }
            for (int k = 0; k < manifold.getNumContacts(); ++k)
            {
                btVector3& normal = manifold.getContactPoint(k).m_normalWorldOnB;
                normal = turn * normal;
            }
            manifold.refreshContactPoints(manifold.getBody0()->getWorldTransform(),
                                          manifold.getBody1()->getWorldTransform());
        }
    }

    double m_way = 0.0;
    std::unordered_map<const btCollisionAlgorithm*, Known> m_known;
};
}  // namespace bullet_ccd::grasp
