/// Planning one hand with one object, with notes and progress on stderr.
#pragma once

#include "grasp/planner/grasp_planner.h"
#include "tools/grasp_cli/inputs/catalogue.h"
#include "tools/support/obstacles/model_share.h"
#include "tools/support/obstacles/obstacle_list.h"

#include <deque>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// What the closings of kinematic engines looked at, a record for each engine.
using ClosingUses = std::deque<ModelUse>;

struct PlanRun
{
    LoadedHand hand;
    LoadedObject object;
    std::vector<grasp::Grasp> grasps{};  ///< best first
    double seconds = 0.0;                ///< planning alone
    ClosingUses uses{};                  ///< if the options have an accuracy
};

/// What a user should know about both, on stderr.
void printNotes(const LoadedHand& hand, const LoadedObject& object);

/// Throws std::runtime_error "<file>: <what>: <remedy>" for names of fingers that the hand has not,
/// and for speeds of joints that do not close by themselves.
void requireFingers(const LoadedHand& hand, const grasp::ClosingOptions& closing);

/// Throws std::runtime_error if there are obstacles, of which the simulated engine knows nothing.
void requireKinematic(const std::vector<Obstacle>& obstacles, const grasp::PlannerOptions& options);

/// @param obstacles  of the kinematic engine; must outlive the engines
/// @param uses       gets a record for each kinematic engine; null: none is kept
[[nodiscard]] grasp::MakeCloseHand closingEngine(grasp::ClosingEngine engine,
                                                 std::span<const RigidBody> obstacles = {},
                                                 ClosingUses* uses = nullptr);

/// True if the closings keep an accuracy, of which a report says what it needed.
[[nodiscard]] bool hasAccuracy(const grasp::PlannerOptions& options);

/// What closing the hand needed of its links, the object and the obstacles, with those out of
/// reach.
[[nodiscard]] ModelShare closingShare(const ClosingUses& uses,
                                      const grasp::HandModel& hand,
                                      const grasp::GraspObject& object,
                                      const ObstacleList& obstacles);

/// The same as JSON: how much was needed in all, and of each link, the object and each obstacle in
/// reach.
[[nodiscard]] std::string closingReport(const ClosingUses& uses,
                                        double accuracy,
                                        const grasp::HandModel& hand,
                                        const grasp::GraspObject& object,
                                        const ObstacleList& obstacles);

/// Plans with the closing engine that the options name and fills in what is found.
void runPlan(PlanRun& run,
             const grasp::PlannerOptions& options,
             bool quiet,
             const grasp::PlanExtras& extras = {});

/// Candidates that were not tried, such as "3, 7 to 9"; empty if all were.
[[nodiscard]] std::string candidatesLeft(const std::vector<grasp::Grasp>& grasps,
                                         std::int64_t candidates);

[[nodiscard]] std::size_t forceClosures(std::span<const grasp::Grasp> grasps);
[[nodiscard]] std::size_t linksInContact(const grasp::Grasp& grasp);
/// Such as "3 no force closure, 1 no approach hit"; empty if nothing was rejected.
[[nodiscard]] std::string rejectionCounts(const std::vector<grasp::Grasp>& grasps);
}  // namespace bullet_ccd::tools
