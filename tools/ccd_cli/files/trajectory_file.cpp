#include "tools/ccd_cli/files/trajectory_file.h"

#include "tools/ccd_cli/files/joint_file.h"
#include "tools/support/yaml_file.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

bool isYaml(const fs::path& path)
{
    return path.extension() == ".yaml" || path.extension() == ".yml";
}

/// A message of the type trajectory_msgs/JointTrajectory.
class JointTrajectoryMessage
{
public:
    JointTrajectoryMessage(const fs::path& path, const KinematicTree& tree)
        : m_file(path), m_tree(tree)
    {
    }

    [[nodiscard]] std::vector<Waypoint> read()
    {
        YAML::Node message = m_file.load("give a trajectory in CSV or YAML");
        if (message.IsMap() && message["trajectory"].IsDefined())  // as MoveIt displays them
        {
            const YAML::Node list = listOf(message, "trajectory");
            if (list.size() != 1)
            {
                m_file.fail(list,
                            "trajectory: ",
                            fmt::format("{} trajectories: give each in a file", list.size()));
            }
            message = YAML::Node(list[0]);
        }
        if (message.IsMap() && message["joint_trajectory"].IsDefined())
        {
            message = message["joint_trajectory"];
        }
        if (!message.IsMap())
        {
            m_file.fail(message, "", "not a map: write joint_names: and points:");
        }
        m_file.checkKeys(message, {"header", "joint_names", "points"});
        readNames(listOf(message, "joint_names"));
        std::vector<Waypoint> waypoints;
        for (const YAML::Node& point : listOf(message, "points"))
        {
            waypoints.push_back(waypointOf(point));
            const std::size_t last = waypoints.size() - 1;
            if (last > 0 && waypoints[last].time <= waypoints[last - 1].time)
            {
                m_file.fail(point["time_from_start"],
                            "time_from_start: ",
                            fmt::format("{} s is not after the {} s of the point before: let times "
                                        "increase",
                                        waypoints[last].time,
                                        waypoints[last - 1].time));
            }
        }
        return waypoints;
    }

    [[nodiscard]] std::vector<std::string> takeNotes() { return std::move(m_notes); }

private:
    [[nodiscard]] YAML::Node listOf(const YAML::Node& map, const std::string& key) const
    {
        YAML::Node list = map[key];
        if (!list.IsDefined() || !list.IsSequence() || list.size() == 0)
        {
            m_file.fail(
                list.IsDefined() ? list : map, key + ": ", "no list: write one item or more");
        }
        return list;
    }

    void readNames(const YAML::Node& names)
    {
        for (const YAML::Node& node : names)
        {
            const std::string name = m_file.textOf(node, "joint_names");
            const std::int32_t link = m_tree.findJoint(name);
            if (link == kNone || !m_tree.links[static_cast<std::size_t>(link)].joint.isMovable())
            {
                m_file.fail(node,
                            "joint_names: ",
                            fmt::format("{}: {}: name joints that move, of: {}",
                                        name,
                                        link == kNone ? "the robot has no such joint"
                                                      : "this joint does not move",
                                        drivenNames(m_tree)));
            }
            if (std::ranges::find(m_links, link) != m_links.end())
            {
                m_file.fail(node, "joint_names: ", name + " is there twice: drop one");
            }
            m_links.push_back(link);
        }
        m_rest.assign(m_tree.size(), 0.0);
        std::string missing;
        for (std::size_t k = 0; k < m_tree.size(); ++k)
        {
            const Joint& joint = m_tree.links[k].joint;
            m_rest[k] = std::clamp(0.0, joint.lower, joint.upper);
            const bool isNamed =
                std::ranges::find(m_links, static_cast<std::int32_t>(k)) != m_links.end();
            if (joint.isMovable() && joint.mimicOf == kNone && !isNamed)
            {
                missing +=
                    fmt::format("{}{} at {}", missing.empty() ? "" : ", ", joint.name, m_rest[k]);
            }
        }
        if (!missing.empty())
        {
            m_notes.push_back(fmt::format(
                "{}: joints that are not named rest: {}", m_file.path().string(), missing));
        }
    }

    [[nodiscard]] Waypoint waypointOf(const YAML::Node& point)
    {
        if (!point.IsMap())
        {
            m_file.fail(
                point, "points: ", "an item is not a map: write positions and time_from_start");
        }
        m_file.checkKeys(point,
                         {"positions", "velocities", "accelerations", "effort", "time_from_start"});
        if (!point["positions"].IsDefined() || !point["time_from_start"].IsDefined())
        {
            m_file.fail(point, "points: ", "an item needs positions and time_from_start");
        }
        Waypoint waypoint{.time = secondsOf(point["time_from_start"]), .positions = m_rest};
        spread(point["positions"], "positions", waypoint.positions);
        checkLimits(point["positions"], waypoint.positions);
        // A list without entries says that there are none, as in messages.
        for (const auto& [key, values] : {std::pair{"velocities", &waypoint.velocities},
                                          std::pair{"accelerations", &waypoint.accelerations}})
        {
            const YAML::Node list = point[key];
            if (list.IsDefined() && !(list.IsSequence() && list.size() == 0))
            {
                values->assign(m_tree.size(), 0.0);
                spread(list, key, *values);
            }
        }
        return waypoint;
    }

