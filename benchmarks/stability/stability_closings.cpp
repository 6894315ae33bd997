#include "benchmarks/stability/stability_closings.h"

#include "benchmarks/reference/scenes/random.h"
#include "grasp/approach/approach.h"
#include "grasp/planner/plan_candidate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <set>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using grasp::Grasp;
using grasp::GraspContact;
using grasp::GraspObject;
using grasp::HandModel;
using grasp::RejectReason;

/// A hand and an object, and what all methods ask them.
class GraspBench
{
public:
    GraspBench(const HandModel& hand, const GraspObject& object)
        : m_hand(hand),
          m_object(object),
          m_bodies{RigidBody{.tree = &object.tree, .motion = {}}},
          m_environment(m_bodies),
          m_check(hand, object),
          m_proximity(treeProximity(hand, object))
    {
    }

    /// @param discrete  none: the continuous method
    Grasp run(const ClosingStart& start,
              const grasp::PlannerOptions& options,
              const std::optional<DiscreteOptions>& discrete)
    {
        Grasp grasp;
        grasp.X_WStart = start.X_WStart;
        grasp::CloseHand close = grasp::kinematicClosing();
        double travel = 1.0;
        if (discrete)
        {
            travel = discreteApproach(
                *m_proximity, m_hand, start.X_WStart, start.shift, start.open, *discrete);
            close = [&](const HandModel& hand,
                        const GraspObject& /*object*/,
                        const Isometry3d& X_WH,
                        const std::vector<double>& positions,
                        const grasp::ClosingOptions& /*options*/)
            { return discreteClosing(*m_proximity, hand, X_WH, positions, *discrete); };
        }
        else
        {
            const ArticulatedToiResult found =
                grasp::approachUntilContact(m_hand,
                                            m_environment,
                                            start.X_WStart,
                                            start.open,
                                            start.shift,
                                            options.closing.tolerance,
                                            m_work);
            grasp.reject = grasp::rejectReasonOf(found.status, RejectReason::OverlapAtStart);
            travel = found.status == ToiStatus::Separated ? 1.0 : found.time;
        }
        if (grasp.reject == RejectReason::None)
        {
            grasp::CandidateContext context{.hand = m_hand,
                                            .object = m_object,
                                            .environment = m_environment,
                                            .options = options,
                                            .close = close,
                                            .check = m_check,
                                            .work = m_work};
            Isometry3d X_WH = start.X_WStart;
            X_WH.translation() += std::min(1.0, travel) * start.shift;
            closeAndScore(grasp, X_WH, start.open, context);
            rejectPenetration(grasp, context);
        }
        return grasp;
    }

private:
    const HandModel& m_hand;
    const GraspObject& m_object;
    std::array<RigidBody, 1> m_bodies;
    Environment m_environment;
    grasp::PenetrationCheck m_check;
    std::unique_ptr<LinkProximity> m_proximity;
    ToiWorkspace m_work;
};

std::set<std::int32_t> linksOf(const Grasp& grasp)
{
    std::set<std::int32_t> links;
    for (const GraspContact& contact : grasp.contacts)
    {
        links.insert(contact.link);
    }
    return links;
}

/// Over the contacts of links that touched before, too; 0 if there are none.
double contactShift(const Grasp& reference, const Grasp& other)
{
    double sum = 0.0;
    int count = 0;
    for (const GraspContact& contact : other.contacts)
    {
        double nearest = INFINITY;
        for (const GraspContact& former : reference.contacts)
        {
            if (former.link == contact.link)
            {
                nearest = std::min(nearest, (former.point - contact.point).norm());
            }
        }
        sum += std::isfinite(nearest) ? nearest : 0.0;
        count += std::isfinite(nearest) ? 1 : 0;
    }
    return sum / std::max(count, 1);
}

/// The solid (|x/a|^m + |y/b|^m)^(n/m) + |z/c|^n = 1 for half = (a, b, c), around = m and up = n,
/// with x and y scaled by `width`(z).
TriangleMesh superellipsoid(
    int level,
    const Vector3d& half,
    double around,
    double up,
    const std::function<double(double)>& width = [](double) { return 1.0; })
{
    const int segments = 32 << level;
    const int last = (16 << level) + 1;
    const auto radiusAt = [](double angle, double exponent)
    {
        return std::pow(std::pow(std::abs(std::cos(angle)), exponent) +
                            std::pow(std::abs(std::sin(angle)), exponent),
                        -1.0 / exponent);
    };
    return makeLofted(
        [&](int station)
        {
            const double angle = std::numbers::pi * (1.0 * station / last - 0.5);
            const bool isPole = station == 0 || station == last;
            const double rho = radiusAt(angle, up);
            const double z = half.z() * rho * std::sin(angle);
            const double scale = isPole ? 0.0 : rho * std::cos(angle) * width(z);
            std::vector<Vector3d> ring;
            for (int i = 0; i < segments; ++i)
            {
                const double turn = 2.0 * std::numbers::pi * i / segments;
                const double r = scale * radiusAt(turn, around);
                ring.emplace_back(half.x() * r * std::cos(turn), half.y() * r * std::sin(turn), z);
            }
            return ring;
        },
        last + 1);
}
}  // namespace

