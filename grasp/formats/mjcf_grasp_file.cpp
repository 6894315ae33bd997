#include "grasp/formats/mjcf_grasp_file.h"

#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/replace_file.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/hand/least_inertia.h"
#include "grasp/hand/xml_text.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
/// The inertia of the motors, over damping times time step. MuJoCo solves contacts without the
/// damping that it then takes implicitly, so light fingers with little else would be shaken off.
constexpr double kArmatureSteps = 2.0;
/// In which contacts push out what is in them, in time steps. Two is the least that MuJoCo takes;
/// contact points that come and go then kick the object out of hands that hold it with less.
constexpr double kContactSteps = 5.0;

std::string decimal(double value, const char* format = "%.17g")
{
    std::array<char, 40> text{};
    (void)std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

template <typename Numbers>
std::string decimals(const Numbers& numbers, const char* format = "%.17g")
{
    std::string text;
    for (const double number : numbers)
    {
        text += (text.empty() ? "" : " ") + decimal(number, format);
    }
    return text;
}

/// Of MuJoCo: w first.
std::string rotationText(const Eigen::Isometry3d& X)
{
    const Eigen::Quaterniond q = Eigen::Quaterniond(X.linear()).normalized();
    return decimals(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()));
}

std::string meshName(const std::string& body, std::size_t piece)
{
    return body + "_" + std::to_string(piece);
}

std::string bodyOf(std::size_t link)
{
    return "link" + std::to_string(link);
}

class GraspWriter : XmlText
{
public:
    GraspWriter(const HandModel& hand,
                const GraspObject& object,
                const Grasp& grasp,
                const Squeeze& squeeze,
                const MjcfPieces& pieces,
                const MjcfOptions& options)
        : m_hand(hand),
          m_object(object),
          m_grasp(grasp),
          m_squeeze(squeeze),
          m_pieces(pieces),
          m_options(options),
          m_joints(independentJoints(hand.robot.tree))
    {
        while (tree().findLink(m_objectName) != kNone)
        {
            m_objectName += "_";
        }
        while (tree().findLink(m_worldName) != kNone)
        {
            m_worldName += "_";
        }
    }

    std::string write(const std::string& meshes)
    {
        open("mujoco", {{"model", m_hand.robot.name + " grasps " + m_object.name}});
        comment();
        element("compiler", {{"angle", "radian"}, {"meshdir", meshes}, {"balanceinertia", "true"}});
        // Static friction that hardly creeps: elliptic cones, friction a hundred times as stiff as
        // the normal force, Newton's method, joints and drives taken implicitly.
        open("option",
             {{"timestep", decimal(m_options.timeStep)},
              {"gravity", "0 0 0"},
              {"cone", "elliptic"},
              {"impratio", "100"},
              {"integrator", "implicit"},
              {"solver", "Newton"},
              {"tolerance", "1e-10"}});
        element("flag", {{"multiccd", "enable"}});
        m_printer.CloseElement();
        writeDefaults();
        writeMeshList();
        open("worldbody", {});
        writeLink(0);
        writeObject();
        m_printer.CloseElement();
        writeExclusions();
        writeCouplings();
        writeControllers();
        writeKeys();
        m_printer.CloseElement();
        return m_printer.CStr();
    }

private:
    [[nodiscard]] const KinematicTree& tree() const { return m_hand.robot.tree; }
    [[nodiscard]] const Link& linkAt(std::size_t link) const { return tree().links[link]; }

    /// MuJoCo has a body of that name.
    [[nodiscard]] std::string bodyName(std::size_t link) const
    {
        const std::string& name = linkAt(link).name;
        return name == "world" ? m_worldName : name;
    }

    void comment()
    {
        std::size_t count = 0;
        double bulge = 0.0;
        for (const ConvexPieces& link : m_pieces.links)
        {
            count += link.pieces.size();
            bulge = std::max(bulge, link.bulge);
        }
        m_printer.PushComment(
            (" A grasp, written by bullet_ccd. MuJoCo takes the convex hull of every mesh, so hand "
             "and object are cut into convex pieces, which contain the full surfaces: " +
             std::to_string(count) + " pieces of the hand, which fill up to " +
             decimal(1e3 * bulge, "%.3g") +
             " mm beside its surface (hollows inside of links count), and " +
             std::to_string(m_pieces.object.pieces.size()) + " of the object, up to " +
             decimal(1e3 * m_pieces.object.bulge, "%.3g") +
             " mm. The world is the object's mesh frame; there is no gravity. Controllers have the "
             "stiffness, damping and effort that the squeeze is for; limits of speed are left "
             "out. ")
                .c_str());
    }

    void writeDefaults()
    {
        open("default", {});
        element(
            "geom",
            {{"type", "mesh"},
             {"condim", m_options.torsion > 0.0 ? "4" : "3"},
             {"friction", decimals(Eigen::Vector3d(m_options.friction, m_options.torsion, 0.0))},
             {"solref", decimal(kContactSteps * m_options.timeStep) + " 1"},
             {"solimp", "0.95 0.99 0.0005"}});
        m_printer.CloseElement();
    }

