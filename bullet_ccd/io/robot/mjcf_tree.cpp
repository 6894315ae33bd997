#include "bullet_ccd/io/robot/mjcf_tree.h"

#include "bullet_ccd/io/robot/mjcf_geometry.h"
#include "bullet_ccd/io/robot/robot_parts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using tinyxml2::XMLElement;

Isometry3d shift(const Vector3d& by)
{
    Isometry3d X = Isometry3d::Identity();
    X.translation() = by;
    return X;
}

bool is(const XMLElement& element, std::string_view tag)
{
    return element.Name() == tag;
}

bool isFree(const XMLElement& joint)
{
    const char* const type = joint.Attribute("type");
    return is(joint, "freejoint") ||
           (is(joint, "joint") && type != nullptr && std::string_view(type) == "free");
}

bool isBall(const XMLElement& joint)
{
    const char* const type = joint.Attribute("type");
    return is(joint, "joint") && type != nullptr && std::string_view(type) == "ball";
}

template <typename Visit>
void forChildren(const XMLElement& element, const Visit& visit)
{
    for (const XMLElement* e = element.FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement())
    {
        visit(*e);
    }
}

bool hasChild(const XMLElement& element, const auto& predicate)
{
    bool found = false;
    forChildren(element, [&](const XMLElement& e) { found = found || predicate(e); });
    return found;
}

/// What may stand in a body and says nothing about links.
bool isWithoutMeaning(const XMLElement& element)
{
    static const std::set<std::string_view> kTags = {"site", "camera", "light", "plugin"};
    return kTags.contains(element.Name());
}

/// Inertials add up.
struct Masses
{
    double mass = 0.0;
    Vector3d moment = Vector3d::Zero();                // mass * centre
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  // about the origin

    void add(const TriangleMesh& mesh, double geomMass)
    {
        const MassProperties properties = massProperties(mesh);
        if (!(geomMass > 0.0) || !(properties.volume > 0.0))
        {
            return;
        }
        const Vector3d& c = properties.center;
        mass += geomMass;
        moment += geomMass * c;
        second += geomMass / properties.volume * properties.inertia +
                  geomMass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
    }

    void put(Link& link) const
    {
        if (mass > 0.0)
        {
            const Vector3d c = moment / mass;
            link.mass = mass;
            link.centerOfMass = c;
            link.inertia =
                second - mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
        }
    }
};

class TreeReader
{
public:
    explicit TreeReader(MjcfDocument& document) : m_document(document), m_geometry(document) {}

    MjcfTree read()
    {
        RobotModel& robot = m_tree.robot;
        robot.name = m_document.modelName();
        robot.file = m_document.path();
        readWorld();
        if (m_collidingGeoms == 0)
        {
            robot.notes.emplace_back(
                "no geom can collide, contype and conaffinity are 0 for all that are read");
        }
        if (!m_movedFrames.empty())
        {
            robot.notes.push_back("link frames moved from the bodies' to their joints' axes: " +
                                  listNames(m_movedFrames));
        }
        robot.notes.insert(robot.notes.end(), m_geometry.notes().begin(), m_geometry.notes().end());
        return std::move(m_tree);
    }

private:
    /// A body below the world, and the frame and class that elements around it give it.
    struct Placed
    {
        const XMLElement* body;
        Isometry3d X_PF;
        std::string childClass;
    };

    /// An element of a body, and the pose of the <frame> around it in the body.
    using PlacedElement = std::pair<MjcfElement, Isometry3d>;

    /// The bodies below this element, through frames; what is neither goes to `other`.
    template <typename Other>
    void forBodies(const XMLElement& element,
                   const Isometry3d& X_PF,
                   const std::string& childClass,
                   std::vector<Placed>& bodies,
                   const Other& other)
    {
        forChildren(element,
                    [&](const XMLElement& e)
                    {
                        if (is(e, "body"))
                        {
                            bodies.push_back({&e, X_PF, childClass});
                        }
                        else if (is(e, "frame"))
                        {
                            const MjcfElement frame(m_document, e, childClass);
                            const char* const named = e.Attribute("childclass");
                            forBodies(e,
                                      X_PF * frame.pose(),
                                      named == nullptr ? childClass : named,
                                      bodies,
                                      other);
                        }
                        else
                        {
                            other(e, X_PF, childClass);
                        }
                    });
    }

