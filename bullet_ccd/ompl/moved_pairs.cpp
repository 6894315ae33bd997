#include "bullet_ccd/ompl/moved_pairs.h"

#include "bullet_ccd/distance/tree_distance.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace bullet_ccd
{
using Eigen::Isometry3d;

namespace
{
bool isNear(const Ball& a, const Ball& b, double reach)
{
    const double most = a.radius + b.radius + reach;
    return (a.center - b.center).squaredNorm() < most * most;
}

/// Around all of them.
Ball ballAround(std::span<const Ball> balls)
{
    Ball around;
    for (const Ball& ball : balls)
    {
        around.center += ball.center / static_cast<double>(balls.size());
    }
    for (const Ball& ball : balls)
    {
        const double reach = (ball.center - around.center).norm() + ball.radius;
        around.radius = std::max(around.radius, reach);
    }
    return around;
}
}  // namespace

MovedPairs::MovedPairs(const ArticulatedBody& body,
                       const Environment& environment,
                       const Isometry3d& X_WR)
{
    placeRobot(body, X_WR);
    for (const RigidBody& obstacle : environment.bodies())
    {
        const Isometry3d& X_WG = obstacle.motion.X_W0;
        m_parts.push_back({.tree = obstacle.tree,
                           .X_MG = X_WG,
                           .ball = {X_WG * obstacle.tree->origin(), obstacle.tree->radius()}});
    }
    collectPairs(body);
}

void MovedPairs::placeRobot(const ArticulatedBody& body, const Isometry3d& X_WR)
{
    m_movers.emplace_back();
    std::vector<std::vector<Ball>> ballsOn(1);
    for (std::size_t i = 0; i < body.tree->size(); ++i)
    {
        const Link& link = body.tree->links[i];
        Part part{.tree = body.linkTrees[i], .X_MG = X_WR};
        if (link.parent != kNone)
        {
            const Part& parent = m_parts[static_cast<std::size_t>(link.parent)];
            part.mover = parent.mover;
            part.X_MG = parent.X_MG * linkInParent(link, body.motion->positions[i]);
            if (body.motion->rates[i] != 0.0)
            {
                m_movers.push_back({.joint = link.joint,
                                    .link = static_cast<std::int32_t>(i),
                                    .parent = parent.mover,
                                    .X_PM0 = parent.X_MG * link.X_PL0});
                ballsOn.emplace_back();
                part.mover = static_cast<std::int32_t>(m_movers.size()) - 1;
                part.X_MG = Isometry3d::Identity();
            }
        }
        if (part.tree != nullptr)
        {
            part.ball = {part.X_MG * part.tree->origin(), part.tree->radius()};
            ballsOn[static_cast<std::size_t>(part.mover)].push_back(part.ball);
        }
        m_parts.push_back(part);
    }
    for (std::size_t i = 0; i < m_movers.size(); ++i)
    {
        m_movers[i].ball = ballAround(ballsOn[i]);
    }
}

void MovedPairs::collectPairs(const ArticulatedBody& body)
{
    const auto linkCount = static_cast<std::int32_t>(body.tree->size());
    const auto obstacleCount = static_cast<std::int32_t>(m_parts.size()) - linkCount;
    for (std::int32_t link = 0; link < linkCount; ++link)
    {
        const Part& part = m_parts[static_cast<std::size_t>(link)];
        const bool isTested = part.tree != nullptr && part.mover != 0;
        for (std::int32_t k = 0; isTested && k < obstacleCount; ++k)
        {
            m_pairs.push_back({link, linkCount + k, body.maskOf({.link = link, .obstacle = k})});
        }
    }
    for (const auto& [a, b] : body.selfPairs)
    {
        if (m_parts[static_cast<std::size_t>(a)].mover !=
            m_parts[static_cast<std::size_t>(b)].mover)
        {
            m_pairs.push_back({a, b, body.maskOf({.link = a, .otherLink = b})});
        }
    }
    const auto groupOf = [&](const Pair& pair)
    {
        return std::tuple(m_parts[static_cast<std::size_t>(pair.partA)].mover,
                          m_parts[static_cast<std::size_t>(pair.partB)].mover,
                          pair.partB < linkCount ? kNone : pair.partB);
    };
    std::ranges::stable_sort(m_pairs, {}, groupOf);
    for (std::size_t i = 0; i < m_pairs.size(); ++i)
    {
        if (i == 0 || groupOf(m_pairs[i]) != groupOf(m_pairs[i - 1]))
        {
            const auto [a, b, obstacle] = groupOf(m_pairs[i]);
            m_groups.push_back({.moverA = a, .moverB = b, .obstacle = obstacle});
        }
        m_groups.back().end = i + 1;
    }
}

/// By parts, which is faster than the products of transforms.
void MovedPairs::placeMovers(std::span<const double> positions, Scratch& scratch) const
{
    scratch.X_WM.resize(m_movers.size());
    scratch.balls.resize(m_movers.size());
    scratch.X_WM[0].setIdentity();
    scratch.balls[0] = m_movers[0].ball;
    for (std::size_t i = 1; i < m_movers.size(); ++i)
    {
        const Mover& mover = m_movers[i];
        const double q = positions[static_cast<std::size_t>(mover.link)];
        const Isometry3d& X_WP = scratch.X_WM[static_cast<std::size_t>(mover.parent)];
        Isometry3d& X_WM = scratch.X_WM[i];
        X_WM.translation().noalias() =
            X_WP.linear() * mover.X_PM0.translation() + X_WP.translation();
        const Eigen::Matrix3d R = X_WP.linear() * mover.X_PM0.linear();
        if (mover.joint.type == JointType::Prismatic)
        {
            X_WM.translation() += R * (q * mover.joint.axis);
            X_WM.linear() = R;
        }
        else
        {
            X_WM.linear().noalias() = R * Eigen::AngleAxisd(q, mover.joint.axis).toRotationMatrix();
        }
        X_WM.makeAffine();
        scratch.balls[i] = {X_WM * mover.ball.center, mover.ball.radius};
    }
}

Ball MovedPairs::ballOf(const Part& part, const Scratch& scratch) const
{
    return {scratch.X_WM[static_cast<std::size_t>(part.mover)] * part.ball.center,
            part.ball.radius};
}

/// At most `enough`.
double MovedPairs::distanceOf(const Pair& pair, const Scratch& scratch, double enough) const
{
    const Part& a = m_parts[static_cast<std::size_t>(pair.partA)];
    const Part& b = m_parts[static_cast<std::size_t>(pair.partB)];
    if (!isNear(ballOf(a, scratch), ballOf(b, scratch), enough))
    {
        return enough;
    }
    const Isometry3d X_WA = scratch.X_WM[static_cast<std::size_t>(a.mover)] * a.X_MG;
    const Isometry3d X_WB = scratch.X_WM[static_cast<std::size_t>(b.mover)] * b.X_MG;
    return treeDistance(*a.tree,
                        *b.tree,
                        X_WB.inverse() * X_WA,
                        enough,
                        pair.mask != nullptr ? pair.mask->nodeMarks() : NodeMarks{})
        .distance;
}

double MovedPairs::leastDistance(std::span<const double> positions,
                                 double enough,
                                 bool any,
                                 Scratch& scratch) const
{
    placeMovers(positions, scratch);
    double least = enough;
    if (any && scratch.nearest < m_pairs.size())
    {
        least = distanceOf(m_pairs[scratch.nearest], scratch, enough);
    }
    std::size_t next = 0;
    for (const Group& group : m_groups)
    {
        const std::size_t first = std::exchange(next, group.end);
        const Ball& ballB = group.obstacle != kNone
                                ? m_parts[static_cast<std::size_t>(group.obstacle)].ball
                                : scratch.balls[static_cast<std::size_t>(group.moverB)];
        if (!isNear(scratch.balls[static_cast<std::size_t>(group.moverA)], ballB, least))
        {
            continue;
        }
        for (std::size_t i = first; i < group.end; ++i)
        {
            if (least <= 0.0 || (any && least < enough))
            {
                return least;
            }
            least = distanceOf(m_pairs[i], scratch, least);
            scratch.nearest = least < enough ? i : scratch.nearest;
        }
    }
    return least;
}
}  // namespace bullet_ccd
