#include "grasp/hand/hand_inference.h"

#include "bullet_ccd/motion/joint_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
bool hasGeometry(const RobotModel& robot, std::int32_t link)
{
    return !robot.linkMeshes[static_cast<std::size_t>(link)].triangles.empty();
}

const Link& linkAt(const KinematicTree& tree, std::int32_t link)
{
    return tree.links[static_cast<std::size_t>(link)];
}

/// The first movable joint at or above the link, as the link below it; kNone if there is none.
std::int32_t movableAbove(const KinematicTree& tree, std::int32_t link)
{
    while (link != kNone &&
           (linkAt(tree, link).parent == kNone || !linkAt(tree, link).joint.isMovable()))
    {
        link = linkAt(tree, link).parent;
    }
    return link;
}

/// Ends of branches: links with geometry, on a movable joint that carries no later link with
/// geometry of a further movable joint.
std::vector<std::int32_t> findTips(const RobotModel& robot)
{
    const KinematicTree& tree = robot.tree;
    const auto count = static_cast<std::int32_t>(tree.size());
    std::vector<std::int32_t> lastOf(tree.size(), kNone);  // per movable joint: its last geometry
    std::vector<bool> isInner(tree.size(), false);
    for (std::int32_t link = 0; link < count; ++link)
    {
        const std::int32_t joint = movableAbove(tree, link);
        if (joint == kNone || !hasGeometry(robot, link))
        {
            continue;
        }
        lastOf[static_cast<std::size_t>(joint)] = link;
        for (std::int32_t above = movableAbove(tree, linkAt(tree, joint).parent); above != kNone;
             above = movableAbove(tree, linkAt(tree, above).parent))
        {
            isInner[static_cast<std::size_t>(above)] = true;
        }
    }
    std::vector<std::int32_t> tips;
    for (std::size_t joint = 0; joint < tree.size(); ++joint)
    {
        if (lastOf[joint] != kNone && !isInner[joint])
        {
            tips.push_back(lastOf[joint]);
        }
    }
    return tips;
}

/// Driving joint of the joint above `link`.
std::size_t driverOf(const KinematicTree& tree, std::int32_t link)
{
    const std::int32_t leader = linkAt(tree, link).joint.mimicOf;
    return static_cast<std::size_t>(leader == kNone ? link : leader);
}

/// Zero for joints without limits.
double middle(const Joint& joint)
{
    return std::isfinite(joint.lower) && std::isfinite(joint.upper)
               ? 0.5 * (joint.lower + joint.upper)
               : clampToLimits(joint, 0.0);
}

std::vector<Eigen::Vector3d> fingertips(const HandModel& hand, std::vector<double> positions)
{
    applyMimics(hand.robot.tree, positions);
    const std::vector<Eigen::Isometry3d> poses =
        linkPoses(hand.robot.tree, Eigen::Isometry3d::Identity(), positions);
    std::vector<Eigen::Vector3d> tips;
    for (const Finger& finger : hand.fingers)
    {
        tips.push_back(fingertip(hand.robot, finger, poses));
    }
    return tips;
}

Eigen::Vector3d mean(const std::vector<Eigen::Vector3d>& points)
{
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& point : points)
    {
        sum += point;
    }
    return sum / static_cast<double>(std::max<std::size_t>(points.size(), 1));
}

/// Centre of the palm's bounding box, or its origin, root frame.
Eigen::Vector3d palmCenter(const HandModel& hand, std::vector<double> positions)
{
    applyMimics(hand.robot.tree, positions);
    const Eigen::Isometry3d X = linkPoses(hand.robot.tree,
                                          Eigen::Isometry3d::Identity(),
                                          positions)[static_cast<std::size_t>(hand.palm)];
    const TriangleMesh& mesh = hand.robot.linkMeshes[static_cast<std::size_t>(hand.palm)];
    return mesh.triangles.empty() ? Eigen::Vector3d(X.translation()) : X * bounds(mesh).center();
}

/// How much nearer the fingertips come to `center` at best when joint `driver` alone moves from
/// `positions` by up to `reach` in `direction`, summed over the fingers.
double closingGain(const HandModel& hand,
                   const std::vector<double>& positions,
                   const Eigen::Vector3d& center,
                   std::size_t driver,
                   int direction)
{
    constexpr int kSamples = 6;
    const Joint& joint = hand.robot.tree.links[driver].joint;
    const double limit = direction > 0 ? joint.upper : joint.lower;
    const double target =
        std::isfinite(limit) ? limit : positions[driver] + direction * 0.5 * std::numbers::pi;
    const std::vector<Eigen::Vector3d> before = fingertips(hand, positions);
    double best = 0.0;
    for (int k = 1; k <= kSamples; ++k)
    {
        std::vector<double> moved = positions;
        moved[driver] += (target - positions[driver]) * k / kSamples;
        const std::vector<Eigen::Vector3d> after = fingertips(hand, moved);
        double gain = 0.0;
        for (std::size_t i = 0; i < after.size(); ++i)
        {
            gain += (before[i] - center).norm() - (after[i] - center).norm();
        }
        best = std::max(best, gain);
    }
    return best;
}
}  // namespace

double clampToLimits(const Joint& joint, double q)
{
    return std::max(joint.lower, std::min(joint.upper, q));
}

std::int32_t palmAbove(const KinematicTree& tree, std::vector<Finger>& fingers)
{
    std::int32_t palm = fingers[0].links.back();
    std::vector<int> uses(tree.size(), 0);
    for (const Finger& finger : fingers)
    {
        palm = commonAncestor(tree, palm, finger.links.back());
        for (const std::int32_t link : finger.links)
        {
            ++uses[static_cast<std::size_t>(link)];
        }
    }
    if (fingers.size() == 1)
    {
        palm = linkAt(tree, fingers[0].links.front()).parent;
    }
    for (Finger& finger : fingers)
    {
        std::erase_if(finger.links,
                      [&](std::int32_t link)
                      { return uses[static_cast<std::size_t>(link)] > 1 || link == palm; });
    }
    return palm;
}