    void readWorld()
    {
        std::vector<Placed> bodies;
        std::vector<std::pair<const XMLElement*, std::pair<Isometry3d, std::string>>> geoms;
        for (const XMLElement* section : m_document.sections("worldbody"))
        {
            forBodies(*section,
                      Isometry3d::Identity(),
                      "main",
                      bodies,
                      [&](const XMLElement& e, const Isometry3d& X, const std::string& childClass)
                      {
                          if (is(e, "geom"))
                          {
                              geoms.push_back({&e, {X, childClass}});
                          }
                          else if (!isWithoutMeaning(e))
                          {
                              m_document.leftOut(e, "<" + std::string(e.Name()) + "> of the world");
                          }
                      });
        }
        if (bodies.empty())
        {
            throw std::runtime_error(m_document.path().string() +
                                     ": worldbody: no body: add the bodies of the robot");
        }
        const auto isObject = [](const Placed& placed)
        {
            return (hasChild(*placed.body, isFree) || hasChild(*placed.body, isBall)) &&
                   !hasChild(*placed.body, [](const XMLElement& e) { return is(e, "body"); });
        };
        if (bodies.size() > 1)
        {
            for (const Placed& placed : bodies)
            {
                if (isObject(placed))
                {
                    const char* const name = placed.body->Attribute("name");
                    m_document.leftOut(*placed.body,
                                       "object '" + std::string(name == nullptr ? "" : name) +
                                           "', a body with a free joint or a ball joint");
                }
            }
            std::erase_if(bodies, isObject);
        }
        if (bodies.size() == 1 &&
            !hasChild(*bodies[0].body,
                      [](const XMLElement& e) { return is(e, "joint") && !isFree(e); }))
        {
            // The pose of the whole robot is given elsewhere.
            if (!geoms.empty())
            {
                m_document.leftOut(*geoms.front().first,
                                   std::to_string(geoms.size()) + " geoms of the world");
            }
            readBody(bodies[0], kNone, Isometry3d::Identity());
            return;
        }
        Link world;
        world.name = "world";
        push(std::move(world), 0.0);
        Masses masses;
        for (const auto& [element, place] : geoms)
        {
            addGeom(MjcfElement(m_document, *element, place.second), place.first, masses);
        }
        masses.put(m_tree.robot.tree.links[0]);
        for (const Placed& placed : bodies)
        {
            readBody(placed, 0, Isometry3d::Identity());
        }
    }

    std::int32_t push(Link link, double reference)
    {
        KinematicTree& tree = m_tree.robot.tree;
        if (tree.findLink(link.name) != kNone ||
            (link.parent != kNone && tree.findJoint(link.joint.name) != kNone))
        {
            throw std::runtime_error(m_document.path().string() + ": body '" + link.name +
                                     "' or its joint '" + link.joint.name +
                                     "' is there twice: give each its own name");
        }
        tree.links.push_back(std::move(link));
        m_tree.robot.linkMeshes.emplace_back();
        m_tree.reference.push_back(reference);
        return static_cast<std::int32_t>(tree.size()) - 1;
    }

    /// @param X_LP pose of the parent body's frame in its link
    void readBody(const Placed& placed, std::int32_t parent, const Isometry3d& X_LP)
    {
        const MjcfElement body(m_document, *placed.body, placed.childClass);
        const char* const named = placed.body->Attribute("childclass");
        const std::string childClass = named == nullptr ? placed.childClass : named;
        const std::string name =
            body.name().empty() ? "body_" + std::to_string(m_tree.robot.tree.size()) : body.name();

        std::vector<PlacedElement> joints;
        std::vector<PlacedElement> geoms;
        std::optional<MjcfElement> inertial;
        std::vector<Placed> children;
        const auto other =
            [&](const XMLElement& e, const Isometry3d& X_BF, const std::string& elementClass)
        {
            if (isFree(e))
            {
                if (parent > 0)
                {
                    throw std::runtime_error(body.where() +
                                             ": a free joint below another body: remove it");
                }
            }
            else if (is(e, "joint"))
            {
                joints.emplace_back(MjcfElement(m_document, e, elementClass), X_BF);
            }
            else if (is(e, "geom"))
            {
                geoms.emplace_back(MjcfElement(m_document, e, elementClass), X_BF);
            }
            else if (is(e, "inertial"))
            {
                // Frames do not move it, as in MuJoCo.
                inertial.emplace(m_document, e, elementClass);
            }
            else if (!isWithoutMeaning(e))
            {
                m_document.leftOut(e, "<" + std::string(e.Name()) + "> of body '" + name + "'");
            }
        };
        forBodies(*placed.body, Isometry3d::Identity(), childClass, children, other);

        // The root's pose in the world is not the robot's business.
        const Isometry3d X_LB0 =
            parent == kNone ? Isometry3d::Identity() : X_LP * placed.X_PF * body.pose();
        const auto [link, X_LB] = readJoints(joints, name, parent, X_LB0);
        readGeometry(geoms, inertial, link, X_LB);
        for (const Placed& child : children)
        {
            readBody(child, link, X_LB);
        }
    }

