#include "grasp/closing/swept_boxes.h"

#include "bullet_ccd/distance/ssv_pair.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Isometry3d;
using Eigen::Vector3d;

template <typename Visit>
void forCorners(const AlignedBox3d& box, const Visit& visit)
{
    for (int corner = 0; corner < 8; ++corner)
    {
        visit(box.corner(static_cast<AlignedBox3d::CornerType>(corner)));
    }
}

AlignedBox3d moved(const AlignedBox3d& box, const Isometry3d& X)
{
    AlignedBox3d result;
    forCorners(box, [&](const Vector3d& corner) { result.extend(X * corner); });
    return result;
}

/// True if some angle + k full turns lies in [begin, end].
bool contains(double begin, double end, double angle)
{
    constexpr double kTurn = 2.0 * std::numbers::pi;
    return angle + kTurn * std::ceil((begin - angle) / kTurn) <= end;
}

/// All places of the point turned about an axis through the origin by angles in [begin, end].
void extendByArc(
    AlignedBox3d& box, const Vector3d& point, const Vector3d& axis, double begin, double end)
{
    const Vector3d along = axis * axis.dot(point);
    const Vector3d across = point - along;
    const Vector3d around = axis.cross(point);
    for (const double angle : {begin, end})
    {
        box.extend(along + across * std::cos(angle) + around * std::sin(angle));
    }
    for (int i = 0; i < 3; ++i)
    {
        const double most = std::atan2(around[i], across[i]);
        const double reach = std::hypot(around[i], across[i]);
        if (contains(begin, end, most))
        {
            box.max()[i] = std::max(box.max()[i], along[i] + reach);
        }
        if (contains(begin, end, most + std::numbers::pi))
        {
            box.min()[i] = std::min(box.min()[i], along[i] - reach);
        }
    }
}

/// The box moved by a joint through all its positions in the range, in the joint's frame.
AlignedBox3d sweptByJoint(const AlignedBox3d& box, const Joint& joint, double from, double to)
{
    const auto [begin, end] = std::minmax({from, to});
    AlignedBox3d swept;
    if (joint.type == JointType::Prismatic)
    {
        return sweptAlong(box.translated(begin * joint.axis), (end - begin) * joint.axis);
    }
    forCorners(box,
               [&, first = begin, last = end](const Vector3d& corner)
               { extendByArc(swept, corner, joint.axis, first, last); });
    return swept;
}

AlignedBox3d boundsOf(const TriangleMesh& mesh)
{
    AlignedBox3d box;
    for (const Vector3d& vertex : mesh.vertices)
    {
        box.extend(vertex);
    }
    return box;
}

/// The box of a link as seen from the root, joints anywhere between the two postures.
AlignedBox3d sweptToRoot(const KinematicTree& tree,
                         std::size_t link,
                         AlignedBox3d box,
                         const std::vector<double>& from,
                         const std::vector<double>& to)
{
    for (std::size_t i = link; i > 0; i = static_cast<std::size_t>(tree.links[i].parent))
    {
        if (tree.links[i].joint.isMovable())
        {
            box = sweptByJoint(box, tree.links[i].joint, from[i], to[i]);
        }
        box = moved(box, tree.links[i].X_PL0);
    }
    return box;
}

PlacedSsv asVolume(const AlignedBox3d& box, const Isometry3d& X_WF)
{
    PlacedSsv volume;
    volume.center = X_WF * box.center();
    volume.axes = X_WF.linear();
    volume.half = 0.5 * box.sizes();
    volume.radius = 0.0;
    volume.coreRadius = volume.half.norm();
    return volume;
}
}  // namespace

AlignedBox3d sweptAlong(const AlignedBox3d& box, const Vector3d& shift)
{
    return box.merged(box.translated(shift));
}

SweptBoxes sweptBoxes(const HandModel& hand, const std::vector<double>& preshape)
{
    const KinematicTree& tree = hand.robot.tree;
    std::vector<double> open = preshape;
    applyMimics(tree, open);
    const std::vector<double> closed = closedPositions(hand, open);
    SweptBoxes boxes{.open = std::vector<AlignedBox3d>(tree.size()),
                     .closing = std::vector<AlignedBox3d>(tree.size())};
    for (std::size_t link = 0; link < tree.size(); ++link)
    {
        if (hand.linkTrees[link] != nullptr)
        {
            const AlignedBox3d box = boundsOf(hand.linkTrees[link]->mesh());
            boxes.open[link] = sweptToRoot(tree, link, box, open, open);
            boxes.closing[link] = sweptToRoot(tree, link, box, open, closed);
        }
    }
    return boxes;
}

bool isApart(const AlignedBox3d& box, const Isometry3d& X_WF, const RigidBody& body)
{
    const Isometry3d& X_WB = body.motion.X_W0;
    const PlacedSsv volume =
        place(body.tree->nodes()[0], X_WB.linear(), X_WB * body.tree->origin());
    return forEachSeparatingAxis(
        asVolume(box, X_WF), volume, [](double gap, const auto&) { return gap > 0.0; });
}

std::vector<std::int32_t> reachable(const SweptBoxes& boxes,
                                    const Isometry3d& X_WH,
                                    const Vector3d& shift,
                                    std::span<const RigidBody> bodies)
{
    const Vector3d shift_H = X_WH.linear().transpose() * shift;
    std::vector<AlignedBox3d> onTheWay;
    AlignedBox3d all;
    for (const AlignedBox3d& box : boxes.closing)
    {
        if (!box.isEmpty())
        {
            onTheWay.push_back(sweptAlong(box, shift_H));
            all.extend(onTheWay.back());
        }
    }
    std::vector<std::int32_t> found;
    for (std::size_t i = 0; i < bodies.size(); ++i)
    {
        if (!isApart(all, X_WH, bodies[i]) &&
            std::any_of(onTheWay.begin(),
                        onTheWay.end(),
                        [&](const AlignedBox3d& box) { return !isApart(box, X_WH, bodies[i]); }))
        {
            found.push_back(static_cast<std::int32_t>(i));
        }
    }
    return found;
}
}  // namespace bullet_ccd::grasp
