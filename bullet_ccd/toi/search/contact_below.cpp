#include "bullet_ccd/distance/ssv_pair.h"
#include "bullet_ccd/toi/search/search.h"

#include <algorithm>
#include <limits>

namespace bullet_ccd
{
namespace
{
using Eigen::Map;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The point of the core of a volume that is nearest to a point.
Vector3d nearestInCore(const PlacedSsv& volume, const Vector3d& point)
{
    const Vector3d along = volume.axes.transpose() * (point - volume.center);
    return volume.center + volume.axes * along.cwiseMin(volume.half).cwiseMax(-volume.half);
}

/// Upper bound of the distance of two volumes and, in both cores, the points that have it: each is
/// the nearest to the one before, back and forth.
struct VolumeDistance
{
    Vector3d inA;
    Vector3d inB;
    double distance;

    VolumeDistance(const PlacedSsv& a, const PlacedSsv& b) : inB(b.center)
    {
        constexpr int kRounds = 4;
        for (int i = 0; i < kRounds; ++i)
        {
            inA = nearestInCore(a, inB);
            inB = nearestInCore(b, inA);
        }
        distance = (inA - inB).norm() - a.radius - b.radius;
    }
};

/// The leaf at the end of a walk from a node to the child whose volume is nearest to a point.
std::int32_t leafNear(const SsvTree& tree, std::int32_t node, const Vector3d& point)
{
    const Eigen::Vector3f target = point.cast<float>();
    while (!tree.nodes()[static_cast<std::size_t>(node)].isLeaf())
    {
        const SsvNode& here = tree.nodes()[static_cast<std::size_t>(node)];
        tree.open(here);
        float least = std::numeric_limits<float>::infinity();
        for (std::int32_t k = here.first; k < here.first + here.count; ++k)
        {
            const SsvNode& child = tree.nodes()[static_cast<std::size_t>(k)];
            const Eigen::Vector3f arm = target - Map<const Eigen::Vector3f>(child.center);
            const Map<const Eigen::Vector3f> axis0(child.axis0);
            const Map<const Eigen::Vector3f> axis1(child.axis1);
            const Eigen::Vector3f along(
                axis0.dot(arm), axis1.dot(arm), axis0.cross(axis1).dot(arm));
            const Eigen::Vector3f beyond =
                (along.cwiseAbs() - Map<const Eigen::Vector3f>(child.half)).cwiseMax(0.0F);
            // Of volumes that hold the point, or are equally far, the one with the nearest center.
            constexpr float kCenters = 0.01F;
            const float order =
                std::max(0.0F, beyond.norm() - child.radius) + kCenters * arm.norm();
            if (order < least)
            {
                least = order;
                node = k;
            }
        }
    }
    return node;
}

}  // namespace

bool findsContactBelow(SearchState& state, const NodePair& p)
{
    ScenePair& pair = state.scene.pair(p.pair);
    const PairState& pose = state.scene.stateAt(p.pair, p.time, state.counters);
    const Matrix3d R = Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.motion.R);
    const Vector3d arm = Map<const Vector3d>(pose.motion.armA);
    const Vector3d place = R * arm + Map<const Vector3d>(pose.motion.p);
    const VolumeDistance apart(bullet_ccd::place(state.scene.nodeA(p), R, place),
                               bullet_ccd::place(state.scene.nodeB(p)));
    if (apart.distance > pair.limits.near())
    {
        return false;
    }
    NodePair leaves = p;
    leaves.nodeA = leafNear(*pair.treeA, p.nodeA, R.transpose() * (apart.inB - place));
    const SsvNode& leafA = state.scene.nodeA(leaves);
    TriangleCorners cornersA = pair.treeA->corners(leafA.first);
    for (Vector3d& corner : cornersA)
    {
        corner = R * corner + place;
    }
    leaves.nodeB = leafNear(*pair.treeB, p.nodeB, pointToTriangle(apart.inB, cornersA).pointB);
    return noteIfNear(state, leaves);
}
}  // namespace bullet_ccd
