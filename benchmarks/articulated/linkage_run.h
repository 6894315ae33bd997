/// Robots that move by their joints, near an object or each other: answers of articulatedToi()
/// compared with samples of the motion that FCL tests for overlap.
#pragma once

#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/support/table.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// Samples are at most this far apart by the fastest joint [rad].
inline constexpr double kSweepStep = 1e-3;

/// Holds all vertices of a mesh; none if the radius is negative.
struct BoundingBall
{
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    double radius = -1.0;
};

/// Something that rests.
struct LinkageObject
{
    explicit LinkageObject(const TriangleMesh& mesh);

    SsvTree tree;
    FclModel model;
    BoundingBall ball;
};

struct LinkageQuery
{
    JointMotion motion;
    const LinkageObject* object = nullptr;  ///< or none
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
};

/// The first sample at which something intersects, or none.
struct SweepHit
{
    bool found = false;
    double time = 1.0;
    std::int32_t link = kNone;
    std::int32_t otherLink = kNone;  ///< kNone: the object
};

struct LinkageTally
{
    int queries = 0;
    int hits = 0;
    int selfHits = 0;
    int samePair = 0;       ///< the pair of FCL's sample is in contact
    int betweenSteps = 0;   ///< contacts that no sample hits, or none within two steps
    int late = 0;           ///< after a sample that intersects, or missed
    int notThere = 0;       ///< contacts at which FCL finds overlap or a gap above the tolerance
    double worstLag = 0.0;  ///< from the contact to the sample, of those within two steps [rad]
    double micros = 0.0;    ///< mean of the medians
    double sweepMicros = 0.0;
    ArticulatedCounters counters;  ///< sums
};

class Linkage
{
public:
    /// @param linkTrees,selfPairs as in ArticulatedBody; must outlive this
    Linkage(const KinematicTree& tree,
            std::span<const SsvTree* const> linkTrees,
            std::span<const std::pair<std::int32_t, std::int32_t>> selfPairs);

    /// Whether nothing that is tested intersects at time t; links at rest are looked at, too.
    [[nodiscard]] bool isFree(const LinkageQuery& query, double t) const;

    /// Answers all, compares them with samples, then takes the time of `repeats` passes.
    [[nodiscard]] LinkageTally run(std::span<const LinkageQuery> queries, int repeats) const;

private:
    using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

    [[nodiscard]] const FclModel& modelOf(const LinkageQuery& query, std::int32_t link) const;
    [[nodiscard]] ArticulatedBody body(const LinkageQuery& query) const;
    [[nodiscard]] Pairs pairsOf(const LinkageQuery& query, bool movingOnly) const;
    [[nodiscard]] SweepHit overlapAt(const LinkageQuery& query, const Pairs& pairs, double t) const;
    [[nodiscard]] SweepHit sweep(const LinkageQuery& query, double step) const;
    [[nodiscard]] bool isContactAt(const LinkageQuery& query, const LinkContact& contact) const;
    void compare(const LinkageQuery& query,
                 const ArticulatedToiResult& result,
                 LinkageTally& tally) const;

    const KinematicTree& m_tree;
    std::span<const SsvTree* const> m_linkTrees;
    std::span<const std::pair<std::int32_t, std::int32_t>> m_selfPairs;
    std::vector<std::int32_t> m_modelOfLink;
    std::vector<FclModel> m_models;
    std::vector<BoundingBall> m_balls;  ///< one entry a link
};

/// Of both commands that run linkages.
struct LinkageOptions
{
    std::filesystem::path data;
    int configurations = 100;  ///< random queries, of each hand
    int repeats = 5;
    std::uint64_t seed = 1;
};

/// The table of both; prints its head.
[[nodiscard]] Table linkageTable();
void printLinkage(const Table& table, const std::string& robot, const LinkageTally& tally);

/// Whether nothing was missed or late, and all contacts are where they are said to be.
[[nodiscard]] bool isRight(const LinkageTally& tally);
}  // namespace bullet_ccd::benchmarks
