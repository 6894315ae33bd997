#include "benchmarks/stability/stability_closings.h"

#include "benchmarks/closing/closing_run.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/approach/approach.h"
#include "grasp/closing/closing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using grasp::ClosingOptions;
using grasp::ClosingResult;
using grasp::Grasp;
using grasp::GraspContact;
using grasp::GraspObject;
using grasp::HandModel;
using grasp::RejectReason;

constexpr double kPi = std::numbers::pi;

std::set<std::int32_t> linksOf(const Grasp& grasp)
{
    std::set<std::int32_t> links;
    for (const GraspContact& contact : grasp.contacts)
    {
        links.insert(contact.link);
    }
    return links;
}

/// Of the contacts of links that touched before, too; 0 if there are none.
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
        if (std::isfinite(nearest))
        {
            sum += nearest;
            ++count;
        }
    }
    return count > 0 ? sum / count : 0.0;
}

/// A solid of rings about z, (|x/a|^m + |y/b|^m)^(n/m) + |z/c|^n = 1, with x and y scaled by
/// `width`(z).
struct RingSolid
{
    Vector3d half;                ///< a, b, c [m]
    double exponentAround = 2.0;  ///< m
    double exponentUp = 2.0;      ///< n
    std::function<double(double)> width = [](double) { return 1.0; };
};

TriangleMesh meshOf(const RingSolid& solid, int level)
{
    const Vector3d& half = solid.half;
    const int segments = 32 << level;
    const int stations = (16 << level) + 2;
    const auto radiusAt = [](double c, double s, double exponent)
    {
        return std::pow(std::pow(std::abs(c), exponent) + std::pow(std::abs(s), exponent),
                        -1.0 / exponent);
    };
    return makeLofted(
        [&](int station)
        {
            const double angle = kPi * (static_cast<double>(station) / (stations - 1) - 0.5);
            const bool isPole = station == 0 || station == stations - 1;
            const double rho = radiusAt(std::cos(angle), std::sin(angle), solid.exponentUp);
            const double z = half.z() * rho * std::sin(angle);
            const double scale = isPole ? 0.0 : rho * std::cos(angle) * solid.width(z);
            std::vector<Vector3d> ring;
            for (int i = 0; i < segments; ++i)
            {
                const double around = 2.0 * kPi * i / segments;
                const double c = std::cos(around);
                const double s = std::sin(around);
                const double r = scale * radiusAt(c, s, solid.exponentAround);
                ring.emplace_back(half.x() * r * c, half.y() * r * s, z);
            }
            return ring;
        },
        stations);
}

double smoothStep(double x)
{
    const double t = std::clamp(x, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}
}  // namespace

Isometry3d poseError(std::uint64_t seed, double magnitude, const Vector3d& center)
{
    reference::Random random(seed);
    const Vector3d shift = random.direction();
    const Vector3d axis = random.direction();
    Isometry3d error = Isometry3d::Identity();
    error.translate(center + magnitude * shift);
    error.rotate(Eigen::AngleAxisd(magnitude, axis));
    error.translate(-center);
    return error;
}

GraspStart startOf(const HandModel& hand, const Grasp& grasp)
{
    const grasp::Preshape* preshape = findPreshape(hand, grasp.preshape);
    if (preshape == nullptr)
    {
        throw std::invalid_argument(grasp.preshape + ": the hand has no preshape of this name");
    }
    return {.X_WStart = grasp.X_WStart,
            .way = grasp.X_WH.translation() - grasp.X_WStart.translation(),
            .open = preshape->positions};
}

GraspStart moved(const GraspStart& start, const Isometry3d& error)
{
    return {
        .X_WStart = error * start.X_WStart, .way = error.linear() * start.way, .open = start.open};
}

