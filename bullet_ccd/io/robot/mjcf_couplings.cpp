#include "bullet_ccd/io/nearest_name.h"
#include "bullet_ccd/io/number_text.h"
#include "bullet_ccd/io/robot/mjcf_tree.h"
#include "bullet_ccd/io/robot/robot_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

namespace bullet_ccd
{
namespace
{
using tinyxml2::XMLElement;

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// A fixed tendon: its length is the sum of joint positions times coefficients.
using FixedTendon = std::vector<std::pair<std::int32_t, double>>;

class Couplings
{
public:
    Couplings(MjcfDocument& document, MjcfTree& tree)
        : m_document(document),
          m_tree(tree.robot.tree),
          m_notes(tree.robot.notes),
          m_reference(tree.reference),
          m_isDriven(tree.robot.tree.size(), false)
    {
    }

    void read()
    {
        readTendons();
        readActuators();
        // What follows a joint that is held has to know where that is.
        for (const bool isHold : {true, false})
        {
            for (const XMLElement* e : m_document.entries("equality"))
            {
                if (isHold ==
                    (std::string_view(e->Name()) == "joint" && e->Attribute("joint2") == nullptr))
                {
                    readEquality(*e);
                }
            }
        }
        flattenMimics();
        for (const auto& [name, actuator] : m_drivenTendons)
        {
            shareTendon(*actuator, m_tendons.at(name));
        }
        flattenMimics();
        leaveOutOthers();
    }

private:
    Joint& joint(std::int32_t link) { return m_tree.links[static_cast<std::size_t>(link)].joint; }

    std::int32_t findJoint(const MjcfElement& element, const char* attribute)
    {
        const std::string name = element.text(attribute).value_or("");
        const std::int32_t link = m_tree.findJoint(name);
        if (link != kNone)
        {
            return link;
        }
        const std::vector<std::string> names = m_document.jointNames();
        if (!m_document.makesNames() && std::ranges::find(names, name) == names.end())
        {
            failName(element, attribute, name, "joint", names);
        }
        // It belongs to an object of the scene that was left out.
        m_document.leftOut(
            element.xml(),
            std::string(element.tag()) + " of joint '" + name + "', which no link has");
        return kNone;
    }

    [[noreturn]] static void failName(const MjcfElement& element,
                                      const std::string& attribute,
                                      const std::string& name,
                                      const std::string& thing,
                                      const std::vector<std::string>& names)
    {
        const std::string nearest = nearestName(name, names);
        element.fail(
            attribute + (name.empty() ? " is missing" : " is '" + name + "', which is no " + thing),
            nearest.empty() ? "add the " + thing : "did you mean '" + nearest + "'?");
    }

    void readTendons()
    {
        for (const XMLElement* e : m_document.entries("tendon"))
        {
            const MjcfElement element(m_document, *e, "main");
            if (element.tag() != "fixed")
            {
                m_document.leftOut(*e, "<" + std::string(element.tag()) + "> of <tendon>");
                m_otherTendons.push_back(element.name());
                continue;
            }
            FixedTendon& tendon = m_tendons[element.name()];
            for (const XMLElement* j = e->FirstChildElement("joint"); j != nullptr;
                 j = j->NextSiblingElement("joint"))
            {
                // These joints are names, not joints with defaults.
                const MjcfElement part(m_document, *j, "main");
                const char* const coef = j->Attribute("coef");
                const auto value = parseNumber<double>(coef == nullptr ? "0" : coef);
                if (!value || !std::isfinite(*value))
                {
                    part.fail("coef is " + quoted(std::string_view(coef)), "give a finite number");
                }
                const double coefficient = *value;
                const std::int32_t link = findJoint(part, "joint");
                if (link != kNone && coefficient != 0.0)
                {
                    tendon.emplace_back(link, coefficient);
                }
            }
        }
    }

    void limitEffort(std::int32_t link, double effort)
    {
        m_isDriven[static_cast<std::size_t>(link)] = true;
        joint(link).maxEffort = std::min(joint(link).maxEffort, effort);
    }

    /// The largest force at the joint or tendon.
    static double effortOf(const MjcfElement& element)
    {
        const auto gear = element.numbers("gear", 1, 6);
        const double factor = std::abs(gear ? gear->front() : 1.0);
        const auto largest = [&](const char* range, const char* limited)
        {
            const auto values =
                element.isLimited(limited, range) ? element.numbers(range, 2) : std::nullopt;
            return values ? factor * std::max(std::abs((*values)[0]), std::abs((*values)[1]))
                          : kUnlimited;
        };
        const double force = largest("forcerange", "forcelimited");
        return element.tag() == "motor" ? std::min(force, largest("ctrlrange", "ctrllimited"))
                                        : force;
    }

