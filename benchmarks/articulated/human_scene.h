/// A recorded human of 15 links among 16 chessmen on their board.
#pragma once

#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// World poses of the links, frame by frame.
using Recording = std::vector<std::vector<Eigen::Isometry3d>>;

/// Triangles of a link and an obstacle that are this near at the start of a query at which the two
/// intersect are exempt from each other [m].
inline constexpr double kMaskReach = 1e-2;

/// From one frame of the recording to the next.
struct HumanQuery
{
    JointMotion motion;
    std::vector<std::unique_ptr<const PairMask>> storage;
    std::vector<LinkMask> masks;  ///< of the pairs that intersect at the start

    [[nodiscard]] const PairMask* maskOf(std::int32_t link, std::int32_t obstacle) const;
};

struct HumanScene
{
    KinematicTree tree;
    std::vector<SsvTree> links;
    std::vector<const SsvTree*> linkTrees;
    std::vector<SsvTree> pieces;
    std::vector<RigidBody> obstacles;
    std::vector<HumanQuery> queries;
    std::size_t humanTriangles = 0;
    std::size_t obstacleTriangles = 0;

    [[nodiscard]] ArticulatedBody body(const HumanQuery& query) const;
};

/// The recording of that name ("walk", "run", "kick"). Chessmen, the king 0.9 m tall, stand on a
/// board just below the lowest foot (human_scene.cpp). Throws std::runtime_error for another name
/// and for files that are missing.
[[nodiscard]] HumanScene makeHumanScene(const std::filesystem::path& data, const std::string& name);
}  // namespace bullet_ccd::benchmarks
