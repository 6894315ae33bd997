/// Manifests: scenes whose rows also say how large each mesh is, so that a program loads only those
/// that something can reach.
#pragma once

#include "tools/support/obstacles/obstacle_scene.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

namespace bullet_ccd::tools
{
/// What a manifest knows of the mesh file, loaded with its scale. Throws as loadMeshFile().
[[nodiscard]] MeshFacts meshFactsOf(const std::filesystem::path& mesh, double scale);

/// The manifest of a scene in CSV or YAML: a scene in CSV with the further columns triangles,
/// low_x low_y low_z high_x high_y high_z (the box of the mesh in its own frame [m]), bytes and
/// hash (of the file). Every mesh is loaded once. Paths are relative to `folder`, where the
/// manifest is to be written.
/// @param progress  is told how many of how many obstacles are done
/// Throws as the readers of scenes and, with the place in the scene before it, as loadMeshFile().
[[nodiscard]] std::string manifestText(
    const std::filesystem::path& scene,
    const std::filesystem::path& folder,
    const std::function<void(std::size_t, std::size_t)>& progress);

/// Throws std::runtime_error "<place in the scene><file>: <what>: <remedy>" if the mesh is not the
/// one that the manifest was made of: its size differs or, where that is looked at, its content.
/// @param looksAtContent  false: only if the file is newer than the manifest
/// @pre placed.facts
void checkFacts(const PlacedMesh& placed,
                const std::filesystem::path& manifest,
                bool looksAtContent);
}  // namespace bullet_ccd::tools
