#include "benchmarks/soak/bullet_soaks.h"

#include "benchmarks/reference/audit/world_audit.h"
#include "benchmarks/soak/bullet_hand_scene.h"
#include "grasp/hand/hand_model.h"
#include "tools/support/progress_line.h"

#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <memory>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;
// Inner half lengths of the bin for twenty objects [m]; its area grows with their number.
const Eigen::Vector2d kHalfInnerForTwenty(0.25, 0.2);
constexpr double kDensityInHand = 500.0;  // of the objects that are held [kg/m^3]

std::map<std::string, std::int64_t> countsOf(const btCcdControl& control, const AuditResult& seen)
{
    const btCcdCounters& counters = control.getCcdCounters();
    return {{"queries", counters.m_queries},
            {"impacts", counters.m_impacts},
            {"sub-steps", counters.m_subSteps},
            {"clamps", counters.m_clamps},
            {"lost time [us]", std::llround(1e6 * counters.m_lostTime)},
            {"pairs that intersected already", counters.m_overlaps},
            {"steps at the limit of impacts", counters.m_eventLimits},
            {"queries that gave up", counters.m_iterationLimits},
            {"colliders not covered", counters.m_unsupported},
            {"poses looked at", seen.poses},
            {"pairs of bodies near each other", seen.pairs},
            {"intersections", seen.intersecting}};
}

void printWorld(const std::string& what,
                const WorldAudit::Busiest& busiest,
                const std::vector<std::string>& names,
                const std::map<std::string, std::int64_t>& counts)
{
    fmt::print("{}\n", what);
    if (busiest.bodyA != kNone && busiest.bodyB != kNone)
    {
        fmt::print("  most impacts: {} of {} and {}\n",
                   busiest.impacts,
                   names[static_cast<std::size_t>(busiest.bodyA)],
                   names[static_cast<std::size_t>(busiest.bodyB)]);
    }
    std::string line = " ";
    for (const auto& [name, number] : counts)
    {
        line += fmt::format(" {} {},", name, number);
    }
    line.back() = '\n';
    fmt::print("{}", line);
    std::fflush(stdout);
}

/// Nothing may intersect, and nothing else be wrong.
Judgement judgementOf(const AuditResult& seen,
                      const std::vector<std::string>& names,
                      const std::string& otherwise)
{
    if (seen.clean() && otherwise.empty())
    {
        return {};
    }
    return {.verdict = Verdict::Missed,
            .time = seen.time,
            .distance = -seen.worst.depth,
            .pair = seen.clean() ? otherwise : describe(seen, names)};
}

/// What is wrong with where the objects are at the end; or "".
std::string restOf(const HouseholdBin& bin, double restSpeed)
{
    for (std::size_t i = 0; i < bin.size(); ++i)
    {
        if (!bin.isInside(i))
        {
            const btVector3& at = bin.object(i).getWorldTransform().getOrigin();
            return fmt::format("{} is not in the bin: ({:.3f}, {:.3f}, {:.3f})",
                               bin.names()[i],
                               double(at.x()),
                               double(at.y()),
                               double(at.z()));
        }
    }
    return bin.meanSpeed() < restSpeed
               ? ""
               : fmt::format("not at rest: mean speed {:.4f} m/s", bin.meanSpeed());
}

SoakAnswer runBin(const BinSoak& soak, std::uint64_t seed)
{
    examples::World world(examples::Engine::Ccd);
    world->setGravity(btVector3(0, 0, btScalar(-9.81)));
    WorldAudit audit(*world, {.longestMove = soak.longestMove, .mostSamples = soak.mostSamples});
    world.ccd().setCcdImpactListener(&audit);
    const double scale = std::sqrt(std::max(1.0, soak.objects / 20.0));
    const HouseholdBin bin(
        world,
        audit,
        {.objects = soak.objects, .seed = seed, .halfInner = scale * kHalfInnerForTwenty});
    const int steps = static_cast<int>(std::ceil(soak.seconds / soak.timeStep - 1e-9));
    AuditResult seen = audit.start();
    tools::ProgressLine progress(static_cast<std::size_t>(steps), "steps");
    for (int step = 1; step <= steps; ++step)
    {
        seen.add(audit.step(soak.timeStep));
        progress.show(static_cast<std::size_t>(step),
                      fmt::format(", {:.2f} s of motion, mean speed {:.3f} m/s, {} intersections",
                                  step * soak.timeStep,
                                  bin.meanSpeed(),
                                  seen.intersecting));
    }
    SoakAnswer answer{.judgement = judgementOf(seen, bin.names(), restOf(bin, soak.restSpeed)),
                      .counts = countsOf(world.ccd(), seen)};
    printWorld(fmt::format("seed {}: {} of {} objects in the bin, mean speed {:.4f} m/s",
                           seed,
                           bin.countInside(),
                           soak.objects,
                           bin.meanSpeed()),
               audit.busiestPair(),
               bin.names(),
               answer.counts);
    return answer;
}

SoakAnswer runHand(const HandModel& hand, const HandSoak& soak, std::uint64_t seed)
{
    const HouseholdObject object = makeHouseholdObject(seed - 1, seed, kDensityInHand);
    HandScene scene(hand, object, soak);
    Random random(7918 + seed);
    int held = 0;
    tools::ProgressLine progress(static_cast<std::size_t>(soak.closings), "closings");
    for (int closing = 0; closing < soak.closings; ++closing)
    {
        held += scene.close(random) ? 1 : 0;
        progress.show(static_cast<std::size_t>(closing) + 1, fmt::format(" on object {}", seed));
    }
    SoakAnswer answer{.status = 2 * held >= soak.closings ? ToiStatus::Hit : ToiStatus::Separated,
                      .judgement = judgementOf(scene.seen(), scene.names(), ""),
                      .counts = countsOf(scene.control(), scene.seen())};
    answer.counts["closings"] = soak.closings;
    answer.counts["held"] = held;
    printWorld(
        fmt::format(
            "seed {}: {} held {} times in {} closings", seed, object.name, held, soak.closings),
        scene.busiest(),
        scene.names(),
        answer.counts);
    return answer;
}
}  // namespace

SoakSubject binSoak(const BinSoak& soak)
{
    return {
        .program = fmt::format("benchmarks/run soak bullet bin --objects {} --seconds {} --dt {}",
                               soak.objects,
                               soak.seconds,
                               soak.timeStep),
        .families = {"bin"},
        .shares = {.leastHits = 0},
        .ask = [soak](std::uint64_t seed) { return runBin(soak, seed); }};
}

SoakSubject handSoak(const HandSoak& soak)
{
    const auto hand = std::make_shared<const HandModel>(grasp::loadHand(soak.hand));
    return {
        .program = fmt::format("benchmarks/run soak bullet hand --hand {} --closings {} --dt {}",
                               soak.hand.string(),
                               soak.closings,
                               soak.timeStep),
        .families = {"hand"},
        .shares = {.leastHits = 50, .leastFree = 0, .enough = 1},
        .ask = [hand, soak](std::uint64_t seed) { return runHand(*hand, soak, seed); }};
}
}  // namespace bullet_ccd::benchmarks
