/// Collision geometry of URDF links: where mesh files are, and what primitives become.
#pragma once

#include "bullet_ccd/io/robot/robot_parts.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>
#include <urdf_model/link.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd
{
/// Reads the collision geometry of the links of one URDF; every mesh file is read once.
class UrdfGeometry
{
public:
    explicit UrdfGeometry(std::filesystem::path urdf) : m_urdf(std::move(urdf)) {}

    /// All collision elements of the link in one mesh, link frame; empty if there are none.
    /// Throws std::runtime_error: "<file>: link '<name>': <what, value>: <remedy>".
    [[nodiscard]] TriangleMesh linkMesh(const urdf::Link& link);

    /// What the mesh files had to tell, one line each.
    [[nodiscard]] const std::vector<std::string>& notes() const { return m_files.notes(); }

private:
    [[nodiscard]] TriangleMesh geometryMesh(const urdf::Geometry& geometry,
                                            const std::string& where);
    [[nodiscard]] TriangleMesh meshOf(const urdf::Mesh& mesh, const std::string& where);

    std::filesystem::path m_urdf;
    MeshFiles m_files;
};

/// The pose as Eigen has it. Throws std::runtime_error starting with `where` if it is not finite.
[[nodiscard]] Eigen::Isometry3d toEigen(const urdf::Pose& pose, const std::string& where);
}  // namespace bullet_ccd