std::vector<ClosingMethod> closingMethods()
{
    const auto withOptions = [](double tolerance, double contacts)
    {
        return grasp::PlannerOptions{
            .closing = ClosingOptions{.tolerance = tolerance, .contactThreshold = contacts},
            .volumes = 0};
    };
    const DiscreteOptions usual{};
    const DiscreteOptions fine{.closingStep = 1e-3,
                               .approachStep = 1e-3,
                               .contactGap = 2e-5,
                               .contactLayer = 4e-5,
                               .maxSteps = 100'000};
    return {{.name = "ours", .options = withOptions(2e-5, 1e-4)},
            {.name = "ours, tolerance 0.1 µm", .options = withOptions(1e-7, 1e-4)},
            {.name = "stepping, GraspIt! steps",
             .discrete = usual,
             .options = withOptions(2e-5, usual.contactLayer)},
            {.name = "stepping, steps / 10", .discrete = fine, .options = withOptions(2e-5, 1e-4)}};
}

struct ClosingBench::Parts
{
    Parts(const HandModel& ofHand, const GraspObject& ofObject)
        : hand(ofHand),
          object(ofObject),
          bodies{RigidBody{.tree = &ofObject.tree, .motion = {}}},
          environment(bodies),
          check(ofHand, ofObject),
          proximity(treeProximity(ofHand, ofObject)),
          continuous(grasp::kinematicClosing())
    {
    }

    const HandModel& hand;
    const GraspObject& object;
    std::array<RigidBody, 1> bodies;
    Environment environment;
    grasp::PenetrationCheck check;
    std::unique_ptr<LinkProximity> proximity;
    grasp::CloseHand continuous;
    ToiWorkspace work;
};

ClosingBench::ClosingBench(const HandModel& hand, const GraspObject& object)
    : m_parts(std::make_unique<Parts>(hand, object))
{
}

ClosingBench::~ClosingBench() = default;

Grasp ClosingBench::close(const ClosingMethod& method, const GraspStart& start)
{
    Parts& parts = *m_parts;
    Grasp grasp;
    grasp.X_WStart = start.X_WStart;
    double travel = 1.0;
    if (!method.discrete)
    {
        const ArticulatedToiResult found =
            grasp::approachUntilContact(parts.hand,
                                        parts.environment,
                                        start.X_WStart,
                                        start.open,
                                        start.way,
                                        method.options.closing.tolerance,
                                        parts.work);
        grasp.reject = grasp::rejectReasonOf(found.status, RejectReason::OverlapAtStart);
        travel = found.status == ToiStatus::Separated ? 1.0 : found.time;
    }
    else
    {
        travel = std::min(1.0,
                          discreteApproach(*parts.proximity,
                                           parts.hand,
                                           start.X_WStart,
                                           start.way,
                                           start.open,
                                           *method.discrete));
    }
    if (grasp.reject != RejectReason::None)
    {
        return grasp;
    }
    const grasp::CloseHand discrete = [&](const HandModel& hand,
                                          const GraspObject& /*object*/,
                                          const Isometry3d& X_WH,
                                          const std::vector<double>& positions,
                                          const ClosingOptions& /*options*/)
    { return discreteClosing(*parts.proximity, hand, X_WH, positions, *method.discrete); };
    const bool isContinuous = !method.discrete;
    grasp::CandidateContext context{.hand = parts.hand,
                                    .object = parts.object,
                                    .environment = parts.environment,
                                    .options = method.options,
                                    .close = isContinuous ? parts.continuous : discrete,
                                    .check = parts.check,
                                    .work = parts.work};
    Isometry3d X_WH = start.X_WStart;
    X_WH.translation() += travel * start.way;
    closeAndScore(grasp, X_WH, start.open, context);
    rejectPenetration(grasp, context);
    return grasp;
}

ClosingChange changeOf(const HandModel& hand, const Grasp& reference, const Grasp& other)
{
    ClosingChange change{.contacts = static_cast<int>(other.contacts.size()),
                         .success = other.reject == RejectReason::None};
    change.closed = !reference.positions.empty() && !other.positions.empty();
    if (change.closed)
    {
        change.posture = postureDifference(hand, reference.positions, other.positions);
        change.sameLinks = linksOf(reference) == linksOf(other);
        change.contactShift = contactShift(reference, other);
        change.epsilon = std::abs(reference.quality.epsilon - other.quality.epsilon);
    }
    return change;
}

const std::vector<std::string>& meshFamilies()
{
    static const std::vector<std::string> kFamilies{"egg", "block", "bottle", "ring"};
    return kFamilies;
}

TriangleMesh meshOfFamily(const std::string& family, int level)
{
    if (family == "egg")
    {
        return meshOf({.half = {0.03, 0.03, 0.042}}, level);
    }
    if (family == "block")
    {
        return meshOf({.half = {0.03, 0.022, 0.05}, .exponentAround = 8.0, .exponentUp = 8.0},
                      level);
    }
    if (family == "bottle")
    {
        // A neck of 13 mm on a body of 33 mm.
        return meshOf({.half = {0.033, 0.033, 0.1},
                       .exponentUp = 8.0,
                       .width = [](double z) { return 1.0 - 0.6 * smoothStep((z - 0.02) / 0.05); }},
                      level);
    }
    if (family == "ring")
    {
        return makeTorus(0.04, 0.013, 32 << level, 16 << level);
    }
    throw std::invalid_argument(family + ": no such family of meshes: egg, block, bottle or ring");
}
}  // namespace bullet_ccd::benchmarks
