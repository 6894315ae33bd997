#include "bullet_ccd/io/robot/urdf_geometry.h"

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <system_error>

namespace bullet_ccd
{
namespace
{
/// All folders in which package `name` is looked for, in this order.
std::vector<std::filesystem::path> packageFolders(const std::filesystem::path& urdf,
                                                  const std::string& name)
{
    std::vector<std::filesystem::path> folders;
    std::error_code error;
    std::filesystem::path folder = std::filesystem::absolute(urdf, error).parent_path();
    while (true)
    {
        folders.push_back(folder / name);
        if (!folder.has_relative_path())
        {
            break;
        }
        folder = folder.parent_path();
    }
    const char* const variable = std::getenv("ROS_PACKAGE_PATH");
    std::string entries = variable == nullptr ? "" : variable;
    while (!entries.empty())
    {
        const std::size_t end = std::min(entries.find(':'), entries.size());
        const std::filesystem::path entry = entries.substr(0, end);
        entries.erase(0, end + 1);
        if (!entry.empty())
        {
            folders.push_back(entry.filename() == name ? entry : entry / name);
        }
    }
    return folders;
}

std::filesystem::path findInPackage(const std::filesystem::path& urdf,
                                    const std::string& uri,
                                    std::size_t prefix,
                                    const std::string& where)
{
    const std::size_t slash = std::min(uri.find('/', prefix), uri.size());
    const std::string name = uri.substr(prefix, slash - prefix);
    const std::string rest = uri.substr(std::min(slash + 1, uri.size()));
    std::string searched;
    for (const std::filesystem::path& folder : packageFolders(urdf, name))
    {
        std::error_code error;
        if (std::filesystem::is_regular_file(folder / rest, error))
        {
            return folder / rest;
        }
        searched += (searched.empty() ? "" : ", ") + folder.string();
    }
    throw std::runtime_error(where + ": mesh '" + uri + "' is in none of the folders " + searched +
                             ": put the package beside the URDF or set ROS_PACKAGE_PATH");
}

std::filesystem::path resolveMesh(const std::filesystem::path& urdf,
                                  const std::string& uri,
                                  const std::string& where)
{
    for (const std::string prefix : {"package://", "model://"})
    {
        if (uri.rfind(prefix, 0) == 0)
        {
            return findInPackage(urdf, uri, prefix.size(), where);
        }
    }
    const std::string filePrefix = "file://";
    const std::filesystem::path named =
        uri.rfind(filePrefix, 0) == 0 ? uri.substr(filePrefix.size()) : uri;
    const std::filesystem::path path = named.is_absolute() ? named : urdf.parent_path() / named;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
    {
        throw std::runtime_error(where + ": mesh '" + uri + "' is missing (looked for " +
                                 path.string() + "): check the filename attribute");
    }
    return path;
}
}  // namespace

Eigen::Isometry3d toEigen(const urdf::Pose& pose, const std::string& where)
{
    const urdf::Rotation& q = pose.rotation;
    const Eigen::Vector3d position(pose.position.x, pose.position.y, pose.position.z);
    const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
    if (!position.allFinite() || !rotation.coeffs().allFinite() || rotation.norm() < 0.5)
    {
        throw std::runtime_error(where + ": origin: not finite: give finite xyz and rpy");
    }
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = rotation.normalized().toRotationMatrix();
    X.translation() = position;
    return X;
}

TriangleMesh UrdfGeometry::meshOf(const urdf::Mesh& mesh, const std::string& where)
{
    const std::filesystem::path path = resolveMesh(m_urdf, mesh.filename, where);
    const Eigen::Vector3d scale(mesh.scale.x, mesh.scale.y, mesh.scale.z);
    return m_files.load(path, mesh.filename, scale, where);
}

TriangleMesh UrdfGeometry::geometryMesh(const urdf::Geometry& geometry, const std::string& where)
{
    switch (geometry.type)
    {
        case urdf::Geometry::SPHERE:
        {
            const auto& sphere = static_cast<const urdf::Sphere&>(geometry);
            requirePositive(sphere.radius, where + ": sphere: radius");
            return sphereMesh(sphere.radius);
        }
        case urdf::Geometry::BOX:
        {
            const auto& box = static_cast<const urdf::Box&>(geometry);
            const Eigen::Vector3d size(box.dim.x, box.dim.y, box.dim.z);
            for (int k = 0; k < 3; ++k)
            {
                requirePositive(size[k], where + ": box: size " + "xyz"[k]);
            }
            return makeBox(0.5 * size);
        }
        case urdf::Geometry::CYLINDER:
        {
            const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
            requirePositive(cylinder.radius, where + ": cylinder: radius");
            requirePositive(cylinder.length, where + ": cylinder: length");
            return cylinderMesh(cylinder.radius, cylinder.length);
        }
        case urdf::Geometry::MESH:
            return meshOf(static_cast<const urdf::Mesh&>(geometry), where);
    }
    throw std::runtime_error(where + ": unknown geometry: use mesh, box, sphere or cylinder");
}

TriangleMesh UrdfGeometry::linkMesh(const urdf::Link& link)
{
    const std::string where = m_urdf.string() + ": link '" + link.name + "'";
    TriangleMesh all;
    for (const urdf::CollisionSharedPtr& collision : link.collision_array)
    {
        if (!collision || !collision->geometry)
        {
            throw std::runtime_error(where +
                                     ": collision without geometry: add a mesh, box, sphere "
                                     "or cylinder");
        }
        TriangleMesh mesh = geometryMesh(*collision->geometry, where);
        transformMesh(mesh, Eigen::Affine3d(toEigen(collision->origin, where + ": collision")));
        appendMesh(all, mesh);
    }
    requireFiniteMesh(all, where);
    return all;
}
}  // namespace bullet_ccd
