#include "bullet_ccd/io/robot/mjcf_document.h"

#include "bullet_ccd/io/nearest_name.h"
#include "bullet_ccd/io/number_text.h"
#include "bullet_ccd/io/robot/robot_parts.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

namespace bullet_ccd
{
namespace
{
using tinyxml2::XMLElement;

/// Attributes that are read, and those that say nothing about links, joints, geometry or efforts.
/// All others are named as left out.
const std::map<std::string_view, std::set<std::string_view>>& knownAttributes()
{
    static const std::set<std::string_view> kPose = {
        "pos", "quat", "axisangle", "euler", "xyaxes", "zaxis"};
    static const auto withPose = [](std::set<std::string_view> names)
    {
        names.insert(kPose.begin(), kPose.end());
        return names;
    };
    static const std::set<std::string_view> kActuator = {
        "name",        "class",        "group",       "nsample",      "interp",     "delay",
        "ctrllimited", "forcelimited", "actlimited",  "ctrlrange",    "forcerange", "actrange",
        "lengthrange", "gear",         "cranklength", "joint",        "tendon",     "jointinparent",
        "cranksite",   "slidersite",   "site",        "refsite",      "user",       "kp",
        "kv",          "dampratio",    "timeconst",   "inheritrange", "biastype",   "biasprm",
        "gaintype",    "gainprm",      "dyntype",     "dynprm",       "actdim",     "actearly",
        "range",       "force",        "scale",       "lmin",         "lmax",       "vmax",
        "fpmax",       "fvmax",        "diameter",    "area",         "bias",       "gain",
        "body"};
    static const std::map<std::string_view, std::set<std::string_view>> kKnown = {
        {"body", withPose({"name", "childclass", "mocap", "gravcomp", "sleep", "user"})},
        {"frame", withPose({"name", "childclass"})},
        {"inertial", withPose({"mass", "diaginertia", "fullinertia"})},
        {"joint",
         {"name",
          "class",
          "type",
          "group",
          "pos",
          "axis",
          "limited",
          "range",
          "ref",
          "actuatorfrcrange",
          "actuatorfrclimited",
          "actuatorgravcomp",
          "springdamper",
          "solreflimit",
          "solimplimit",
          "solreffriction",
          "solimpfriction",
          "stiffness",
          "springref",
          "armature",
          "damping",
          "frictionloss",
          "margin",
          "user"}},
        {"freejoint", {"name", "group", "align"}},
        {"equality/joint",
         {"name", "class", "active", "joint1", "joint2", "polycoef", "solref", "solimp"}},
        {"geom", withPose({"name",     "class",  "type",     "contype",      "conaffinity",
                           "condim",   "group",  "priority", "size",         "material",
                           "friction", "mass",   "density",  "shellinertia", "solmix",
                           "solref",   "solimp", "margin",   "gap",          "fromto",
                           "mesh",     "hfield", "rgba",     "fitscale",     "user"})},
        {"mesh",
         {"name",
          "class",
          "file",
          "scale",
          "refpos",
          "refquat",
          "smoothnormal",
          "maxhullvert",
          "vertex",
          "face",
          "normal",
          "texcoord",
          "inertia",
          "content_type",
          "material"}},
        {"fixed",
         {"name",
          "class",
          "group",
          "limited",
          "range",
          "actuatorfrcrange",
          "actuatorfrclimited",
          "solreflimit",
          "solimplimit",
          "solreffriction",
          "solimpfriction",
          "frictionloss",
          "springlength",
          "stiffness",
          "damping",
          "armature",
          "margin",
          "user"}},
        {"fixed/joint", {"joint", "coef"}},
        {"general", kActuator},
        {"motor", kActuator},
        {"position", kActuator},
        {"velocity", kActuator},
        {"intvelocity", kActuator},
        {"damper", kActuator},
        {"cylinder", kActuator},
        {"muscle", kActuator},
        {"adhesion", kActuator},
    };
    return kKnown;
}

const std::vector<std::string>& actuatorTags()
{
    static const std::vector<std::string> kTags = {"general",
                                                   "motor",
                                                   "position",
                                                   "velocity",
                                                   "damper",
                                                   "intvelocity",
                                                   "cylinder",
                                                   "muscle",
                                                   "adhesion",
                                                   "plugin"};
    return kTags;
}

/// Actuators of all kinds share their defaults.
std::string defaultKey(std::string_view tag, const char* attribute)
{
    return std::string(isMjcfActuator(tag) ? "general" : tag) + "." + attribute;
}

void noteUnknown(MjcfDocument& document, const XMLElement& element)
{
    const XMLElement* const parent = element.Parent()->ToElement();
    const std::string_view above = parent == nullptr ? "" : parent->Name();
    const auto known = knownAttributes().find(
        (above == "equality" || above == "fixed" ? std::string(above) + "/" : "") + element.Name());
    if (known == knownAttributes().end())
    {
        return;
    }
    for (const tinyxml2::XMLAttribute* a = element.FirstAttribute(); a != nullptr; a = a->Next())
    {
        if (!known->second.contains(a->Name()))
        {
            const std::vector<std::string> names(known->second.begin(), known->second.end());
            document.leftOut(element,
                             std::string("attribute ") + a->Name() + " of <" + element.Name() +
                                 "> (" + quoted(std::string_view(a->Value())) + "; did you mean " +
                                 nearestName(a->Name(), names) + "?)");
        }
    }
}

void loadXml(tinyxml2::XMLDocument& document, const std::filesystem::path& path)
{
    const std::string content = readText(path);
    requireShallowXml(content, path.string());
    if (document.Parse(content.c_str(), content.size()) != tinyxml2::XML_SUCCESS)
    {
        throw std::runtime_error(path.string() + ": not XML: " + document.ErrorStr() +
                                 ": correct the file");
    }
}

std::vector<std::string_view> wordsOf(std::string_view text)
{
    std::vector<std::string_view> words;
    constexpr std::string_view kSpace = " \t\r\n";
    while (true)
    {
        const std::size_t begin = text.find_first_not_of(kSpace);
        if (begin == std::string_view::npos)
        {
            return words;
        }
        text.remove_prefix(begin);
        words.push_back(text.substr(0, text.find_first_of(kSpace)));
        text.remove_prefix(words.back().size());
    }
}

/// What an element says where its class says something as well: the numbers of a geom's size
/// replace the first ones of the class only, as in MuJoCo.
std::string over(const std::optional<std::string>& inherited,
                 const std::string& key,
                 const char* own)
{
    std::string value = own;
    if (key == "geom.size" && inherited)
    {
        const std::vector<std::string_view> words = wordsOf(*inherited);
        for (std::size_t k = wordsOf(own).size(); k < words.size(); ++k)
        {
            value.append(" ").append(words[k]);
        }
    }
    return value;
}

template <typename Visit>
void forAll(const XMLElement& element, const Visit& visit)
{
    visit(element);
    for (const XMLElement* e = element.FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement())
    {
        forAll(*e, visit);
    }
}

/// All elements of a copy, each with the one that it is a copy of.
template <typename Visit>
void forCopies(const XMLElement& copy, const XMLElement& source, const Visit& visit)
{
    visit(copy, source);
    const XMLElement* from = source.FirstChildElement();
    for (const XMLElement* e = copy.FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement(), from = from->NextSiblingElement())
    {
        forCopies(*e, *from, visit);
    }
}

Eigen::Matrix3d about(const Eigen::Vector3d& axis, double angle)
{
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}
}  // namespace

bool isMjcfActuator(std::string_view tag)
{
    return std::ranges::find(actuatorTags(), tag) != actuatorTags().end();
}

MjcfElement::MjcfElement(MjcfDocument& document,
                         const XMLElement& xml,
                         const std::string& childClass)
    : m_document(&document), m_xml(&xml), m_class(childClass)
{
    if (const char* const own = xml.Attribute("class"))
    {
        m_class = own;
    }
    if (!document.hasClass(m_class))
    {
        const std::string nearest = nearestName(m_class, document.classNames());
        fail("class '" + m_class + "' does not exist", "did you mean '" + nearest + "'?");
    }
    noteUnknown(document, xml);
}

std::string MjcfElement::name() const
{
    const char* const value = m_xml->Attribute("name");
    return value == nullptr ? "" : value;
}

std::optional<std::string> MjcfElement::text(const char* attribute) const
{
    const std::optional<std::string> inherited = m_document->defaultOf(m_class, tag(), attribute);
    const char* const own = m_xml->Attribute(attribute);
    return own == nullptr ? inherited : over(inherited, defaultKey(tag(), attribute), own);
}

std::optional<std::vector<double>> MjcfElement::parsed(const char* attribute,
                                                       const std::string& value,
                                                       std::size_t least,
                                                       std::size_t most) const
{
    std::vector<double> result;
    for (const std::string_view word : wordsOf(value))
    {
        const std::optional<double> number = parseNumber<double>(word);
        if (!number || !std::isfinite(*number))
        {
            fail(std::string(attribute) + " holds " + quoted(word), "give finite numbers");
        }
        result.push_back(*number);
    }
    if (result.size() < least || result.size() > most)
    {
        fail(std::string(attribute) + " holds " + std::to_string(result.size()) + " numbers",
             "give " + std::to_string(least) +
                 (most == least          ? ""
                  : most == kManyNumbers ? " or more"
                                         : " to " + std::to_string(most)));
    }
    return result;
}

std::optional<std::vector<double>> MjcfElement::numbers(const char* attribute,
                                                        std::size_t least,
                                                        std::size_t most) const
{
    const std::optional<std::string> value = text(attribute);
    return value ? parsed(attribute, *value, least, std::max(least, most)) : std::nullopt;
}

std::optional<double> MjcfElement::number(const char* attribute) const
{
    const auto values = numbers(attribute, 1);
    return values ? std::optional(values->front()) : std::nullopt;
}

std::optional<Eigen::Vector3d> MjcfElement::vector(const char* attribute) const
{
    const auto values = numbers(attribute, 3);
    return values ? std::optional(Eigen::Vector3d((*values)[0], (*values)[1], (*values)[2]))
                  : std::nullopt;
}

Eigen::Matrix3d MjcfElement::orientation() const
{
    // What the element itself says comes before what its class says in another way.
    const auto says = [&](const char* attribute, bool own)
    { return own ? m_xml->Attribute(attribute) != nullptr : text(attribute).has_value(); };
    const auto direction = [&](const char* attribute, const Eigen::Vector3d& v)
    {
        if (!(v.norm() > 1e-9))
        {
            fail(std::string(attribute) + " has no direction", "give a vector other than 0");
        }
        return Eigen::Vector3d(v.normalized());
    };
    for (const bool own : {true, false})
    {
        if (says("axisangle", own))
        {
            const std::vector<double> v = *numbers("axisangle", 4);
            return about(direction("axisangle", {v[0], v[1], v[2]}), m_document->radians(v[3]));
        }
        if (says("xyaxes", own))
        {
            const std::vector<double> v = *numbers("xyaxes", 6);
            const Eigen::Vector3d x = direction("xyaxes", {v[0], v[1], v[2]});
            const Eigen::Vector3d second(v[3], v[4], v[5]);
            const Eigen::Vector3d y = direction("xyaxes", second - x * x.dot(second));
            Eigen::Matrix3d R;
            R << x, y, x.cross(y);
            return R;
        }
        if (says("zaxis", own))
        {
            const Eigen::Vector3d z = direction("zaxis", *vector("zaxis"));
            return rotationToZ(z);
        }
        if (says("euler", own))
        {
            const Eigen::Vector3d angles = *vector("euler");
            const std::string& sequence = m_document->compiler("eulerseq");
            Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
            for (int k = 0; k < 3; ++k)
            {
                const char letter = sequence[static_cast<std::size_t>(k)];
                const int axis = (letter | 0x20) - 'x';
                const Eigen::Matrix3d turn =
                    about(Eigen::Vector3d::Unit(axis), m_document->radians(angles[k]));
                // Small letters turn with the frame, capitals stay with the parent.
                R = letter >= 'x' ? Eigen::Matrix3d(R * turn) : Eigen::Matrix3d(turn * R);
            }
            return R;
        }
        if (says("quat", own))
        {
            const std::vector<double> v = *numbers("quat", 4);
            const Eigen::Quaterniond q(v[0], v[1], v[2], v[3]);
            if (!(q.norm() > 1e-9))
            {
                fail("quat is 0", "give w x y z of a rotation");
            }
            return q.normalized().toRotationMatrix();
        }
    }
    return Eigen::Matrix3d::Identity();
}

Eigen::Isometry3d MjcfElement::pose() const
{
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = orientation();
    X.translation() = vector("pos").value_or(Eigen::Vector3d::Zero());
    return X;
}

bool MjcfElement::isLimited(const char* attribute, const char* range) const
{
    const std::string value = text(attribute).value_or("auto");
    if (value != "true" && value != "false" && value != "auto")
    {
        fail(std::string(attribute) + " is " + quoted(std::string_view(value)),
             "use true, false or auto");
    }
    const auto limits = numbers(range, 2);
    if (limits && (*limits)[0] > (*limits)[1] && value != "false")
    {
        fail(std::string(range) + " is " + quoted(std::string_view(*text(range))) +
                 ", and its first number is above its second",
             "give the lower limit first");
    }
    if (value != "auto" || !m_document->autoLimits())
    {
        return value == "true";
    }
    return limits && (*limits)[0] < (*limits)[1];
}

std::string MjcfElement::where() const
{
    const std::string own = name();
    const char* const className = m_xml->Attribute("class");
    return m_document->placeOf(*m_xml) + ": " + std::string(tag()) +
           (!own.empty()           ? " '" + own + "'"
            : className != nullptr ? " of class '" + std::string(className) + "'"
                                   : "");
}

void MjcfElement::fail(const std::string& what, const std::string& remedy) const
{
    throw std::runtime_error(where() + ": " + what + ": " + remedy);
}

Eigen::Matrix3d rotationToZ(const Eigen::Vector3d& z)
{
    // The shortest turn; about x if z points down.
    const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ().cross(z);
    const double sine = axis.norm();
    return sine > 1e-10 ? about(axis / sine, std::atan2(sine, z.z()))
                        : about(Eigen::Vector3d::UnitX(), z.z() > 0.0 ? 0.0 : std::acos(-1.0));
}

MjcfDocument::MjcfDocument(std::filesystem::path path) : m_path(std::move(path))
{
    loadXml(m_xml, m_path);
    if (root() == nullptr)
    {
        throw std::runtime_error(m_path.string() + ": no <mujoco> element: is this MJCF?");
    }
    m_included.push_back(std::filesystem::absolute(m_path).lexically_normal().string());
    expandIncludes(*m_xml.FirstChildElement("mujoco"), 1);
    noteUnknownElements();
    readCompiler();
    m_classes["main"];
    for (const XMLElement* e = root()->FirstChildElement("default"); e != nullptr;
         e = e->NextSiblingElement("default"))
    {
        readDefaults(*e, "main", true);
    }
}

void MjcfDocument::expandIncludes(XMLElement& element, int depth)
{
    requireDepth(depth, m_path.string());
    XMLElement* child = element.FirstChildElement();
    while (child != nullptr)
    {
        XMLElement* const next = child->NextSiblingElement();
        if (std::string_view(child->Name()) != "include")
        {
            expandIncludes(*child, depth + 1);
            child = next;
            continue;
        }
        const char* const name = child->Attribute("file");
        if (name == nullptr)
        {
            throw std::runtime_error(m_path.string() + ": include: no file: name one");
        }
        const std::filesystem::path file = m_path.parent_path() / name;
        const std::string key = std::filesystem::absolute(file).lexically_normal().string();
        if (std::ranges::find(m_included, key) != m_included.end())
        {
            throw std::runtime_error(m_path.string() + ": include '" + name +
                                     "': the file is included already: include it once");
        }
        m_included.push_back(key);
        tinyxml2::XMLDocument included;
        loadXml(included, file);
        const XMLElement* const root = included.RootElement();
        tinyxml2::XMLNode* after = child;
        XMLElement* first = nullptr;
        for (const XMLElement* e = root == nullptr ? nullptr : root->FirstChildElement();
             e != nullptr;
             e = e->NextSiblingElement())
        {
            after = element.InsertAfterChild(after, e->DeepClone(&m_xml));
            first = first == nullptr ? after->ToElement() : first;
            forCopies(*after->ToElement(),
                      *e,
                      [&](const XMLElement& copy, const XMLElement& source) {
                          m_origins[&copy] = {file, source.GetLineNum()};
                      });
        }
        element.DeleteChild(child);
        // What was put in may include in turn.
        child = first == nullptr ? next : first;
    }
}

void MjcfDocument::readCompiler()
{
    m_compiler = {{"angle", "degree"},
                  {"eulerseq", "xyz"},
                  {"autolimits", "true"},
                  {"meshdir", ""},
                  {"assetdir", ""},
                  {"strippath", "false"},
                  {"inertiafromgeom", "auto"},
                  {"coordinate", "local"},
                  {"settotalmass", "-1"}};
    static const std::set<std::string_view> kWithoutMeaning = {"texturedir",
                                                               "discardvisual",
                                                               "usethread",
                                                               "fusestatic",
                                                               "boundmass",
                                                               "boundinertia",
                                                               "balanceinertia",
                                                               "fitaabb",
                                                               "alignfree",
                                                               "saveinertial",
                                                               "convexhull"};
    for (const XMLElement* e = root()->FirstChildElement("compiler"); e != nullptr;
         e = e->NextSiblingElement("compiler"))
    {
        for (const tinyxml2::XMLAttribute* a = e->FirstAttribute(); a != nullptr; a = a->Next())
        {
            if (m_compiler.contains(a->Name()))
            {
                m_compiler[a->Name()] = a->Value();
            }
            else if (!kWithoutMeaning.contains(a->Name()))
            {
                leftOut(*e, std::string("attribute ") + a->Name() + " of <compiler>");
            }
        }
    }
    const auto require = [&](const std::string& attribute, bool isGood, const std::string& remedy)
    {
        if (!isGood)
        {
            throw std::runtime_error(m_path.string() + ": compiler: " + attribute + " is " +
                                     quoted(std::string_view(m_compiler[attribute])) + ": " +
                                     remedy);
        }
    };
    const std::string& angle = m_compiler["angle"];
    require("angle", angle == "degree" || angle == "radian", "use degree or radian");
    m_inDegrees = angle == "degree";
    const std::string& sequence = m_compiler["eulerseq"];
    require("eulerseq",
            sequence.size() == 3 && sequence.find_first_not_of("xyzXYZ") == std::string::npos,
            "use three of the letters xyzXYZ");
    require("coordinate", m_compiler["coordinate"] == "local", "use local coordinates");
    if (m_compiler["settotalmass"] != "-1")
    {
        leftOut(*root()->FirstChildElement("compiler"), "settotalmass of <compiler>");
    }
}

void MjcfDocument::readDefaults(const XMLElement& element, const std::string& parent, bool isTop)
{
    const char* const named = element.Attribute("class");
    if (named == nullptr && !isTop)
    {
        throw std::runtime_error(m_path.string() +
                                 ": default: no class: name it, only the outermost may have none");
    }
    const std::string name = named == nullptr ? "main" : named;
    // The outermost one has every element that names no class, whatever it is called itself.
    if (isTop && name != "main")
    {
        m_classes[name].parent = "main";
    }
    if (!isTop && m_classes.contains(name))
    {
        throw std::runtime_error(m_path.string() + ": default: class '" + name +
                                 "' is there twice: give each class its own name");
    }
    DefaultClass& own = m_classes[isTop ? "main" : name];
    own.parent = isTop ? "" : parent;
    for (const XMLElement* e = element.FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement())
    {
        if (std::string_view(e->Name()) == "default")
        {
            readDefaults(*e, isTop ? "main" : name, false);
            continue;
        }
        static const std::vector<std::string> kHaveDefaults = {
            "mesh",   "material", "joint",  "geom",        "site",     "camera",   "light",
            "pair",   "equality", "tendon", "general",     "motor",    "position", "velocity",
            "damper", "cylinder", "muscle", "intvelocity", "adhesion", "plugin"};
        noteUnless(*e, kHaveDefaults, "default");
        noteUnknown(*this, *e);
        for (const tinyxml2::XMLAttribute* a = e->FirstAttribute(); a != nullptr; a = a->Next())
        {
            const std::string key = defaultKey(e->Name(), a->Name());
            own.values[key] =
                over(defaultOf(isTop ? "main" : name, e->Name(), a->Name()), key, a->Value());
        }
    }
}

std::string MjcfDocument::modelName() const
{
    const char* const name = root()->Attribute("model");
    return name == nullptr ? "robot" : name;
}

std::vector<const XMLElement*> MjcfDocument::sections(const char* name) const
{
    std::vector<const XMLElement*> found;
    for (const XMLElement* s = root()->FirstChildElement(name); s != nullptr;
         s = s->NextSiblingElement(name))
    {
        found.push_back(s);
    }
    return found;
}

std::vector<const XMLElement*> MjcfDocument::entries(const char* section) const
{
    std::vector<const XMLElement*> found;
    for (const XMLElement* s : sections(section))
    {
        for (const XMLElement* e = s->FirstChildElement(); e != nullptr;
             e = e->NextSiblingElement())
        {
            found.push_back(e);
        }
    }
    return found;
}

std::optional<std::string> MjcfDocument::defaultOf(const std::string& className,
                                                   std::string_view tag,
                                                   const char* attribute) const
{
    const std::string key = defaultKey(tag, attribute);
    for (std::string name = className; !name.empty();)
    {
        const DefaultClass& own = m_classes.at(name);
        const auto found = own.values.find(key);
        if (found != own.values.end())
        {
            return found->second;
        }
        name = own.parent;
    }
    return std::nullopt;
}

std::vector<std::string> MjcfDocument::classNames() const
{
    std::vector<std::string> names;
    for (const auto& [name, unused] : m_classes)
    {
        names.push_back(name);
    }
    return names;
}

std::string MjcfDocument::placeOf(const XMLElement& element) const
{
    const auto found = m_origins.find(&element);
    return found == m_origins.end()
               ? m_path.string() + ":" + std::to_string(element.GetLineNum())
               : found->second.first.string() + ":" + std::to_string(found->second.second);
}

std::vector<std::string> MjcfDocument::jointNames() const
{
    std::vector<std::string> names;
    for (const XMLElement* section : sections("worldbody"))
    {
        forAll(*section,
               [&](const XMLElement& e)
               {
                   const std::string_view tag = e.Name();
                   const char* const name = e.Attribute("name");
                   if (name != nullptr && (tag == "joint" || tag == "freejoint"))
                   {
                       names.emplace_back(name);
                   }
               });
    }
    return names;
}

bool MjcfDocument::makesNames() const
{
    static const std::set<std::string_view> kMakers = {
        "replicate", "attach", "composite", "flexcomp"};
    bool makes = false;
    for (const XMLElement* section : sections("worldbody"))
    {
        forAll(*section, [&](const XMLElement& e) { makes = makes || kMakers.contains(e.Name()); });
    }
    return makes;
}

void MjcfDocument::leftOut(const XMLElement& element, const std::string& what)
{
    if (m_leftOutBefore.insert(what).second)
    {
        const auto origin = m_origins.find(&element);
        m_leftOut.push_back((origin == m_origins.end()
                                 ? "line " + std::to_string(element.GetLineNum())
                                 : origin->second.first.filename().string() + " line " +
                                       std::to_string(origin->second.second)) +
                            ": " + what);
    }
}

void MjcfDocument::noteUnless(const XMLElement& element,
                              const std::vector<std::string>& known,
                              const std::string& section)
{
    if (std::ranges::find(known, element.Name()) == known.end())
    {
        leftOut(element,
                std::string("unknown element <") + element.Name() + "> of <" + section +
                    "> (did you mean <" + nearestName(element.Name(), known) + ">?)");
    }
}

void MjcfDocument::noteUnknownElements()
{
    static const std::vector<std::string> kSections = {"compiler",
                                                       "option",
                                                       "size",
                                                       "visual",
                                                       "statistic",
                                                       "default",
                                                       "custom",
                                                       "asset",
                                                       "contact",
                                                       "equality",
                                                       "worldbody",
                                                       "tendon",
                                                       "deformable",
                                                       "actuator",
                                                       "sensor",
                                                       "keyframe",
                                                       "extension"};
    static const std::vector<std::string> kAssets = {
        "mesh", "texture", "material", "hfield", "skin", "model"};
    for (const XMLElement* e = root()->FirstChildElement(); e != nullptr;
         e = e->NextSiblingElement())
    {
        noteUnless(*e, kSections, "mujoco");
    }
    for (const XMLElement* e : entries("asset"))
    {
        noteUnless(*e, kAssets, "asset");
    }
    for (const XMLElement* e : entries("actuator"))
    {
        noteUnless(*e, actuatorTags(), "actuator");
    }
}
}  // namespace bullet_ccd
