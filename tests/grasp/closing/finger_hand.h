/// Hands of segments and boxes for which the joint angles at contact are known in closed form.
#pragma once

#include "grasp/hand/hand_model.h"

#include <vector>

namespace bullet_ccd::tests
{
/// A hand put together link by link. The root is a palm without geometry unless one is given.
class HandBuilder
{
public:
    HandBuilder();

    /// Geometry of the root, in its frame.
    void setPalm(const TriangleMesh& mesh);

    /// Adds a link under `parent` (0: the palm); closes towards `limit` with the sign of
    /// `direction` (0: a joint that keeps its place).
    std::int32_t add(std::int32_t parent,
                     const Eigen::Isometry3d& X_PL0,
                     const Joint& joint,
                     int direction,
                     const TriangleMesh& mesh);

    /// Makes `link` follow `of`.
    void mimic(std::int32_t link, std::int32_t of, double multiplier, double offset);
    void selfPair(std::int32_t a, std::int32_t b) { m_hand.selfPairs.emplace_back(a, b); }

    [[nodiscard]] grasp::HandModel take();

private:
    grasp::HandModel m_hand;
    std::vector<std::int32_t> m_treeOf;
};

[[nodiscard]] Joint revolute(const Eigen::Vector3d& axis, double lower, double upper);
[[nodiscard]] Joint prismatic(const Eigen::Vector3d& axis, double lower, double upper);

/// The segment from the link's origin to `length` along x.
[[nodiscard]] TriangleMesh finger(double length);
}  // namespace bullet_ccd::tests
