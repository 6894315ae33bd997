/// Writes a robot as MJCF in the style of MuJoCo's Menagerie: what tests read again.
#pragma once

#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/robot_file.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <string>

namespace bullet_ccd::tests
{
inline std::string mjcfNumbers(const Eigen::VectorXd& values)
{
    std::ostringstream text;
    text << std::setprecision(17);
    for (Eigen::Index i = 0; i < values.size(); ++i)
    {
        text << (i == 0 ? "" : " ") << values[i];
    }
    return text.str();
}

inline std::string mjcfPose(const Eigen::Isometry3d& X)
{
    const Eigen::Quaterniond q(X.linear());
    return "pos=\"" + mjcfNumbers(X.translation()) + "\" quat=\"" +
           mjcfNumbers(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z())) + "\"";
}

/// One body and those below it.
inline void writeMjcfBody(const RobotModel& robot, std::size_t index, std::ostream& out)
{
    const Link& link = robot.tree.links[index];
    out << "<body name=\"" << link.name << "\" " << mjcfPose(link.X_PL0) << ">\n";
    Eigen::VectorXd inertia(6);
    const Eigen::Matrix3d& m = link.inertia;
    inertia << m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2);
    out << "<inertial pos=\"" << mjcfNumbers(link.centerOfMass) << "\" mass=\""
        << mjcfNumbers(Eigen::VectorXd::Constant(1, link.mass)) << "\" fullinertia=\""
        << mjcfNumbers(inertia) << "\"/>\n";
    const Joint& joint = link.joint;
    if (index > 0 && joint.isMovable())
    {
        out << "<joint name=\"" << joint.name << "\" class=\""
            << (joint.type == JointType::Revolute ? "turns" : "slides") << "\" axis=\""
            << mjcfNumbers(joint.axis) << "\"";
        if (std::isfinite(joint.lower))
        {
            out << " range=\"" << mjcfNumbers(Eigen::Vector2d(joint.lower, joint.upper)) << "\"";
        }
        out << "/>\n";
    }
    if (!robot.linkMeshes[index].triangles.empty())
    {
        out << "<geom class=\"collision\" mesh=\"mesh" << index << "\"/>\n";
        out << "<geom class=\"visual\" mesh=\"mesh" << index << "\"/>\n";
    }
    for (std::size_t child = index + 1; child < robot.tree.size(); ++child)
    {
        if (robot.tree.links[child].parent == static_cast<std::int32_t>(index))
        {
            writeMjcfBody(robot, child, out);
        }
    }
    out << "</body>\n";
}

/// Writes <folder>/<robot>.xml and the meshes below it, and returns the path. Meshes are written
/// in millimetres, so that their scale has something to do.
inline std::filesystem::path writeMjcf(const RobotModel& robot, const std::filesystem::path& folder)
{
    const std::filesystem::path path = folder / (robot.name + ".xml");
    std::filesystem::create_directories(folder / "assets");
    std::ofstream out(path);
    out << "<mujoco model=\"" << robot.name << "\">\n"
        << "<compiler angle=\"radian\" meshdir=\"assets\" autolimits=\"true\"/>\n"
        << "<default><default class=\"hand\"><mesh scale=\"0.001 0.001 0.001\"/>"
        << "<default class=\"turns\"><joint type=\"hinge\"/></default>"
        << "<default class=\"slides\"><joint type=\"slide\"/></default>"
        << "<default class=\"visual\"><geom type=\"mesh\" contype=\"0\" conaffinity=\"0\" "
           "group=\"2\" density=\"0\"/></default>"
        << "<default class=\"collision\"><geom type=\"mesh\" group=\"3\"/></default>"
        << "</default></default>\n<asset>\n";
    for (std::size_t i = 0; i < robot.tree.size(); ++i)
    {
        if (!robot.linkMeshes[i].triangles.empty())
        {
            TriangleMesh mesh = robot.linkMeshes[i];
            transformMesh(mesh, Eigen::Affine3d(Eigen::Scaling(1000.0)));
            writeObj(mesh, folder / "assets" / ("mesh" + std::to_string(i) + ".obj"));
            out << "<mesh class=\"hand\" file=\"mesh" << i << ".obj\"/>\n";
        }
    }
    out << "</asset>\n<worldbody>\n";
    writeMjcfBody(robot, 0, out);
    out << "</worldbody>\n<actuator>\n";
    for (const Link& link : robot.tree.links)
    {
        if (link.joint.isMovable() && std::isfinite(link.joint.maxEffort))
        {
            const double effort = link.joint.maxEffort;
            out << "<position name=\"" << link.joint.name << "_motor\" joint=\"" << link.joint.name
                << "\" kp=\"1\" forcerange=\"" << mjcfNumbers(Eigen::Vector2d(-effort, effort))
                << "\"/>\n";
        }
    }
    out << "</actuator>\n<equality>\n";
    for (const Link& link : robot.tree.links)
    {
        const Joint& joint = link.joint;
        if (joint.mimicOf != kNone)
        {
            Eigen::VectorXd polynomial = Eigen::VectorXd::Zero(5);
            polynomial[0] = joint.mimicOffset;
            polynomial[1] = joint.mimicMultiplier;
            out << "<joint joint1=\"" << joint.name << "\" joint2=\""
                << robot.tree.links[static_cast<std::size_t>(joint.mimicOf)].joint.name
                << "\" polycoef=\"" << mjcfNumbers(polynomial) << "\"/>\n";
        }
    }
    out << "</equality>\n</mujoco>\n";
    return path;
}
}  // namespace bullet_ccd::tests
