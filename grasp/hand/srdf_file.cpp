#include "grasp/hand/srdf_file.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <tinyxml2.h>

namespace bullet_ccd::grasp
{
namespace
{
using tinyxml2::XMLElement;

class SrdfReader
{
public:
    explicit SrdfReader(const std::filesystem::path& path) { m_srdf.file = path; }

    Srdf read()
    {
        const std::string file = m_srdf.file.string();
        std::error_code error;
        if (!std::filesystem::is_regular_file(m_srdf.file, error))
        {
            throw std::runtime_error(file + ": no such file: check the path of the SRDF");
        }
        tinyxml2::XMLDocument document;
        if (document.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS)
        {
            throw std::runtime_error(file + ": not XML: " + document.ErrorStr() +
                                     ": correct the file");
        }
        const XMLElement* const robot = document.FirstChildElement("robot");
        if (robot == nullptr)
        {
            throw std::runtime_error(file + ": no <robot> element: is this an SRDF?");
        }
        for (const XMLElement* e = robot->FirstChildElement(); e != nullptr;
             e = e->NextSiblingElement())
        {
            readElement(*e);
        }
        return std::move(m_srdf);
    }

private:
    void readElement(const XMLElement& element)
    {
        const std::string_view name = element.Name();
        if (name == "group")
        {
            readGroup(element);
        }
        else if (name == "group_state")
        {
            readState(element);
        }
        else if (name == "disable_collisions")
        {
            m_srdf.disabledPairs.emplace_back(attribute(element, "link1"),
                                              attribute(element, "link2"));
        }
        else if (name == "passive_joint")
        {
            m_srdf.passiveJoints.push_back(attribute(element, "name"));
        }
        else if (name == "closing")
        {
            readClosing(element);
        }
        else if (name == "end_effector")
        {
            m_srdf.endEffectors.push_back({.name = attribute(element, "name"),
                                           .parentLink = attribute(element, "parent_link"),
                                           .group = attribute(element, "group")});
        }
        else if (name == "grasp_frame")
        {
            readGraspFrame(element);
        }
    }

    void readGroup(const XMLElement& element)
    {
        SrdfGroup group;
        group.name = attribute(element, "name");
        if (const XMLElement* const chain = element.FirstChildElement("chain"))
        {
            group.hasChain = true;
            group.baseLink = attribute(*chain, "base_link");
            group.tipLink = attribute(*chain, "tip_link");
            if (const XMLElement* const second = chain->NextSiblingElement("chain"))
            {
                fail(*second,
                     "group '" + group.name + "' has a second chain",
                     "make it a group of its own, a finger is one chain");
            }
        }
        for (const XMLElement* link = element.FirstChildElement("link"); link != nullptr;
             link = link->NextSiblingElement("link"))
        {
            group.links.push_back(attribute(*link, "name"));
        }
        if (group.hasChain)
        {
            group.links.push_back(group.tipLink);
        }
        m_srdf.groups.push_back(group);
    }

    void readState(const XMLElement& element)
    {
        SrdfState state;
        state.name = attribute(element, "name");
        state.group = attribute(element, "group");
        for (const XMLElement* joint = element.FirstChildElement("joint"); joint != nullptr;
             joint = joint->NextSiblingElement("joint"))
        {
            const std::vector<double> values = numbers(*joint, "value", 1);
            state.joints.emplace_back(attribute(*joint, "name"), values[0]);
        }
        m_srdf.states.push_back(std::move(state));
    }

    void readClosing(const XMLElement& element)
    {
        const std::string direction = attribute(element, "direction");
        if (direction != "+1" && direction != "1" && direction != "-1")
        {
            fail(element, "direction is '" + direction + "'", "use +1 or -1");
        }
        SrdfClosing closing{.joint = attribute(element, "joint"),
                            .direction = direction == "-1" ? -1 : 1};
        if (element.Attribute("speed") != nullptr)
        {
            closing.speed = numbers(element, "speed", 1)[0];
        }
        if (!(closing.speed > 0.0) || !std::isfinite(closing.speed))
        {
            fail(element,
                 "speed is '" + attribute(element, "speed") + "'",
                 "give a ratio > 0 to the usual speed");
        }
        m_srdf.closings.push_back(std::move(closing));
    }

    void readGraspFrame(const XMLElement& element)
    {
        SrdfGraspFrame frame;
        if (const char* const preshape = element.Attribute("preshape"))
        {
            frame.preshape = preshape;
        }
        if (std::ranges::any_of(m_srdf.graspFrames,
                                [&](const SrdfGraspFrame& other)
                                { return other.preshape == frame.preshape; }))
        {
            fail(element,
                 frame.preshape.empty() ? "a second one"
                                        : "a second one of preshape '" + frame.preshape + "'",
                 "keep one");
        }
        frame.link = attribute(element, "link");
        const std::vector<double> xyz = numbers(element, "xyz", 3);
        const std::vector<double> rpy = numbers(element, "rpy", 3);
        frame.X_LG.translation() = Eigen::Vector3d(xyz[0], xyz[1], xyz[2]);
        frame.X_LG.linear() = (Eigen::AngleAxisd(rpy[2], Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(rpy[1], Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(rpy[0], Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix();
        m_srdf.graspFrames.push_back(std::move(frame));
    }

    [[nodiscard]] std::string attribute(const XMLElement& element, const char* name) const
    {
        const char* const value = element.Attribute(name);
        if (value == nullptr || *value == '\0')
        {
            fail(element, std::string("attribute '") + name + "' is missing or empty", "add it");
        }
        return value;
    }

    [[nodiscard]] std::vector<double> numbers(const XMLElement& element,
                                              const char* name,
                                              std::size_t count) const
    {
        const std::string text = attribute(element, name);
        std::istringstream stream(text);
        std::vector<double> values;
        double value = 0.0;
        while (stream >> value)
        {
            values.push_back(value);
        }
        if (!stream.eof() || values.size() != count)
        {
            fail(element,
                 std::string(name) + " is '" + text + "'",
                 count == 1 ? "give one finite number" : "give three finite numbers");
        }
        return values;
    }

    [[noreturn]] void fail(const XMLElement& element,
                           const std::string& what,
                           const std::string& remedy) const
    {
        throw std::runtime_error(m_srdf.file.string() + ": line " +
                                 std::to_string(element.GetLineNum()) + ": <" + element.Name() +
                                 ">: " + what + ": " + remedy);
    }

    Srdf m_srdf;
};
}  // namespace

Srdf readSrdf(const std::filesystem::path& path)
{
    return SrdfReader(path).read();
}
}  // namespace bullet_ccd::grasp
