#include "tests/grasp/planner/toi_closing.h"

#include "bullet_ccd/toi/articulated_toi.h"

#include <algorithm>
#include <array>

namespace bullet_ccd::tests
{
namespace
{
/// Stops the joints between the link and the root, and whatever moves with them.
void stopLink(const KinematicTree& tree, std::int32_t link, std::vector<double>& rates)
{
    for (; link != kNone; link = tree.links[static_cast<std::size_t>(link)].parent)
    {
        const Joint& joint = tree.links[static_cast<std::size_t>(link)].joint;
        const std::int32_t driver = joint.mimicOf != kNone ? joint.mimicOf : link;
        for (std::size_t k = 0; k < rates.size(); ++k)
        {
            if (static_cast<std::int32_t>(k) == driver || tree.links[k].joint.mimicOf == driver)
            {
                rates[k] = 0.0;
            }
        }
    }
}
}  // namespace

grasp::ClosingResult closeByToi(const grasp::HandModel& hand,
                                const grasp::GraspObject& object,
                                const Eigen::Isometry3d& X_WH,
                                const std::vector<double>& positions,
                                const grasp::ClosingOptions& options)
{
    const KinematicTree& tree = hand.robot.tree;
    const std::vector<double> closed = grasp::closedPositions(hand, positions);
    JointMotion motion{.root = restAt(X_WH), .positions = positions, .rates = closed};
    for (std::size_t k = 0; k < closed.size(); ++k)
    {
        motion.rates[k] -= positions[k];
    }
    const std::vector<double> fullRates = motion.rates;
    const std::array obstacles{RigidBody{.tree = &object.tree, .motion = {}}};
    ToiWorkspace work;
    grasp::ClosingResult result;
    double elapsed = 0.0;
    const auto isMoving = [&]
    {
        return std::any_of(
            motion.rates.begin(), motion.rates.end(), [](double rate) { return rate != 0.0; });
    };
    while (elapsed < 1.0 && isMoving())
    {
        const ArticulatedBody body{.tree = &tree,
                                   .linkTrees = hand.linkTrees,
                                   .motion = &motion,
                                   .selfPairs = hand.selfPairs};
        const ArticulatedToiResult step =
            articulatedToi(body, obstacles, {.tolerance = options.tolerance}, work);
        result.status = step.status;
        ++result.steps;
        for (std::size_t k = 0; k < motion.positions.size(); ++k)
        {
            motion.positions[k] += step.time * motion.rates[k];
        }
        elapsed += step.time * (1.0 - elapsed);
        if (step.status != ToiStatus::Hit)
        {
            break;
        }
        for (const LinkContact& contact : step.contacts)
        {
            result.stops.push_back(
                {.link = contact.link, .time = elapsed, .byObject = contact.obstacle != kNone});
            stopLink(tree, contact.link, motion.rates);
            if (contact.otherLink != kNone)
            {
                stopLink(tree, contact.otherLink, motion.rates);
            }
        }
        // The next step runs over what is left of the time.
        for (std::size_t k = 0; k < motion.rates.size(); ++k)
        {
            motion.rates[k] = motion.rates[k] == 0.0 ? 0.0 : (1.0 - elapsed) * fullRates[k];
        }
    }
    result.positions = motion.positions;
    return result;
}
}  // namespace bullet_ccd::tests
