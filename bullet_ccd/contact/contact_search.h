/// Pairs of features of two surfaces that are in contact: the search below findPatches().
///
/// A pair counts if each of its closest points is the nearest to the other on its own surface
/// around it: of a vertex over a face and of crossing sharp edges within 0.1 rad, so that bodies
/// which lie on each other nearly flat touch at all corners; of all others exactly. Features inside
/// a flat part are no feature of their own.
#pragma once

#include "bullet_ccd/contact/contact_surface.h"
#include "bullet_ccd/contact/find_contacts.h"
#include "bullet_ccd/contact/near_slots.h"
#include "bullet_ccd/export.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace bullet_ccd
{
/// Scratch memory of a search; one per thread, grows to what is needed once.
struct ContactSearchWorkspace
{
    IndexPairs open;   ///< pairs of nodes to look at
    IndexPairs slots;  ///< pairs of triangles near by
    std::vector<Contact> pierced;
    std::int64_t pairs = 0;  ///< counts pairs of triangles whose volumes are near, over all queries
};

/// Appends all contacts of two surfaces with a gap of at most `threshold`, in W, in no order.
///
/// Guarantee: the closest points of the surfaces are among them (to rounding) if they are at most
/// `threshold` apart. Where surfaces intersect, gap = -depth of a vertex behind a face, or of two
/// edges past each other, if that is at most `threshold`; else 0 where an edge pierces a face. The
/// normal is the direction in which B gives way soonest.
/// Deterministic. Allocates nothing once `work` and `contacts` are large enough.
BULLET_CCD_API void appendContacts(const ContactSurface& surfaceA,
                                   const Eigen::Isometry3d& X_WA,
                                   const ContactSurface& surfaceB,
                                   const Eigen::Isometry3d& X_WB,
                                   double threshold,
                                   ContactSearchWorkspace& work,
                                   std::vector<Contact>& contacts);
}  // namespace bullet_ccd
