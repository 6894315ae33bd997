/// All contacts of a closing motion: after a contact its joints stop, and the rest goes on.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <vector>

namespace bullet_ccd
{
/// Which joints stop at a contact.
enum class StopRule : std::uint8_t
{
    /// All joints from the link to the root, or, at a contact of two links, to their deepest common
    /// ancestor: the link comes to rest. A finger whose second phalanx touches goes on with its
    /// last joint only.
    Chain,
    /// LinkContact::stopJoint alone: joints nearer to the root go on, and with them the link. They
    /// stop at the next contact unless they carry the link away from this one or along it.
    NearestJoint,
};

struct ContactSequenceOptions
{
    ArticulatedToiOptions query{};
    StopRule rule = StopRule::Chain;
};

struct ContactSequence
{
    /// Hit if contacts were found, Separated if none; Overlapping and IterationLimit end the
    /// sequence where they occur.
    ToiStatus status = ToiStatus::Separated;
    /// In the order of time; each once, with its time and the joint that had to stop.
    std::vector<LinkContact> contacts;
    /// When each joint stopped, one entry a link: 1 if it went all the way.
    std::vector<double> stopTimes;
    JointMotion end;    ///< where the body is in the end: positions, balls, root; rates are zero
    double time = 1.0;  ///< up to which the motion is certified; 1 unless the sequence ended early
    ArticulatedCounters counters;  ///< of all queries
    int queries = 0;
};

/// Follows the motion of the body over [0, 1] through all its contacts.
///
/// At a contact the joints that the rule names stop where they are, and with each the joints that
/// it drives or that drive it (mimic). Pairs that are in contact then are exempt as long as they
/// separate, slide or rest on each other: pairs without relative motion are not looked at, and the
/// others must close in to three quarters of their distance to count again. To leave room for that
/// ToiOptions::aim is taken to be 1/2: steps stop half a tolerance short. A root that moves stops
/// with a chain. Where nothing that can stop is left moving, but an obstacle presses on, the
/// sequence ends.
///
/// Guarantee: nothing touches at any time of the resulting motion (as of articulatedToi(), query
/// by query). Obstacles with user motions are refused (std::invalid_argument): their motion cannot
/// be cut. Else throws as articulatedToi() does.
[[nodiscard]] BULLET_CCD_API ContactSequence
articulatedContacts(const ArticulatedBody& body,
                    std::span<const RigidBody> obstacles,
                    const ContactSequenceOptions& options,
                    ToiWorkspace& work);
}  // namespace bullet_ccd