    /// The links of a body; returns the last one, and the pose of the body's frame in it.
    std::pair<std::int32_t, Isometry3d> readJoints(const std::vector<PlacedElement>& joints,
                                                   const std::string& body,
                                                   std::int32_t parent,
                                                   Isometry3d X_PB)
    {
        if (joints.empty())
        {
            Link link;
            link.name = body;
            link.parent = parent;
            if (parent != kNone)
            {
                link.X_PL0 = X_PB;
                link.joint.name = body + "_fixed";
            }
            return {push(std::move(link), 0.0), Isometry3d::Identity()};
        }
        for (std::size_t k = 0; k < joints.size(); ++k)
        {
            const auto& [source, X_BF] = joints[k];
            const bool isLast = k + 1 == joints.size();
            Link link;
            const std::string suffix = joints.size() > 1 ? std::to_string(k + 1) : "";
            const std::string jointName =
                source.name().empty() ? body + "_joint" + suffix : source.name();
            link.name = isLast ? body : body + "/" + jointName;
            link.parent = parent;
            link.joint = readJoint(source, jointName);
            link.joint.axis = X_BF.linear() * link.joint.axis;
            // A translation has no axis to be at.
            const Vector3d anchor =
                link.joint.type == JointType::Revolute
                    ? Vector3d(X_BF * source.vector("pos").value_or(Vector3d::Zero()))
                    : Vector3d(Vector3d::Zero());
            const double reference =
                angleOrLength(link.joint.type, source.number("ref").value_or(0.0));
            link.X_PL0 = X_PB * shift(anchor);
            link.X_PL0 = linkInParent(link, -reference);
            if (isLast && !anchor.isZero())
            {
                m_movedFrames.push_back(link.name);
            }
            X_PB = shift(-anchor);
            parent = push(std::move(link), reference);
        }
        return {parent, X_PB};
    }

    [[nodiscard]] double angleOrLength(JointType type, double value) const
    {
        return type == JointType::Revolute ? m_document.radians(value) : value;
    }

    Joint readJoint(const MjcfElement& source, const std::string& name)
    {
        Joint joint;
        joint.name = name;
        const std::string type = source.text("type").value_or("hinge");
        if (type != "hinge" && type != "slide")
        {
            source.fail("type is '" + type + "'",
                        type == "ball" ? "write it as three hinges" : "use hinge or slide");
        }
        joint.type = type == "hinge" ? JointType::Revolute : JointType::Prismatic;
        const Vector3d axis = source.vector("axis").value_or(Vector3d::UnitZ());
        if (!(axis.norm() > 0.0))
        {
            source.fail("axis has no direction", "give a vector other than 0");
        }
        joint.axis = axis.normalized();
        if (source.isLimited("limited", "range"))
        {
            const auto range = source.numbers("range", 2);
            if (!range || !((*range)[0] < (*range)[1]))
            {
                source.fail("range is missing, or its first number is not below the second",
                            "give the lower limit and the upper one");
            }
            joint.lower = angleOrLength(joint.type, (*range)[0]);
            joint.upper = angleOrLength(joint.type, (*range)[1]);
        }
        if (source.isLimited("actuatorfrclimited", "actuatorfrcrange"))
        {
            const auto range = source.numbers("actuatorfrcrange", 2);
            joint.maxEffort =
                range ? std::max(std::abs((*range)[0]), std::abs((*range)[1])) : joint.maxEffort;
        }
        return joint;
    }

    void addGeom(const MjcfElement& element, const Isometry3d& X_LF, Masses& masses)
    {
        std::optional<MjcfGeom> geom = m_geometry.geom(element);
        if (!geom)
        {
            return;
        }
        transformMesh(geom->mesh, Eigen::Affine3d(X_LF));
        masses.add(geom->mesh, geom->mass);
        if (geom->collides)
        {
            ++m_collidingGeoms;
            appendMesh(m_tree.robot.linkMeshes.back(), geom->mesh);
        }
    }

    void readGeometry(const std::vector<PlacedElement>& geoms,
                      const std::optional<MjcfElement>& inertial,
                      std::int32_t index,
                      const Isometry3d& X_LB)
    {
        Masses masses;
        for (const auto& [element, X_BF] : geoms)
        {
            addGeom(element, X_LB * X_BF, masses);
        }
        Link& link = m_tree.robot.tree.links[static_cast<std::size_t>(index)];
        if (inertial && m_document.compiler("inertiafromgeom") != "true")
        {
            readInertial(*inertial, X_LB, link);
        }
        else
        {
            masses.put(link);
        }
    }

    static void readInertial(const MjcfElement& source, const Isometry3d& X_LB, Link& link)
    {
        const std::optional<double> mass = source.number("mass");
        if (!mass)
        {
            source.fail("no mass", "give it");
        }
        Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
        if (const auto full = source.numbers("fullinertia", 6))
        {
            const std::vector<double>& m = *full;
            inertia << m[0], m[3], m[4], m[3], m[1], m[5], m[4], m[5], m[2];
        }
        else if (const auto diagonal = source.vector("diaginertia"))
        {
            inertia = diagonal->asDiagonal();
        }
        const Isometry3d X_LC = X_LB * source.pose();
        link.mass = *mass;
        link.centerOfMass = X_LC.translation();
        link.inertia = X_LC.linear() * inertia * X_LC.linear().transpose();
    }

    MjcfDocument& m_document;
    MjcfGeometry m_geometry;
    MjcfTree m_tree;
    std::vector<std::string> m_movedFrames;
    int m_collidingGeoms = 0;
};
}  // namespace

MjcfTree mjcfTree(MjcfDocument& document)
{
    return TreeReader(document).read();
}
}  // namespace bullet_ccd
