/// Contacts between two bodies at fixed poses, as point contacts with a normal.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Geometry>

#include <vector>

namespace bullet_ccd
{
/// A point contact; witnesses on both surfaces, in the frame of the query.
struct Contact
{
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, from A to B
    double gap = 0.0;                                  ///< |pointB - pointA| [m]
    std::int32_t triangleA = kNone;
    std::int32_t triangleB = kNone;
};

struct ContactOptions
{
    double threshold = 2e-4;   ///< features closer than this are in contact [m]
    double mergeAngle = 0.35;  ///< normals within this angle belong to one patch [rad]
    int maxPerPatch = 4;       ///< a patch keeps the points that span it best
};

/// Contacts of two meshes: all pairs of triangles within the threshold, clustered into patches of
/// like normals, each patch reduced to the few points that span it (the deepest first).
/// Deterministic order. Empty if the meshes are farther apart; pairs that intersect are reported
/// with gap 0 and the normal of B's triangle.
/// @param X_WA, X_WB poses; the result is in W
[[nodiscard]] BULLET_CCD_API std::vector<Contact> findContacts(const SsvTree& treeA,
                                                               const Eigen::Isometry3d& X_WA,
                                                               const SsvTree& treeB,
                                                               const Eigen::Isometry3d& X_WB,
                                                               const ContactOptions& options);
}  // namespace bullet_ccd
