/// What plain methods do about deforming features: boxes over the whole step, then every pair by
/// itself. Yardstick of benchmarks, and reference of tests.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace bullet_ccd::reference
{
/// A pair of features of one mesh, as DeformableContact has its vertices.
struct FeaturePair
{
    ElementaryKind kind = ElementaryKind::VertexFace;
    std::array<std::int32_t, 4> vertices{};
};

/// Boxes over the whole step of the features of a mesh, in binary trees that are made once.
class UnionBoxes
{
public:
    explicit UnionBoxes(const TriangleMesh& mesh);
    /// Pairs without a common vertex whose boxes, widened by the distance, overlap.
    [[nodiscard]] std::vector<FeaturePair> overlapping(std::span<const Eigen::Vector3d> start,
                                                       std::span<const Eigen::Vector3d> end,
                                                       double distance) const;

private:
    struct Trees;
    std::shared_ptr<Trees> m_trees;
};

/// The features of a mesh whose vertices move from `start` to `end`.
[[nodiscard]] ElementaryPair pairOf(const FeaturePair& features,
                                    std::span<const Eigen::Vector3d> start,
                                    std::span<const Eigen::Vector3d> end);

/// Time of contact, or 2 without one, by halving time and the places on both features, in at most
/// 100,000 cells.
[[nodiscard]] double bisectionToi(const ElementaryPair& pair, double tolerance);

/// Time of contact, or 2 without one, by advancement. Never late: nothing can meet before the
/// distance has been used up at the largest relative speed.
[[nodiscard]] double advancementToi(const ElementaryPair& pair, double tolerance);
}  // namespace bullet_ccd::reference
