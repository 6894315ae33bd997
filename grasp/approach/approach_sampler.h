/// Candidate hand poses around an object.
#pragma once

#include "grasp/grasp.h"
#include "grasp/hand/hand_model.h"

#include <cstdint>

namespace bullet_ccd::grasp
{
/// A pose from which the hand approaches, and the preshape it does so in.
struct ApproachCandidate
{
    std::int64_t number = 0;
    std::size_t preshape = 0;
    Eigen::Isometry3d X_WStart = Eigen::Isometry3d::Identity();  ///< root link
    Eigen::Vector3d direction_W = Eigen::Vector3d::Zero();       ///< unit
    double distance = 0.0;  ///< longest travel that makes sense [m]
};

/// Candidate `number` of the sequence of `seed`: the grasp frame's z axis points at (about) the
/// centre of mass, from directions that cover the sphere evenly over the first `count` candidates;
/// rolls that align the hand's opposition axis with a thin direction of the object are preferred.
/// The hand starts outside the object's bounding sphere. A pure function of its arguments.
[[nodiscard]] ApproachCandidate sampleApproach(const HandModel& hand,
                                               const GraspObject& object,
                                               std::uint64_t seed,
                                               std::int64_t number,
                                               std::int64_t count);
}  // namespace bullet_ccd::grasp
