#include "grasp/hand/hand_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bullet_ccd::grasp
{
const std::string& linkName(const HandModel& hand, std::int32_t link)
{
    return hand.robot.tree.links[static_cast<std::size_t>(link)].name;
}

const Preshape* findPreshape(const HandModel& hand, const std::string& name)
{
    const auto found =
        std::find_if(hand.preshapes.begin(),
                     hand.preshapes.end(),
                     [&](const Preshape& preshape) { return preshape.name == name; });
    return found == hand.preshapes.end() ? nullptr : &*found;
}

const Eigen::Isometry3d& graspFrame(const HandModel& hand, const Preshape& preshape)
{
    return preshape.X_RG ? *preshape.X_RG : hand.X_RG;
}

bool fingersAreCoupled(const HandModel& hand)
{
    std::int32_t driver = kNone;
    int closing = 0;
    for (std::size_t link = 0; link < hand.closingDirections.size(); ++link)
    {
        const Joint& joint = hand.robot.tree.links[link].joint;
        if (hand.closingDirections[link] != 0 || joint.mimicOf != kNone)
        {
            const auto itsDriver =
                joint.mimicOf != kNone ? joint.mimicOf : static_cast<std::int32_t>(link);
            if (driver != kNone && itsDriver != driver)
            {
                return false;
            }
            driver = itsDriver;
            ++closing;
        }
    }
    return closing >= 2;
}

std::vector<double> closedPositions(const HandModel& hand, const std::vector<double>& from)
{
    std::vector<double> closed = from;
    for (std::size_t i = 0; i < closed.size(); ++i)
    {
        const int direction = hand.closingDirections[i];
        const Joint& joint = hand.robot.tree.links[i].joint;
        if (direction == 0)
        {
            continue;
        }
        const double limit = direction > 0 ? joint.upper : joint.lower;
        closed[i] = std::isfinite(limit) ? limit : from[i] + direction * 2.0 * std::numbers::pi;
    }
    applyMimics(hand.robot.tree, closed);
    return closed;
}
}  // namespace bullet_ccd::grasp
