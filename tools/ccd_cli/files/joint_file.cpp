#include "tools/ccd_cli/files/joint_file.h"

#include "tools/support/csv_table.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace bullet_ccd::tools
{
namespace
{
/// Beyond a limit by more than what decimals of a file account for [rad] or [m].
constexpr double kLimitSlack = 1e-4;

/// A column and the link below its joint.
struct JointColumn
{
    std::size_t column = 0;
    std::int32_t link = kNone;
};

bool isDriven(const Link& link)
{
    return link.joint.isMovable() && link.joint.mimicOf == kNone && link.parent != kNone;
}

std::vector<JointColumn> jointColumns(const CsvTable& table, const KinematicTree& tree)
{
    std::vector<JointColumn> columns;
    for (std::size_t k = 0; k < table.names.size(); ++k)
    {
        const std::string& name = table.names[k];
        if (name == "id" || name == "time" || isPoseColumn(name, "base_"))
        {
            continue;
        }
        const std::int32_t link = tree.findJoint(name);
        if (link == kNone || !tree.links[static_cast<std::size_t>(link)].joint.isMovable())
        {
            table.failNames(fmt::format(
                "{}: {}: name joints that move, of: {}",
                name,
                link == kNone ? "the robot has no such joint" : "this joint does not move",
                drivenNames(tree)));
        }
        columns.push_back({.column = k, .link = link});
    }
    return columns;
}

class JointFileReader
{
public:
    JointFileReader(CsvTable table, const KinematicTree& tree, TimeColumn times)
        : m_table(std::move(table)),
          m_tree(tree),
          m_time(times == TimeColumn::Increasing ? m_table.find("time") : std::nullopt),
          m_columns(jointColumns(m_table, tree)),
          m_base(poseColumns(m_table, "base_")),
          m_rest(tree.size(), 0.0)
    {
    }

    JointFile read()
    {
        setRest();
        for (const JointColumn& column : m_columns)
        {
            m_file.names.push_back(m_table.names[column.column]);
        }
        for (const CsvRow& row : m_table.rows)
        {
            m_file.rows.push_back(configuration(row));
        }
        return std::move(m_file);
    }

private:
    void setRest()
    {
        std::string missing;
        for (std::size_t k = 0; k < m_tree.size(); ++k)
        {
            const Link& link = m_tree.links[k];
            if (!isDriven(link))
            {
                continue;
            }
            m_rest[k] = std::clamp(0.0, link.joint.lower, link.joint.upper);
            if (!m_table.find(link.joint.name))
            {
                missing += fmt::format(
                    "{}{} at {}", missing.empty() ? "" : ", ", link.joint.name, m_rest[k]);
            }
        }
        if (!missing.empty())
        {
            m_file.notes.push_back(fmt::format(
                "{}: joints without a column rest: {}", m_table.path.string(), missing));
        }
    }

    Configuration configuration(const CsvRow& row)
    {
        Configuration result{
            .id = std::to_string(m_file.rows.size()), .positions = m_rest, .base = std::nullopt};
        if (const std::optional<std::size_t> id = m_table.find("id"))
        {
            result.id = row.cells[*id];
        }
        for (const JointColumn& column : m_columns)
        {
            const double q = m_table.number(row, column.column);
            result.positions[static_cast<std::size_t>(column.link)] = q;
            checkLimits(row, column, q);
        }
        if (m_base)
        {
            result.base = poseOf(m_table, row, *m_base);
        }
        applyMimics(m_tree, result.positions);
        result.time = static_cast<double>(m_file.rows.size());
        if (m_time)
        {
            result.time = m_table.number(row, *m_time);
            if (!m_file.rows.empty() && result.time <= m_file.rows.back().time)
            {
                m_table.fail(row,
                             *m_time,
                             fmt::format("{} s is not after the {} s of the row before: let times "
                                         "increase",
                                         result.time,
                                         m_file.rows.back().time));
            }
        }
        return result;
    }

    /// Notes the first row of each joint.
    void checkLimits(const CsvRow& row, const JointColumn& column, double q)
    {
        const Joint& joint = m_tree.links[static_cast<std::size_t>(column.link)].joint;
        const bool isOutside = q < joint.lower - kLimitSlack || q > joint.upper + kLimitSlack;
        if (isOutside && joint.mimicOf == kNone && m_outside.insert(column.link).second)
        {
            m_file.notes.push_back(
                fmt::format("{}:{}: {}: {} is outside its limits {} to {}: answered as asked",
                            m_table.path.string(),
                            row.line,
                            joint.name,
                            q,
                            joint.lower,
                            joint.upper));
        }
    }

    CsvTable m_table;
    const KinematicTree& m_tree;
    std::optional<std::size_t> m_time;
    std::vector<JointColumn> m_columns;
    std::optional<PoseColumns> m_base;
    std::vector<double> m_rest;
    std::set<std::int32_t> m_outside;
    JointFile m_file;
};
}  // namespace

JointFile readJointFile(const std::filesystem::path& path,
                        const KinematicTree& tree,
                        TimeColumn times)
{
    return JointFileReader(readCsvTable(path, "give a CSV file of joint positions"), tree, times)
        .read();
}

std::string drivenNames(const KinematicTree& tree)
{
    std::string text;
    for (const Link& link : tree.links)
    {
        if (isDriven(link))
        {
            text += text.empty() ? "" : ", ";
            text += link.joint.name;
        }
    }
    return text;
}
}  // namespace bullet_ccd::tools
