/// Robots in files for the program bullet-ccd.
#pragma once

#include "tests/tools/bullet_ccd_program.h"

#include <filesystem>
#include <fmt/format.h>
#include <string>

namespace bullet_ccd::tools
{
/// An arm of two boxes, 1 m long and 0.02 thick, in the plane z = 0: `shoulder` at the origin and
/// `elbow` at the end of the first, both about z. Its base has no geometry.
inline std::string twoLinkArm()
{
    const auto link = [](const char* name)
    {
        return fmt::format(R"(
  <link name="{}"><collision><origin xyz="0.5 0 0"/>
    <geometry><box size="0.96 0.02 0.02"/></geometry></collision></link>)",
                           name);
    };
    const auto joint = [](const char* name, const char* parent, const char* child, double x)
    {
        return fmt::format(R"(
  <joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/><origin xyz="{} 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-3.2" upper="3.2" effort="1" velocity="1"/></joint>)",
                           name,
                           parent,
                           child,
                           x);
    };
    std::string text = R"(<robot name="arm"><link name="base"/>)";
    text += link("upper");
    text += link("fore");
    text += joint("shoulder", "base", "upper", 0.0);
    text += joint("elbow", "upper", "fore", 1.0);
    return text + "</robot>\n";
}

/// The program with the arm and a wall whose near face is x = 1.5.
class ArticulatedProgram : public BulletCcdProgram
{
protected:
    void SetUp() override
    {
        BulletCcdProgram::SetUp();
        writeObj(makeBox({0.1, 3.0, 1.0}), m_wall);
        m_temp.write("arm.urdf", twoLinkArm());
        m_temp.write("scene.csv",
                     "mesh,name,qw,qx,qy,qz,tx,ty,tz\nwall.obj,wall,1,0,0,0,1.6,0,0\n");
    }

    /// Writes a file of joints and returns its quoted path.
    [[nodiscard]] std::string joints(const std::string& name, const std::string& text) const
    {
        return quoted(m_temp.write(name, text));
    }

    [[nodiscard]] static std::string quoted(const std::filesystem::path& path)
    {
        return fmt::format("'{}' ", path.string());
    }

    [[nodiscard]] std::string file(const std::string& name) const
    {
        return quoted(m_temp.path() / name);
    }

    /// Runs the arm's verb.
    [[nodiscard]] Outcome ask(const std::string& arguments) const
    {
        return run("articulated " + file("arm.urdf") + arguments);
    }

    std::filesystem::path m_wall = m_temp.path() / "wall.obj";
};
}  // namespace bullet_ccd::tools