    void readActuators()
    {
        for (const XMLElement* e : m_document.entries("actuator"))
        {
            const MjcfElement element(m_document, *e, "main");
            if (!isMjcfActuator(element.tag()))
            {
                continue;
            }
            const double effort = effortOf(element);
            // What is not read shall not be turned round either.
            (void)element.isLimited("ctrllimited", "ctrlrange");
            const std::optional<std::string> tendon = element.text("tendon");
            if (element.text("joint") || element.text("jointinparent"))
            {
                const std::int32_t link =
                    findJoint(element, element.text("joint") ? "joint" : "jointinparent");
                if (link != kNone)
                {
                    limitEffort(link, effort);
                }
            }
            else if (tendon && m_tendons.contains(*tendon))
            {
                for (const auto& [link, coefficient] : m_tendons[*tendon])
                {
                    limitEffort(link, std::abs(coefficient) * effort);
                }
                m_drivenTendons.emplace_back(*tendon, e);
            }
            else
            {
                if (tendon && !m_document.makesNames())
                {
                    requireTendon(element, "tendon", *tendon);
                }
                m_document.leftOut(
                    *e,
                    "actuator '" + element.name() + "', which drives no joint and no fixed tendon");
            }
        }
        for (std::size_t i = 1; i < m_tree.size(); ++i)
        {
            m_isDriven[i] = m_isDriven[i] && m_tree.links[i].joint.isMovable();
        }
    }

    void readEquality(const XMLElement& e)
    {
        const MjcfElement element(m_document, e, "main");
        if (element.text("active") == "false")
        {
            return;
        }
        std::vector<double> polynomial{0.0, 1.0, 0.0, 0.0, 0.0};
        if (const auto given = element.numbers("polycoef", 1, 5))
        {
            std::ranges::copy(*given, polynomial.begin());
        }
        if (element.tag() == "joint")
        {
            equateJoints(element, polynomial);
        }
        else if (element.tag() == "tendon" && !element.text("tendon2"))
        {
            holdTendon(element, polynomial[0]);
        }
        else
        {
            m_document.leftOut(e,
                               "<" + std::string(element.tag()) + "> of <equality>" +
                                   (element.name().empty() ? "" : " '" + element.name() + "'"));
        }
    }

    void equateJoints(const MjcfElement& element, const std::vector<double>& polynomial)
    {
        const std::int32_t first = findJoint(element, "joint1");
        if (first == kNone)
        {
            return;
        }
        const double offset = reference(first) + polynomial[0];
        if (!element.text("joint2"))
        {
            hold(first, offset);
            return;
        }
        const std::int32_t second = findJoint(element, "joint2");
        if (second == kNone)
        {
            return;
        }
        if (polynomial[2] != 0.0 || polynomial[3] != 0.0 || polynomial[4] != 0.0)
        {
            m_document.leftOut(element.xml(),
                               "terms beyond the linear one of polycoef between '" +
                                   joint(first).name + "' and '" + joint(second).name + "'");
        }
        // q1 - r1 = a0 + a1 (q2 - r2)
        follow(element.xml(),
               first,
               second,
               polynomial[1],
               offset - polynomial[1] * reference(second));
    }

    /// Held where it is, it is no joint any more.
    void hold(std::int32_t index, double position)
    {
        Link& link = m_tree.links[static_cast<std::size_t>(index)];
        link.X_PL0 = linkInParent(link, position);
        const std::string name = link.joint.name;
        link.joint = {};
        link.joint.name = name;
        m_held[index] = position;
    }

    /// A tendon of constant length couples two joints.
    void holdTendon(const MjcfElement& element, double change)
    {
        const std::string name = element.text("tendon1").value_or("");
        requireTendon(element, "tendon1", name);
        const auto found = m_tendons.find(name);
        if (found == m_tendons.end() || found->second.size() != 2)
        {
            m_document.leftOut(element.xml(),
                               "<tendon> of <equality>, which is no fixed tendon of two joints");
            return;
        }
        const auto [a, ca] = found->second[0];
        const auto [b, cb] = found->second[1];
        // ca (qa - ra) + cb (qb - rb) = change
        follow(element.xml(), b, a, -ca / cb, reference(b) + (change + ca * reference(a)) / cb);
    }

    /// Throws for a name that no tendon has.
    void requireTendon(const MjcfElement& element, const char* attribute, const std::string& name)
    {
        std::vector<std::string> names = m_otherTendons;
        for (const auto& [known, unused] : m_tendons)
        {
            names.push_back(known);
        }
        if (std::ranges::find(names, name) == names.end())
        {
            failName(element, attribute, name, "tendon", names);
        }
    }

