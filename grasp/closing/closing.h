/// Closing a hand: the contract of closing engines, and the one that needs time-of-impact queries
/// alone. docs/glossary.md defines tolerance and gap.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "bullet_ccd/toi/model_use.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
enum class ClosingEngine : std::uint8_t
{
    Kinematic,  ///< kinematicClosing(), by time-of-impact queries alone
    Simulated,  ///< simulatedClosing(), by staged steps of Bullet's multibody world
};
[[nodiscard]] BULLET_CCD_API const char* toString(ClosingEngine engine);

enum class ClosingOrder : std::uint8_t
{
    Together,  ///< all fingers at once
    OneByOne,  ///< the next begins when all joints of the one before it have stopped
};
[[nodiscard]] BULLET_CCD_API const char* toString(ClosingOrder order);

struct ClosingOptions
{
    double tolerance = kDefaultTolerance;  ///< links stop at this distance from the object [m]
    double contactThreshold = 1e-4;  ///< features of stopped links this close are contacts [m]
    ClosingOrder order = ClosingOrder::Together;
    /// For OneByOne: the names of the fingers that close first, in this order. The others follow in
    /// the order of HandModel::fingers.
    std::vector<std::string> firstFingers = {};
    /// Joints that close faster or slower than the hand's own speeds say: name and ratio > 0 to the
    /// usual speed (ClosingDrives). A joint that mimics another one has no speed of its own.
    std::vector<std::pair<std::string, double>> speeds = {};
};

struct ClosingResult
{
    ToiStatus status = ToiStatus::Separated;  ///< Overlapping or IterationLimit: the closing failed
    std::vector<double> positions;            ///< one entry per link [rad or m]
    std::vector<StopEvent> stops;             ///< in the order of time
    /// For each link that the object stopped, in the order of `stops`, the pair of points that
    /// stopped it. They are at most the tolerance apart, and the link rests from then on, so this
    /// is a contact of the final posture. The link may touch at more points, and at nearer ones:
    /// the planner looks for all within ClosingOptions::contactThreshold.
    std::vector<GraspContact> contacts = {};
    bool touchedObstacle = false;       ///< something beside the object was touched
    std::int64_t steps = 0;             ///< queries or simulation steps
    ArticulatedCounters counters = {};  ///< of the queries, of a kinematic engine
};

/// Closes all fingers from `positions` (one entry per link [rad or m]) with the root link fixed at
/// X_WH. Each link stops at its first contact with the object or another link, together with the
/// joints between it and the palm. The others go on until all are stopped or at their limits. If
/// fingers close one by one, those that the same joint moves close together, and a finger that
/// another one runs into before its turn stays where it is.
///
/// Guarantee: motion between contacts is continuous; nothing is jumped over.
using CloseHand = std::function<ClosingResult(const HandModel& hand,
                                              const GraspObject& object,
                                              const Eigen::Isometry3d& X_WH,
                                              const std::vector<double>& positions,
                                              const ClosingOptions& options)>;
/// Makes one closing engine per thread.
using MakeCloseHand = std::function<CloseHand()>;

/// True if a link intersects the object or a link that it is paired with.
/// @param positions one entry per link [rad or m]
[[nodiscard]] BULLET_CCD_API bool handOverlaps(const HandModel& hand,
                                               const GraspObject& object,
                                               const Eigen::Isometry3d& X_WH,
                                               const std::vector<double>& positions);

/// A closing engine for the planner. Use one per thread. CloseHand states the contract.
///
/// Fingers that close independently are queried one by one for their first contact, up to the limit
/// of their next joint. The earliest contact of all is taken: its links stop, together with the
/// joints between them and the palm, and only the fingers that this changes are queried again.
/// Contacts between fingers are looked for up to that contact only.
///
/// Guarantee: as that of articulatedToi(), so no contact at any time of the closing, however far
/// the joints turn. A link stops with a part of the tolerance as gap. Status: Hit if a link was
/// stopped; Separated if all joints reached their limits; Overlapping if a closing link intersects
/// something at the start; IterationLimit if a query gave up, with the positions reached so far.
/// @param obstacles bodies at rest in W beside the object. Their hierarchies and the list itself
///                  must outlive the engine. An obstacle out of reach costs one test of boxes.
/// @param use       where closings note what they look at; null: nowhere. It must outlive the
///                  engine, and is written by the thread that closes.
/// @pre hand and object stay alive and unchanged between calls with the same addresses
[[nodiscard]] BULLET_CCD_API CloseHand kinematicClosing(std::span<const RigidBody> obstacles = {},
                                                        ModelUse* use = nullptr);
}  // namespace bullet_ccd::grasp