    void writeMeshList()
    {
        open("asset", {});
        const auto list = [&](const std::string& body, const ConvexPieces& pieces)
        {
            for (std::size_t k = 0; k < pieces.pieces.size(); ++k)
            {
                const std::string name = meshName(body, k);
                element("mesh", {{"name", name}, {"file", name + ".obj"}});
            }
        };
        for (std::size_t i = 0; i < m_pieces.links.size(); ++i)
        {
            list(bodyOf(i), m_pieces.links[i]);
        }
        list("object", m_pieces.object);
        m_printer.CloseElement();
    }

    void writeInertial(const Eigen::Vector3d& center, double mass, const Eigen::Matrix3d& inertia)
    {
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(inertia);
        const Eigen::Matrix3d& R = principal.eigenvectors();
        const Eigen::Matrix3d I =
            R * principal.eigenvalues().cwiseMax(kLeastLinkMoment).asDiagonal() * R.transpose();
        element("inertial",
                {{"pos", decimals(center)},
                 {"mass", decimal(mass)},
                 {"fullinertia",
                  decimals(std::array{I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)})}});
    }

    void writeGeoms(const std::string& body, const ConvexPieces& pieces)
    {
        for (std::size_t k = 0; k < pieces.pieces.size(); ++k)
        {
            element("geom", {{"name", meshName(body, k)}, {"mesh", meshName(body, k)}});
        }
    }

    /// With all links below it: MuJoCo numbers joints in this order.
    void writeLink(std::size_t index)
    {
        const Link& link = linkAt(index);
        const Eigen::Isometry3d& X = index == 0 ? m_grasp.X_WH : link.X_PL0;
        open("body",
             {{"name", bodyName(index)},
              {"pos", decimals(X.translation())},
              {"quat", rotationText(X)}});
        if (index > 0 && link.joint.isMovable())
        {
            writeJoint(index);
            m_positions.push_back(m_grasp.positions[index]);
        }
        writeInertial(link.centerOfMass, std::max(link.mass, kLeastLinkMass), link.inertia);
        writeGeoms(bodyOf(index), m_pieces.links[index]);
        for (std::size_t below = index + 1; below < tree().size(); ++below)
        {
            if (linkAt(below).parent == static_cast<std::int32_t>(index))
            {
                writeLink(below);
            }
        }
        m_printer.CloseElement();
    }

    void writeJoint(std::size_t index)
    {
        const Joint& joint = linkAt(index).joint;
        // What follows another joint needs no stops of its own.
        const bool isLimited = joint.mimicOf == kNone && joint.lower < joint.upper &&
                               std::isfinite(joint.lower) && std::isfinite(joint.upper);
        Attributes attributes{{"name", joint.name},
                              {"type", joint.type == JointType::Revolute ? "hinge" : "slide"},
                              {"axis", decimals(joint.axis)},
                              {"limited", isLimited ? "true" : "false"}};
        if (isLimited)
        {
            attributes.emplace_back("range", decimal(joint.lower) + " " + decimal(joint.upper));
        }
        const std::int32_t driver =
            joint.mimicOf == kNone ? static_cast<std::int32_t>(index) : joint.mimicOf;
        const auto controller = std::ranges::find(m_joints, driver) - m_joints.begin();
        const double damping =
            m_options.dampingTime * m_squeeze.stiffness[static_cast<std::size_t>(controller)];
        attributes.emplace_back("armature", decimal(kArmatureSteps * m_options.timeStep * damping));
        element("joint", attributes);
    }

    void writeObject()
    {
        open("body", {{"name", m_objectName}});
        element("freejoint", {});
        writeInertial(m_object.centerOfMass,
                      m_options.mass,
                      inertiaAtMass(m_object.tree.mesh(), m_options.mass));
        writeGeoms("object", m_pieces.object);
        m_printer.CloseElement();
    }

    void writeExclusions()
    {
        open("contact", {});
        const auto hasGeometry = [&](std::size_t link)
        { return !m_pieces.links[link].pieces.empty(); };
        for (std::size_t a = 0; a < tree().size(); ++a)
        {
            for (std::size_t b = a + 1; b < tree().size(); ++b)
            {
                const std::pair pair(static_cast<std::int32_t>(a), static_cast<std::int32_t>(b));
                if (hasGeometry(a) && hasGeometry(b) &&
                    std::ranges::find(m_hand.selfPairs, pair) == m_hand.selfPairs.end())
                {
                    element("exclude", {{"body1", bodyName(a)}, {"body2", bodyName(b)}});
                }
            }
        }
        m_printer.CloseElement();
    }

    void writeCouplings()
    {
        open("equality", {});
        for (const Link& link : tree().links)
        {
            if (link.joint.isMovable() && link.joint.mimicOf != kNone)
            {
                const Joint& driver = linkAt(static_cast<std::size_t>(link.joint.mimicOf)).joint;
                element("joint",
                        {{"joint1", link.joint.name},
                         {"joint2", driver.name},
                         {"polycoef",
                          decimals(std::array{
                              link.joint.mimicOffset, link.joint.mimicMultiplier, 0.0, 0.0, 0.0})},
                         {"solref", decimal(2.0 * m_options.timeStep) + " 1"},
                         {"solimp", "0.99 0.999 0.001"}});
            }
        }
        m_printer.CloseElement();
    }

    void writeControllers()
    {
        open("actuator", {});
        for (std::size_t j = 0; j < m_joints.size(); ++j)
        {
            const std::string& name = linkAt(static_cast<std::size_t>(m_joints[j])).joint.name;
            const double stiffness = m_squeeze.stiffness[j];
            const double limit = m_squeeze.efforts[j].limit;
            element(
                "general",
                {{"name", name},
                 {"joint", name},
                 {"gaintype", "fixed"},
                 {"gainprm", decimal(stiffness)},
                 {"biastype", "affine"},
                 {"biasprm",
                  decimals(Eigen::Vector3d(0.0, -stiffness, -m_options.dampingTime * stiffness))},
                 {"forcelimited", "true"},
                 {"forcerange", decimal(-limit) + " " + decimal(limit)}});
        }
        m_printer.CloseElement();
    }

    void writeKeys()
    {
        open("keyframe", {});
        const std::string positions =
            decimals(m_positions) + (m_positions.empty() ? "" : " ") + "0 0 0 1 0 0 0";
        std::vector<double> held;
        for (const std::int32_t joint : m_joints)
        {
            held.push_back(m_grasp.positions[static_cast<std::size_t>(joint)]);
        }
        element("key", {{"name", "grasp"}, {"qpos", positions}, {"ctrl", decimals(held)}});
        if (m_squeeze.exists())
        {
            element(
                "key",
                {{"name", "squeeze"}, {"qpos", positions}, {"ctrl", decimals(m_squeeze.targets)}});
        }
        m_printer.CloseElement();
    }

    const HandModel& m_hand;
    const GraspObject& m_object;
    const Grasp& m_grasp;
    const Squeeze& m_squeeze;
    const MjcfPieces& m_pieces;
    const MjcfOptions& m_options;
    std::vector<std::int32_t> m_joints;
    std::string m_objectName = "object";
    std::string m_worldName = "world_";
    std::vector<double> m_positions;  ///< of the joints, in the order of MuJoCo
};

