#include "grasp/formats/content_hash.h"

#include "grasp/hand/hash.h"

#include <algorithm>

namespace bullet_ccd::grasp
{
std::string contentHash(const HandModel& hand)
{
    Hash hash;
    for (std::size_t link = 0; link < hand.robot.tree.size(); ++link)
    {
        hash.add(hand.robot.tree.links[link]);
        if (hand.linkTrees[link] != nullptr)
        {
            hash.add(contentHash(hand.linkTrees[link]->mesh()));
        }
        hash.add(static_cast<std::int32_t>(hand.closingDirections[link]));
    }
    for (const double speed : hand.closingSpeeds)
    {
        hash.add(speed);
    }
    for (const Preshape& preshape : hand.preshapes)
    {
        hash.add(preshape.name);
        std::for_each(preshape.positions.begin(),
                      preshape.positions.end(),
                      [&](double position) { hash.add(position); });
        if (preshape.X_RG)
        {
            hash.add(*preshape.X_RG);
        }
    }
    for (const auto& [first, second] : hand.selfPairs)
    {
        hash.add(first);
        hash.add(second);
    }
    hash.add(hand.X_RG);
    return hexadecimal(hash.value());
}

std::string contentHash(const GraspObject& object)
{
    return hexadecimal(contentHash(object.tree.mesh()));
}

std::string contentHash(std::span<const RigidBody> obstacles)
{
    Hash hash;
    for (const RigidBody& obstacle : obstacles)
    {
        hash.add(contentHash(obstacle.tree->mesh()));
        hash.add(obstacle.motion.X_W0);
    }
    return obstacles.empty() ? std::string() : hexadecimal(hash.value());
}
}  // namespace bullet_ccd::grasp
