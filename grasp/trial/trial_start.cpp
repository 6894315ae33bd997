#include "grasp/trial/trial_start.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"
#include "grasp/approach/approach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kLever = 0.05;  // by which a finger that turns opens [m]
constexpr int kOpenings = 4;     // each twice as wide as the one before

/// Of the link that is nearest to the object; `clearance` if that is as far away or farther.
double distanceTo(const GraspObject& object,
                  const HandModel& hand,
                  const TrialPosture& posture,
                  double clearance)
{
    const std::vector<Eigen::Isometry3d> poses =
        linkPoses(hand.robot.tree, posture.X_WH, posture.positions);
    double least = clearance;
    for (std::size_t i = 0; i < poses.size() && least > 0.0; ++i)
    {
        if (hand.linkTrees[i] != nullptr)
        {
            least = std::min(
                least, treeDistance(*hand.linkTrees[i], object.tree, poses[i], least).distance);
        }
    }
    return least;
}

bool isAbove(const HandModel& hand,
             const Eigen::Isometry3d& X_WH,
             const std::vector<double>& positions,
             const Eigen::Vector3d& up,
             double height)
{
    const std::vector<Eigen::Isometry3d> poses = linkPoses(hand.robot.tree, X_WH, positions);
    for (std::size_t i = 0; i < poses.size(); ++i)
    {
        if (hand.linkTrees[i] != nullptr && lowestHeight(*hand.linkTrees[i], poses[i], up) < height)
        {
            return false;
        }
    }
    return true;
}

/// Opens all closing joints, as far as their limits allow.
std::vector<double> opened(const HandModel& hand, std::vector<double> positions, double way)
{
    const KinematicTree& tree = hand.robot.tree;
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        if (!joint.isMovable() || joint.mimicOf != kNone || hand.closingDirections[i] == 0)
        {
            continue;
        }
        const double by = joint.type == JointType::Prismatic ? way : way / kLever;
        const double moved = positions[i] - hand.closingDirections[i] * by;
        positions[i] =
            joint.lower < joint.upper ? std::clamp(moved, joint.lower, joint.upper) : moved;
    }
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        if (joint.isMovable() && joint.mimicOf != kNone)
        {
            positions[i] =
                joint.mimicMultiplier * positions[static_cast<std::size_t>(joint.mimicOf)] +
                joint.mimicOffset;
        }
    }
    return positions;
}

Eigen::Vector3d randomDirection(std::mt19937_64& engine)
{
    std::normal_distribution<double> normal;
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    while (direction.norm() < 1e-3)
    {
        for (double& entry : direction)
        {
            entry = normal(engine);
        }
    }
    return direction.normalized();
}

Eigen::Isometry3d randomError(const TrialProtocol& protocol,
                              std::uint64_t seed,
                              const Eigen::Vector3d& center)
{
    std::mt19937_64 engine(seed);
    const Eigen::Vector3d shift = protocol.shift * randomDirection(engine);
    const Eigen::AngleAxisd turn(protocol.turn, randomDirection(engine));
    Eigen::Isometry3d error = Eigen::Isometry3d::Identity();
    error.translate(center + shift);
    error.rotate(turn);
    error.translate(-center);
    return error;
}
}  // namespace

TrialPosture heldStart(const HandModel& hand,
                       const GraspObject& object,
                       const Grasp& grasp,
                       double clearance)
{
    TrialPosture posture{.blocked = {}, .X_WH = grasp.X_WH, .positions = grasp.positions};
    TrialPosture apart = posture;
    apart.blocked = "the hand is in the object from the start: plan or close it anew";
    if (distanceTo(object, hand, apart, clearance) > 0.0)
    {
        apart.blocked.clear();
    }
    posture.X_WH.translation() -= clearance * grasp.approach_W;
    double way = clearance;
    for (int k = 0; k <= kOpenings; ++k)
    {
        const double distance = distanceTo(object, hand, posture, clearance);
        apart = distance > 0.0 ? posture : apart;
        if (distance >= clearance)
        {
            break;
        }
        posture.positions = opened(hand, grasp.positions, way);
        way *= 2.0;
    }
    return apart;
}

TrialPosture openStart(const HandModel& hand,
                       const GraspObject& object,
                       const Grasp& grasp,
                       const TrialProtocol& protocol,
                       std::uint64_t seed,
                       double clearance,
                       const Eigen::Vector3d& up)
{
    const Preshape* preshape = findPreshape(hand, grasp.preshape);
    require(preshape != nullptr,
            "trial: the hand has no preshape \"" + grasp.preshape +
                "\" of the grasp's name: give the SRDF that the grasp was planned with");
    const std::uint64_t number = static_cast<std::uint64_t>(grasp.candidate) + 1;
    const Eigen::Isometry3d error =
        randomError(protocol, seed * 0x9E3779B97F4A7C15ULL + number, object.centerOfMass);
    const Eigen::Vector3d shift =
        error.linear() * (grasp.X_WH.translation() - grasp.X_WStart.translation());
    TrialPosture posture{
        .blocked = {}, .X_WH = error * grasp.X_WStart, .positions = preshape->positions};
    // The last bits of the orientation are those of the final pose.
    posture.X_WH.linear() = error.linear() * grasp.X_WH.linear();
    const std::array bodies{RigidBody{.tree = &object.tree, .motion = {}}};
    ToiWorkspace work;
    const ArticulatedToiResult result = approachUntilContact(
        hand, Environment(bodies), posture.X_WH, posture.positions, shift, kDefaultTolerance, work);
    if (result.status == ToiStatus::Overlapping || result.status == ToiStatus::IterationLimit)
    {
        posture.blocked = "the open hand is in the object where its approach begins";
        return posture;
    }
    const bool isFree = result.status == ToiStatus::Separated;
    posture.X_WH.translation() += (isFree ? 1.0 : result.time) * shift;
    if (shift.norm() > 0.0)
    {
        posture.X_WH.translation() -= clearance * shift.normalized();
    }
    if (protocol.start == TrialStart::Table)
    {
        const double table =
            lowestHeight(object.tree, Eigen::Isometry3d::Identity(), up) - clearance;
        if (!isAbove(hand, posture.X_WH, posture.positions, up, table) ||
            !isAbove(hand, error * grasp.X_WH, grasp.positions, up, table))
        {
            posture.blocked =
                "the hand would be in the table: try another grasp, or plan with --table-top";
        }
    }
    return posture;
}
}  // namespace bullet_ccd::grasp
