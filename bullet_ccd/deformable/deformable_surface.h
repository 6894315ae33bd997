/// A triangle mesh that deforms: its topology and hierarchy, built once, and where its vertices are
/// at both ends of a step, set for every step.
///
/// The triangles are kept in patches of at most eight, under a hierarchy with eight children a node
/// whose boxes move: one box at t = 0, one at t = 1. Every vertex and edge belongs to one patch, so
/// that no pair of features is met twice.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace bullet_ccd
{
/// How a surface is built.
struct DeformableSurfaceOptions
{
    /// Vertices at exactly the same place count as one: features that share such a vertex are
    /// neighbours and never tested against each other. Otherwise they are refused.
    bool weldDuplicates = false;
    /// Pairs of vertices that are sewn together: they count as one as well, wherever they are.
    std::span<const std::array<std::int32_t, 2>> seams{};
};

/// A mesh that deforms. Two triangles with a vertex in common are neighbours and not tested where
/// they share it. A triangle may name a vertex twice: then it is an edge (a rope is such
/// triangles). Vertices of no triangle are ignored; a triangle that is there twice counts once.
class BULLET_CCD_API DeformableSurface
{
public:
    /// Builds the hierarchy over the mesh at rest, and sets a step in which it stays there.
    /// Throws std::invalid_argument for a mesh that checkMesh() refuses, seams that name no vertex,
    /// and vertices at the same place, unless they are welded.
    explicit DeformableSurface(const TriangleMesh& rest,
                               const DeformableSurfaceOptions& options = {});
    ~DeformableSurface();
    DeformableSurface(DeformableSurface&&) noexcept;
    DeformableSurface& operator=(DeformableSurface&&) noexcept;

    /// Where the vertices are when the step begins and ends; in between they move on straight
    /// lines. Refits the hierarchy. Quality, not correctness, suffers when the mesh has changed its
    /// shape much since it was built; then build another.
    /// @param start,end  one place for every vertex of the mesh that the surface was built from [m]
    /// @param threads    that share the work; the outcome does not depend on them
    /// Throws std::invalid_argument for another number of places, for one that is not finite, and
    /// without a thread; the step before stays.
    void setStep(std::span<const Eigen::Vector3d> start,
                 std::span<const Eigen::Vector3d> end,
                 int threads = 1);

    [[nodiscard]] std::size_t vertexCount() const;
    [[nodiscard]] std::size_t triangleCount() const;
    /// Bytes that the surface holds.
    [[nodiscard]] std::size_t memory() const;

    struct Data;
    [[nodiscard]] const Data& data() const { return *m_data; }

private:
    std::unique_ptr<Data> m_data;
};
}  // namespace bullet_ccd
