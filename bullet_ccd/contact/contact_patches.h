/// Contacts of two bodies in patches of like normals, each reduced to the few points that a
/// solver of rigid contacts needs.
#pragma once

#include "bullet_ccd/contact/contact_outline.h"
#include "bullet_ccd/contact/contact_search.h"
#include "bullet_ccd/export.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Contacts of a patch: `count` in a row from `first` on.
struct ContactPatch
{
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of its deepest contact
    std::int32_t first = 0;
    std::int32_t count = 0;  ///< 1 to kPointsPerPatch
};

struct PatchOptions
{
    double threshold = 2e-4;       ///< features closer than this are in contact [m], > 0
    double mergeAngle = 0.35;      ///< normals within this angle belong to one patch [rad]
    std::int32_t maxPatches = 64;  ///< those with the deepest contacts are kept
    /// Most points of a patch, from 4 to kPointsPerPatch; the deepest may be one more than 4.
    std::int32_t maxPoints = kPointsPerPatch;
};

/// Input, scratch memory and result of a query; one per thread.
struct PatchWorkspace
{
    std::vector<Contact> raw;  ///< all contacts
    /// A patch keeps the points that it had if these are still in contact and span nearly as much
    /// as any: else those of something round change from one query to the next, and no solver comes
    /// to an end.
    std::vector<FormerContact> former;

    ContactSearchWorkspace search;
    std::vector<std::int32_t> patchOf;
    std::vector<std::int32_t> members;

    std::vector<ContactPatch> patches;  ///< the deepest first
    std::vector<Contact> contacts;      ///< of all patches; the deepest of each first
};

/// Groups `work.raw`, in the frame of work.former, to `work.patches` and `work.contacts`: each
/// patch keeps four points that make the polygon of support about as large as any four can, and
/// where it is not flat up to eight more that lie below those (see contact_outline.h); a deepest
/// one (within 2 % of the threshold) is always among them. Deterministic; does not depend on the
/// order of work.raw but for equal contacts.
BULLET_CCD_API void reducePatches(const PatchOptions& options, PatchWorkspace& work);

/// Contacts of two surfaces, see appendContacts(), reduced; in W. Fills work.raw itself.
BULLET_CCD_API void findPatches(const ContactSurface& surfaceA,
                                const Eigen::Isometry3d& X_WA,
                                const ContactSurface& surfaceB,
                                const Eigen::Isometry3d& X_WB,
                                const PatchOptions& options,
                                PatchWorkspace& work);
}  // namespace bullet_ccd
