#include "grasp/hand/hand_inference.h"

#include "bullet_ccd/motion/kinematic_tree.h"

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

/// The joints that flex one finger, and how.
struct Flexion
{
    std::size_t finger = 0;
    /// One entry a link: +1 or -1 for a driving joint that turns (or slides) with the finger's
    /// common axis as it grows, against it, 0 for all others.
    std::vector<int> senses;
};

/// Flexing are the joints whose axes are nearly parallel to the last one of the finger, at zero;
/// the others spread or turn it.
Flexion findFlexion(const HandModel& hand, std::size_t finger, const std::vector<bool>& isPassive)
{
    constexpr double kMinCosine = 0.9;
    const KinematicTree& tree = hand.robot.tree;
    std::vector<double> zero(tree.size(), 0.0);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        zero[i] = clampToLimits(tree.links[i].joint, 0.0);
    }
    applyMimics(tree, zero);
    const std::vector<Eigen::Isometry3d> poses =
        linkPoses(tree, Eigen::Isometry3d::Identity(), zero);
    Flexion flexion{finger, std::vector<int>(tree.size(), 0)};
    std::int32_t last = kNone;
    for (const std::int32_t link : hand.fingers[finger].links)
    {
        last = linkAt(tree, link).joint.isMovable() ? link : last;
    }
    for (const std::int32_t link : hand.fingers[finger].links)
    {
        const Joint& joint = linkAt(tree, link).joint;
        const std::size_t driver = driverOf(tree, link);
        // The joint nearest to the palm decides how a driver moves the finger: those behind it may
        // turn back to keep the tip upright.
        if (!joint.isMovable() || isPassive[driver] || flexion.senses[driver] != 0 ||
            (joint.type == JointType::Prismatic) !=
                (linkAt(tree, last).joint.type == JointType::Prismatic))
        {
            continue;
        }
        const Eigen::Vector3d axis = poses[static_cast<std::size_t>(link)].linear() * joint.axis;
        const Eigen::Vector3d common =
            poses[static_cast<std::size_t>(last)].linear() * linkAt(tree, last).joint.axis;
        const double ratio = joint.mimicOf == kNone ? 1.0 : joint.mimicMultiplier;
        if (std::abs(axis.dot(common)) > kMinCosine && ratio != 0.0)
        {
            flexion.senses[driver] = (axis.dot(common) > 0.0) == (ratio > 0.0) ? 1 : -1;
        }
    }
    return flexion;
}

/// How much nearer the fingertip comes to `center` at best when all flexing joints of the finger
/// move together from `positions` to their limits, `sense` times their own senses.
double closingGain(const HandModel& hand,
                   const Flexion& flexion,
                   const std::vector<double>& positions,
                   const Eigen::Vector3d& center,
                   int sense)
{
    constexpr int kSamples = 12;
    const double before = (fingertips(hand, positions)[flexion.finger] - center).norm();
    double best = 0.0;
    for (int k = 1; k <= kSamples; ++k)
    {
        std::vector<double> moved = positions;
        for (std::size_t i = 0; i < moved.size(); ++i)
        {
            const Joint& joint = hand.robot.tree.links[i].joint;
            const int direction = sense * flexion.senses[i];
            if (direction != 0)
            {
                const double limit = direction > 0 ? joint.upper : joint.lower;
                const double target = std::isfinite(limit)
                                          ? limit
                                          : positions[i] + direction * 0.5 * std::numbers::pi;
                moved[i] += (target - positions[i]) * k / kSamples;
            }
        }
        best = std::max(best, before - (fingertips(hand, moved)[flexion.finger] - center).norm());
    }
    return best;
}

/// How much farther from zero the limits of the flexing joints are on the positive side.
double rangeExcess(const KinematicTree& tree, const Flexion& flexion)
{
    double sum = 0.0;
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        if (flexion.senses[i] != 0 && std::isfinite(joint.lower) && std::isfinite(joint.upper))
        {
            sum += flexion.senses[i] * (joint.lower + joint.upper);
        }
    }
    return sum;
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
    // Below this share of the better sense's gain, the difference of the two says nothing.
    constexpr double kClearShare = 0.2;

    const KinematicTree& tree = hand.robot.tree;
    std::vector<double> positions(tree.size(), 0.0);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        positions[i] = middle(tree.links[i].joint);
    }
    const Eigen::Vector3d center =
        0.5 * (mean(fingertips(hand, positions)) + palmCenter(hand, positions));
    std::vector<double> gains(tree.size(), -1.0);
    std::vector<int> directions(tree.size(), 0);
    for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger)
    {
        const Flexion flexion = findFlexion(hand, finger, isPassive);
        const double with = closingGain(hand, flexion, positions, center, 1);
        const double against = closingGain(hand, flexion, positions, center, -1);
        const double gain = std::max(with, against);
        const double excess = rangeExcess(tree, flexion);
        const bool isClear =
            std::abs(with - against) > kClearShare * gain || std::abs(excess) < 1e-9;
        const int sense = (isClear ? with >= against : excess > 0.0) ? 1 : -1;
        for (std::size_t i = 0; i < tree.size(); ++i)
        {
            // A joint that drives several fingers obeys the one that it helps most.
            if (flexion.senses[i] != 0 && gain > gains[i])
            {
                directions[i] = sense * flexion.senses[i];
                gains[i] = gain;
            }
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

std::vector<Preshape> inferOpenings(const HandModel& hand, const Preshape& open)
{
    const std::vector<Link>& links = hand.robot.tree.links;
    const auto hasNoLimit = [&](std::size_t link)
    {
        const double limit =
            hand.closingDirections[link] > 0 ? links[link].joint.upper : links[link].joint.lower;
        return hand.closingDirections[link] != 0 && !std::isfinite(limit);
    };
    std::vector<Preshape> openings;
    for (std::size_t link = 0; link < links.size(); ++link)
    {
        if (!fingersAreCoupled(hand) || hasNoLimit(link))
        {
            return {};
        }
    }
    const std::vector<double> closed = closedPositions(hand, open.positions);
    for (const auto& [name, share] : {std::pair("half", 0.5), std::pair("near", 0.25)})
    {
        Preshape opening{name, closed};
        for (std::size_t link = 0; link < closed.size(); ++link)
        {
            opening.positions[link] += share * (open.positions[link] - closed[link]);
        }
        applyMimics(hand.robot.tree, opening.positions);
        openings.push_back(std::move(opening));
    }
    return openings;
}

Eigen::Isometry3d inferGraspFrame(const HandModel& hand, const std::vector<double>& open)
{
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