Isometry3d poseError(std::uint64_t seed, double magnitude, const Vector3d& center)
{
    reference::Random random(seed);
    const Vector3d shift = random.direction();
    const Vector3d axis = random.direction();
    return Eigen::Translation3d(center + magnitude * shift) * Eigen::AngleAxisd(magnitude, axis) *
           Eigen::Translation3d(-center);
}

ClosingStart startOf(const HandModel& hand, const Grasp& grasp)
{
    const grasp::Preshape* preshape = findPreshape(hand, grasp.preshape);
    if (preshape == nullptr)
    {
        throw std::invalid_argument(grasp.preshape + ": the hand has no preshape of this name");
    }
    return {.X_WStart = grasp.X_WStart,
            .shift = grasp.X_WH.translation() - grasp.X_WStart.translation(),
            .open = preshape->positions,
            .X_WH = grasp.X_WH};
}

ClosingStart moved(ClosingStart start, const Isometry3d& error)
{
    start.X_WStart = error * start.X_WStart;
    start.X_WH = error * start.X_WH;
    start.shift = error.linear() * start.shift;
    return start;
}

std::vector<GraspMethod> graspMethods(const HandModel& hand, const GraspObject& object)
{
    const auto bench = std::make_shared<GraspBench>(hand, object);
    const auto method = [&](std::string name,
                            double tolerance,
                            double contacts,
                            std::optional<DiscreteOptions> discrete = {})
    {
        const grasp::PlannerOptions options{
            .closing = {.tolerance = tolerance, .contactThreshold = contacts}, .volumes = 0};
        return GraspMethod{std::move(name), [=](const ClosingStart& start) {
                               return bench->run(start, options, discrete);
                           }};
    };
    const DiscreteOptions usual{};
    const DiscreteOptions fine{.closingStep = 1e-3,
                               .approachStep = 1e-3,
                               .contactGap = 2e-5,
                               .contactLayer = 4e-5,
                               .maxSteps = 100'000};
    return {method("ours", 2e-5, 1e-4),
            method("ours, tolerance 0.1 µm", 1e-7, 1e-4),
            method("stepping, GraspIt! steps", 2e-5, usual.contactLayer, usual),
            method("stepping, steps / 10", 2e-5, 1e-4, fine)};
}

nlohmann::json changeOf(const HandModel& hand, const Grasp& reference, const Grasp& other)
{
    const bool closed = !reference.positions.empty() && !other.positions.empty();
    return {
        {"closed", closed},
        {"posture", closed ? postureDifference(hand, reference.positions, other.positions) : 0.0},
        {"sameLinks", closed && linksOf(reference) == linksOf(other)},
        {"shift", closed ? contactShift(reference, other) : 0.0},
        {"epsilon", closed ? std::abs(reference.quality.epsilon - other.quality.epsilon) : 0.0},
        {"contacts", other.contacts.size()},
        {"success", other.reject == RejectReason::None}};
}

TriangleMesh meshOfFamily(const std::string& family, int level)
{
    if (family == "egg")
    {
        return superellipsoid(level, {0.03, 0.03, 0.042}, 2.0, 2.0);
    }
    if (family == "block")
    {
        return superellipsoid(level, {0.03, 0.022, 0.05}, 8.0, 8.0);
    }
    if (family == "bottle")
    {
        // A neck of 13 mm on a body of 33 mm.
        const auto width = [](double z)
        {
            const double t = std::clamp((z - 0.02) / 0.05, 0.0, 1.0);
            return 1.0 - 0.6 * t * t * (3.0 - 2.0 * t);
        };
        return superellipsoid(level, {0.033, 0.033, 0.1}, 2.0, 8.0, width);
    }
    if (family == "ring")
    {
        return makeTorus(0.04, 0.013, 32 << level, 16 << level);
    }
    throw std::invalid_argument(family + ": no such family of meshes: egg, block, bottle or ring");
}
}  // namespace bullet_ccd::benchmarks
