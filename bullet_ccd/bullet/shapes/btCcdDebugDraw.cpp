#include "bullet_ccd/bullet/shapes/btCcdDebugDraw.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/shapes/btCcdTiles.h"

#include <algorithm>

using bullet_ccd::SsvNode;
using bullet_ccd::SsvTree;

namespace
{
const btVector3& volumeColor()
{
    static const btVector3 kColor(btScalar(0.2), btScalar(0.8), btScalar(1));
    return kColor;
}

const btVector3& sweptColor()
{
    static const btVector3 kColor(1, 1, 0);
    return kColor;
}

const btVector3& impactColor()
{
    static const btVector3 kColor(1, 0, 0);
    return kColor;
}

/// @param radius of the ball that sweeps the part, in addition to the node's
void drawVolume(const SsvTree& tree,
                const SsvNode& node,
                const Eigen::Isometry3d& X_WG,
                double radius,
                const btVector3& color,
                btIDebugDraw& draw)
{
    const Eigen::Vector3d axis0(node.axis0[0], node.axis0[1], node.axis0[2]);
    const Eigen::Vector3d axis1(node.axis1[0], node.axis1[1], node.axis1[2]);
    const Eigen::Vector3d center(node.center[0], node.center[1], node.center[2]);
    Eigen::Isometry3d X_GN = Eigen::Isometry3d::Identity();
    X_GN.linear() << axis0, axis1, axis0.cross(axis1);
    X_GN.translation() = tree.origin() + center;
    const btScalar ball = btScalar(radius + double(node.radius));
    const btVector3 half(btScalar(node.half[0]) + ball,
                         btScalar(node.half[1]) + ball,
                         btScalar(node.half[2]) + ball);
    draw.drawBox(-half, half, btCcdToBullet(X_WG * X_GN), color);
}

void drawBelow(const SsvTree& tree,
               std::int32_t index,
               int level,
               const Eigen::Isometry3d& X_WG,
               double radius,
               btIDebugDraw& draw)
{
    const SsvNode& node = tree.nodes()[std::size_t(index)];
    if (level <= 0 || node.isLeaf())
    {
        drawVolume(tree, node, X_WG, radius, volumeColor(), draw);
        return;
    }
    tree.open(node);
    for (std::int32_t k = 0; k < node.count; ++k)
    {
        drawBelow(tree, node.first + k, level - 1, X_WG, radius, draw);
    }
}

/// All hierarchies that there are by now.
template <typename Visit>
void forTrees(const btCcdShapeModel& model, const Visit& visit)
{
    for (const btCcdShapePart& part : model.m_parts)
    {
        if (part.m_tiles == nullptr)
        {
            visit(*part.m_tree, part);
            continue;
        }
        part.m_tiles->forPieces([&](const btCcdTiles::Piece& piece)
                                { visit(*piece.m_tree, part); });
    }
}

void drawRoots(const btCcdPosedModel& posed, const btVector3& color, btIDebugDraw& draw)
{
    const Eigen::Isometry3d X_WS = btCcdToEigen(posed.m_pose);
    forTrees(
        posed.m_model,
        [&](const SsvTree& tree, const btCcdShapePart& part)
        { drawVolume(tree, tree.nodes().front(), X_WS * part.X_SG, part.m_radius, color, draw); });
}

void drawCross(const btVector3& point, btScalar size, btIDebugDraw& draw)
{
    for (int axis = 0; axis < 3; ++axis)
    {
        btVector3 arm(0, 0, 0);
        arm[axis] = size;
        draw.drawLine(point - arm, point + arm, impactColor());
    }
}
}  // namespace

void btCcdDrawHierarchy(const btCcdPosedModel& posed, int level, btIDebugDraw& draw)
{
    const Eigen::Isometry3d X_WS = btCcdToEigen(posed.m_pose);
    forTrees(posed.m_model,
             [&](const SsvTree& tree, const btCcdShapePart& part)
             { drawBelow(tree, 0, level, X_WS * part.X_SG, part.m_radius, draw); });
}

void btCcdDrawSweptBox(const btVector3& low, const btVector3& high, btIDebugDraw& draw)
{
    draw.drawBox(low, high, sweptColor());
}

void btCcdDrawImpact(const btCcdPosedModel& a,
                     const btVector3& pointA,
                     const btCcdPosedModel& b,
                     const btVector3& pointB,
                     const btVector3& normal,
                     btIDebugDraw& draw)
{
    drawRoots(a, impactColor(), draw);
    drawRoots(b, impactColor(), draw);
    const btScalar size = btScalar(0.25 * std::min(a.m_model.m_reach, b.m_model.m_reach));
    drawCross(pointA, size * btScalar(0.2), draw);
    drawCross(pointB, size * btScalar(0.2), draw);
    draw.drawLine(pointA, pointA + size * normal, impactColor());
}

void btCcdDrawPath(const btVector3& from, const btVector3& to, btIDebugDraw& draw)
{
    draw.drawLine(from, to, sweptColor());
}

void btCcdDrawSoftContact(const btVector3& pointA,
                          const btVector3& pointB,
                          const btVector3& normal,
                          btScalar length,
                          btIDebugDraw& draw)
{
    draw.drawLine(pointA, pointB, impactColor());
    draw.drawLine(pointA, pointA + length * normal, impactColor());
}
