/// An arm of seven joints in clutter, for planners.
#pragma once

#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/ompl/certified_planning.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace bullet_ccd::benchmarks
{
inline constexpr std::size_t kArmJoints = 7;
using Configuration = std::array<double, kArmJoints>;

/// Links of 0.2 m and 0.06 m thick, joints that turn by 2.5 rad to both sides about z and y in
/// turn, and rods and plates of 1 to 4 cm about it. Self-collision is not tested.
class ClutteredArm
{
public:
    explicit ClutteredArm(std::uint64_t seed, int obstacles = 24);
    ClutteredArm(const ClutteredArm&) = delete;
    ClutteredArm& operator=(const ClutteredArm&) = delete;

    [[nodiscard]] const std::shared_ptr<const CertifiedRobot>& robot() const { return m_robot; }

    /// Whether no link overlaps an obstacle, by FCL.
    [[nodiscard]] bool isFreeByFcl(std::span<const double> q) const;

    /// One that is free.
    [[nodiscard]] Configuration freeConfiguration(reference::Random& random) const;

private:
    KinematicTree m_tree;
    SsvTree m_link;
    std::vector<const SsvTree*> m_links;
    std::vector<SsvTree> m_obstacles;
    Environment m_environment;
    std::shared_ptr<const CertifiedRobot> m_robot;
    FclModel m_fclLink;
    std::vector<FclModel> m_fclObstacles;
    std::vector<Eigen::Vector3d> m_centers;  ///< of the spheres around the obstacles, in W
};
}  // namespace bullet_ccd::benchmarks
