#include "bullet_ccd/io/robot/robot_parts.h"

#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <system_error>

namespace bullet_ccd
{
namespace
{
/// Half the angle between neighbouring vertices at which a chord is kPrimitiveChordError below its
/// circle.
double chordHalfAngle(double radius)
{
    return std::acos(1.0 - std::min(1.0, kPrimitiveChordError / radius));
}

int cylinderSegments(double radius)
{
    constexpr double kMinSegments = 12.0;
    constexpr double kMaxSegments = 4096.0;
    return static_cast<int>(std::clamp(
        std::ceil(std::numbers::pi / chordHalfAngle(radius)), kMinSegments, kMaxSegments));
}

int sphereSubdivisions(double radius)
{
    // Circumscribed angle of an icosahedron's face. A subdivision halves it, but for the middle of
    // the face, which keeps up to 1.2 times that.
    constexpr double kFaceAngle = 37.38 * std::numbers::pi / 180.0;
    constexpr double kUnevenness = 1.2;
    constexpr double kMaxSubdivisions = 6.0;
    const double needed = std::log2(kUnevenness * kFaceAngle / chordHalfAngle(radius));
    return static_cast<int>(std::clamp(std::ceil(needed), 1.0, kMaxSubdivisions));
}

void inertialFromMesh(const TriangleMesh& mesh, Link& link)
{
    constexpr double kDensity = 1000.0;
    const MassProperties properties = massProperties(mesh);
    link.mass = kDensity * properties.volume;
    link.centerOfMass = properties.center;
    link.inertia = kDensity * properties.inertia;
}

/// Of links that only carry a frame: small against any finger, large against rounding.
void tinyInertial(Link& link)
{
    link.mass = 1e-3;
    link.centerOfMass.setZero();
    link.inertia = 1e-7 * Eigen::Matrix3d::Identity();
}

}  // namespace

void requirePositive(double value, const std::string& what)
{
    if (!(value > 0.0) || !std::isfinite(value))
    {
        throw std::runtime_error(what + " is " + std::to_string(value) +
                                 ": give a finite number > 0");
    }
}

TriangleMesh sphereMesh(double radius)
{
    return makeSphere(radius, sphereSubdivisions(radius));
}

TriangleMesh cylinderMesh(double radius, double length)
{
    return makeCylinder(radius, length, cylinderSegments(radius));
}

TriangleMesh capsuleMesh(double radius, double length)
{
    return makeCapsule(radius, length, cylinderSegments(radius));
}

TriangleMesh ellipsoidMesh(const Eigen::Vector3d& semiAxes)
{
    TriangleMesh mesh = makeSphere(1.0, sphereSubdivisions(semiAxes.maxCoeff()));
    transformMesh(mesh, Eigen::Affine3d(Eigen::Scaling(semiAxes)));
    return mesh;
}

TriangleMesh MeshFiles::load(const std::filesystem::path& path,
                             const std::string& shown,
                             const Eigen::Vector3d& scale,
                             const std::string& where)
{
    for (int k = 0; k < 3; ++k)
    {
        if (!(std::abs(scale[k]) > 0.0) || !std::isfinite(scale[k]))
        {
            throw std::runtime_error(where + ": mesh '" + shown + "': scale " + "xyz"[k] + " is " +
                                     std::to_string(scale[k]) +
                                     ": give a finite number other than 0");
        }
    }
    // The size goes into the reader, so that its notes speak of metres; proportions and mirroring
    // are applied to what it returns.
    const double size = scale.cwiseAbs().maxCoeff();
    const std::pair<std::string, double> key(path.lexically_normal().string(), size);
    auto found = m_meshes.find(key);
    if (found == m_meshes.end())
    {
        MeshFile file;
        try
        {
            file = loadMeshFile(path, {.scale = size});
        }
        catch (const std::runtime_error& error)
        {
            throw std::runtime_error(where + ": mesh " + error.what());
        }
        for (const std::string& note : file.notes)
        {
            m_notes.push_back("mesh " + shown + ": " + note);
        }
        found = m_meshes.emplace(key, std::move(file.mesh)).first;
    }
    TriangleMesh result = found->second;
    transformMesh(result, Eigen::Affine3d(Eigen::Scaling(Eigen::Vector3d(scale / size))));
    return result;
}

void requireFiniteMesh(const TriangleMesh& mesh, const std::string& where)
{
    if (mesh.triangles.empty())
    {
        return;
    }
    try
    {
        checkMesh(mesh, where);
    }
    catch (const std::invalid_argument& error)
    {
        throw std::runtime_error(error.what());
    }
    constexpr double kMostReach = 1e6;  // [m]
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        const double reach = vertex.cwiseAbs().maxCoeff();
        if (reach > kMostReach)
        {
            std::ostringstream text;
            text << where << ": its geometry reaches " << reach
                 << " m from the origin: give sizes in metres, below 1e6";
            throw std::runtime_error(text.str());
        }
    }
}

