#include "bullet_ccd/io/robot/robot_format.h"
#include "bullet_ccd/io/robot/robot_parts.h"
#include "bullet_ccd/io/robot/urdf_geometry.h"
#include "bullet_ccd/io/robot/urdf_joints.h"
#include "bullet_ccd/io/robot_file.h"

#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <console_bridge/console.h>
#include <mutex>
#include <stdexcept>
#include <string_view>
#include <tinyxml2.h>
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

/// Efforts and velocities that limits do not state are 0, which says the same: urdfdom insists.
void completeLimits(tinyxml2::XMLElement& element)
{
    for (auto* child = element.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement())
    {
        for (const char* name : {"effort", "velocity"})
        {
            if (std::string_view(child->Name()) == "limit" && child->Attribute(name) == nullptr)
            {
                child->SetAttribute(name, 0);
            }
        }
        completeLimits(*child);
    }
}

std::string withWholeLimits(const std::string& text)
{
    tinyxml2::XMLDocument document;
    if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS ||
        document.RootElement() == nullptr)
    {
        return text;  // urdfdom says what is wrong
    }
    completeLimits(*document.RootElement());
    tinyxml2::XMLPrinter printer;
    document.Print(&printer);
    return printer.CStr();
}

urdf::ModelInterfaceSharedPtr parse(const std::string& text, const std::string& file)
{
    static std::mutex parserMutex;
    const std::lock_guard lock(parserMutex);
    MessageCapture capture;
    urdf::ModelInterfaceSharedPtr model;
    std::string thrown;
    try
    {
        model = urdf::parseURDF(withWholeLimits(text));
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

/// Takes over the inertial of the URDF if it is usable.
void readInertial(const urdf::Link& source, const std::string& file, Link& link)
{
    if (!source.inertial)
    {
        return;
    }
    const urdf::Inertial& inertial = *source.inertial;
    Eigen::Matrix3d inertia;
    inertia << inertial.ixx, inertial.ixy, inertial.ixz,  //
        inertial.ixy, inertial.iyy, inertial.iyz,         //
        inertial.ixz, inertial.iyz, inertial.izz;
    if (isPhysical(inertial.mass, inertia))
    {
        const Eigen::Isometry3d X_LC =
            toEigen(inertial.origin, file + ": link '" + source.name + "': inertial");
        link.mass = inertial.mass;
        link.centerOfMass = X_LC.translation();
        link.inertia = X_LC.linear() * inertia * X_LC.linear().transpose();
    }
}
}  // namespace

RobotModel urdfFromText(const std::string& text, const std::filesystem::path& path)
{
    const urdf::ModelInterfaceSharedPtr source = parse(text, path.string());
    RobotModel robot;
    robot.name = source->name_;
    robot.file = path;
    robot.tree = buildTree(*source, path.string(), robot.notes);
    UrdfGeometry geometry(path);
    for (Link& link : robot.tree.links)
    {
        const urdf::Link& described = *source->links_.at(link.name);
        readInertial(described, path.string(), link);
        robot.linkMeshes.push_back(geometry.linkMesh(described));
    }
    robot.notes.insert(robot.notes.end(), geometry.notes().begin(), geometry.notes().end());
    completeInertials(robot);
    return robot;
}

RobotModel loadUrdf(const std::filesystem::path& path)
{
    const std::string text = readText(path);
    requireShallowXml(text, path.string());
    requireUrdf(text, path);
    return urdfFromText(text, path);
}
}  // namespace bullet_ccd
