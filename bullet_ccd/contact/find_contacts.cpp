#include "bullet_ccd/contact/contact_patches.h"
#include "bullet_ccd/contact/contacts.h"

#include <limits>
#include <utility>

namespace bullet_ccd
{
std::vector<Contact> findContacts(const SsvTree& treeA,
                                  const Eigen::Isometry3d& X_WA,
                                  const SsvTree& treeB,
                                  const Eigen::Isometry3d& X_WB,
                                  double threshold,
                                  const StopCondition& stop)
{
    std::optional<NearFeatures> near =
        nearFeatures(treeA, X_WA, treeB, X_WB, threshold, ContactView::Points, stop);
    if (!near || near->contacts.empty())
    {
        return {};
    }
    PatchWorkspace work;
    work.raw = std::move(near->contacts);
    toWorld(near->poses, near->a, near->b, work.raw);
    reducePatches({.threshold = threshold,
                   .maxPatches = std::numeric_limits<std::int32_t>::max(),
                   .maxPoints = 4},
                  work);
    if (work.raw.front().gap < work.contacts.front().gap)
    {
        work.contacts.insert(work.contacts.begin(), work.raw.front());
    }
    return std::move(work.contacts);
}
}  // namespace bullet_ccd