bool isPhysical(double mass, const Eigen::Matrix3d& inertia)
{
    // Printed inertias carry a few digits only.
    constexpr double kTriangleTolerance = 1e-3;
    if (!(mass > 0.0) || !std::isfinite(mass) || !inertia.allFinite())
    {
        return false;
    }
    const Eigen::Vector3d moments =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly)
            .eigenvalues();
    return moments[0] > 0.0 && moments[2] <= (1.0 + kTriangleTolerance) * (moments[0] + moments[1]);
}

void completeInertials(RobotModel& robot)
{
    std::vector<std::string> fromMesh;
    std::vector<std::string> tiny;
    for (std::size_t i = 0; i < robot.tree.size(); ++i)
    {
        Link& link = robot.tree.links[i];
        if (isPhysical(link.mass, link.inertia))
        {
            continue;
        }
        if (!robot.linkMeshes[i].triangles.empty())
        {
            inertialFromMesh(robot.linkMeshes[i], link);
            if (isPhysical(link.mass, link.inertia))
            {
                fromMesh.push_back(link.name);
                continue;
            }
        }
        tinyInertial(link);
        tiny.push_back(link.name);
    }
    if (!fromMesh.empty())
    {
        robot.notes.push_back(
            "inertial missing or not physical, computed from the collision mesh at 1000 kg/m^3: " +
            listNames(fromMesh));
    }
    if (!tiny.empty())
    {
        robot.notes.push_back("no usable inertial and no solid geometry, mass set to 1 g: " +
                              listNames(tiny));
    }
}
void noteMimicLimits(const KinematicTree& tree, std::vector<std::string>& notes)
{
    // Multipliers and limits are printed with a few digits.
    constexpr double kTolerance = 0.01;
    std::vector<std::string> names;
    for (const Link& link : tree.links)
    {
        const Joint& joint = link.joint;
        if (joint.mimicOf == kNone)
        {
            continue;
        }
        const Joint& driver = tree.links[static_cast<std::size_t>(joint.mimicOf)].joint;
        for (const double q : {driver.lower, driver.upper})
        {
            const double mimicked = joint.mimicMultiplier * q + joint.mimicOffset;
            if (mimicked < joint.lower - kTolerance || mimicked > joint.upper + kTolerance)
            {
                names.push_back(joint.name);
                break;
            }
        }
    }
    if (!names.empty())
    {
        notes.push_back("mimic joints leave their own limits, which are ignored: " +
                        listNames(names));
    }
}

void noteUnlimited(const KinematicTree& tree, std::vector<std::string>& notes)
{
    std::vector<std::string> effort;
    std::vector<std::string> velocity;
    for (const Link& link : tree.links)
    {
        if (link.joint.isMovable() && std::isinf(link.joint.maxEffort))
        {
            effort.push_back(link.joint.name);
        }
        if (link.joint.isMovable() && std::isinf(link.joint.maxVelocity))
        {
            velocity.push_back(link.joint.name);
        }
    }
    if (!effort.empty())
    {
        notes.push_back("effort limit 0 or missing: " + listNames(effort));
    }
    if (!velocity.empty())
    {
        notes.push_back("velocity limit 0 or missing, taken as unlimited: " + listNames(velocity));
    }
}
std::string listNames(const std::vector<std::string>& names)
{
    constexpr std::size_t kMaxNames = 8;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMaxNames); ++i)
    {
        text += (i == 0 ? "" : ", ") + names[i];
    }
    if (names.size() > kMaxNames)
    {
        text += " and " + std::to_string(names.size() - kMaxNames) + " more";
    }
    return text;
}

std::string readText(const std::filesystem::path& path)
{
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
    {
        throw std::runtime_error(path.string() + ": no such file: check the path");
    }
    std::ifstream file(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!file || text.empty())
    {
        throw std::runtime_error(path.string() +
                                 ": empty or not readable: check the file and its permissions");
    }
    return text;
}

void requireDepth(int depth, const std::string& name)
{
    constexpr int kMaxDepth = 200;
    if (depth > kMaxDepth)
    {
        throw std::runtime_error(name + ": XML with more than " + std::to_string(kMaxDepth) +
                                 " nested elements: close the elements");
    }
}

void requireShallowXml(const std::string& content, const std::string& name)
{
    int depth = 0;
    for (std::size_t i = 0; i + 1 < content.size(); ++i)
    {
        const char c = content[i];
        const char next = content[i + 1];
        const bool opens = c == '<' && next != '/' && next != '!' && next != '?';
        const bool closes = (c == '<' && next == '/') || (c == '/' && next == '>');
        depth = std::max(0, depth + static_cast<int>(opens) - static_cast<int>(closes));
        requireDepth(depth, name);
    }
}
}  // namespace bullet_ccd
