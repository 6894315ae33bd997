#include "benchmarks/soak/bullet_bin_soak.h"

#include "benchmarks/soak/bullet_soak_report.h"
#include "benchmarks/soak/soak_progress.h"
#include "bullet_ccd/examples/household_bin.h"

#include <cmath>
#include <cstdio>

namespace bullet_ccd::tests
{
namespace
{
// Inner half lengths of the bin for twenty objects [m]; its area grows with their number.
const Eigen::Vector2d kHalfInnerForTwenty(0.25, 0.2);

std::string stateOf(const examples::HouseholdBin& bin, double time, const AuditResult& seen)
{
    char text[160];
    std::snprintf(text,
                  sizeof text,
                  "%.2f s of motion, mean speed %.3f m/s, %lld intersections",
                  time,
                  bin.meanSpeed(),
                  static_cast<long long>(seen.intersecting));
    return text;
}
}  // namespace

bool runBinSoak(const BinSoak& soak)
{
    examples::World world(examples::Engine::Ccd);
    world->setGravity(btVector3(0, 0, btScalar(-9.81)));
    WorldAudit audit(*world, {.longestMove = soak.longestMove, .mostSamples = soak.mostSamples});
    world.ccd().setCcdImpactListener(&audit);
    std::printf("making %d objects\n", soak.objects);
    std::fflush(stdout);
    const double scale = std::sqrt(std::max(1.0, soak.objects / 20.0));
    const examples::HouseholdBin bin(
        world,
        audit,
        {.objects = soak.objects, .seed = soak.seed, .halfInner = scale * kHalfInnerForTwenty});

    const int steps = static_cast<int>(std::ceil(soak.seconds / soak.timeStep - 1e-9));
    std::printf("%d steps of %.6f s\n", steps, soak.timeStep);
    AuditResult seen = audit.start();
    {
        SoakProgress progress(steps);
        for (int step = 1; step <= steps; ++step)
        {
            const bool wasClean = seen.clean();
            seen.add(audit.step(soak.timeStep));
            if (wasClean && !seen.clean())
            {
                std::printf("\nfirst intersection: %s\n", examples::describe(bin, seen).c_str());
            }
            progress.show(step, stateOf(bin, step * soak.timeStep, seen));
        }
    }

    const WorldAudit::Busiest busiest = audit.busiestPair();
    if (busiest.bodyA != kNone && busiest.bodyB != kNone)
    {
        std::printf("most impacts: %lld of %s and %s\n",
                    static_cast<long long>(busiest.impacts),
                    bin.nameOf(busiest.bodyA).c_str(),
                    bin.nameOf(busiest.bodyB).c_str());
    }
    printCounters(world.ccd(), soak.seconds);
    for (std::size_t i = 0; i < bin.size(); ++i)
    {
        if (!bin.isInside(i))
        {
            const btVector3& at = bin.object(i).getWorldTransform().getOrigin();
            std::printf("%s is not in the bin: (%.3f, %.3f, %.3f)\n",
                        bin.nameOf(static_cast<std::int32_t>(i)).c_str(),
                        double(at.x()),
                        double(at.y()),
                        double(at.z()));
        }
    }
    const bool inside = bin.countInside() == static_cast<int>(bin.size());
    const bool rests = soak.restSpeed < 0.0 || bin.meanSpeed() < soak.restSpeed;
    std::printf("at the end: %d of %d objects in the bin, mean speed %.4f m/s%s\n",
                bin.countInside(),
                soak.objects,
                bin.meanSpeed(),
                rests ? "" : " (not at rest)");
    printAudit(seen, seen.clean() ? std::string() : examples::describe(bin, seen));
    return seen.clean() && inside && rests;
}
}  // namespace bullet_ccd::tests
