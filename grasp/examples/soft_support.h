/// What the programs with soft bodies share: volumes of tetrahedra, a check that shares nothing
/// with the library, strips of pictures.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/report/canvas.h"
#include "grasp/report/raster.h"

#include <BulletSoftBody/btSoftBody.h>
#include <Eigen/Geometry>

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace bullet_ccd::grasp::examples
{
[[nodiscard]] btVector3 vec(double x, double y, double z);

/// Cubes of five tetrahedra wherever the middle of a cube is inside; at the surface the nodes are
/// moved onto it. `distance` is negative inside. It stands on z = 0 and fits into a cube of
/// size * cell about x = y = 0.
[[nodiscard]] btSoftBody* makeVolume(btSoftBodyWorldInfo& info,
                                     double cell,
                                     int size,
                                     const std::function<double(const Eigen::Vector3d&)>& distance);

/// The faces of a soft body where they are.
[[nodiscard]] TriangleMesh meshOf(const btSoftBody& body);

struct BoxedFace
{
    std::array<Eigen::Vector3d, 3> m_corners;
    Eigen::AlignedBox3d m_box;
};

/// Triangles of a mesh at a pose that meet the box.
[[nodiscard]] std::vector<BoxedFace> facesNear(const TriangleMesh& mesh,
                                               const Eigen::Isometry3d& X,
                                               const Eigen::AlignedBox3d& box);

/// Edges of one that cross faces of the other; faces that share a corner are neighbours.
[[nodiscard]] int crossings(const std::vector<BoxedFace>& a, const std::vector<BoxedFace>& b);

/// What is drawn.
struct Drawn
{
    TriangleMesh m_mesh;
    Eigen::Isometry3d X_W;
    Color m_color;
};
[[nodiscard]] Canvas drawScene(const Camera& camera, const std::vector<Drawn>& scene);

/// The pictures beside each other, half as large. Throws std::runtime_error if the file cannot be
/// written.
void writeStrip(const std::vector<Canvas>& pictures, const std::filesystem::path& file);

/// A scene of a program, by its name. It writes its pictures into the folder and says whether it
/// ended as it should.
struct NamedScene
{
    std::string m_name;
    std::function<bool(const std::filesystem::path& folder)> m_run;
};

/// main() of a program `PROGRAM FOLDER [scene ...]`: runs those that are named, or all. The exit
/// code is 0 if all end as they should, 1 if one does not, 2 for a command line that makes no
/// sense, 3 if something is thrown; of the last two the standard error output says what is wrong.
[[nodiscard]] int runScenes(const std::string& program,
                            const std::vector<NamedScene>& scenes,
                            int count,
                            char** words);
}  // namespace bullet_ccd::grasp::examples
