#include "benchmarks/closing/closing_run.h"

#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/support/timing.h"
#include "grasp/approach/approach.h"
#include "grasp/approach/approach_sampler.h"
#include "grasp/closing/closing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <optional>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using grasp::ApproachCandidate;
using grasp::ClosingResult;
using grasp::GraspObject;
using grasp::HandModel;

constexpr double kTolerance = 2e-5;  // [m]
constexpr std::array kFactors{1.0, 2.5, 5.0, 10.0, 20.0};

/// The baseline's collision library is the peer's.
class FclProximity : public LinkProximity
{
public:
    FclProximity(const HandModel& hand, const GraspObject& object) : m_object(object.tree.mesh())
    {
        for (const SsvTree* tree : hand.linkTrees)
        {
            m_links.push_back(tree != nullptr ? std::optional<FclModel>(FclModel(tree->mesh()))
                                              : std::nullopt);
        }
    }

    void place(std::span<const Isometry3d> X_WL) override
    {
        m_poses.assign(X_WL.begin(), X_WL.end());
    }

    bool overlap(std::int32_t link, std::int32_t other) override
    {
        return fclOverlap(modelOf(link), poseOf(link), modelOf(other), poseOf(other));
    }

    double distance(std::int32_t link, std::int32_t other, double /*bound*/) override
    {
        return fclDistance(modelOf(link), poseOf(link), modelOf(other), poseOf(other));
    }

private:
    [[nodiscard]] const FclModel& modelOf(std::int32_t link) const
    {
        return link == kNone ? m_object : *m_links[static_cast<std::size_t>(link)];
    }
    [[nodiscard]] Isometry3d poseOf(std::int32_t link) const
    {
        return link == kNone ? Isometry3d::Identity() : m_poses[static_cast<std::size_t>(link)];
    }

    FclModel m_object;
    std::vector<std::optional<FclModel>> m_links;
    std::vector<Isometry3d> m_poses;
};

/// In rings about the object.
std::vector<RigidBody> clutterOf(const GraspObject& object, int count)
{
    std::vector<RigidBody> bodies;
    for (int i = 0; i < count; ++i)
    {
        const double away = 2.0 * object.radius + 0.9 + 0.3 * (i / 10);
        const double around = 2.0 * std::numbers::pi * (i % 10) / 10.0;
        Isometry3d X = Isometry3d::Identity();
        X.translation() = away * Eigen::Vector3d(std::cos(around), std::sin(around), 0.0);
        bodies.push_back({.tree = &object.tree, .motion = restAt(X)});
    }
    return bodies;
}

class Ours
{
public:
    Ours(const ClosingCase& scene, double tolerance)
        : m_hand(scene.hand),
          m_object(scene.object),
          m_tolerance(tolerance),
          m_clutter(clutterOf(scene.object, scene.clutter)),
          m_bodies{RigidBody{.tree = &scene.object.tree, .motion = {}}},
          m_environment(m_bodies),
          m_close(grasp::kinematicClosing(m_clutter))
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
    std::vector<RigidBody> m_clutter;
    std::array<RigidBody, 1> m_bodies;
    Environment m_environment;
    grasp::CloseHand m_close;
    ToiWorkspace m_work;
};
}  // namespace

std::vector<ClosingStart> closingStarts(const ClosingCase& scene)
{
    Ours ours(scene, kTolerance);
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
    return std::make_unique<FclProximity>(hand, object);
}

ClosingComparison compareClosing(const ClosingCase& scene, Peers peers)
{
    const std::vector<ClosingStart> starts = closingStarts(scene);
    ClosingComparison comparison{.candidates = static_cast<int>(starts.size()), .methods = {}};
    const auto add = [&](std::string name, const RunClosing& run)
    {
        MethodResult method{.name = std::move(name), .outcomes = {}};
        std::vector<double> micros;
        for (const ClosingStart& start : starts)
        {
            method.outcomes.push_back(run(start));
            micros.push_back(method.outcomes.back().microseconds);
        }
        method.meanMicroseconds = meanOf(micros);
        comparison.methods.push_back(std::move(method));
    };
    add("ours", runContinuous(scene, kTolerance));
    if (peers == Peers::None)
    {
        return comparison;
    }
    if (isFclPresent())
    {
        const std::unique_ptr<LinkProximity> fcl = fclProximity(scene.hand, scene.object);
        add("FCL, default step", runDiscrete(*fcl, scene.hand, {}));
    }
    const std::unique_ptr<LinkProximity> trees = treeProximity(scene.hand, scene.object);
    for (const double factor : kFactors)
    {
        const DiscreteOptions options{.closingStep = 0.01 * factor};
        add(fmt::format("own trees, step x {:g}", factor),
            runDiscrete(*trees, scene.hand, options));
    }
    const DiscreteOptions fine{.closingStep = 0.001, .contactGap = kTolerance, .maxSteps = 100'000};
    for (std::size_t i = 0; i < starts.size(); ++i)
    {
        const ClosingResult reference =
            discreteClosing(*trees, scene.hand, starts[i].X_WH, starts[i].open, fine);
        for (MethodResult& method : comparison.methods)
        {
            const double by = postureDifference(
                scene.hand, method.outcomes[i].closing.positions, reference.positions);
            method.otherPosture += by > kSamePosture ? 1 : 0;
            if (&method == comparison.methods.data())
            {
                comparison.worstOther = std::max(comparison.worstOther, by);
            }
        }
    }
    comparison.oursOther = comparison.methods.front().otherPosture;
    return comparison;
}
}  // namespace bullet_ccd::benchmarks
