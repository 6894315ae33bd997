/// What the readers of robots share: meshes of primitives, mesh files, inertials, notes.
#pragma once

#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <Eigen/Core>

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd
{
/// Throws std::runtime_error starting with `what` if the value is not finite and > 0.
void requirePositive(double value, const std::string& what);

/// Primitives centred at the origin, along z, with chords at most kPrimitiveChordError [m] below
/// the surface (a sphere has at most six subdivisions). `length` of a capsule is that of its
/// cylinder.
[[nodiscard]] TriangleMesh sphereMesh(double radius);
[[nodiscard]] TriangleMesh cylinderMesh(double radius, double length);
[[nodiscard]] TriangleMesh capsuleMesh(double radius, double length);
[[nodiscard]] TriangleMesh ellipsoidMesh(const Eigen::Vector3d& semiAxes);

/// Mesh files of one robot; every file is read once.
class MeshFiles
{
public:
    /// The mesh of the file, scaled along its axes.
    /// @param shown how the robot's file calls it
    /// Throws std::runtime_error starting with `where`.
    [[nodiscard]] TriangleMesh load(const std::filesystem::path& path,
                                    const std::string& shown,
                                    const Eigen::Vector3d& scale,
                                    const std::string& where);

    /// What the files had to tell, one line each.
    [[nodiscard]] const std::vector<std::string>& notes() const { return m_notes; }

private:
    /// By path and scale factor.
    std::map<std::pair<std::string, double>, TriangleMesh> m_meshes;
    std::vector<std::string> m_notes;
};

/// Throws std::runtime_error starting with `where` if coordinates of a mesh that is not empty are
/// not finite, or larger than any robot: finite factors can still overflow when they are
/// multiplied.
void requireFiniteMesh(const TriangleMesh& mesh, const std::string& where);

/// Positive definite with principal moments that some mass distribution has: none larger than the
/// sum of the other two.
[[nodiscard]] bool isPhysical(double mass, const Eigen::Matrix3d& inertia);

/// Gives an inertial, with a note, to every link that has no physical one: from its mesh at
/// 1000 kg/m^3, or a tiny one.
void completeInertials(RobotModel& robot);

/// Mimics that leave their own limits while the joint they follow stays within its own: usually a
/// wrong sign.
void noteMimicLimits(const KinematicTree& tree, std::vector<std::string>& notes);

/// Joints that have no limit of effort or velocity.
void noteUnlimited(const KinematicTree& tree, std::vector<std::string>& notes);

/// "a, b, c": at most eight names, then "and n more".
[[nodiscard]] std::string listNames(const std::vector<std::string>& names);

/// The bytes of the file. Throws std::runtime_error if it is missing, empty or not readable.
[[nodiscard]] std::string readText(const std::filesystem::path& path);

/// Refuses XML in which more than 200 elements are open at once: parsers recurse into elements, and
/// nothing real nests deeper.
void requireShallowXml(const std::string& content, const std::string& name);
/// The same of a depth that is known: files include others.
void requireDepth(int depth, const std::string& name);
}  // namespace bullet_ccd