    /// The joints of a tendon that a motor pulls, and nothing else couples, share the way.
    void shareTendon(const XMLElement& actuator, FixedTendon tendon)
    {
        std::erase_if(tendon, [this](const auto& part) { return m_held.contains(part.first); });
        const auto driver = [&](std::int32_t link)
        {
            for (std::size_t steps = 0; joint(link).mimicOf != kNone && steps < m_tree.size();
                 ++steps)
            {
                link = joint(link).mimicOf;
            }
            return link;
        };
        std::vector<std::string> names;
        for (std::size_t i = 1; i < tendon.size(); ++i)
        {
            const auto [first, c0] = tendon.front();
            const auto [link, c] = tendon[i];
            if (driver(link) != driver(first) &&
                follow(actuator, link, first, c / c0, reference(link) - c / c0 * reference(first)))
            {
                names.push_back(joint(link).name);
            }
        }
        if (!names.empty())
        {
            m_notes.push_back("joints on one tendon move in proportion to its coefficients, with " +
                              joint(tendon.front().first).name + ": " + listNames(names));
        }
    }

    /// follower = multiplier * leader + offset, or the other way round if the follower follows
    /// another one already, or is the one that a motor drives. False if others contradict.
    /// @param reason  the element that says so
    bool follow(const XMLElement& reason,
                std::int32_t follower,
                std::int32_t leader,
                double multiplier,
                double offset)
    {
        const auto isFree = [&](std::int32_t link)
        { return joint(link).isMovable() && joint(link).mimicOf == kNone; };
        const bool prefersOther =
            !isFree(follower) || (m_isDriven[static_cast<std::size_t>(follower)] &&
                                  !m_isDriven[static_cast<std::size_t>(leader)]);
        if (prefersOther && isFree(leader) && multiplier != 0.0)
        {
            std::swap(follower, leader);
            offset = -offset / multiplier;
            multiplier = 1.0 / multiplier;
        }
        bool loops = !isFree(follower);
        for (std::int32_t link = leader; link != kNone && !loops; link = joint(link).mimicOf)
        {
            loops = link == follower;
        }
        if (loops || (!joint(leader).isMovable() && !m_held.contains(leader)))
        {
            m_document.leftOut(reason,
                               "the coupling of '" + joint(follower).name + "' and '" +
                                   joint(leader).name + "', which others contradict");
            return false;
        }
        joint(follower).mimicOf = leader;
        joint(follower).mimicMultiplier = multiplier;
        joint(follower).mimicOffset = offset;
        return true;
    }

    /// A joint follows one that follows none; if that is held, it is held as well.
    void flattenMimics()
    {
        for (std::size_t i = 1; i < m_tree.size(); ++i)
        {
            Joint& own = m_tree.links[i].joint;
            while (own.mimicOf != kNone && joint(own.mimicOf).mimicOf != kNone)
            {
                const Joint& next = joint(own.mimicOf);
                own.mimicOffset += own.mimicMultiplier * next.mimicOffset;
                own.mimicMultiplier *= next.mimicMultiplier;
                own.mimicOf = next.mimicOf;
            }
            const auto held = m_held.find(own.mimicOf);
            if (held != m_held.end())
            {
                hold(static_cast<std::int32_t>(i),
                     own.mimicMultiplier * held->second + own.mimicOffset);
            }
        }
    }

    void leaveOutOthers()
    {
        for (const XMLElement* e : m_document.entries("contact"))
        {
            m_document.leftOut(*e, "<" + std::string(e->Name()) + "> of <contact>");
        }
        for (const char* const section : {"deformable", "extension"})
        {
            for (const XMLElement* e : m_document.entries(section))
            {
                m_document.leftOut(*e, "<" + std::string(e->Name()) + "> of <" + section + ">");
            }
        }
    }

    [[nodiscard]] double reference(std::int32_t link) const
    {
        return m_reference[static_cast<std::size_t>(link)];
    }

    MjcfDocument& m_document;
    KinematicTree& m_tree;
    std::vector<std::string>& m_notes;
    const std::vector<double>& m_reference;
    std::vector<bool> m_isDriven;
    std::map<std::string, FixedTendon> m_tendons;
    std::vector<std::string> m_otherTendons;  ///< spatial ones
    std::vector<std::pair<std::string, const XMLElement*>> m_drivenTendons;
    std::map<std::int32_t, double> m_held;  ///< where joints are that move no more
};
}  // namespace

void coupleMjcf(MjcfDocument& document, MjcfTree& tree)
{
    Couplings(document, tree).read();
}
}  // namespace bullet_ccd
