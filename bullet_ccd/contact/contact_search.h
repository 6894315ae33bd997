/// The search for contacts that all three views share: pairs of features of two surfaces at fixed
/// poses, found in the pairs of triangles that are near each other.
///
/// A pair of features counts if each of its closest points is the nearest to the other on its own
/// surface around it; how exactly, is what the views differ in. Features inside a flat part are no
/// feature of their own.
#pragma once

#include "bullet_ccd/contact/contact_surface.h"
#include "bullet_ccd/contact/contacts.h"
#include "bullet_ccd/contact/near_slots.h"
#include "bullet_ccd/export.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace bullet_ccd
{
enum class ContactView : std::uint8_t
{
    /// What a solver needs: vertices over faces and sharp edges that cross within 0.1 rad, so that
    /// bodies which lie on each other nearly flat touch at all corners; all others exactly, so that
    /// facets that stand for something round touch where that would. Where surfaces intersect, gap
    /// = -depth of a vertex behind a face, or of two edges past each other, if that is at most the
    /// threshold; else 0 at the edges that pierce a face least deep.
    Patches,
    /// All features in contact: smooth edges within 0.1 rad, too; gap 0 at every edge that pierces
    /// a face.
    Features,
    /// What a grasp needs: as Features, but all within half a right angle, so that things that are
    /// round touch with as much of them as is near.
    Points,
};

/// Where one tree is as the other sees it. F is the frame of B's tree.
struct ContactPoses
{
    Eigen::Isometry3d X_WB;
    Eigen::Vector3d originB;
    Eigen::Matrix3d R_FA;  ///< of the frame of A's tree
    Eigen::Vector3d p_FA;
    double rounding;  ///< of a distance [m]
};

/// Scratch memory of a search; one per thread, grows to what is needed once.
struct ContactSearchWorkspace
{
    IndexPairs open;   ///< pairs of nodes to look at
    IndexPairs slots;  ///< pairs of triangles near by
    std::vector<Contact> pierced;
    std::int64_t pairs = 0;  ///< counts pairs of triangles whose volumes are near, over all queries
};

/// Appends all contacts of two surfaces with a gap of at most `threshold`, in W, in no order, by
/// the view of patches.
///
/// Guarantee: the closest points of the surfaces are among them (to rounding) if they are at most
/// `threshold` apart. Where surfaces intersect, the normal is the direction in which B gives way
/// soonest.
/// Deterministic. Allocates nothing once `work`, `contacts` and `kept` are large enough.
/// @param kept if not null, of these two surfaces: changes no answer, and spares work where they
///        hardly move
BULLET_CCD_API void appendContacts(const ContactSurface& surfaceA,
                                   const Eigen::Isometry3d& X_WA,
                                   const ContactSurface& surfaceB,
                                   const Eigen::Isometry3d& X_WB,
                                   double threshold,
                                   ContactSearchWorkspace& work,
                                   std::vector<Contact>& contacts,
                                   KeptSlots* kept = nullptr);

/// The answer to one query for features or points. The same guarantee; the normal at an edge that
/// pierces a face is that of the face, by which the middle of the edge's body stays on its side.
struct NearFeatures
{
    ContactPoses poses;
    ContactSurface a;  ///< the triangles near the other body, in the order of the mesh
    ContactSurface b;
    std::vector<Contact> contacts;  ///< in F; their triangles are slots of a and b
};

/// Throws QueryStopped.
[[nodiscard]] std::optional<NearFeatures> nearFeatures(const SsvTree& treeA,
                                                       const Eigen::Isometry3d& X_WA,
                                                       const SsvTree& treeB,
                                                       const Eigen::Isometry3d& X_WB,
                                                       double threshold,
                                                       ContactView view,
                                                       const StopCondition& stop);

/// From F and slots to W and triangles of the meshes.
void toWorld(const ContactPoses& poses,
             const ContactSurface& a,
             const ContactSurface& b,
             std::span<Contact> contacts);
}  // namespace bullet_ccd