    void spread(const YAML::Node& list, const std::string& key, std::vector<double>& values) const
    {
        const std::vector<double> numbers = m_file.numbersOf(list, key, m_links.size());
        for (std::size_t k = 0; k < m_links.size(); ++k)
        {
            values[static_cast<std::size_t>(m_links[k])] = numbers[k];
        }
    }

    /// Notes the first point of each joint.
    void checkLimits(const YAML::Node& list, const std::vector<double>& positions)
    {
        constexpr double kSlack = 1e-4;  // decimals of a file [rad] or [m]
        for (const std::int32_t link : m_links)
        {
            const auto k = static_cast<std::size_t>(link);
            const Joint& joint = m_tree.links[k].joint;
            const bool isOutside =
                positions[k] < joint.lower - kSlack || positions[k] > joint.upper + kSlack;
            if (isOutside && joint.mimicOf == kNone && m_outside.insert(link).second)
            {
                m_notes.push_back(
                    fmt::format("{}positions: {}: {} is outside its limits {} to {}: answered as "
                                "asked",
                                m_file.place(list),
                                joint.name,
                                positions[k],
                                joint.lower,
                                joint.upper));
            }
        }
    }

    [[nodiscard]] double secondsOf(const YAML::Node& node) const
    {
        if (!node.IsMap())
        {
            return m_file.numberOf(node, "time_from_start");
        }
        m_file.checkKeys(node, {"sec", "nanosec", "secs", "nsecs"});
        const auto part = [&](const char* key)
        { return node[key].IsDefined() ? m_file.numberOf(node[key], key) : 0.0; };
        return part("sec") + part("secs") + 1e-9 * (part("nanosec") + part("nsecs"));
    }

    YamlFile m_file;
    const KinematicTree& m_tree;
    std::vector<std::int32_t> m_links;  // below the joints that are named, in their order
    std::vector<double> m_rest;
    std::set<std::int32_t> m_outside;
    std::vector<std::string> m_notes;
};

std::vector<Waypoint> waypointsOf(const JointFile& file)
{
    std::vector<Waypoint> waypoints;
    for (const Configuration& row : file.rows)
    {
        waypoints.push_back({.time = row.time, .positions = row.positions});
    }
    return waypoints;
}
}  // namespace

TrajectoryFile readTrajectoryFile(const fs::path& path,
                                  const KinematicTree& tree,
                                  const Eigen::Isometry3d& X_WR)
{
    TrajectoryFile file;
    std::vector<Waypoint> waypoints;
    if (isYaml(path))
    {
        JointTrajectoryMessage message(path, tree);
        waypoints = message.read();
        file.notes = message.takeNotes();
    }
    else if (path.extension() == ".csv")
    {
        JointFile joints = readJointFile(path, tree, TimeColumn::Increasing);
        if (joints.rows[0].base)
        {
            throw std::runtime_error(path.string() +
                                     ": has columns of the base, which rests on a trajectory: "
                                     "remove them and give --base");
        }
        waypoints = waypointsOf(joints);
        file.notes = std::move(joints.notes);
    }
    else
    {
        throw std::runtime_error(path.string() +
                                 ": not a kind of trajectory: give a file that ends in .csv, .yaml "
                                 "or .yml");
    }
    if (waypoints.size() < 2)
    {
        throw std::runtime_error(path.string() + ": one waypoint: a trajectory has two or more");
    }
    file.trajectory = trajectoryThrough(tree, X_WR, waypoints);
    return file;
}

std::vector<fs::path> trajectoryFilesOf(const std::vector<std::string>& paths)
{
    std::vector<fs::path> files;
    for (const std::string& path : paths)
    {
        if (!fs::is_directory(path))
        {
            files.emplace_back(path);
            continue;
        }
        std::vector<fs::path> found;
        for (const fs::directory_entry& entry : fs::directory_iterator(path))
        {
            if (entry.is_regular_file() &&
                (isYaml(entry.path()) || entry.path().extension() == ".csv"))
            {
                found.push_back(entry.path());
            }
        }
        if (found.empty())
        {
            throw std::runtime_error(path +
                                     ": no trajectories in this folder: give files that end in "
                                     ".csv, .yaml or .yml");
        }
        std::ranges::sort(found);
        files.insert(files.end(), found.begin(), found.end());
    }
    return files;
}
}  // namespace bullet_ccd::tools
