/// Certifies trajectories of a robot among obstacles.
#pragma once

#include "bullet_ccd/trajectory/trajectory.h"
#include "tools/ccd_cli/files/robot_links.h"
#include "tools/support/obstacles/obstacle_list.h"

#include <optional>
#include <span>
#include <string>

namespace bullet_ccd::tools
{
/// What is known of one trajectory.
struct Certificate
{
    std::string name;  ///< of its file
    std::size_t segments = 0;
    double start = 0.0;  ///< [s]
    TrajectoryToiResult toi;
    /// If the trajectory is free, it was asked for, and something moves.
    std::optional<TrajectoryLeastDistance> least;
    std::string error;  ///< what is wrong with the file; the rest is not filled in
    double microseconds = 0.0;
};

enum class Verdict
{
    Free,
    Contact,
    Unknown,   ///< the query gave up
    BadInput,  ///< the file cannot be read
};
[[nodiscard]] Verdict verdictOf(const Certificate& certificate);

struct CertifyOptions
{
    ToiOptions toi;
    bool wantsDistance = true;
    std::span<ToiWorkspace> work;  ///< one thread for each
};

/// Asks for the first contact, and of a free trajectory for the least distance.
[[nodiscard]] Certificate certify(const RobotLinks& links,
                                  std::span<const RigidBody> obstacles,
                                  const Trajectory& trajectory,
                                  const CertifyOptions& options);

/// Two names of links, attached objects or obstacles that may touch.
struct AllowedPair
{
    std::string a;
    std::string b;
};

/// Takes the pair out of what is tested. Throws std::runtime_error for names that do not exist and
/// for two obstacles.
void allowPair(RobotLinks& links, std::span<const Obstacle> obstacles, const AllowedPair& pair);
}  // namespace bullet_ccd::tools
