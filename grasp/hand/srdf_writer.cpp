#include "grasp/hand/srdf_writer.h"

#include "grasp/hand/xml_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
/// Chains are groups, and so is what belongs to none of them.
constexpr const char* kOthers = "other_joints";

std::string numberText(double value)
{
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6f", std::abs(value) < 5e-7 ? 0.0 : value);
    return text.data();
}

std::string tripleText(const Eigen::Vector3d& v)
{
    return numberText(v.x()) + " " + numberText(v.y()) + " " + numberText(v.z());
}

/// Roll, pitch and yaw as URDF has them: R = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Vector3d rollPitchYaw(const Eigen::Matrix3d& R)
{
    const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
    if (std::hypot(R(0, 0), R(1, 0)) < 1e-9)
    {
        return {0.0, pitch, std::atan2(-R(0, 1), R(1, 1))};
    }
    return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

class HandWriter : XmlText
{
public:
    explicit HandWriter(const HandModel& hand) : m_hand(hand)
    {
        for (std::size_t i = 1; i < tree().size(); ++i)
        {
            const Joint& joint = tree().links[i].joint;
            if (joint.isMovable() && joint.mimicOf == kNone)
            {
                m_joints.push_back(i);
            }
        }
    }

    std::string write()
    {
        m_printer.PushHeader(false, true);
        open("robot", {{"name", m_hand.robot.name}});
        m_printer.PushComment(
            " How this hand grasps. What is deleted here is inferred again when the hand is "
            "loaded; 'grasp hand show' prints what came of it. Positions in rad and m. ");
        writeGroups();
        writePreshapes();
        writeClosing();
        writeFrames();
        m_printer.PushComment(
            " Pairs of links that need not be tested against each other: 'grasp hand check' finds "
            "them and prints the elements disable_collisions. ");
        m_printer.CloseElement();
        return m_printer.CStr();
    }

private:
    [[nodiscard]] const KinematicTree& tree() const { return m_hand.robot.tree; }

    /// Name of the group of the joint above the link.
    [[nodiscard]] std::string groupOf(std::size_t link) const
    {
        for (const Finger& finger : m_hand.fingers)
        {
            if (std::ranges::find(finger.links, static_cast<std::int32_t>(link)) !=
                finger.links.end())
            {
                return finger.name;
            }
        }
        return kOthers;
    }

    void writeGroups()
    {
        m_printer.PushComment(" A finger: the chain from the palm to its last link. ");
        for (const Finger& finger : m_hand.fingers)
        {
            const Link& first = tree().links[static_cast<std::size_t>(finger.links.front())];
            open("group", {{"name", finger.name}});
            element("chain",
                    {{"base_link", linkName(m_hand, first.parent)},
                     {"tip_link", linkName(m_hand, finger.links.back())}});
            m_printer.CloseElement();
        }
        if (std::ranges::any_of(m_joints,
                                [&](std::size_t joint) { return groupOf(joint) == kOthers; }))
        {
            open("group", {{"name", kOthers}});
            for (const std::size_t joint : m_joints)
            {
                if (groupOf(joint) == kOthers)
                {
                    element("joint", {{"name", tree().links[joint].joint.name}});
                }
            }
            m_printer.CloseElement();
        }
    }

    void writePreshapes()
    {
        m_printer.PushComment(
            " A preshape: where the joints are before the hand closes. States of one name are "
            "parts of one preshape, the first is the default, and joints that are not listed are "
            "at 0. ");
        std::vector<std::string> groups;
        for (const std::size_t joint : m_joints)
        {
            const std::string group = groupOf(joint);
            if (std::ranges::find(groups, group) == groups.end())
            {
                groups.push_back(group);
            }
        }
        for (const Preshape& preshape : m_hand.preshapes)
        {
            for (const std::string& group : groups)
            {
                open("group_state", {{"name", preshape.name}, {"group", group}});
                for (const std::size_t joint : m_joints)
                {
                    if (groupOf(joint) == group)
                    {
                        element("joint",
                                {{"name", tree().links[joint].joint.name},
                                 {"value", numberText(preshape.positions[joint])}});
                    }
                }
                m_printer.CloseElement();
            }
        }
    }

    void writeClosing()
    {
        m_printer.PushComment(
            " A joint that keeps its preshape while the hand closes: wrist, spread, opposition. ");
        for (const std::size_t joint : m_joints)
        {
            if (m_hand.closingDirections[joint] == 0)
            {
                element("passive_joint", {{"name", tree().links[joint].joint.name}});
            }
        }
        m_printer.PushComment(
            " A joint that closes, towards its upper (+1) or lower limit (-1). speed=\"0.5\" "
            "makes it half as fast as others. ");
        for (const std::size_t joint : m_joints)
        {
            if (m_hand.closingDirections[joint] != 0)
            {
                Attributes attributes{
                    {"joint", tree().links[joint].joint.name},
                    {"direction", m_hand.closingDirections[joint] > 0 ? "+1" : "-1"}};
                if (!m_hand.closingSpeeds.empty() && m_hand.closingSpeeds[joint] != 1.0)
                {
                    attributes.emplace_back("speed", numberText(m_hand.closingSpeeds[joint]));
                }
                element("closing", attributes);
            }
        }
    }

    void writeFrames()
    {
        m_printer.PushComment(
            " The grasp frame: its origin is where the fingers meet, z the direction in which the "
            "hand comes at an object, x that in which the fingers oppose each other. With a "
            "preshape it belongs to that one, without to all others. ");
        const std::string root = linkName(m_hand, 0);
        const auto frame = [&](const std::string& preshape, const Eigen::Isometry3d& X_RG)
        {
            Attributes attributes;
            if (!preshape.empty())
            {
                attributes.emplace_back("preshape", preshape);
            }
            attributes.emplace_back("link", root);
            attributes.emplace_back("xyz", tripleText(X_RG.translation()));
            attributes.emplace_back("rpy", tripleText(rollPitchYaw(X_RG.linear())));
            element("grasp_frame", attributes);
        };
        bool isShared = false;
        for (const Preshape& preshape : m_hand.preshapes)
        {
            if (preshape.X_RG)
            {
                frame(preshape.name, *preshape.X_RG);
            }
            isShared = isShared || !preshape.X_RG;
        }
        if (isShared)
        {
            frame("", m_hand.X_RG);
        }
    }

    const HandModel& m_hand;
    std::vector<std::size_t> m_joints;  // that move by themselves, as the links below them
};
}  // namespace

std::string handSrdf(const HandModel& hand)
{
    return HandWriter(hand).write();
}
}  // namespace bullet_ccd::grasp
