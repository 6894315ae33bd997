/// Candidate hand poses around an object.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/approach/approach.h"
#include "grasp/approach/object_shape.h"
#include "grasp/hand/hand_model.h"

#include <cstdint>

namespace bullet_ccd::grasp
{
/// A pose from which the hand approaches, and the preshape it does so in.
struct ApproachCandidate
{
    std::int64_t number = 0;
    ApproachSource source = ApproachSource::Sphere;  ///< never Mixed
    std::size_t preshape = 0;
    Eigen::Isometry3d X_WStart = Eigen::Isometry3d::Identity();  ///< root link
    Eigen::Vector3d direction_W = Eigen::Vector3d::Zero();       ///< unit
    double distance = 0.0;        ///< longest travel that makes sense [m]
    double centerDistance = 0.0;  ///< travel that brings the grasp frame's origin to its target [m]
};

/// Candidate `number` of the sequence of `seed`.
///
/// For ApproachSource::Sphere the grasp frame's z axis is the direction of approach and points at
/// (about) the centre of mass; over the first `count` candidates the directions cover the sphere
/// evenly, except that each may be turned within its neighbourhood, or square to a thin principal
/// axis of the object, where that lets the object fit between the fingers. The roll lays the hand's
/// opposition axis along a thin direction of the object. The preshapes that open wide enough for
/// the object's thinnest direction take turns, or all if none does. The hand's bounding ball about
/// the grasp frame starts clear of the object's about its centre of mass. A pure function of its
/// arguments.
///
/// For Surface the line of approach goes through a point of the surface drawn with probability by
/// area and is turned from the normal there by at most kLargestTurn; the roll is as above. For
/// Boxes it meets a face of the box along the object's principal axes at right angles; points are
/// spread evenly over the faces, which take turns, and the opposition axis lies along the face's
/// shorter side. Both bring the grasp frame to the middle of what the line goes through.
///
/// With tableTop the directions of Sphere cover the cap within maxTilt of -up instead; what would
/// be tilted more is turned back to the limit. A roll beyond the limits is drawn anew within them.
///
/// For Mixed the sources, and for each of them the preshapes, take turns; see ApproachTurn.
///
/// Throws std::invalid_argument for count <= 0, number < 0, a hand without preshapes, or options
/// that cannot be.
[[nodiscard]] BULLET_CCD_API ApproachCandidate sampleApproach(const HandModel& hand,
                                                              const GraspObject& object,
                                                              std::uint64_t seed,
                                                              std::int64_t number,
                                                              std::int64_t count,
                                                              const ApproachOptions& options = {});

/// A preshape as its grasp frame sees it.
struct OpenHand
{
    double radius = 0.0;  ///< of the ball about the grasp frame's origin that holds all links [m]
    /// Of jaws on one motor the free distance between the pads along x, else the extent along x of
    /// the fingertips' middles [m].
    double opening = 0.0;
};

[[nodiscard]] BULLET_CCD_API OpenHand openHand(const HandModel& hand, const Preshape& preshape);

/// What the sampler looks at, for many candidates of one hand and object.
struct ApproachShapes
{
    ObjectShape object;
    std::vector<OpenHand> hands;  ///< one a preshape
    /// Only the preshape that opens widest takes part, of those that the object fits into.
    /// planGrasps() wants that of jaws on one motor where nothing is in the way: narrow openings
    /// hold less, but need less room among obstacles.
    bool widestOnly = false;
};

[[nodiscard]] BULLET_CCD_API ApproachShapes approachShapes(const HandModel& hand,
                                                           const GraspObject& object);

/// The preshapes that the object fits into across its thinnest direction, in the order of the hand;
/// all of them if it fits into none; the widest of these if only that takes part. Closing from a
/// preshape that it does not fit into stops at the fingers themselves, before they are round the
/// object.
[[nodiscard]] BULLET_CCD_API std::vector<std::size_t> fittingPreshapes(
    const ApproachShapes& shapes);

/// Where one candidate of a mixed sequence comes from.
struct ApproachTurn
{
    ApproachSource source = ApproachSource::Sphere;  ///< not Mixed
    std::size_t preshape = 0;
    std::int64_t turn = 0;  ///< number among the candidates of this source and preshape
};

/// Candidate `number` of a mixed sequence. Directions of Sphere and points of Boxes are spread
/// evenly over the turns, however many there will be.
[[nodiscard]] BULLET_CCD_API ApproachCandidate sampleApproach(const HandModel& hand,
                                                              const GraspObject& object,
                                                              const ApproachShapes& shapes,
                                                              std::uint64_t seed,
                                                              std::int64_t number,
                                                              std::int64_t count,
                                                              const ApproachTurn& turn,
                                                              const ApproachOptions& options);

/// The same for many candidates: `shapes` is approachShapes(hand, object).
[[nodiscard]] BULLET_CCD_API ApproachCandidate sampleApproach(const HandModel& hand,
                                                              const GraspObject& object,
                                                              const ApproachShapes& shapes,
                                                              std::uint64_t seed,
                                                              std::int64_t number,
                                                              std::int64_t count,
                                                              const ApproachOptions& options = {});
}  // namespace bullet_ccd::grasp