std::vector<Finger> inferFingers(const RobotModel& robot, std::int32_t& palm)
{
    std::vector<Finger> fingers;
    for (const std::int32_t tip : findTips(robot))
    {
        Finger finger;
        finger.name = linkAt(robot.tree, tip).name;
        for (std::int32_t link = tip; link != 0; link = linkAt(robot.tree, link).parent)
        {
            finger.links.insert(finger.links.begin(), link);
        }
        fingers.push_back(std::move(finger));
    }
    if (!fingers.empty())
    {
        palm = palmAbove(robot.tree, fingers);
    }
    return fingers;
}

Eigen::Vector3d fingertip(const RobotModel& robot,
                          const Finger& finger,
                          const std::vector<Eigen::Isometry3d>& poses)
{
    for (auto link = finger.links.rbegin(); link != finger.links.rend(); ++link)
    {
        if (hasGeometry(robot, *link))
        {
            const auto index = static_cast<std::size_t>(*link);
            return poses[index] * bounds(robot.linkMeshes[index]).center();
        }
    }
    return poses[static_cast<std::size_t>(finger.links.back())].translation();
}

std::vector<int> inferClosingDirections(const HandModel& hand, const std::vector<bool>& isPassive)
{
    // Spreading joints also bring tips a little nearer to the centre; flexing ones do much more.
    constexpr double kSidewaysShare = 0.35;

    const KinematicTree& tree = hand.robot.tree;
    std::vector<double> positions(tree.size(), 0.0);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        positions[i] = middle(tree.links[i].joint);
    }
    const Eigen::Vector3d center =
        0.5 * (mean(fingertips(hand, positions)) + palmCenter(hand, positions));
    std::vector<double> gains(tree.size(), 0.0);
    std::vector<int> directions(tree.size(), 0);
    for (const Finger& finger : hand.fingers)
    {
        double largest = 0.0;
        for (const std::int32_t link : finger.links)
        {
            const std::size_t driver = driverOf(tree, link);
            if (!linkAt(tree, link).joint.isMovable() || isPassive[driver])
            {
                continue;
            }
            const double up = closingGain(hand, positions, center, driver, 1);
            const double down = closingGain(hand, positions, center, driver, -1);
            directions[driver] = up >= down ? 1 : -1;
            gains[driver] = std::max(up, down);
            largest = std::max(largest, gains[driver]);
        }
        for (const std::int32_t link : finger.links)
        {
            const std::size_t driver = driverOf(tree, link);
            directions[driver] = gains[driver] > kSidewaysShare * largest ? directions[driver] : 0;
        }
    }
    return directions;
}

Preshape inferPreshape(const HandModel& hand)
{
    constexpr double kMaxBackward = 20.0 * std::numbers::pi / 180.0;
    const KinematicTree& tree = hand.robot.tree;
    Preshape preshape{"open", std::vector<double>(tree.size(), 0.0)};
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        const int direction = hand.closingDirections[i];
        double q = clampToLimits(joint, 0.0);
        if (direction != 0)
        {
            const double limit = direction > 0 ? joint.lower : joint.upper;
            const bool isRevolute = joint.type == JointType::Revolute;
            q = std::isfinite(limit) ? limit : q;
            q = isRevolute && direction > 0 ? std::max(q, clampToLimits(joint, -kMaxBackward)) : q;
            q = isRevolute && direction < 0 ? std::min(q, clampToLimits(joint, kMaxBackward)) : q;
        }
        preshape.positions[i] = joint.isMovable() ? q : 0.0;
    }
    applyMimics(tree, preshape.positions);
    return preshape;
}

Eigen::Isometry3d inferGraspFrame(const HandModel& hand)
{
    const std::vector<double>& open = hand.preshapes[0].positions;
    const std::vector<double> closed = closedPositions(hand, open);
    std::vector<double> half(open.size());
    for (std::size_t i = 0; i < open.size(); ++i)
    {
        half[i] = 0.5 * (open[i] + closed[i]);
    }
    const std::vector<Eigen::Vector3d> tips = fingertips(hand, half);
    const std::vector<Eigen::Vector3d> before = fingertips(hand, open);
    // The finger that moves most against the others.
    std::size_t opposing = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < tips.size(); ++i)
    {
        double sum = 0.0;
        for (std::size_t k = 0; k < tips.size(); ++k)
        {
            sum += k == i
                       ? 0.0
                       : (tips[i] - before[i]).normalized().dot((tips[k] - before[k]).normalized());
        }
        if (sum < least)
        {
            least = sum;
            opposing = i;
        }
    }
    std::vector<Eigen::Vector3d> others = tips;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(opposing));
    const Eigen::Vector3d across = mean(others) - tips[opposing];
    const Eigen::Vector3d origin = tips[opposing] + 0.5 * across;
    Eigen::Vector3d x = across.normalized();
    const Eigen::Vector3d away = origin - palmCenter(hand, half);
    Eigen::Vector3d z = away - away.dot(x) * x;
    if (!(across.norm() > 1e-6) || !(z.norm() > 1e-6))
    {
        x = Eigen::Vector3d::UnitX();
        z = Eigen::Vector3d::UnitZ();
    }
    z.normalize();
    Eigen::Isometry3d X_RG = Eigen::Isometry3d::Identity();
    X_RG.linear() << x, z.cross(x), z;
    X_RG.translation() = origin;
    return X_RG;
}
}  // namespace bullet_ccd::grasp
