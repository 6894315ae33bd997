#include "bullet_ccd/io/nearest_name.h"
#include "grasp/trial/protocol.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <yaml-cpp/yaml.h>

namespace bullet_ccd::grasp
{
namespace
{
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
            fail(node, name, "not a map: write KEY: VALUE, one a line");
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

    /// @param largest  what a value may be at most, in its size
    [[nodiscard]] double number(const std::string& key,
                                double otherwise,
                                double largest = 1e6) const
    {
        return has(key) ? number(m_node[key], key, largest) : otherwise;
    }

    [[nodiscard]] std::string text(const std::string& key) const
    {
        const YAML::Node node = at(key);
        if (!node.IsScalar() || node.Scalar().empty())
        {
            fail(node, key, "no value: write one");
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
            fail(node, key, "not three numbers: write [X, Y, Z]");
        }
        constexpr double kLargest = 1e6;
        return {number(node[0], key, kLargest),
                number(node[1], key, kLargest),
                number(node[2], key, kLargest)};
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
    [[nodiscard]] double number(const YAML::Node& node,
                                const std::string& key,
                                double largest) const
    {
        double value = 0.0;
        if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) ||
            !std::isfinite(value))
        {
            fail(node, key, "not a number: write one");
        }
        if (std::abs(value) > largest)
        {
            fail(node,
                 key,
                 node.Scalar() + ": write a number of at most " +
                     std::to_string(static_cast<std::int64_t>(largest)));
        }
        return value;
    }

    const std::filesystem::path& m_file;
    std::string m_name;
    YAML::Node m_node;
};

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
    TrialPhase phase;
    if (kind == "load")
    {
        const KeyedMap map(file, kind, content, {"direction", "weights", "seconds"});
        phase.direction = map.vector("direction", phase.direction);
        phase.amount = map.number("weights", 1.0, 1e4);
        phase.time = map.number("seconds", 1.0);
    }
    else if (kind == "shake")
    {
        const KeyedMap map(file, kind, content, {"direction", "mm", "hz", "seconds"});
        phase.kind = TrialPhase::Kind::Shake;
        (void)map.at("direction");
        phase.direction = map.vector("direction", phase.direction);
        phase.amount = 1e-3 * map.number("mm", 20.0, 1e4);
        phase.frequency = map.number("hz", 2.0, 20.0);
        phase.time = map.number("seconds", 2.0);
    }
    else if (kind == "lift")
    {
        const KeyedMap map(file, kind, content, {"mm", "seconds"});
        phase.kind = TrialPhase::Kind::Lift;
        phase.amount = 1e-3 * map.number("mm", 200.0, 1e4);
        phase.time = map.number("seconds", 1.0);
    }
    else
    {
        const KeyedMap map(file, kind, content, {"force", "moment", "random", "seed"});
        if (map.has("random"))
        {
            const double count = map.number("random", 0.0);
            const double seed = map.number("seed", 1.0);
            if (!(count >= 1.0 && count <= 1e4 && seed >= 0.0) || map.has("force") ||
                map.has("moment"))
            {
                map.fail(map.at("random"),
                         "random",
                         "give 1 to 10000 wrenches, a seed from 0, and neither force nor moment");
            }
            const std::vector<TrialPhase> pulls =
                randomPulls(static_cast<int>(count), static_cast<std::uint64_t>(seed));
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
    protocol.name = map.has("name") ? map.text("name") : file.stem().string();
    protocol.start = startOf(map);
    protocol.shift = 1e-3 * map.number("error_mm", 0.0, 1e3);
    protocol.turn = kRadian * map.number("error_deg", 0.0, 180.0);
    protocol.heldWay = 1e-3 * map.number("held_mm", 1e3 * protocol.heldWay);
    protocol.heldTurn = kRadian * map.number("held_deg", protocol.heldTurn / kRadian);
    protocol.lostWay = 1e-3 * map.number("lost_mm", 1e3 * protocol.lostWay);
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
        map.fail(node, protocol.name, error.what());
    }
    return protocol;
}
}  // namespace bullet_ccd::grasp
