/// What a DeformableSurface holds. Internal to the room.
///
/// Vertices, edges and faces are numbered in the order of the patches, so that what lies together
/// is together in memory.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/deformable/kernels/surface_kernels.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Bits of what a step leaves alone.
constexpr std::uint8_t kRests = 1;      ///< it does not move in the step
constexpr std::uint8_t kUnchanged = 2;  ///< its step is that of before

struct DeformableSurface::Data
{
    std::size_t meshVertices = 0;
    std::size_t meshTriangles = 0;

    // Topology.
    std::vector<SurfacePatch> patches;
    std::vector<SurfaceNode> nodes;        ///< parents before their children; 0 is the root
    std::vector<std::int32_t> meshVertex;  ///< by number of the vertex: its index in the mesh

    // The step.
    std::vector<VertexStep> steps;
    std::vector<MovingBox> patchBoxes;
    std::vector<MovingBox> nodeBoxes;
    std::vector<std::uint8_t> vertexIdle;  ///< bits: kRests, kUnchanged
    std::vector<std::uint8_t> patchIdle;   ///< bits that all of its vertices have
    std::vector<std::uint8_t> nodeIdle;
    bool isUnchanged = false;    ///< all of it
    Eigen::AlignedBox3d bounds;  ///< of all places at both ends
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double halfExtent = 0.0;  ///< the largest of the three

    [[nodiscard]] const MovingBox& box(std::int32_t child) const
    {
        const std::int32_t leaf = ~child;
        return child < 0 ? patchBoxes[static_cast<std::size_t>(leaf)]
                         : nodeBoxes[static_cast<std::size_t>(child)];
    }
    [[nodiscard]] std::uint8_t idle(std::int32_t child) const
    {
        const std::int32_t leaf = ~child;
        return child < 0 ? patchIdle[static_cast<std::size_t>(leaf)]
                         : nodeIdle[static_cast<std::size_t>(child)];
    }
    [[nodiscard]] const SurfacePatch& patch(std::int32_t index) const
    {
        return patches[static_cast<std::size_t>(index)];
    }
    [[nodiscard]] const SurfaceNode& node(std::int32_t index) const
    {
        return nodes[static_cast<std::size_t>(index)];
    }
};

/// Patches and nodes of the mesh; labels[v] names the vertices that count as one with v.
void buildPatches(const TriangleMesh& mesh,
                  const std::vector<std::int32_t>& labels,
                  DeformableSurface::Data& data);

/// Boxes and places of a step.
/// @pre both spans have a finite place for every vertex of the mesh
void refitSurface(std::span<const Eigen::Vector3d> start,
                  std::span<const Eigen::Vector3d> end,
                  int threads,
                  DeformableSurface::Data& data);
}  // namespace bullet_ccd
