/// Robots, and what their queries take and return, for all files that ask about robots.
#pragma once

#include "bullet_ccd/bullet_ccd.h"
#include "bullet_ccd/io.h"

#include "python/src/arrays.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::python
{
using LinkNames = std::pair<std::string, std::string>;
using LinkPair = std::pair<std::int32_t, std::int32_t>;
/// Meshes with Motions or poses.
using Obstacles = std::vector<std::pair<std::shared_ptr<SsvTree>, py::object>>;

/// A robot with the hierarchies of its links.
struct Robot
{
    Robot(RobotModel loaded, std::filesystem::path path)
        : model(std::move(loaded)), file(std::move(path))
    {
        trees.reserve(model.linkMeshes.size());
        for (std::size_t i = 0; i < model.tree.size(); ++i)
        {
            const TriangleMesh& mesh = model.linkMeshes[i];
            linkTrees.push_back(
                mesh.triangles.empty()
                    ? nullptr
                    : &*trees.emplace_back(std::make_unique<SsvTree>(buildSsvTree(mesh))));
            const Joint& joint = model.tree.links[i].joint;
            if (joint.isMovable() && joint.mimicOf == kNone)
            {
                movable.push_back(static_cast<std::int32_t>(i));
            }
        }
    }

    RobotModel model;
    std::filesystem::path file;
    std::vector<std::unique_ptr<SsvTree>> trees;
    std::vector<const SsvTree*> linkTrees;
    std::vector<std::int32_t> movable;  ///< links below joints that move by themselves

    [[nodiscard]] const Joint& joint(std::int32_t link) const
    {
        return model.tree.links[static_cast<std::size_t>(link)].joint;
    }

    [[nodiscard]] std::int32_t link(const std::string& name) const
    {
        const std::int32_t found = model.tree.findLink(name);
        if (found == kNone)
        {
            throw py::key_error(model.name + " has no link '" + name + "'");
        }
        return found;
    }

    /// Nothing for kNone.
    [[nodiscard]] std::optional<std::string> linkName(std::int32_t link) const
    {
        return link == kNone ? std::nullopt
                             : std::optional(model.tree.links[static_cast<std::size_t>(link)].name);
    }
};

/// Positions of all links from those of the joints that move by themselves: a dictionary by name,
/// an array in the order of Robot.joint_names, or None for zeros, clamped into the limits.
[[nodiscard]] std::vector<double> positionsOf(const Robot& robot,
                                              const py::handle& value,
                                              const char* name);

/// From start to end, linear in time; the root rests at rootStart if rootEnd is None.
[[nodiscard]] JointMotion jointMotionOf(const Robot& robot,
                                        const py::object& start,
                                        const py::object& end,
                                        const py::object& rootStart,
                                        const py::object& rootEnd);

/// Throws TypeError "<argument>[<index>]: ..." for None.
[[nodiscard]] std::vector<RigidBody> bodiesOf(const Obstacles& obstacles, const char* argument);

/// A robot among obstacles, and which of its links are tested against each other.
struct RobotScene
{
    /// Throws KeyError for a name that is no link, and as bodiesOf() does.
    RobotScene(const Robot& robot,
               const Obstacles& obstacles,
               const std::vector<LinkNames>& selfPairs);

    [[nodiscard]] ArticulatedBody body(const JointMotion* motion = nullptr) const
    {
        return {.tree = &robot.model.tree,
                .linkTrees = robot.linkTrees,
                .motion = motion,
                .selfPairs = pairs};
    }

    const Robot& robot;
    std::vector<LinkPair> pairs;
    std::vector<RigidBody> obstacles;
};

/// A contact with names in place of indices.
struct NamedContact : LinkContact
{
    std::string linkName;
    std::optional<std::string> otherLinkName;
};

[[nodiscard]] std::vector<NamedContact> namedContacts(const Robot& robot,
                                                      std::span<const LinkContact> contacts);

/// What a query about a robot says.
struct ArticulatedAnswer
{
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;
    std::vector<NamedContact> contacts;
};
}  // namespace bullet_ccd::python