void writePiece(const std::filesystem::path& file, const TriangleMesh& mesh)
{
    std::string text = "# A convex piece [m].\n";
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        text += "v " + decimals(vertex, "%.9g") + "\n";
    }
    for (const Triangle& t : mesh.triangles)
    {
        text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
                std::to_string(t[2] + 1) + "\n";
    }
    if (const std::error_code error = replaceFile(file, {text}))
    {
        throw std::runtime_error(file.string() + ": " + error.message() +
                                 ": give a folder that can be written");
    }
}

void writePieces(const std::filesystem::path& folder,
                 const std::string& body,
                 const ConvexPieces& pieces)
{
    for (std::size_t k = 0; k < pieces.pieces.size(); ++k)
    {
        writePiece(folder / (meshName(body, k) + ".obj"), pieces.pieces[k]);
    }
}
}  // namespace

void writeMjcf(std::ostream& out,
               const HandModel& hand,
               const GraspObject& object,
               const Grasp& grasp,
               const Squeeze& squeeze,
               const MjcfPieces& pieces,
               const MjcfOptions& options,
               const std::string& meshes)
{
    const KinematicTree& tree = hand.robot.tree;
    require(grasp.positions.size() == tree.size(),
            "writeMjcf: candidate " + std::to_string(grasp.candidate) + " never closed (" +
                toString(grasp.reject) + "): choose another one");
    require(pieces.links.size() == tree.size() && !pieces.object.pieces.empty(),
            "writeMjcf: pieces of " + std::to_string(pieces.links.size()) + " links for " +
                std::to_string(tree.size()) + ", or none of the object: give those of this hand");
    require(squeeze.stiffness.size() == independentJoints(tree).size(),
            "writeMjcf: the squeeze is of another hand: give that of this one");
    for (const double positive :
         {options.mass, options.friction, options.timeStep, options.dampingTime})
    {
        require(std::isfinite(positive) && positive > 0.0,
                "writeMjcf: " + decimal(positive) +
                    " as mass, friction, time step or damping time: give positive numbers");
    }
    require(std::isfinite(options.torsion) && options.torsion >= 0.0,
            "writeMjcf: torsion " + decimal(options.torsion) + " m: give 0 or more");
    out << GraspWriter(hand, object, grasp, squeeze, pieces, options).write(meshes);
}

void writeMjcfMeshes(const std::filesystem::path& folder, const MjcfPieces& pieces)
{
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
    {
        throw std::runtime_error(folder.string() + ": " + error.message() +
                                 ": give a folder that can be made");
    }
    for (std::size_t i = 0; i < pieces.links.size(); ++i)
    {
        writePieces(folder, bodyOf(i), pieces.links[i]);
    }
    writePieces(folder, "object", pieces.object);
}
}  // namespace bullet_ccd::grasp
