#include "bullet_ccd/io/nearest_name.h"
#include "grasp/trial/protocol.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <yaml-cpp/yaml.h>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kLeast = 1e-6;                       // of what must be above 0
constexpr double kRadian = std::numbers::pi / 180.0;  // of a degree

/// A map of the file; every error names the line and the key.
class KeyedMap
{
public:
    KeyedMap(const std::filesystem::path& file,
             const std::string& name,
             const YAML::Node& node,
             const std::vector<std::string>& keys)
        : m_file(file), m_name(name), m_node(node)
    {
        if (!node.IsMap())
        {
            fail(node, name, shown(node) + "not a map: write KEY: VALUE, one a line");
        }
        std::vector<std::string> seen;
        for (const auto& entry : node)
        {
            const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
            if (std::find(keys.begin(), keys.end(), key) == keys.end())
            {
                fail(entry.first, key, "no such key: did you mean " + nearestName(key, keys) + "?");
            }
            if (std::find(seen.begin(), seen.end(), key) != seen.end())
            {
                fail(entry.first, key, "there twice: drop one");
            }
            seen.push_back(key);
        }
    }

    [[nodiscard]] bool has(const std::string& key) const { return bool(m_node[key]); }

    [[nodiscard]] YAML::Node at(const std::string& key) const
    {
        const YAML::Node node = m_node[key];
        if (!node)
        {
            fail(m_node, m_name, "the key \"" + key + "\" is missing: add it");
        }
        return node;
    }

    [[nodiscard]] double number(const std::string& key,
                                double otherwise,
                                double least = -1e6,
                                double most = 1e6) const
    {
        return has(key) ? number(m_node[key], key, least, most) : otherwise;
    }

    /// A whole number from `least` on.
    [[nodiscard]] std::uint64_t whole(const std::string& key,
                                      std::uint64_t otherwise,
                                      std::uint64_t least,
                                      std::uint64_t most) const
    {
        if (!has(key))
        {
            return otherwise;
        }
        const YAML::Node node = m_node[key];
        std::uint64_t value = 0;
        if (!node.IsScalar() || node.Scalar().find('-') != std::string::npos ||
            !YAML::convert<std::uint64_t>::decode(node, value) || value < least || value > most)
        {
            fail(node,
                 key,
                 shown(node) + "write a whole number from " + std::to_string(least) + " to " +
                     std::to_string(most));
        }
        return value;
    }

    [[nodiscard]] std::string text(const std::string& key) const
    {
        const YAML::Node node = at(key);
        if (!node.IsScalar() || node.Scalar().empty())
        {
            fail(node, key, shown(node) + "not a word: write one");
        }
        return node.Scalar();
    }

    [[nodiscard]] Eigen::Vector3d vector(const std::string& key,
                                         const Eigen::Vector3d& otherwise) const
    {
        if (!has(key))
        {
            return otherwise;
        }
        const YAML::Node node = m_node[key];
        if (!node.IsSequence() || node.size() != 3)
        {
            fail(node, key, shown(node) + "not three numbers: write [X, Y, Z]");
        }
        constexpr double kMost = 1e6;
        return {number(node[0], key, -kMost, kMost),
                number(node[1], key, -kMost, kMost),
                number(node[2], key, -kMost, kMost)};
    }

    [[noreturn]] void fail(const YAML::Node& node,
                           const std::string& key,
                           const std::string& what) const
    {
        throw std::runtime_error(m_file.string() + ":" +
                                 std::to_string(std::max(node.Mark().line, 0) + 1) + ": " + key +
                                 ": " + what);
    }

private:
    /// What stands there, in one line.
    static std::string shown(const YAML::Node& node)
    {
        YAML::Emitter emitter;
        emitter.SetSeqFormat(YAML::Flow);
        emitter.SetMapFormat(YAML::Flow);
        emitter << node;
        const std::string text = node.IsNull() ? "nothing" : emitter.c_str();
        constexpr std::size_t kMost = 60;
        return text.substr(0, std::min(kMost, text.find('\n'))) + ": ";
    }

    [[nodiscard]] double number(const YAML::Node& node,
                                const std::string& key,
                                double least,
                                double most) const
    {
        double value = 0.0;
        if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) ||
            !std::isfinite(value))
        {
            fail(node, key, shown(node) + "not a number: write one");
        }
        if (!(value >= least && value <= most))
        {
            std::ostringstream range;
            range << "write a number from " << least << " to " << most;
            fail(node, key, shown(node) + range.str());
        }
        return value;
    }

    const std::filesystem::path& m_file;
    std::string m_name;
    YAML::Node m_node;
};

/// Files are called so, too.
std::string nameOf(const KeyedMap& map)
{
    constexpr const char* kAllowed =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
    const std::string name = map.text("name");
    if (name.find_first_not_of(kAllowed) != std::string::npos)
    {
        map.fail(map.at("name"), "name", "\"" + name + "\": write letters, digits, - and _ only");
    }
    return name;
}

TrialStart startOf(const KeyedMap& map)
{
    if (!map.has("start"))
    {
        return TrialStart::Held;
    }
    const std::string name = map.text("start");
    const std::vector<std::string> names{"held", "open", "table"};
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
    {
        map.fail(map.at("start"), "start", "\"" + name + "\": write held, open or table");
    }
    return static_cast<TrialStart>(found - names.begin());
}

