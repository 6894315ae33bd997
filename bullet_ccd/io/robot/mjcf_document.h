/// MJCF as a file says it: includes expanded, compiler settings, default classes.
#pragma once

#include <Eigen/Geometry>

#include <cstddef>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tinyxml2.h>
#include <utility>
#include <vector>

namespace bullet_ccd
{
class MjcfDocument;

/// No limit of the numbers that an attribute holds.
constexpr std::size_t kManyNumbers = std::numeric_limits<std::size_t>::max();

/// The shortest rotation that turns +z to the unit vector; half a turn about x if that is -z.
[[nodiscard]] Eigen::Matrix3d rotationToZ(const Eigen::Vector3d& z);

/// True for the elements of <actuator> that MJCF has.
[[nodiscard]] bool isMjcfActuator(std::string_view tag);

/// An element together with the class from which it takes what it does not say.
class MjcfElement
{
public:
    MjcfElement(MjcfDocument& document,
                const tinyxml2::XMLElement& xml,
                const std::string& childClass);

    [[nodiscard]] std::string_view tag() const { return m_xml->Name(); }
    /// The attribute "name", which no class gives; empty if there is none.
    [[nodiscard]] std::string name() const;
    /// The attribute of the element itself, else that of its class or the classes above it.
    [[nodiscard]] std::optional<std::string> text(const char* attribute) const;
    [[nodiscard]] std::optional<double> number(const char* attribute) const;
    /// Throws std::runtime_error unless there are `least` numbers, or up to `most`, all finite.
    [[nodiscard]] std::optional<std::vector<double>> numbers(const char* attribute,
                                                             std::size_t least,
                                                             std::size_t most = 0) const;
    [[nodiscard]] std::optional<Eigen::Vector3d> vector(const char* attribute) const;
    /// Position and orientation, whichever way it is given.
    [[nodiscard]] Eigen::Isometry3d pose() const;
    /// The orientation alone.
    [[nodiscard]] Eigen::Matrix3d orientation() const;
    /// What the attribute says: "true", "false", or "auto", which is the default and means true if
    /// the range has a width. Throws std::runtime_error for a range that is turned round.
    [[nodiscard]] bool isLimited(const char* attribute, const char* range) const;

    [[noreturn]] void fail(const std::string& what, const std::string& remedy) const;
    /// "<file>:<line>: joint 'name'".
    [[nodiscard]] std::string where() const;
    [[nodiscard]] const tinyxml2::XMLElement& xml() const { return *m_xml; }

private:
    [[nodiscard]] std::optional<std::vector<double>> parsed(const char* attribute,
                                                            const std::string& value,
                                                            std::size_t least,
                                                            std::size_t most) const;

    MjcfDocument* m_document;
    const tinyxml2::XMLElement* m_xml;
    std::string m_class;
};

/// A parsed file. Elements refer into it.
class MjcfDocument
{
public:
    /// Throws std::runtime_error: "<file>: <what>: <remedy>".
    explicit MjcfDocument(std::filesystem::path path);

    [[nodiscard]] const std::filesystem::path& path() const { return m_path; }
    /// Of the element <mujoco>; "robot" if it has none.
    [[nodiscard]] std::string modelName() const;
    /// All children of <mujoco> of that name, in the order of the file.
    [[nodiscard]] std::vector<const tinyxml2::XMLElement*> sections(const char* name) const;
    /// The children of all sections of that name, in the order of the file.
    [[nodiscard]] std::vector<const tinyxml2::XMLElement*> entries(const char* section) const;

    /// Radians of an angle of this file.
    [[nodiscard]] double radians(double angle) const
    {
        return m_inDegrees ? angle * kDegree : angle;
    }
    /// True if limits follow from ranges where "limited" does not say.
    [[nodiscard]] bool autoLimits() const { return m_compiler.at("autolimits") == "true"; }
    /// A setting of <compiler>.
    [[nodiscard]] const std::string& compiler(const std::string& attribute) const
    {
        return m_compiler.at(attribute);
    }

    /// The value that a class gives an attribute of this element.
    [[nodiscard]] std::optional<std::string> defaultOf(const std::string& className,
                                                       std::string_view tag,
                                                       const char* attribute) const;
    [[nodiscard]] bool hasClass(const std::string& className) const
    {
        return m_classes.contains(className);
    }
    [[nodiscard]] std::vector<std::string> classNames() const;

    /// "<file>:<line>" of an element, also of one that an <include> brought in.
    [[nodiscard]] std::string placeOf(const tinyxml2::XMLElement& element) const;

    /// Names of all joints below <worldbody>, also of bodies that are left out.
    [[nodiscard]] std::vector<std::string> jointNames() const;
    /// True if joints can have names that no element states: replicates, composites and attached
    /// models make them.
    [[nodiscard]] bool makesNames() const;

    /// Names what is left out, once, and the line of the first of its kind.
    void leftOut(const tinyxml2::XMLElement& element, const std::string& what);
    [[nodiscard]] const std::vector<std::string>& leftOut() const { return m_leftOut; }
    /// Names an element that is none of the known ones of its section.
    void noteUnless(const tinyxml2::XMLElement& element,
                    const std::vector<std::string>& known,
                    const std::string& section);

private:
    static constexpr double kDegree = 3.14159265358979323846 / 180.0;

    struct DefaultClass
    {
        std::string parent;
        std::map<std::string, std::string> values;  ///< by "tag.attribute"
    };

    [[nodiscard]] const tinyxml2::XMLElement* root() const
    {
        return m_xml.FirstChildElement("mujoco");
    }
    void expandIncludes(tinyxml2::XMLElement& element, int depth);
    void noteUnknownElements();
    void readCompiler();
    void readDefaults(const tinyxml2::XMLElement& element, const std::string& parent, bool isTop);

    std::filesystem::path m_path;
    tinyxml2::XMLDocument m_xml;
    std::vector<std::string> m_included;
    std::map<std::string, std::string> m_compiler;
    bool m_inDegrees = true;
    std::map<std::string, DefaultClass> m_classes;
    std::vector<std::string> m_leftOut;
    std::set<std::string> m_leftOutBefore;  ///< without lines
    /// Where included elements come from.
    std::map<const tinyxml2::XMLElement*, std::pair<std::filesystem::path, int>> m_origins;
};
}  // namespace bullet_ccd
