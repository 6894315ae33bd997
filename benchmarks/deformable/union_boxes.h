/// What a plain method does, as yardstick: boxes over the whole step, then every pair of features
/// by itself.
///
/// A hierarchy over the triangles has one box a node that holds its triangles during the whole
/// step. Vertices and edges belong to the first of their triangles, so that every pair comes once.
/// Pairs whose boxes overlap are examined either by bisection of time and both features (the value
/// on a box is within the hull of the values at its corners), or by advancement: nothing can meet
/// before the distance has been used up at the largest relative speed.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// A pair of features of one mesh, as DeformableContact has its vertices.
struct FeaturePair
{
    ElementaryKind kind = ElementaryKind::VertexFace;
    std::array<std::int32_t, 4> vertices{};
};

class UnionBoxes
{
public:
    explicit UnionBoxes(const TriangleMesh& mesh);
    ~UnionBoxes();

    /// Pairs without a common vertex whose boxes, widened by the distance, overlap.
    [[nodiscard]] std::vector<FeaturePair> candidates(std::span<const Eigen::Vector3d> start,
                                                      std::span<const Eigen::Vector3d> end,
                                                      double distance);

private:
    struct Tree;
    std::unique_ptr<Tree> m_tree;
};

/// Time of contact, or 2 without one. Never late; a box of the search that is smaller than the
/// tolerance counts as contact.
[[nodiscard]] double bisectionToi(const ElementaryPair& pair, double tolerance);
[[nodiscard]] double advancementToi(const ElementaryPair& pair, double tolerance);
}  // namespace bullet_ccd::benchmarks
