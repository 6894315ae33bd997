#include "bullet_ccd/motion/kinematic_tree.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
const Link& linkOf(const KinematicTree& tree, std::int32_t index)
{
    return tree.links[static_cast<std::size_t>(index)];
}

/// What holds of the joint above the link, which is not the root: of a spherical one its angular
/// speed.
JointPathBounds boundsOf(const KinematicTree& tree, const JointMotion& motion, std::int32_t link)
{
    const Joint& joint = linkOf(tree, link).joint;
    if (joint.type == JointType::Spherical)
    {
        const double speed = motion.ball(link).rate.norm();
        return {.lowestRate = speed, .highestRate = speed};
    }
    return joint.isMovable() ? motion.path(link).bounds() : JointPathBounds{};
}

bool turns(const Link& link)
{
    return link.joint.type == JointType::Revolute || link.joint.type == JointType::Spherical;
}

/// State of a link below a spherical joint, from its parent's.
MotionState ballStateAt(const Link& link,
                        const BallMotion& ball,
                        const MotionState& parent,
                        double t)
{
    const Eigen::Isometry3d X_WJ = parent.X_W * link.X_PL0;
    const RigidMotion turn{.v_W = Eigen::Vector3d::Zero(), .w_W = ball.rate};
    MotionState state;
    state.X_W = X_WJ * turn.at(t).X_W;
    state.X_W.linear() *= ball.start;
    state.w_W = parent.w_W + X_WJ.linear() * ball.rate;
    state.v_W = parent.v_W + parent.w_W.cross(state.X_W.translation() - parent.X_W.translation());
    return state;
}
}  // namespace

BallMotion ballBetween(const Eigen::Matrix3d& start, const Eigen::Matrix3d& end)
{
    Eigen::Isometry3d first = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d last = Eigen::Isometry3d::Identity();
    first.linear() = start;
    last.linear() = end;
    return {.start = start, .rate = motionBetween(first, last).w_W};
}

JointMotion partOf(const JointMotion& motion, double begin, double end)
{
    JointMotion part = motion;
    part.root = partOf(motion.root, begin, end);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(part.positions.size()); ++i)
    {
        part.setPath(i, motion.path(i).partOf(begin, end));
    }
    for (BallMotion& ball : part.balls)
    {
        const RigidMotion turn{.v_W = Eigen::Vector3d::Zero(), .w_W = ball.rate};
        ball.start = turn.at(begin).X_W.linear() * ball.start;
        ball.rate *= end - begin;
    }
    return part;
}

MotionState linkStateAt(const KinematicTree& tree,
                        const JointMotion& motion,
                        std::int32_t base,
                        std::int32_t link,
                        double t)
{
    if (link == base)
    {
        return {};
    }
    const Link& here = linkOf(tree, link);
    if (here.parent == kNone)
    {
        return motion.root.at(t);
    }
    const MotionState parent = linkStateAt(tree, motion, base, here.parent, t);
    if (here.joint.type == JointType::Spherical)
    {
        return ballStateAt(here, motion.ball(link), parent, t);
    }
    const JointPath path = motion.path(link);
    const double rate = here.joint.isMovable() ? path.rateAt(t) : 0.0;

    MotionState state;
    state.X_W = parent.X_W * linkInParent(here, path.at(t));
    state.w_W = parent.w_W;
    state.v_W = parent.v_W + parent.w_W.cross(state.X_W.translation() - parent.X_W.translation());
    if (rate != 0.0)
    {
        const Eigen::Vector3d axisRate = rate * (state.X_W.linear() * here.joint.axis);
        (here.joint.type == JointType::Revolute ? state.w_W : state.v_W) += axisRate;
    }
    return state;
}

AccelerationBound linkAccelerationBound(const KinematicTree& tree,
                                        const JointMotion& motion,
                                        std::int32_t base,
                                        std::int32_t link)
{
    // Second derivative of a point P of the last link, o_k the joints' origins, from
    // d2P/dq_j dq_k = a_j x (a_k x (P - o_k)) for j <= k, both revolute, and a_j x a_k for a
    // prismatic k; a prismatic j before k contributes nothing.
    double total = 0.0;    // sum of the angular speeds between base and link
    double turning = 0.0;  // and of the angular accelerations of the joints themselves
    for (std::int32_t k = link; k != base && k != kNone; k = linkOf(tree, k).parent)
    {
        const Link& here = linkOf(tree, k);
        if (here.parent == kNone)
        {
            total += motion.root.w_W.norm();
        }
        else if (turns(here))
        {
            const JointPathBounds own = boundsOf(tree, motion, k);
            total += own.speed();
            turning += own.bend;
        }
    }

    AccelerationBound bound{.constant = 0.0, .perRadius = total * total + turning};
    double above = total;  // angular speed of the joints above k
    double reach = 0.0;    // bound of |o_link - o_k|
    for (std::int32_t k = link; k != base && k != kNone; k = linkOf(tree, k).parent)
    {
        const Link& here = linkOf(tree, k);
        if (here.parent == kNone)
        {
            const double spin = motion.root.w_W.norm();
            bound.constant += spin * reach * spin;
            break;
        }
        const JointPathBounds own = boundsOf(tree, motion, k);
        const double rate = own.speed();
        double travel = 0.0;
        if (turns(here))
        {
            above -= rate;
            bound.constant += reach * (rate * (rate + 2.0 * std::max(above, 0.0)) + own.bend);
        }
        else if (here.joint.type == JointType::Prismatic)
        {
            travel = own.reach;
            bound.constant += 2.0 * rate * std::max(above, 0.0) + own.bend;
        }
        reach += here.X_PL0.translation().norm() + travel;
    }
    bound.constant *= 1.0 + 1e-12;
    bound.perRadius *= 1.0 + 1e-12;
    return bound;
}

std::int32_t commonAncestor(const KinematicTree& tree, std::int32_t linkA, std::int32_t linkB)
{
    while (linkA != linkB)
    {
        std::int32_t& deeper = linkA > linkB ? linkA : linkB;
        deeper = linkOf(tree, deeper).parent;
    }
    return linkA;
}

bool moves(const KinematicTree& tree,
           const JointMotion& motion,
           std::int32_t base,
           std::int32_t link)
{
    for (std::int32_t k = link; k != base; k = linkOf(tree, k).parent)
    {
        if (linkOf(tree, k).parent == kNone)
        {
            return !motion.root.v_W.isZero(0.0) || !motion.root.w_W.isZero(0.0);
        }
        const Joint& joint = linkOf(tree, k).joint;
        if (joint.type == JointType::Spherical ? !motion.ball(k).rate.isZero(0.0)
                                               : joint.isMovable() && !motion.path(k).isConstant())
        {
            return true;
        }
    }
    return false;
}
}  // namespace bullet_ccd
