#include "bullet_ccd/contact/contact_patches.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace bullet_ccd
{
namespace
{
bool isDeeper(const Contact& x, const Contact& y)
{
    return std::tie(x.gap, x.triangleA, x.triangleB) < std::tie(y.gap, y.triangleA, y.triangleB);
}
}  // namespace

void reducePatches(const PatchOptions& options, PatchWorkspace& work)
{
    work.patches.clear();
    work.contacts.clear();
    std::sort(work.raw.begin(), work.raw.end(), isDeeper);
    const double cosine = std::cos(options.mergeAngle);
    work.patchOf.clear();
    for (const Contact& contact : work.raw)
    {
        const auto patch = std::find_if(work.patches.begin(),
                                        work.patches.end(),
                                        [&](const ContactPatch& p)
                                        { return p.normal.dot(contact.normal) >= cosine; });
        const auto index = static_cast<std::int32_t>(patch - work.patches.begin());
        if (patch == work.patches.end() && index < options.maxPatches)
        {
            work.patches.push_back({.normal = contact.normal});
        }
        work.patchOf.push_back(index);
    }
    for (std::size_t k = 0; k < work.patches.size(); ++k)
    {
        work.members.clear();
        for (std::size_t i = 0; i < work.raw.size(); ++i)
        {
            if (work.patchOf[i] == static_cast<std::int32_t>(k))
            {
                work.members.push_back(static_cast<std::int32_t>(i));
            }
        }
        ContactPatch& patch = work.patches[k];
        patch.first = static_cast<std::int32_t>(work.contacts.size());
        ContactOutline(work.raw, work.members, patch.normal, options.threshold)
            .appendChoice(work.former, options.maxPoints, work.contacts);
        patch.count = static_cast<std::int32_t>(work.contacts.size()) - patch.first;
    }
}

void findPatches(const ContactSurface& surfaceA,
                 const Eigen::Isometry3d& X_WA,
                 const ContactSurface& surfaceB,
                 const Eigen::Isometry3d& X_WB,
                 const PatchOptions& options,
                 PatchWorkspace& work)
{
    work.raw.clear();
    appendContacts(surfaceA, X_WA, surfaceB, X_WB, options.threshold, work.search, work.raw);
    reducePatches(options, work);
}
}  // namespace bullet_ccd
