/// All contacts of a motion in which joints stop one after the other: at a contact some joints
/// stop, and the others go on.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <vector>

namespace bullet_ccd
{
/// Which joints stop at a contact.
enum class StopRule : std::uint8_t
{
    /// All joints from the link to the root stop, or, at a contact of two links, to their deepest
    /// common ancestor. So the link comes to rest. A finger whose second phalanx touches goes on
    /// with its last joint only.
    Chain,
    /// LinkContact::stopJoint alone stops. Joints nearer to the root go on, and the link with them.
    /// They stop at the next contact unless they carry the link away from this one or along it.
    NearestJoint,
};

struct ContactSequenceOptions
{
    ArticulatedToiOptions query{};
    StopRule rule = StopRule::Chain;
};

struct ContactSequence
{
    /// Hit if contacts were found, Separated if there were none. Overlapping and IterationLimit end
    /// the sequence where they occur.
    ToiStatus status = ToiStatus::Separated;
    /// In the order of time. Each contact is listed once, with its time and the joint that had to
    /// stop.
    std::vector<LinkContact> contacts;
    /// When each joint stopped, in [0, 1], one entry per link; 1 if it went all the way.
    std::vector<double> stopTimes;
    JointMotion end;    ///< where the body ends: positions, balls and root; rates are zero
    double time = 1.0;  ///< up to which the motion is certified; 1 unless the sequence ended early
    ArticulatedCounters counters;  ///< of all queries
    int queries = 0;
};

/// Follows the motion of the body over [0, 1] through all its contacts.
///
/// At a contact the joints that the rule names stop where they are, together with the joints that
/// they drive or that drive them (mimic). A moving root stops with a chain. Pairs that are in
/// contact then are exempt as long as they separate, slide or rest on each other: pairs without
/// relative motion are not looked at, and the others must close in to three quarters of their
/// distance to count again. ToiOptions::aim is taken to be 1/2 to leave room for that, so every
/// query stops half a tolerance short. The sequence ends where an obstacle presses on and nothing
/// that can stop is left moving.
///
/// Guarantee: no contact at any time of the resulting motion, query by query as articulatedToi()
/// promises.
/// Throws std::invalid_argument as articulatedToi() does, and for obstacles with user motions,
/// which cannot be cut.
[[nodiscard]] BULLET_CCD_API ContactSequence
articulatedContacts(const ArticulatedBody& body,
                    std::span<const RigidBody> obstacles,
                    const ContactSequenceOptions& options,
                    ToiWorkspace& work);
}  // namespace bullet_ccd
