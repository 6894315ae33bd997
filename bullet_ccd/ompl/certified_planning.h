/// Certified validity for OMPL's planners: motions between states are tested as a whole, not at
/// samples.
///
/// OMPL's own DiscreteMotionValidator looks at states along a motion, by default one per hundredth
/// of the extent of the space, so planners return paths that collide between them. Here a motion is
/// one query of articulatedToi(): it is free, or the time of its first contact gives the last valid
/// state.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <ompl/base/SpaceInformation.h>
#include <vector>

namespace bullet_ccd
{
/// What a planner moves, among obstacles at rest. The tree, the hierarchies, the masks and the
/// environment are referred to: they must outlive the scene and must not change.
///
/// An object that the robot carries is a further link of the tree, on a fixed joint. Pairs that may
/// touch are left out of `body.selfPairs`, or have a LinkMask.
struct PlanningScene
{
    ArticulatedBody body;  ///< its motion is not used
    const Environment* environment = nullptr;
    /// The links below the joints that are planned, in the order of the space's dimensions.
    std::vector<std::int32_t> joints;
    /// Positions of all other joints, one entry per link [rad or m]; empty: all 0.
    std::vector<double> positions{};
    Eigen::Isometry3d X_WR = Eigen::Isometry3d::Identity();  ///< pose of the root
    /// Tolerance and minimum separation [m]: states are valid if they keep that separation. Whole
    /// intervals are looked at first: most of the motions that a planner asks about are free, and
    /// these are then certified several times faster.
    ToiOptions toi{.aim = 0.5, .strategy = ToiStrategy::Interval};
};

/// Tests states and motions of a scene. It may be used by many threads at once. All functions throw
/// std::invalid_argument for positions that are not finite, or of another number than that of the
/// planned joints.
class BULLET_CCD_API CertifiedRobot
{
public:
    /// Throws std::invalid_argument for scenes that articulatedToi() would refuse, no joints,
    /// joints that do not move, are there twice or follow others, and environments that move.
    explicit CertifiedRobot(PlanningScene scene);
    ~CertifiedRobot();
    CertifiedRobot(const CertifiedRobot&) = delete;
    CertifiedRobot& operator=(const CertifiedRobot&) = delete;

    [[nodiscard]] const PlanningScene& scene() const { return m_scene; }

    /// True if all pairs that the planned joints move relative to each other are farther apart than
    /// the minimum separation.
    /// @param q one position for each planned joint
    [[nodiscard]] bool isFree(std::span<const double> q) const;

    /// The smallest distance of these pairs, at most `enough` [m].
    [[nodiscard]] double clearance(std::span<const double> q, double enough) const;

    /// True if the linear motion from one configuration to another keeps the minimum separation at
    /// all times; false if it does not, comes within the tolerance of it, or the query gave up.
    ///
    /// The answer of motionToi(), mostly sooner: of a motion that is blocked a few states are
    /// looked at first, and nobody asks when it is (ArticulatedToiOptions::anyContact).
    [[nodiscard]] bool isFreeMotion(std::span<const double> from, std::span<const double> to) const;

    /// The linear motion from one configuration to another.
    ///
    /// Guarantee: certified as articulatedToi() does; `time` is in [0, 1].
    [[nodiscard]] ArticulatedToiResult motionToi(std::span<const double> from,
                                                 std::span<const double> to) const;

    /// How much of the linear motion, in [0, 1], is certified to keep a tolerance and a quarter
    /// more than the minimum separation.
    ///
    /// Guarantee: isFreeMotion() is true of a part that is not 0, and of what turns back along it.
    [[nodiscard]] double freePart(std::span<const double> from, std::span<const double> to) const;

private:
    struct Impl;
    [[nodiscard]] ArticulatedToiResult motionToi(std::span<const double> from,
                                                 std::span<const double> to,
                                                 const ArticulatedToiOptions& options) const;
    void setPositions(std::span<const double> q, std::vector<double>& positions) const;
    [[nodiscard]] double leastDistance(std::span<const double> q, double enough, bool any) const;

    PlanningScene m_scene;
    std::unique_ptr<Impl> m_impl;
};

/// Thread-safe. clearance() of OMPL is that of the robot, up to a metre beyond the separation.
class BULLET_CCD_API CertifiedStateChecker : public ::ompl::base::StateValidityChecker
{
public:
    /// Throws std::invalid_argument unless there is a robot, and a space, a RealVectorStateSpace
    /// with a dimension for each planned joint.
    CertifiedStateChecker(const ::ompl::base::SpaceInformationPtr& information,
                          std::shared_ptr<const CertifiedRobot> robot);

    bool isValid(const ::ompl::base::State* state) const override;
    double clearance(const ::ompl::base::State* state) const override;

private:
    std::shared_ptr<const CertifiedRobot> m_robot;
};

/// Thread-safe.
class BULLET_CCD_API CertifiedMotionValidator : public ::ompl::base::MotionValidator
{
public:
    /// Throws as CertifiedStateChecker.
    CertifiedMotionValidator(const ::ompl::base::SpaceInformationPtr& information,
                             std::shared_ptr<const CertifiedRobot> robot);

    /// Guarantee: if true, no tested pair comes nearer than the minimum separation at any time of
    /// the motion.
    bool checkMotion(const ::ompl::base::State* from, const ::ompl::base::State* to) const override;

    /// The same; if false, the motion up to lastValid.second in [0, 1) is free: the other form says
    /// so, too. 0 if the motion begins nearer than CertifiedRobot::freePart() keeps.
    bool checkMotion(const ::ompl::base::State* from,
                     const ::ompl::base::State* to,
                     std::pair<::ompl::base::State*, double>& lastValid) const override;

private:
    [[nodiscard]] bool count(bool isFree) const;

    std::shared_ptr<const CertifiedRobot> m_robot;
};

/// The space of the planned joints within their limits; joints without limits have one turn, or a
/// metre, to both sides.
[[nodiscard]] BULLET_CCD_API ::ompl::base::StateSpacePtr jointSpace(
    const KinematicTree& tree, std::span<const std::int32_t> joints);

/// A space information over jointSpace() with both validators set. Throws std::invalid_argument
/// without a robot.
[[nodiscard]] BULLET_CCD_API ::ompl::base::SpaceInformationPtr certifiedSpace(
    std::shared_ptr<const CertifiedRobot> robot);
}  // namespace bullet_ccd
