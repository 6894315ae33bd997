#include "bullet_ccd/io/robot_file.h"

#include "bullet_ccd/io/robot/mjcf_document.h"
#include "bullet_ccd/io/robot/mjcf_tree.h"
#include "bullet_ccd/io/robot/robot_format.h"
#include "bullet_ccd/io/robot/robot_parts.h"

#include <string>
#include <utility>

namespace bullet_ccd
{
RobotModel loadMjcf(const std::filesystem::path& path)
{
    MjcfDocument document(path);
    MjcfTree tree = mjcfTree(document);
    coupleMjcf(document, tree);
    RobotModel robot = std::move(tree.robot);
    for (std::size_t i = 0; i < robot.tree.size(); ++i)
    {
        requireFiniteMesh(robot.linkMeshes[i],
                          path.string() + ": body '" + robot.tree.links[i].name + "'");
    }
    completeInertials(robot);
    noteMimicLimits(robot.tree, robot.notes);
    noteUnlimited(robot.tree, robot.notes);
    if (!document.leftOut().empty())
    {
        std::string all;
        for (const std::string& what : document.leftOut())
        {
            all += (all.empty() ? "" : ", ") + what;
        }
        robot.notes.push_back("not understood or not needed, left out: " + all);
    }
    return robot;
}
RobotModel loadRobot(const std::filesystem::path& path)
{
    switch (robotFormat(readText(path)))
    {
        case RobotFormat::Mjcf:
            return loadMjcf(path);
        case RobotFormat::Xacro:
        {
            const std::string text = expandXacro(path);
            requireShallowXml(text, path.string());
            return urdfFromText(text, path);
        }
        default:
            return loadUrdf(path);
    }
}
}  // namespace bullet_ccd
