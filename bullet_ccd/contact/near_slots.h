/// Pairs of triangles that may be near each other, for appendContacts().
#pragma once

#include "bullet_ccd/export.h"
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

/// Answers collectNearSlots() for two bodies that hardly move relative to each other from one query
/// to the next: pairs are collected with some room, and used for as long as no point has moved by
/// more. What moves fast for its room is asked for anew each time, without any.
class BULLET_CCD_API KeptSlots
{
public:
    /// Sets `slots` to all pairs of triangles that are at most `threshold` apart, and to some that
    /// are farther, in the order of collectNearSlots().
    /// @pre all calls are about the same two trees, in the same order
    void collect(const SsvTree& treeA,
                 const SsvTree& treeB,
                 const Eigen::Matrix3d& R,
                 const Eigen::Vector3d& p,
                 double threshold,
                 IndexPairs& open,
                 IndexPairs& slots);

private:
    struct Place
    {
        Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
        Eigen::Vector3d p = Eigen::Vector3d::Zero();

        /// No point of A's tree is farther from where it was.
        [[nodiscard]] double wayTo(const Place& other, double radiusA) const
        {
            return (other.p - p).norm() + (other.R - R).norm() * radiusA;
        }
    };

    void boundDistances(const SsvTree& treeA, const SsvTree& treeB, double slack);

    IndexPairs m_slots;
    std::vector<double> m_bounds;  ///< of their distances when they were collected
    Place m_collected;
    Place m_asked;          ///< last
    double m_reach = -1.0;  ///< that they were collected with; negative: none were
    double m_room = 0.0;    ///< for the next time
};

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
