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

/// Contacts of two meshes: all pairs of features within the threshold, each of which is the nearest
/// to the other on its own surface around it to within half a right angle, so that round things
/// touch with a patch of points; clustered into patches of like normals, each patch reduced to four
/// points that span it, and the deepest if that is not one of them (see reducePatches()). The
/// nearest contact of all comes first. Deterministic order. Empty if the meshes are farther apart;
/// where surfaces intersect, the edges that pierce a face are contacts with gap 0 and the normal of
/// the face.
/// @param X_WA, X_WB poses; the result is in W
/// @param threshold features at most so far apart are in contact [m], > 0
[[nodiscard]] BULLET_CCD_API std::vector<Contact> findContacts(const SsvTree& treeA,
                                                               const Eigen::Isometry3d& X_WA,
                                                               const SsvTree& treeB,
                                                               const Eigen::Isometry3d& X_WB,
                                                               double threshold);
}  // namespace bullet_ccd
