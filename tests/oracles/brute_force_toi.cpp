#include "tests/oracles/brute_force_toi.h"

#include "tests/oracles/brute_force_distance.h"
#include "tests/support/shapes.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::tests
{
namespace
{
constexpr double kFloorStep = 1e-9;
constexpr double kBracket = 1e-15;

/// Crossing in (apart, crossed], as narrow as doubles allow.
double bisectCrossing(const OracleBody& a, const OracleBody& b, double apart, double crossed)
{
    while (crossed - apart > kBracket)
    {
        const double middle = 0.5 * (apart + crossed);
        if (middle <= apart || middle >= crossed)
        {
            break;
        }
        (oracleDistanceAt(a, b, middle) > 0.0 ? apart : crossed) = middle;
    }
    return crossed;
}
}  // namespace

Eigen::Isometry3d oraclePose(const RigidMotion& motion, double t)
{
    Eigen::Isometry3d X = motion.X_W0;
    X.translation() += t * motion.v_W;
    const double turn = motion.w_W.norm();
    if (turn > 0.0)
    {
        X.linear() = Eigen::AngleAxisd(t * turn, motion.w_W / turn).toRotationMatrix() *
                     motion.X_W0.linear();
    }
    return X;
}

Eigen::Isometry3d oracleLinkPose(const KinematicTree& tree,
                                 const JointMotion& motion,
                                 std::int32_t link,
                                 double t)
{
    const auto index = static_cast<std::size_t>(link);
    const Link& here = tree.links[index];
    if (here.parent == kNone)
    {
        return oraclePose(motion.root, t);
    }
    Eigen::Isometry3d X = oracleLinkPose(tree, motion, here.parent, t) * here.X_PL0;
    const double q = motion.positions[index] + t * motion.rates[index];
    if (here.joint.type == JointType::Revolute)
    {
        X.rotate(Eigen::AngleAxisd(q, here.joint.axis));
    }
    else if (here.joint.type == JointType::Prismatic)
    {
        X.translate(q * here.joint.axis);
    }
    return X;
}

OracleBody oracleBody(const TriangleMesh& mesh, const RigidMotion& motion)
{
    return {.mesh = &mesh,
            .poseAt = [motion](double t) { return oraclePose(motion, t); },
            .speed = motion.v_W.norm() + motion.w_W.norm() * radiusOf(mesh)};
}

OracleBody oracleLink(const TriangleMesh& mesh,
                      const KinematicTree& tree,
                      const JointMotion& motion,
                      std::int32_t link)
{
    double speed = 0.0;
    double reach = radiusOf(mesh);
    std::int32_t at = link;
    for (; tree.links[static_cast<std::size_t>(at)].parent != kNone;
         at = tree.links[static_cast<std::size_t>(at)].parent)
    {
        const auto index = static_cast<std::size_t>(at);
        const Link& here = tree.links[index];
        const double q = motion.positions[index];
        const double rate = motion.rates[index];
        if (here.joint.type == JointType::Revolute)
        {
            speed += std::abs(rate) * reach;
        }
        else if (here.joint.type == JointType::Prismatic)
        {
            speed += std::abs(rate);
            reach += std::max(std::abs(q), std::abs(q + rate));
        }
        reach += here.X_PL0.translation().norm();
    }
    speed += motion.root.v_W.norm() + motion.root.w_W.norm() * reach;
    return {.mesh = &mesh,
            .poseAt = [&tree, &motion, link](double t)
            { return oracleLinkPose(tree, motion, link, t); },
            .speed = speed};
}

double oracleDistanceAt(const OracleBody& a, const OracleBody& b, double t)
{
    const Eigen::Isometry3d X_BA = b.poseAt(t).inverse() * a.poseAt(t);
    return bruteForceMeshDistance(*a.mesh, *b.mesh, X_BA).distance;
}

OracleToi bruteForceToi(const OracleBody& a, const OracleBody& b)
{
    const double speed = a.speed + b.speed;
    OracleToi result;
    double t = 0.0;
    double distance = oracleDistanceAt(a, b, t);
    result.minDistance = distance;
    if (distance == 0.0)
    {
        result.low = 0.0;
        result.contact = 0.0;
        return result;
    }
    bool certified = true;
    double floorStep = kFloorStep;
    while (t < 1.0 && speed > 0.0)
    {
        double step = distance / speed;
        if (step >= floorStep)
        {
            floorStep = kFloorStep;
        }
        else
        {
            result.low = certified ? t : result.low;
            certified = false;
            step = floorStep;
            floorStep *= 2.0;
        }
        const double next = std::min(1.0, t + step);
        distance = oracleDistanceAt(a, b, next);
        result.minDistance = std::min(result.minDistance, distance);
        if (distance == 0.0)
        {
            result.contact = bisectCrossing(a, b, t, next);
            // Certified steps only: the crossing lies at the very end of the last one.
            result.low = certified ? *result.contact : result.low;
            break;
        }
        t = next;
    }
    return result;
}
}  // namespace bullet_ccd::tests
