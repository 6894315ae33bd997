/// Answers and times queries of a robot among obstacles.
#pragma once

#include "bullet_ccd/toi/articulated_toi.h"
#include "tools/ccd_cli/files/robot_links.h"

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// From one configuration of the robot to another.
struct ArticulatedQuery
{
    std::string id;
    JointMotion motion;
};

/// Appends boxes in W that enclose all links over the motion, widened by `reach` [m].
void addSweptBoxes(const RobotLinks& links,
                   const JointMotion& motion,
                   double reach,
                   std::vector<Eigen::AlignedBox3d>& boxes);

struct ArticulatedAnswer
{
    ArticulatedToiResult result;
    double microseconds = 0.0;  ///< of articulatedToi() alone; median of the passes
};

/// Answers in the order of the queries, on one thread whose workspace has been used once before
/// anything is timed. Between two times of one query that enter its median lie all other queries.
/// @param goOn  called after every query, with the number of queries answered so far; no further
/// one is
///              begun once it has returned false, and what was not answered is missing at the end
[[nodiscard]] std::vector<ArticulatedAnswer> runArticulated(
    const RobotLinks& links,
    std::span<const RigidBody> obstacles,
    std::span<const ArticulatedQuery> queries,
    const ToiOptions& options,
    int repeat,
    const std::function<bool(std::size_t)>& goOn);

/// One query through all its contacts, and its microseconds.
struct SequenceAnswer
{
    ContactSequence sequence;
    double microseconds = 0.0;
};
[[nodiscard]] SequenceAnswer runSequence(const RobotLinks& links,
                                         std::span<const RigidBody> obstacles,
                                         const JointMotion& motion,
                                         const ContactSequenceOptions& options);
}  // namespace bullet_ccd::tools
