/// Which links of a hand may meet in a Bullet world.
#pragma once

#include "grasp/hand/hand_model.h"

#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
/// Lets only those pairs of links meet that the hand lists, and every link all other objects.
class HandPairs : public btOverlapFilterCallback
{
public:
    explicit HandPairs(const HandModel& hand)
    {
        for (const auto& [a, b] : hand.selfPairs)
        {
            m_pairs.emplace_back(std::min(a, b), std::max(a, b));
        }
        std::sort(m_pairs.begin(), m_pairs.end());
    }

    [[nodiscard]] bool mayMeet(std::int32_t linkA, std::int32_t linkB) const
    {
        return std::binary_search(m_pairs.begin(),
                                  m_pairs.end(),
                                  std::pair(std::min(linkA, linkB), std::max(linkA, linkB)));
    }

    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override
    {
        const std::int32_t linkA = linkOf(static_cast<btCollisionObject*>(a->m_clientObject));
        const std::int32_t linkB = linkOf(static_cast<btCollisionObject*>(b->m_clientObject));
        return linkA == kNone || linkB == kNone || mayMeet(linkA, linkB);
    }

    /// Index in the hand, or kNone for what is no link.
    static std::int32_t linkOf(const btCollisionObject* object)
    {
        const auto* collider = btMultiBodyLinkCollider::upcast(object);
        return collider != nullptr ? collider->m_link + 1 : kNone;
    }

private:
    std::vector<std::pair<std::int32_t, std::int32_t>> m_pairs;
};
}  // namespace bullet_ccd::grasp
