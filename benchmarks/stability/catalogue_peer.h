/// Other codes behind one interface: a case in, contact and time out.
#pragma once

#include "benchmarks/reference/catalogue/cases.h"

#include <cstdint>

namespace bullet_ccd::tests
{
enum class PeerOutcome : std::uint8_t
{
    Free,
    Contact,
    GaveUp,  ///< says itself that it has no answer
};

struct PeerAnswer
{
    PeerOutcome outcome = PeerOutcome::Free;
    double time = 1.0;       ///< of the contact, a fraction of the motion
    std::int64_t pairs = 0;  ///< of nodes and triangles that were looked at; 0 if not counted
    double seconds = 0.0;    ///< of processor time, with building hierarchies
};

[[nodiscard]] inline PeerAnswer contactAt(double time)
{
    return {.outcome = PeerOutcome::Contact, .time = time};
}

/// This library, at the finest tolerance of the case.
[[nodiscard]] PeerAnswer ours(const RigidCase& tested, ToiStrategy strategy);
[[nodiscard]] PeerAnswer ours(const ArticulatedCase& tested, ToiStrategy strategy);

/// Exact distances at `steps` + 1 poses: contact where a pair is within the tolerance of the case.
[[nodiscard]] PeerAnswer distanceSampling(const ArticulatedCase& tested, int steps);

/// Fraction of the motion at which FCL's continuousCollide reports a contact: by testing
/// `steps` + 1 poses, or by its conservative advancement. Motions are handed over as two poses and
/// the reference point, the only form that FCL takes.
[[nodiscard]] PeerAnswer fclSampling(const RigidCase& tested, int steps);
[[nodiscard]] PeerAnswer fclAdvancement(const RigidCase& tested);
/// FCL's overlap test at `steps` + 1 poses of the links.
[[nodiscard]] PeerAnswer fclSampling(const ArticulatedCase& tested, int steps);
[[nodiscard]] bool hasFcl();

/// Bullet's casts, in double precision, on convex hulls with no margin; and its closest points of
/// hulls at `steps` + 1 poses: contact where they are within the tolerance of the case.
enum class BulletCast : std::uint8_t
{
    Continuous,  ///< btContinuousConvexCollision
    Gjk,         ///< btGjkConvexCast: translation only
    Subsimplex,  ///< btSubsimplexConvexCast: translation only
};
[[nodiscard]] PeerAnswer bulletCast(const RigidCase& tested, BulletCast cast);
[[nodiscard]] PeerAnswer bulletSampling(const RigidCase& tested, int steps);
[[nodiscard]] bool hasBullet();

/// Two links, or a link and an obstacle, that move relative to each other.
struct MovingPair
{
    std::size_t link = 0;
    std::size_t other = 0;
    bool isObstacle = false;
};
[[nodiscard]] std::vector<MovingPair> movingPairs(const ArticulatedCase& tested);
}  // namespace bullet_ccd::tests
