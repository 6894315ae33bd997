/// How far the triangles below a node reach along a direction, in double precision.
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
/// Extent along `n` of what is below the node, in the frame of the tree. It is exact for a single
/// triangle and along the normals of the largest faces, up to a few roundings of double precision;
/// otherwise it is that of the volume.
inline Slab extentAlong(const SsvTree& tree, std::int32_t index, const Eigen::Vector3d& n)
{
    using Eigen::Map;
    using Eigen::Vector3d;
    using Eigen::Vector3f;
    const SsvNode& node = tree.nodes()[static_cast<std::size_t>(index)];
    if (node.isLeaf())
    {
        const auto corners = tree.corners(node.first);
        const auto [low, high] =
            std::minmax({n.dot(corners[0]), n.dot(corners[1]), n.dot(corners[2])});
        return {.low = low, .high = high};
    }
    const Vector3d center = Map<const Vector3f>(node.center).cast<double>();
    const Vector3d axis0 = Map<const Vector3f>(node.axis0).cast<double>();
    const Vector3d axis1 = Map<const Vector3f>(node.axis1).cast<double>();
    const double reach = std::abs(n.dot(axis0)) * static_cast<double>(node.half[0]) +
                         std::abs(n.dot(axis1)) * static_cast<double>(node.half[1]) +
                         std::abs(n.dot(axis0.cross(axis1))) * static_cast<double>(node.half[2]) +
                         n.norm() * static_cast<double>(node.radius);
    const double middle = n.dot(center);
    Slab extent{.low = middle - reach, .high = middle + reach};
    const FaceSlabs& faces = tree.faceSlabs();
    for (std::size_t k = 0; k < faces.normals.size(); ++k)
    {
        // n is split into a part along the normal and a part in the plane of the face.
        const double along = n.dot(faces.normals[k]);
        const Vector3d across = n - along * faces.normals[k];
        const Slab& slab = faces.ofNode(index)[k];
        const double atCenter = across.dot(center);
        const double inPlane = across.norm() * static_cast<double>(node.size());
        const double low = along * (along > 0.0 ? slab.low : slab.high);
        const double high = along * (along > 0.0 ? slab.high : slab.low);
        extent.low = std::max(extent.low, low + atCenter - inPlane);
        extent.high = std::min(extent.high, high + atCenter + inPlane);
    }
    return extent;
}
}  // namespace bullet_ccd
