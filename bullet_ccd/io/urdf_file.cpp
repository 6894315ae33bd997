#include "bullet_ccd/io/urdf_file.h"

#include "bullet_ccd/io/urdf_geometry.h"
#include "bullet_ccd/io/urdf_joints.h"

#include <Eigen/Eigenvalues>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <console_bridge/console.h>
#include <fstream>
#include <iterator>
#include <mutex>
#include <stdexcept>
#include <utility>

namespace bullet_ccd
{
namespace
{
/// Collects what urdfdom would print. Its handler is global: one parse at a time.
class MessageCapture : public console_bridge::OutputHandler
{
public:
    MessageCapture() { console_bridge::useOutputHandler(this); }
    ~MessageCapture() override { console_bridge::restorePreviousOutputHandler(); }
    MessageCapture(const MessageCapture&) = delete;
    MessageCapture& operator=(const MessageCapture&) = delete;

    void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override
    {
        if (level == console_bridge::CONSOLE_BRIDGE_LOG_ERROR)
        {
            const std::size_t end = text.find_last_not_of(". \n");
            m_errors += (m_errors.empty() ? "" : "; ") + text.substr(0, end + 1);
        }
    }

    [[nodiscard]] const std::string& errors() const { return m_errors; }

private:
    std::string m_errors;
};

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

/// Refuses XML in which more than 200 elements are open at once: the parser recurses into elements,
/// and nothing real nests deeper.
void requireShallowXml(const std::string& content, const std::string& name)
{
    constexpr int kMaxDepth = 200;
    int depth = 0;
    for (std::size_t i = 0; i + 1 < content.size(); ++i)
    {
        const char c = content[i];
        const char next = content[i + 1];
        const bool opens = c == '<' && next != '/' && next != '!' && next != '?';
        const bool closes = (c == '<' && next == '/') || (c == '/' && next == '>');
        depth = std::max(0, depth + static_cast<int>(opens) - static_cast<int>(closes));
        if (depth > kMaxDepth)
        {
            throw std::runtime_error(name + ": XML with more than " + std::to_string(kMaxDepth) +
                                     " nested elements: close the elements");
        }
    }
}

urdf::ModelInterfaceSharedPtr parse(const std::filesystem::path& path)
{
    const std::string file = path.string();
    const std::string text = readText(path);
    requireShallowXml(text, file);

    static std::mutex parserMutex;
    const std::lock_guard lock(parserMutex);
    MessageCapture capture;
    urdf::ModelInterfaceSharedPtr model;
    std::string thrown;
    try
    {
        model = urdf::parseURDF(text);
    }
    catch (const std::exception& error)
    {
        thrown = error.what();
    }
    // A model with errors lacks parts of what the file says.
    if (!model || !capture.errors().empty())
    {
        std::string reason = capture.errors();
        reason += (reason.empty() || thrown.empty() ? "" : "; ") + thrown;
        throw std::runtime_error(file + ": " + (reason.empty() ? "not a URDF" : reason) +
                                 ": correct the file (check_urdf may tell more)");
    }
    return model;
}

/// Positive definite with principal moments that some mass distribution has: none larger than the
/// sum of the other two.
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

/// Takes over the inertial of the URDF if it is usable.
bool readInertial(const urdf::Link& source, const std::string& file, Link& link)
{
    if (!source.inertial)
    {
        return false;
    }
    const urdf::Inertial& inertial = *source.inertial;
    Eigen::Matrix3d inertia;
    inertia << inertial.ixx, inertial.ixy, inertial.ixz,  //
        inertial.ixy, inertial.iyy, inertial.iyz,         //
        inertial.ixz, inertial.iyz, inertial.izz;
    if (!isPhysical(inertial.mass, inertia))
    {
        return false;
    }
    const Eigen::Isometry3d X_LC =
        toEigen(inertial.origin, file + ": link '" + source.name + "': inertial");
    link.mass = inertial.mass;
    link.centerOfMass = X_LC.translation();
    link.inertia = X_LC.linear() * inertia * X_LC.linear().transpose();
    return true;
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

void setInertials(const urdf::ModelInterface& source, RobotModel& robot)
{
    std::vector<std::string> fromMesh;
    std::vector<std::string> tiny;
    for (std::size_t i = 0; i < robot.tree.size(); ++i)
    {
        Link& link = robot.tree.links[i];
        if (readInertial(*source.links_.at(link.name), robot.file.string(), link))
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
}  // namespace

RobotModel loadUrdf(const std::filesystem::path& path)
{
    const urdf::ModelInterfaceSharedPtr source = parse(path);
    RobotModel robot;
    robot.name = source->name_;
    robot.file = path;
    robot.tree = buildTree(*source, path.string(), robot.notes);
    UrdfGeometry geometry(path);
    for (const Link& link : robot.tree.links)
    {
        robot.linkMeshes.push_back(geometry.linkMesh(*source->links_.at(link.name)));
    }
    robot.notes.insert(robot.notes.end(), geometry.notes().begin(), geometry.notes().end());
    setInertials(*source, robot);
    return robot;
}
}  // namespace bullet_ccd
