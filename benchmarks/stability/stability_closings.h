/// Closings repeated from poses that are a little off, by several methods.
#pragma once

#include "benchmarks/closing/discrete_closing.h"
#include "grasp/planner/plan_candidate.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// An error of a pose: a shift by exactly `magnitude` [m] and a turn by exactly as many radians
/// about `center`, each in a direction that is uniform over all. The same seed gives the same two
/// directions for every magnitude.
[[nodiscard]] Eigen::Isometry3d poseError(std::uint64_t seed,
                                          double magnitude,
                                          const Eigen::Vector3d& center);

/// Where an open hand begins, and how far it goes unless it meets the object before.
struct GraspStart
{
    Eigen::Isometry3d X_WStart = Eigen::Isometry3d::Identity();
    Eigen::Vector3d way = Eigen::Vector3d::Zero();  ///< W [m]
    std::vector<double> open;                       ///< joint positions, one entry a link
};

/// That of a grasp that was planned. Throws std::invalid_argument if the hand has no such preshape.
[[nodiscard]] GraspStart startOf(const grasp::HandModel& hand, const grasp::Grasp& grasp);

/// The same, seen by a hand that is where `error` puts it.
[[nodiscard]] GraspStart moved(const GraspStart& start, const Eigen::Isometry3d& error);

struct ClosingMethod
{
    std::string name;
    std::optional<DiscreteOptions> discrete = {};  ///< none: the continuous method
    grasp::PlannerOptions options = {};
};

/// Ours at its usual tolerance and at 0.1 um; the discrete baseline at GraspIt!'s steps (10 mm,
/// 0.01 rad, contact within 0.1 mm), and at a tenth of them with contact within our tolerance.
[[nodiscard]] std::vector<ClosingMethod> closingMethods();

/// Approaches, closes and scores one hand on one object; refers to both.
class ClosingBench
{
public:
    ClosingBench(const grasp::HandModel& hand, const grasp::GraspObject& object);
    ~ClosingBench();
    ClosingBench(const ClosingBench&) = delete;
    ClosingBench& operator=(const ClosingBench&) = delete;

    /// The hand moves from its start along its way until the method sees a contact, closes there
    /// once, and what it holds is scored. Rejections are those of grasp::closeAtPose(); a grasp
    /// that was not closed has no positions.
    [[nodiscard]] grasp::Grasp close(const ClosingMethod& method, const GraspStart& start);

private:
    struct Parts;
    std::unique_ptr<Parts> m_parts;
};

/// How a closing differs from that without the error.
struct ClosingChange
{
    bool closed = false;        ///< both were; else the rest means nothing
    double posture = 0.0;       ///< the largest difference of a joint [rad]; sliding: 10 * [m]
    bool sameLinks = false;     ///< the very links touch the object
    int contacts = 0;           ///< of the closing with the error
    double contactShift = 0.0;  ///< mean distance to the nearest former contact of the link [m]
    double epsilon = 0.0;       ///< |change|
    bool success = false;       ///< force closure and no penetration
};
[[nodiscard]] ClosingChange changeOf(const grasp::HandModel& hand,
                                     const grasp::Grasp& reference,
                                     const grasp::Grasp& other);

/// Shapes by formula at about 1K, 4K and 16K triangles, all vertices on the same smooth surface.
inline constexpr int kMeshLevels = 3;
[[nodiscard]] const std::vector<std::string>& meshFamilies();
/// @param level  0 to kMeshLevels - 1: 1024 * 4^level triangles
/// Throws std::invalid_argument for an unknown family.
[[nodiscard]] TriangleMesh meshOfFamily(const std::string& family, int level);
}  // namespace bullet_ccd::benchmarks
