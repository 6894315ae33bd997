#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/robot_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <tinyxml2.h>

namespace bullet_ccd
{
namespace
{
/// Shortest text that reads as the same numbers.
std::string text(const Eigen::VectorXd& values)
{
    std::ostringstream out;
    out.precision(17);
    for (Eigen::Index i = 0; i < values.size(); ++i)
    {
        out << (i == 0 ? "" : " ") << values[i];
    }
    return out.str();
}

std::string text(double value)
{
    return text(Eigen::VectorXd::Constant(1, value));
}

class UrdfWriter
{
public:
    UrdfWriter(const RobotModel& robot, const std::filesystem::path& file)
        : m_robot(robot),
          m_file(file),
          m_meshes(file.stem().string() + "_meshes"),
          m_printer(nullptr, false)
    {
    }

    void write()
    {
        m_printer.PushHeader(false, true);
        open("robot", {{"name", m_robot.name}});
        for (std::size_t i = 0; i < m_robot.tree.size(); ++i)
        {
            writeLink(i);
        }
        for (std::size_t i = 1; i < m_robot.tree.size(); ++i)
        {
            writeJoint(m_robot.tree.links[i]);
        }
        m_printer.CloseElement();
        std::ofstream out(m_file);
        out << m_printer.CStr();
        out.close();
        if (!out)
        {
            throw std::runtime_error(m_file.string() +
                                     ": cannot be written: check the folder and the space left");
        }
    }

private:
    using Attributes = std::initializer_list<std::pair<const char*, std::string>>;

    void open(const char* name, Attributes attributes)
    {
        m_printer.OpenElement(name);
        for (const auto& [key, value] : attributes)
        {
            m_printer.PushAttribute(key, value.c_str());
        }
    }

    void element(const char* name, Attributes attributes)
    {
        open(name, attributes);
        m_printer.CloseElement();
    }

    void origin(const Eigen::Isometry3d& X)
    {
        // Fixed axes x, y, z: R = Rz(yaw) Ry(pitch) Rx(roll).
        const Eigen::Matrix3d& R = X.matrix().topLeftCorner<3, 3>();
        const double level = std::hypot(R(0, 0), R(1, 0));
        const bool isUpright = level < 1e-9;  // then only the sum of roll and yaw counts
        const Eigen::Vector3d rpy(
            isUpright ? std::atan2(-R(1, 2), R(1, 1)) : std::atan2(R(2, 1), R(2, 2)),
            std::atan2(-R(2, 0), level),
            isUpright ? 0.0 : std::atan2(R(1, 0), R(0, 0)));
        element("origin", {{"xyz", text(X.translation())}, {"rpy", text(rpy)}});
    }

    void writeLink(std::size_t index)
    {
        const Link& link = m_robot.tree.links[index];
        open("link", {{"name", link.name}});
        if (link.mass > 0.0)
        {
            const Eigen::Matrix3d& m = link.inertia;
            open("inertial", {});
            origin(Eigen::Isometry3d(Eigen::Translation3d(link.centerOfMass)));
            element("mass", {{"value", text(link.mass)}});
            element("inertia",
                    {{"ixx", text(m(0, 0))},
                     {"ixy", text(m(0, 1))},
                     {"ixz", text(m(0, 2))},
                     {"iyy", text(m(1, 1))},
                     {"iyz", text(m(1, 2))},
                     {"izz", text(m(2, 2))}});
            m_printer.CloseElement();
        }
        if (const TriangleMesh& mesh = m_robot.linkMeshes[index]; !mesh.triangles.empty())
        {
            // By number: names of links may have characters that files must not have.
            const std::filesystem::path file = m_meshes / (std::to_string(index) + ".obj");
            std::filesystem::create_directories(m_file.parent_path() / m_meshes);
            writeObj(mesh, m_file.parent_path() / file);
            for (const char* use : {"visual", "collision"})
            {
                open(use, {});
                open("geometry", {});
                element("mesh", {{"filename", file.string()}});
                m_printer.CloseElement();
                m_printer.CloseElement();
            }
        }
        m_printer.CloseElement();
    }

    void writeJoint(const Link& link)
    {
        const Joint& joint = link.joint;
        if (joint.type == JointType::Spherical)
        {
            throw std::runtime_error(m_file.string() + ": joint '" + joint.name +
                                     "' is spherical, which URDF does not know");
        }
        const bool hasLimits = std::isfinite(joint.lower) && std::isfinite(joint.upper);
        const bool turns = joint.type == JointType::Revolute;
        open("joint",
             {{"name", joint.name.empty() ? link.name + "_joint" : joint.name},
              {"type",
               !joint.isMovable() ? "fixed"
               : !turns           ? "prismatic"
               : hasLimits        ? "revolute"
                                  : "continuous"}});
        origin(link.X_PL0);
        element("parent", {{"link", m_robot.tree.links[std::size_t(link.parent)].name}});
        element("child", {{"link", link.name}});
        if (joint.isMovable())
        {
            element("axis", {{"xyz", text(joint.axis)}});
            const auto orNone = [](double limit)
            { return text(std::isfinite(limit) ? limit : 0.0); };
            const auto within = [](double limit) { return text(std::clamp(limit, -1e6, 1e6)); };
            element("limit",
                    {{"lower", within(joint.lower)},
                     {"upper", within(joint.upper)},
                     {"effort", orNone(joint.maxEffort)},
                     {"velocity", orNone(joint.maxVelocity)}});
        }
        if (joint.mimicOf != kNone)
        {
            element("mimic",
                    {{"joint", m_robot.tree.links[std::size_t(joint.mimicOf)].joint.name},
                     {"multiplier", text(joint.mimicMultiplier)},
                     {"offset", text(joint.mimicOffset)}});
        }
        m_printer.CloseElement();
    }

    const RobotModel& m_robot;
    const std::filesystem::path m_file;
    const std::filesystem::path m_meshes;
    tinyxml2::XMLPrinter m_printer;
};
}  // namespace

void writeUrdf(const RobotModel& robot, const std::filesystem::path& path)
{
    UrdfWriter(robot, path).write();
}
}  // namespace bullet_ccd
