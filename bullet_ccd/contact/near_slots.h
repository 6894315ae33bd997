/// Pairs of triangles that may be near each other. Internal to appendContacts().
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/math/stop_condition.h"

#include <Eigen/Core>

#include <cstdint>
#include <utility>
#include <vector>

namespace bullet_ccd
{
using IndexPairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

/// Sets `slots` to all pairs of triangles, by their slots, whose volumes are at most `threshold`
/// apart, and to some that are farther. Deterministic order.
/// @param R, p pose of A's tree frame in that of B's tree
/// @param open scratch
/// Throws QueryStopped.
void collectNearSlots(const SsvTree& treeA,
                      const SsvTree& treeB,
                      const Eigen::Matrix3d& R,
                      const Eigen::Vector3d& p,
                      double threshold,
                      IndexPairs& open,
                      IndexPairs& slots,
                      const StopCondition& stop = {});

/// Looks at a stop condition now and then.
class StopCheck
{
public:
    explicit StopCheck(const StopCondition& stop) : m_stop(stop), m_isGiven(stop.isGiven()) {}

    /// To be called for every pair. Throws QueryStopped.
    void look()
    {
        constexpr std::uint32_t kPairsBetween = 512;
        if (m_isGiven && m_count++ % kPairsBetween == 0 && m_stop.isDue())
        {
            throw QueryStopped("contacts: the query was stopped before all were found");
        }
    }

private:
    const StopCondition& m_stop;
    bool m_isGiven;
    std::uint32_t m_count = 0;
};
}  // namespace bullet_ccd