/// Appends what one entry of the list of phases says.
void addPhases(const std::filesystem::path& file,
               const YAML::Node& node,
               std::vector<TrialPhase>& phases)
{
    const KeyedMap entry(file, "phases", node, {"load", "shake", "lift", "pull"});
    if (node.size() != 1)
    {
        entry.fail(node, "phases", "more than one kind in an entry: begin each with a dash");
    }
    const std::string kind = node.begin()->first.Scalar();
    const YAML::Node content = node.begin()->second;
    if (content.IsNull())  // stands where the next thing does
    {
        entry.fail(node, kind, "nothing: write {} for a phase as it is by default");
    }
    TrialPhase phase;
    if (kind == "load")
    {
        const KeyedMap map(file, kind, content, {"direction", "weights", "seconds"});
        phase.direction = map.vector("direction", phase.direction);
        phase.amount = map.number("weights", 1.0, 0.0, 1e4);
        phase.time = map.number("seconds", 1.0, kLeast, 600.0);
    }
    else if (kind == "shake")
    {
        const KeyedMap map(file, kind, content, {"direction", "mm", "hz", "seconds"});
        phase.kind = TrialPhase::Kind::Shake;
        (void)map.at("direction");
        phase.direction = map.vector("direction", phase.direction);
        phase.amount = 1e-3 * map.number("mm", 20.0, 0.0, 1e4);
        phase.frequency = map.number("hz", 2.0, kLeast, 20.0);
        phase.time = map.number("seconds", 2.0, kLeast, 600.0);
    }
    else if (kind == "lift")
    {
        const KeyedMap map(file, kind, content, {"mm", "seconds"});
        phase.kind = TrialPhase::Kind::Lift;
        phase.amount = 1e-3 * map.number("mm", 200.0, 0.0, 1e4);
        phase.time = map.number("seconds", 1.0, kLeast, 600.0);
    }
    else
    {
        const KeyedMap map(file, kind, content, {"force", "moment", "random", "seed"});
        if (map.has("random"))
        {
            const std::uint64_t count = map.whole("random", 1, 1, 10000);
            const std::uint64_t seed =
                map.whole("seed", 1, 0, std::numeric_limits<std::uint64_t>::max());
            if (map.has("force") || map.has("moment"))
            {
                map.fail(
                    map.at("random"), "random", "neither force nor moment go with it: drop it");
            }
            const std::vector<TrialPhase> pulls = randomPulls(static_cast<int>(count), seed);
            phases.insert(phases.end(), pulls.begin(), pulls.end());
            return;
        }
        phase.kind = TrialPhase::Kind::Pull;
        phase.wrench << map.vector("force", Eigen::Vector3d::Zero()),
            map.vector("moment", Eigen::Vector3d::Zero());
    }
    // What the values are worth is looked at here, where the line is known.
    try
    {
        checkProtocol({.name = file.stem().string(), .phases = {phase}});
    }
    catch (const std::invalid_argument& error)
    {
        const std::string what = error.what();
        entry.fail(node, kind, what.substr(what.find("): ") + 3));
    }
    phases.push_back(phase);
}
}  // namespace

TrialProtocol readProtocol(const std::filesystem::path& file)
{
    YAML::Node node;
    try
    {
        if (std::filesystem::is_directory(file))
        {
            throw YAML::BadFile(file.string());
        }
        node = YAML::LoadFile(file.string());
    }
    catch (const YAML::BadFile&)
    {
        std::string names;
        for (const std::string& name : shippedProtocols())
        {
            names += (names.empty() ? "" : ", ") + name;
        }
        throw std::runtime_error(
            file.string() +
            ": cannot be read: give a YAML file, or a protocol that ships: " + names);
    }
    catch (const YAML::Exception& error)
    {
        throw std::runtime_error(file.string() + ":" + std::to_string(error.mark.line + 1) +
                                 ": not YAML: " + error.msg + ": correct the line");
    }
    const KeyedMap map(
        file,
        "protocol",
        node,
        {"name", "start", "phases", "error_mm", "error_deg", "held_mm", "held_deg", "lost_mm"});
    TrialProtocol protocol;
    protocol.name = map.has("name") ? nameOf(map) : file.stem().string();
    protocol.start = startOf(map);
    protocol.shift = 1e-3 * map.number("error_mm", 0.0, 0.0, 1e3);
    protocol.turn = kRadian * map.number("error_deg", 0.0, 0.0, 180.0);
    protocol.heldWay = 1e-3 * map.number("held_mm", 1e3 * protocol.heldWay, kLeast);
    protocol.heldTurn = kRadian * map.number("held_deg", protocol.heldTurn / kRadian, kLeast);
    protocol.lostWay = 1e-3 * map.number("lost_mm", 1e3 * protocol.lostWay, kLeast);
    const YAML::Node phases = map.at("phases");
    if (!phases.IsSequence() || phases.size() == 0)
    {
        map.fail(phases, "phases", "no list: write one phase a line, each beginning with a dash");
    }
    for (const YAML::Node& phase : phases)
    {
        addPhases(file, phase, protocol.phases);
    }
    try
    {
        checkProtocol(protocol);
    }
    catch (const std::invalid_argument& error)
    {
        // Each key is right by itself: two of them contradict each other, or the start one.
        const std::vector<std::string> keys =
            protocol.lostWay < protocol.heldWay ? std::vector<std::string>{"held_mm", "lost_mm"}
                                                : std::vector<std::string>{"error_mm", "error_deg"};
        const std::string& key = map.has(keys[0]) ? keys[0] : keys[1];
        const std::string what = error.what();
        map.fail(map.at(key), key, map.text(key) + ": " + what.substr(what.find("\": ") + 3));
    }
    return protocol;
}
}  // namespace bullet_ccd::grasp
