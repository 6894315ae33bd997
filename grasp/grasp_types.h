/// Value types of the grasp pipeline.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// The object to grasp. It is at rest, and its mesh frame is W.
struct GraspObject
{
    std::string name;
    SsvTree tree;
    Eigen::Vector3d centerOfMass = Eigen::Vector3d::Zero();  ///< [m]
    double radius = 0.0;  ///< largest distance of a vertex from the centre of mass [m]
    bool watertight = false;
};

/// Builds the hierarchy of the mesh and computes what GraspObject holds.
/// Throws std::invalid_argument as buildSsvTree() does.
[[nodiscard]] BULLET_CCD_API GraspObject makeGraspObject(std::string name, TriangleMesh mesh);

/// How low a body at a pose in W reaches: the least height of its vertices along `up` [m].
/// @param up  unit, W
[[nodiscard]] BULLET_CCD_API double lowestHeight(const SsvTree& tree,
                                                 const Eigen::Isometry3d& X_W,
                                                 const Eigen::Vector3d& up);

/// A point contact of a link on the object.
struct GraspContact
{
    std::int32_t link = kNone;                         ///< of the hand
    Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< on the object, W [m]
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, into the object, W
    double gap = 0.0;                                  ///< distance of the two surfaces [m]
};

using Wrench = Eigen::Matrix<double, 6, 1>;  ///< (force; moment); some functions scale the moment
using Twist = Eigen::Matrix<double, 6, 1>;   ///< (velocity of a point; angular velocity)

/// Which forces a contact can transmit.
enum class ContactModel : std::uint8_t
{
    Frictionless,  ///< along the normal only
    HardFinger,    ///< also tangential, by Coulomb's law
    SoftFinger,    ///< also a torsional moment about the normal
};

/// A contact model and its numbers. docs/glossary.md defines friction and torsion.
struct ContactLaw
{
    ContactModel model = ContactModel::HardFinger;
    double friction = 0.5;  ///< Coulomb coefficient mu
    double torsion = 0.01;  ///< soft finger: e, largest torsional moment over largest friction [m]
};

/// Why a candidate is no grasp. None means that it is one.
enum class RejectReason : std::uint8_t
{
    None,
    OverlapAtStart,  ///< the open hand intersects the object where the approach begins
    SelfOverlap,     ///< two links that must not touch intersect in the preshape
    NoApproachHit,   ///< the approach ends without any contact
    TooFewContacts,  ///< fewer than two contacts after closing
    NoForceClosure,  ///< epsilon below the threshold
    Penetration,     ///< the independent check found an intersection; it is never expected
    IterationLimit,  ///< a time-of-impact query gave up
    Obstacle,        ///< something beside the object is touched on the way or while closing
    OutOfReach,      ///< a force closure to which the arm does not bring the hand
};
[[nodiscard]] BULLET_CCD_API const char* toString(RejectReason reason);

/// How much a force closure is worth by its epsilon: "marginal" below 0.05, "fair" below 0.2,
/// "firm" from there on.
[[nodiscard]] BULLET_CCD_API const char* epsilonClass(double epsilon);

/// Quality of a grasp by its wrench space.
struct GraspQuality
{
    double epsilon =
        0.0;  ///< radius of the largest ball about 0 in the L1 wrench space; 0 if outside
    double volume = 0.0;        ///< of that space (6-D); 0 if it was not asked for
    bool forceClosure = false;  ///< epsilon >= the threshold asked for
    /// Of a force closure: the largest mass that it holds with gravity in any direction, within the
    /// robot's efforts [kg]; see largestMassHeld().
    std::optional<double> largestMass{};
};

/// A link that was stopped during closing.
struct StopEvent
{
    std::int32_t link = kNone;
    double time = 0.0;     ///< simulated time since closing began [s]
    bool byObject = true;  ///< false: stopped by another link
};

/// Outcome of one candidate.
struct Grasp
{
    std::int64_t candidate = 0;  ///< its number in the sampling sequence
    RejectReason reject = RejectReason::None;
    std::string preshape;
    std::string source;  ///< of the approach, such as "sphere"; empty for one that was given
    Eigen::Isometry3d X_WStart = Eigen::Isometry3d::Identity();  ///< root link at the start
    Eigen::Vector3d approach_W = Eigen::Vector3d::Zero();        ///< unit
    double approachDistance = 0.0;                               ///< travelled until contact [m]
    std::int64_t obstaclesInReach = 0;  ///< obstacles that swept boxes do not rule out
    Eigen::Isometry3d X_WH = Eigen::Isometry3d::Identity();  ///< root link of the final grasp
    std::vector<double> positions;                           ///< one entry per link [rad or m]
    std::vector<GraspContact> contacts;
    std::vector<StopEvent> stops;
    GraspQuality quality;
};
}  // namespace bullet_ccd::grasp
