/// Generated meshes that deform, of any size.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace bullet_ccd::reference
{
/// The square [0, 1] x [0, 1] of the plane z = 0: (cells + 1)^2 vertices row by row along x, and
/// 2 * cells^2 triangles.
[[nodiscard]] TriangleMesh sheet(int cells);

/// One mesh, and where its vertices are in every frame; a step goes from one frame to the next.
struct DeformingScene
{
    TriangleMesh mesh;
    std::vector<std::vector<Eigen::Vector3d>> frames;
};

/// The names that makeDeformingScene() knows.
[[nodiscard]] const std::vector<std::string>& deformingScenes();

/// breaking  a torus that breaks into shards of about 500 triangles, which move and turn at random
/// falling   a wavy cloth that falls on a sphere of half as many triangles
/// layers    fifty cloths on top of each other, each with waves of its own, that are pressed
/// together
/// @param triangles  about how many
/// @param steps      at least 1
/// Throws std::invalid_argument for other names.
[[nodiscard]] DeformingScene makeDeformingScene(const std::string& name, int triangles, int steps);
}  // namespace bullet_ccd::reference
