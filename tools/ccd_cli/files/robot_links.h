/// The links of a robot: hierarchies, which of them to test against each other, and what is exempt
/// about their joints.
#pragma once

#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::tools
{
/// Triangles of joined links this near to each other count as the region of their joint [m].
inline constexpr double kDefaultJointReach = 2e-3;

struct RobotLinks
{
    RobotModel robot;
    /// One entry a link; null without geometry.
    std::vector<std::unique_ptr<const SsvTree>> trees;
    std::vector<const SsvTree*> linkTrees;
    std::vector<std::pair<std::int32_t, std::int32_t>> selfPairs;
    std::vector<std::unique_ptr<const PairMask>> masks;
    std::vector<LinkMask> linkMasks;
    std::vector<std::string> notes;  ///< what was assumed or ignored, one line each

    [[nodiscard]] const std::string& linkName(std::int32_t link) const
    {
        return robot.tree.links[static_cast<std::size_t>(link)].name;
    }
    /// @pre nothing of this moves or changes while the body is in use
    [[nodiscard]] ArticulatedBody body(const JointMotion& motion) const;
};

/// Reads a robot and builds its hierarchies. Throws as loadUrdf().
[[nodiscard]] RobotLinks loadRobotLinks(const std::filesystem::path& urdf);

/// Lets all links be tested against each other but for the pairs that the SRDF disables (no file:
/// an empty path).
///
/// Links with one joint between them, or two or three and no other geometry, are exempt where they
/// come within `reach` [m] of each other at some position within the limits of the joint: the
/// region of the joint. The rest of both is tested. Throws as readSrdf().
void addSelfPairs(RobotLinks& links, const std::filesystem::path& srdf, double reach);

/// Fixes an object to a link, as a further link of that name. After addSelfPairs() it can be tested
/// against all other links too, whole.
/// @param X_LO      pose of the mesh in the link
/// @param testsSelf test it against the links that joints move relative to it
void attachObject(RobotLinks& links,
                  const std::string& name,
                  TriangleMesh mesh,
                  std::int32_t link,
                  const Eigen::Isometry3d& X_LO,
                  bool testsSelf);
}  // namespace bullet_ccd::tools
