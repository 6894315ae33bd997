#include "benchmarks/closing/closing_run.h"

#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/support/timing.h"
#include "grasp/approach/approach.h"
#include "grasp/approach/approach_sampler.h"
#include "grasp/closing/closing.h"

#include <array>
#include <cmath>
#include <map>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using grasp::ApproachCandidate;
using grasp::ClosingResult;
using grasp::GraspObject;
using grasp::HandModel;

class Ours
{
public:
    Ours(const ClosingCase& scene, double tolerance)
        : m_hand(scene.hand),
          m_object(scene.object),
          m_tolerance(tolerance),
          m_bodies{RigidBody{.tree = &scene.object.tree, .motion = {}}},
          m_environment(m_bodies),
          m_close(grasp::kinematicClosing())
    {
    }

    [[nodiscard]] ArticulatedToiResult approach(const ClosingStart& start)
    {
        return grasp::approachUntilContact(
            m_hand, m_environment, start.X_WStart, start.open, start.shift, m_tolerance, m_work);
    }

    [[nodiscard]] ClosingOutcome run(const ClosingStart& start)
    {
        ClosingOutcome outcome;
        outcome.microseconds = microsecondsOf(
            [&]
            {
                const ArticulatedToiResult found = approach(start);
                outcome.travel = found.status == ToiStatus::Hit ? found.time : INFINITY;
                outcome.closing =
                    m_close(m_hand, m_object, start.X_WH, start.open, {.tolerance = m_tolerance});
            });
        return outcome;
    }

private:
    const HandModel& m_hand;
    const GraspObject& m_object;
    double m_tolerance;
    std::array<RigidBody, 1> m_bodies;
    Environment m_environment;
    grasp::CloseHand m_close;
    ToiWorkspace m_work;
};
}  // namespace

std::vector<ClosingStart> closingStarts(const ClosingCase& scene)
{
    Ours ours(scene, kClosingTolerance);
    std::vector<ClosingStart> starts;
    for (int number = 0; number < scene.candidates; ++number)
    {
        const ApproachCandidate candidate =
            grasp::sampleApproach(scene.hand, scene.object, scene.seed, number, scene.candidates);
        ClosingStart start{.X_WStart = candidate.X_WStart,
                           .shift = candidate.distance * candidate.direction_W,
                           .open = scene.hand.preshapes[candidate.preshape].positions,
                           .X_WH = candidate.X_WStart};
        const ArticulatedToiResult found = ours.approach(start);
        if (found.status == ToiStatus::Hit)
        {
            start.X_WH.translation() += found.time * start.shift;
            starts.push_back(std::move(start));
        }
    }
    return starts;
}

RunClosing runContinuous(const ClosingCase& scene, double tolerance)
{
    return [ours = std::make_shared<Ours>(scene, tolerance)](const ClosingStart& start)
    { return ours->run(start); };
}

RunClosing runDiscrete(LinkProximity& proximity,
                       const HandModel& hand,
                       const DiscreteOptions& options)
{
    return [&proximity, &hand, options](const ClosingStart& start)
    {
        ClosingOutcome outcome;
        outcome.microseconds = microsecondsOf(
            [&]
            {
                outcome.travel = discreteApproach(
                    proximity, hand, start.X_WStart, start.shift, start.open, options);
                outcome.closing = discreteClosing(proximity, hand, start.X_WH, start.open, options);
            });
        return outcome;
    };
}

std::unique_ptr<LinkProximity> fclProximity(const HandModel& hand, const GraspObject& object)
{
    std::map<std::int32_t, FclModel> models{{kNone, FclModel(object.tree.mesh())}};
    for (std::size_t link = 0; link < hand.linkTrees.size(); ++link)
    {
        if (hand.linkTrees[link] != nullptr)
        {
            models.emplace(static_cast<std::int32_t>(link), hand.linkTrees[link]->mesh());
        }
    }
    const auto overlap =
        [models](std::int32_t a, const Isometry3d& X_WA, std::int32_t b, const Isometry3d& X_WB)
    { return fclOverlap(models.at(a), X_WA, models.at(b), X_WB); };
    const auto distance =
        [models](
            std::int32_t a, const Isometry3d& X_WA, std::int32_t b, const Isometry3d& X_WB, double)
    { return fclDistance(models.at(a), X_WA, models.at(b), X_WB); };
    return std::make_unique<LinkProximity>(overlap, distance);
}

}  // namespace bullet_ccd::benchmarks
